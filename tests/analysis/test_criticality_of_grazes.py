"""Power laws of grazes and what follows, beside closed forms, motions and iterated maps."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import nonsmooth as ns
from nonsmooth.analysis.normal_forms.grazing import scenario_behind
from nonsmooth.analysis.normal_forms.touch import Touch

R, STIFFNESS, PRELOAD = 0.8, 30.0, 0.7


class Driven:
    """x'' + 2 zeta x' + x = cos(omega t) below a wall at sigma, in closed form."""

    def __init__(self, omega: float, zeta: float) -> None:
        self.omega, self.zeta = omega, zeta
        self.reach = 1.0 / np.hypot(1 - omega**2, 2 * zeta * omega)
        self.period = 2 * np.pi / omega
        # cos(omega t - lag): the lowest place of the guard is where the phase is lag
        self.lag = np.arctan2(2 * zeta * omega, 1 - omega**2)
        self.touch = (self.lag / omega) % self.period
        self.matrix = np.array([[0.0, 1.0], [-1.0, -2 * zeta]])
        self.curvature = self.reach * omega**2
        # sigma - x at the touch, by the start of the period
        self.gradient = expm(self.matrix * self.touch)[0]
        self.behind = expm(self.matrix * (self.period - self.touch))

    @property
    def start(self) -> np.ndarray:
        """Section point of the free orbit."""
        return self.reach * np.array([np.cos(self.lag), self.omega * np.sin(self.lag)])

    def jump(self, kind: str) -> np.ndarray:
        """What the section point gains per power of the depth."""
        c = self.curvature
        speed = {
            # the speed sqrt(2 c d) at the wall becomes -R times that
            "rigid": -(1 + R) * np.sqrt(2 * c),
            # the stop pushes by STIFFNESS (x - sigma), whose integral is this
            "soft": -STIFFNESS * (4 / 3) * np.sqrt(2 / c),
            # a force PRELOAD, under which the speed turns round in another time
            "preloaded": -PRELOAD * 2 * c / (c + PRELOAD) * np.sqrt(2 / c),
        }[kind]
        return self.behind @ np.array([0.0, speed])

    def system(self, kind: str) -> ns.System:
        pull = "cos(omega*t) - 2*zeta*v - x"
        push = {"soft": f"{STIFFNESS}*(x - sigma)", "preloaded": f"{PRELOAD}"}.get(kind)
        if push is None:
            wall = ns.Exit("sigma - x", reset={"v": f"-{R}*v"}, name="impact")
            modes = {"free": ns.Mode({"x": "v", "v": pull}, exits=[wall])}
        else:
            modes = {
                "free": ns.Mode({"x": "v", "v": pull}, exits=[ns.Exit("sigma - x", to="pushed")]),
                "pushed": ns.Mode(
                    {"x": "v", "v": f"{pull} - {push}"}, exits=[ns.Exit("x - sigma", to="free")]
                ),
            }
        parameters = {"omega": self.omega, "zeta": self.zeta, "sigma": 2 * self.reach}
        return ns.System(states=["x", "v"], modes=modes, parameters=parameters, period="2*pi/omega")


DRIVEN = Driven(2.0, 0.1)
KINDS = {"rigid": 0.5, "preloaded": 0.5, "soft": 1.5}


def graze_of(driven: Driven, kind: str):
    system = driven.system(kind)
    between = (0.7 * driven.reach, 2.1 * driven.reach)
    branch = ns.continue_orbit(system, "sigma", between, direction="down")
    return system, branch, ns.criticality(branch, "grazing").isel(special=0)


@pytest.mark.few(3)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("driven", [DRIVEN, Driven(0.7, 0.25)], ids=["above", "below"])
def test_the_vectors_of_a_graze_in_closed_form(driven, kind):
    """Beside matrix exponentials; the engine has 1e-12, and a curvature by differences 1e-10."""
    _, _, found = graze_of(driven, kind)
    assert float(found["special_value"]) == pytest.approx(driven.reach, rel=1e-12)
    assert float(found["amplitude_power"]) == KINDS[kind]
    jump = driven.jump(kind)
    assert found["adjoint"].values.real == pytest.approx(driven.gradient, rel=1e-9)
    made = float(found["amplitude_factor"]) * found["eigenvector"].values.real
    assert made == pytest.approx(jump, rel=1e-8)
    exact = driven.gradient @ jump
    assert abs(float(found["coefficient"]) - exact) <= 1e-8 * np.abs(driven.gradient * jump).sum()
    assert float(found["parameter_coefficient"]) == pytest.approx(-1.0, abs=1e-9)
    assert str(found["side"].item()) == "below"


def after_one_period(system, state, sigma):
    run = ns.simulate(system, dict(zip("xv", state, strict=True)), periods=1,
                      parameters={"sigma": sigma})  # fmt: skip
    return run["end_state"].values


@pytest.mark.few(1)
@pytest.mark.parametrize("kind", KINDS)
def test_motions_leave_as_the_power_law_says(kind):
    """A motion that reaches a little deeper, beside the same one without the wall."""
    system, _, found = graze_of(DRIVEN, kind)
    n, power = found["adjoint"].values.real, float(found["amplitude_power"])
    jump = float(found["amplitude_factor"]) * found["eigenvector"].values.real
    depths = np.array([1e-9, 1e-8, 1e-7, 1e-6])
    ratios = []
    for depth in depths:
        start = DRIVEN.start + depth * n / (n @ n)
        struck = after_one_period(system, start, DRIVEN.reach)
        free = after_one_period(system, start, 10.0)
        ratios.append((struck - free) @ jump / (jump @ jump) / depth**power)
    # the next term is by the root of the depth smaller
    assert np.abs(np.array(ratios) - 1.0) == pytest.approx(0.0, abs=10 * np.sqrt(depths.max()))
    slope = np.diff(np.log(ratios)) / np.diff(np.log(depths))
    assert np.abs(slope[0]) < 1e-3


def test_the_multiplier_grows_as_the_coefficient_over_the_root():
    """Of orbits with one impact of the speed s the depth is s^2/2c."""
    system, _, found = graze_of(DRIVEN, "rigid")
    close = (DRIVEN.reach * (1 - 1e-6), DRIVEN.reach * (1 + 1e-6))
    branch = ns.continue_orbit(
        system, "sigma", close, direction="down", parameters={"sigma": close[1]}
    )
    struck = np.flatnonzero(branch["leg_exit"].isel(leg=0).values == "impact")
    # sizes of the multipliers are looked at where the derivative is mostly that of the root
    depths, largest = [], []
    for k in struck:
        point = branch.isel(point=int(k))
        speed = float(point["leg_states"].isel(leg=1).sel(state="v")) / R
        values = point["multipliers"].values
        depths.append(speed**2 / (2 * DRIVEN.curvature))
        largest.append(values[np.argmax(np.abs(values))].real)
    near = (np.array(depths) < 1e-9) & (np.array(depths) > 1e-14)
    assert np.count_nonzero(near) >= 2
    expected = float(found["coefficient"]) / (2 * np.sqrt(np.array(depths)[near]))
    # the other parts of the derivative are of order one
    assert np.array(largest)[near] == pytest.approx(expected, abs=2.0)
    assert np.abs(expected).min() > 100.0


def touch_of(jacobian, gradient, jump) -> Touch:
    return Touch(0.5, np.array(gradient), np.array(jump), np.array(jacobian), 0.0)


def depths_and_exponents(touch: Touch, distances, turns=4000):
    """Largest depth, over the distance, and the exponent of x -> A x + E sqrt(n x + distance)."""
    a, n, e = touch.jacobian, touch.gradient, touch.jump
    x = np.zeros((distances.size, n.size))
    v = np.tile(np.linspace(1.0, 2.0, n.size), (distances.size, 1))
    total, deepest = np.zeros(distances.size), np.zeros(distances.size)
    for turn in range(2 * turns):
        depth = x @ n + distances
        struck = depth > 0.0
        root = np.sqrt(np.where(struck, depth, 1.0))
        v = v @ a.T + np.where(struck, (v @ n) / (2 * root), 0.0)[:, None] * e
        x = x @ a.T + np.where(struck, root, 0.0)[:, None] * e
        length = np.linalg.norm(v, axis=1)
        v /= length[:, None]
        if turn >= turns:
            total += np.log(length)
            deepest = np.maximum(deepest, depth)
    return deepest / distances, total / turns


def turned(radius, angle):
    c, s = np.cos(angle), np.sin(angle)
    return radius * np.array([[c, -s], [s, c]])


DISTANCES = np.geomspace(1e-9, 1e-8, 60)


@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("word", "jacobian", "gradient", "jump"),
    [
        ("period adding", [[0.1]], [1.0], [-1.0]),
        ("period adding", [[0.24]], [1.0], [-1.0]),
        ("period adding", np.diag([0.2, 0.15]), [1.0, 1.0], [-0.2, -0.5]),
        ("period adding and chaos", [[0.3]], [1.0], [-1.0]),
        ("period adding and chaos", [[0.6]], [1.0], [-1.0]),
        ("period adding and chaos", np.diag([0.5, 0.3]), [1.0, 1.0], [-1.0, -0.2]),
        ("chaos", [[0.69]], [1.0], [-1.0]),
        ("chaos", np.diag([0.8, 0.5]), [1.0, 1.0], [-1.0, 0.5]),
        ("chaos", np.diag([0.8, -0.3]), [1.0, 1.0], [-1.0, -0.2]),
        ("jump", np.diag([0.5, 0.3]), [1.0, 1.0], [-1.0, 2.0]),
        ("jump", np.diag([0.8, -0.9]), [1.0, 1.0], [-1.0, -0.2]),
        ("jump", turned(0.9, 0.3), [1.0, 0.0], [-1.0, 0.0]),
        ("jump", turned(0.5, 2.0), [1.0, 0.0], [-1.0, 0.0]),
    ],
)
def test_scenarios_are_those_of_the_iterated_map(word, jacobian, gradient, jump):
    """The map with the root itself, a little beyond the graze, for many distances."""
    touch = touch_of(jacobian, gradient, jump)
    found, _ = scenario_behind(touch, "beyond")
    assert found == word
    deepest, exponent = depths_and_exponents(touch, DISTANCES)
    if word == "jump":
        assert deepest.min() > 1e3  # far deeper than the parameter is beyond the graze
        return
    assert deepest.max() < 1.0 + 1e-9
    chaotic = np.mean(exponent > 1e-3)
    if word == "period adding":
        assert chaotic == 0.0
    elif word == "chaos":
        assert chaotic == 1.0
    else:
        # of distances that are each a ratio of the multiplier apart, some are in each window
        wide = np.geomspace(1e-9, 1e-7, 2000)
        _, exponent = depths_and_exponents(touch, wide)
        assert 0.0 < np.mean(exponent > 1e-3) < 1.0


def test_an_unstable_orbit_and_a_sign_within_rounding_are_not_decided():
    for jacobian, jump, text in (
        ([[1.2]], [-1.0], "unstable before"),
        (np.diag([0.5, 0.5]), [-1.0, 1.0], "within rounding"),
    ):
        word, detail = scenario_behind(touch_of(jacobian, np.ones(len(jump)), jump), "beyond")
        assert word == "not decided"
        assert text in detail


OVERDAMPED = {"period adding": 2.0, "period adding and chaos": 6.0, "chaos": 12.0}


@pytest.mark.parametrize("word", OVERDAMPED)
def test_scenarios_of_an_overdamped_oscillator(word):
    """zeta = 1.2: the multipliers are exp(-T (zeta -+ sqrt(zeta^2 - 1)))."""
    driven = Driven(OVERDAMPED[word], 1.2)
    system, _, found = graze_of(driven, "rigid")
    largest = np.exp(-driven.period * (1.2 - np.sqrt(1.2**2 - 1)))
    expected = "period adding" if largest < 1 / 4 else "chaos" if largest > 2 / 3 else word
    assert expected == word
    assert str(found["criticality"].item()) == word
    assert f"{largest:.4g}" in str(found["criticality_detail"].item())
    beyond = 1e-6 * driven.reach * np.geomspace(1.0, 1.0 / largest, 5)[:-1]
    for distance in beyond:
        at = {"sigma": driven.reach - distance}
        run = ns.simulate(system, {"x": driven.start[0], "v": driven.start[1]}, periods=600,
                          parameters=at)  # fmt: skip
        speeds = run["state_before"].sel(state="v").values
        # the attractor is small: no impact reaches deeper than the free motion would
        assert speeds[len(speeds) // 2 :].max() ** 2 / (2 * driven.curvature) < 1.1 * distance
        if word == "period adding":
            assert ns.regime(system, parameters=at)["regime"].item() == "periodic"
        if word == "chaos":
            spectrum = ns.lyapunov_spectrum(system, parameters=at, transient=500, record=2000)
            assert float(spectrum["lyapunov_exponent"][0]) > 0.0


DAMPER = 0.05


def plated(driven: Driven) -> ns.System:
    """A plate without mass on a spring and a damper, at which the mass pushes as 2 xi v + q."""
    pull = "cos(omega*t) - 2*zeta*v - x"
    return ns.System(
        states=["x", "v", "q"],
        period="2*pi/omega",
        parameters={
            "omega": driven.omega, "zeta": driven.zeta, "xi": DAMPER, "sigma": 2 * driven.reach,
        },
        modes={
            "free": ns.Mode(
                {"x": "v", "v": pull, "q": "-q/(2*xi)"},
                exits=[ns.Exit("q + sigma - x", to="contact")],
            ),
            "contact": ns.Mode(
                {"v": f"{pull} - 2*xi*v - q", "q": "v"},
                slaved={"x": "q + sigma"},
                exits=[ns.Exit("2*xi*v + q", to="free")],
            ),
        },
    )  # fmt: skip


def test_a_plate_without_mass_leaves_what_is_as_large_as_the_depth():
    """The force 2 xi sqrt(2 c d) falls to zero in sqrt(2 d/c): v loses 2 xi d, and q gains d."""
    system = plated(DRIVEN)
    between = (0.7 * DRIVEN.reach, 2.1 * DRIVEN.reach)
    branch = ns.continue_orbit(system, "sigma", between, direction="down")
    found = ns.criticality(branch, "grazing").isel(special=0)
    assert float(found["amplitude_power"]) == 1.0
    relaxed = np.exp(-(DRIVEN.period - DRIVEN.touch) / (2 * DAMPER))
    jump = np.append(DRIVEN.behind @ [0.0, -2 * DAMPER], relaxed)
    made = float(found["amplitude_factor"]) * found["eigenvector"].values.real
    assert made == pytest.approx(jump, rel=1e-8, abs=1e-10)
    n = found["adjoint"].values.real
    assert n[:2] == pytest.approx(DRIVEN.gradient, rel=1e-9)
    start = np.append(DRIVEN.start, 0.0)
    for depth in (1e-10, 1e-8, 1e-6):
        moved = start + depth * n / (n @ n)
        state = dict(zip(system.states, moved, strict=True))
        struck, free = (
            ns.simulate(system, state, periods=1, parameters={"sigma": sigma})["end_state"].values
            for sigma in (DRIVEN.reach, 10.0)
        )
        ratio = (struck - free) @ jump / (jump @ jump) / depth
        assert ratio == pytest.approx(1.0, abs=50 * np.sqrt(depth) + 1e-13 / depth)
    assert found["criticality"].item() == "continuous"


def test_a_stop_with_a_damper_is_not_decided():
    """Its force depends on the speed at the guard, for which the law of a spring does not hold."""
    pull = "cos(omega*t) - 2*zeta*v - x"
    stop = ns.Mode(
        {"x": "v", "v": f"{pull} - 30*(x - sigma) - 0.5*v"}, exits=[ns.Exit("x - sigma", to="free")]
    )
    system = ns.System(
        states=["x", "v"],
        period="2*pi/omega",
        parameters={"omega": 2.0, "zeta": 0.1, "sigma": 0.6},
        modes={
            "free": ns.Mode({"x": "v", "v": pull}, exits=[ns.Exit("sigma - x", to="contact")]),
            "contact": stop,
        },
    )
    branch = ns.continue_orbit(system, "sigma", (0.3, 0.7), direction="down")
    found = ns.criticality(branch, "grazing").isel(special=0)
    assert found["criticality"].item() == "not decided"
    assert "damper" in found["criticality_detail"].item()


@pytest.mark.slow
def test_multipliers_of_the_mole_jump_at_a_graze():
    """To what those behind it come to as the contact becomes short."""
    mole = ns.models.moling()
    branch = ns.continue_orbit(mole, "b", (0.1, 0.17), direction="up")
    found = ns.criticality(branch, "grazing").isel(special=0)
    assert found["criticality"].item() == "nonsmooth fold"
    behind = float(str(found["criticality_detail"].item()).split()[-1])
    place = int(branch["special_point"][int(found["special"])])
    value, first = float(branch["b"][place]), branch.isel(point=place + 1)
    close = ns.continue_orbit(mole, "b", (value, value + 6e-7), initial=first, largest_step=0.02)
    contact = close["durations"].where(close["leg_mode"] == close["leg_mode"][0, 1]).min("leg")
    largest = close["multipliers"].values[:, 0].real
    assert contact.min() < 0.06
    line = np.polynomial.Polynomial.fit(contact.values, largest, 3)
    assert float(line(0.0)) == pytest.approx(behind, abs=0.02)


def test_periods_grow_by_one_towards_the_graze():
    """With each factor m^2 of the distance: m^n sqrt(d) is as large as d after n turns."""
    driven = Driven(OVERDAMPED["period adding"], 1.2)
    system = driven.system("rigid")
    largest = np.exp(-driven.period * (1.2 - np.sqrt(1.2**2 - 1)))
    periods = []
    for k in range(4):
        at = {"sigma": driven.reach * (1.0 - 1e-5 * largest ** (2 * k))}
        found = ns.regime(system, parameters=at)
        assert found["regime"].item() == "periodic"
        assert float(found["impacts"]) * int(found["period"]) == pytest.approx(1.0)
        periods.append(int(found["period"]))
    assert np.diff(periods).tolist() == [1, 1, 1]


def test_behind_a_jump_impacts_are_fast():
    system, _, found = graze_of(DRIVEN, "rigid")
    assert str(found["criticality"].item()) == "jump"
    distance = 1e-9
    run = ns.simulate(
        system, dict(zip("xv", DRIVEN.start, strict=True)), periods=2000,
        parameters={"sigma": DRIVEN.reach - distance},
    )  # fmt: skip
    speeds = run["state_before"].sel(state="v").values
    assert speeds[len(speeds) // 2 :].max() ** 2 / (2 * DRIVEN.curvature) > 1e4 * distance


def self_excited(coupling: float) -> ns.System:
    """Van der Pol's oscillator below a wall, which passes marks, with a state that follows it."""
    rates = {"x": "v", "v": "0.5*(1 - x**2)*v - x + k*z", "z": "x - 0.4*z"}
    wall = ns.Exit("sigma - x", reset={"v": f"-{R}*v"}, name="impact")
    return ns.System(
        states=["x", "v", "z"],
        parameters={"sigma": 3.0, "k": coupling},
        modes={
            "down": ns.Mode(rates, exits=[wall, ns.Exit("x + 0.5", to="low", name="falls")]),
            "low": ns.Mode(rates, exits=[ns.Exit("0.5 - x", to="down", name="rises")]),
        },
    )


def test_the_graze_of_a_cycle_without_forcing():
    """Motions that begin at the section beside the cycle, with and without the wall."""
    system = self_excited(-0.2)
    branch = ns.continue_orbit(
        system, "sigma", (1.5, 3.1), initial={"x": 1.0, "v": 0.0, "z": 0.0}, direction="down"
    )
    found = ns.criticality(branch, "grazing").isel(special=0)
    assert float(found["amplitude_power"]) == 0.5
    place = int(branch["special_point"][int(found["special"])])
    start = np.array([float(branch[name][place]) for name in system.states])
    sigma = float(found["special_value"])
    n = found["adjoint"].values.real
    jump = float(found["amplitude_factor"]) * found["eigenvector"].values.real
    mode = str(branch["word"].values[place]).split()[0]
    section = [str(name) for name in branch["leg_exit"].values[place] if name][-1]

    def at_section(wall: float, state) -> np.ndarray:
        """Where the motion comes through the section again."""
        run = ns.simulate(
            system, dict(zip(system.states, state, strict=True)), t_end=15.0, mode=mode,
            parameters={"sigma": wall},
        )  # fmt: skip
        passed = (run["event_name"].values == section) & (run["event_time"].values > 0.1)
        return run["state_after"].values[int(np.flatnonzero(passed)[0])]

    for depth in (1e-9, 1e-7):
        # along the section, on which x stays
        moved = start + depth * np.array([0.0, n[1], n[2]]) / (n[1] ** 2 + n[2] ** 2)
        off = at_section(sigma, moved) - at_section(3.0, moved)
        ratio = (off @ jump) / (jump @ jump) / np.sqrt(depth)
        assert ratio == pytest.approx(1.0, abs=20 * np.sqrt(depth))


def test_a_kick_along_the_motion_leaves_no_root():
    """In the plane a graze without forcing is at v = 0, where the motion itself is along v."""
    whole = self_excited(0.0)
    rates = {"x": "v", "v": "0.5*(1 - x**2)*v - x"}
    modes = {name: ns.Mode(rates, exits=mode.exits) for name, mode in whole.modes.items()}
    system = ns.System(states=["x", "v"], parameters={"sigma": 3.0}, modes=modes)
    branch = ns.continue_orbit(
        system, "sigma", (1.5, 3.1), initial={"x": 1.0, "v": 0.0}, direction="down"
    )
    found = ns.criticality(branch, "grazing").isel(special=0)
    assert found["criticality"].item() == "not decided"
    assert "along the motion" in found["criticality_detail"].item()


def test_a_guard_of_time_alone_has_no_criticality():
    """A ball that rests on a shaken table leaves it from A w**2 = g on, whatever its state."""
    table = ns.Exit(
        "y - A*sin(w*t)", reset={"v": "-r*v + (1 + r)*A*w*cos(w*t)"}, sticks="low", name="low"
    )
    system = ns.System(
        states=["y", "v"],
        parameters={"A": 0.08, "w": 10.0, "r": 0.6, "g": 9.81},
        period="2*pi/w",
        modes={"air": ns.Mode({"y": "v", "v": "-g"}, exits=[table])},
    )
    branch = ns.continue_orbit(system, "w", (10.0, 11.2), steps=60)
    place = branch["special_kind"].values.tolist().index("grazing")
    assert branch["special_value"].values[place] == pytest.approx((9.81 / 0.08) ** 0.5, rel=1e-11)
    found = ns.criticality(branch)
    assert found["criticality"].values.tolist() == ["not decided"]
    assert "depends on time alone" in found["criticality_detail"].item()
