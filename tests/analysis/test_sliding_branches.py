"""Branches of orbits through sliding: each kind where its own equations place it."""

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.linalg import expm
from scipy.optimize import brentq

import nonsmooth as ns
from periodic_orbits.references import belt as reference
from periodic_orbits.systems import LIFT_OFF, cam_follower

SAME = dict(rel=0.0, abs=1e-10)  # located to rounding over the rates of the tests


def belt(**changed) -> ns.System:
    values = {"v_b": 1.0, "mu": 0.3, "F": 1.0, "omega": 2.0, "zeta": 0.05} | changed
    return ns.System(
        states=["x", "v"],
        parameters=values,
        period="2*pi/omega",
        equations={"x": "v", "v": "F*cos(omega*t) - x - 2*zeta*v - mu*sign(slip)"},
        surfaces={"slip": ns.Surface("v - v_b", below="lag", on="stick", above="lead")},
    )


def exact(omega: float, v_b: float = 0.5) -> reference.Belt:
    return reference.Belt(mpf(v_b), mpf(0.3), mpf(omega), mpf(0.05))


def specials(branch) -> list[tuple[str, float]]:
    values = branch["special_value"].values.tolist()
    return [
        (kind, value)
        for kind, value in zip(branch["special_kind"].values.tolist(), values, strict=True)
        if kind != "bound"
    ]


def is_run(system: ns.System, branch, parameter: str) -> None:
    """Every point is a motion: a run from it, which knows nothing of words, comes back to it."""
    for k in range(0, branch.sizes["point"], 3):
        point = branch.isel(point=k)
        there = {"x": float(point["x"]), "v": float(point["v"])}
        changed = {parameter: float(point[parameter])}
        run = ns.simulate(system, there, periods=1, parameters=changed)
        scale = max(abs(there["x"]), abs(there["v"]))
        for state, value in there.items():
            assert float(run[state][-1]) == pytest.approx(value, abs=1e-7 * scale)


@pytest.fixture(scope="module")
def fast():
    system = belt()
    return system, ns.continue_orbit(system, "v_b", (0.05, 1.2))


@pytest.fixture(scope="module")
def slow():
    system = belt(omega=0.3)
    return system, ns.continue_orbit(system, "v_b", (0.05, 1.2))


@pytest.mark.slow
def test_the_branch_goes_on_from_bound_to_bound(fast, slow):
    for system, branch in (fast, slow):
        assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("bound", "bound")
        assert bool(branch["admissible"].all())
        is_run(system, branch, "v_b")


def test_kinds_in_order(fast, slow):
    assert [kind for kind, _ in specials(fast[1])] == [
        "crossing_sliding", "switching_sliding", "grazing_sliding",
    ]  # fmt: skip
    assert [kind for kind, _ in specials(slow[1])] == [
        "adding_sliding", "adding_sliding", "grazing_sliding", "grazing_sliding",
    ]  # fmt: skip


def test_grazing_sliding_where_the_mass_reaches_the_belt(fast, slow):
    for omega, (_, branch) in ((2.0, fast), (0.3, slow)):
        kind, value = specials(branch)[-1]
        assert kind == "grazing_sliding"
        assert value == pytest.approx(float(reference.grazing(exact(omega))), **SAME)


def test_switching_sliding_where_motion_comes_onto_the_belt_at_its_border(fast):
    *_, v_b = reference.switching(exact(2.0), (0.518, 0.147, 0.756, 0.627))
    assert dict(specials(fast[1]))["switching_sliding"] == pytest.approx(float(v_b), **SAME)


def test_crossing_sliding_where_motion_crosses_the_belt_at_its_border(fast):
    branch = fast[1]
    kind, value = specials(branch)[0]
    before = branch.isel(point=int(branch["special_point"][1]))
    guess = [float(before["leg_time"][1]), float(before["leg_states"][1, 0]),
             float(before["leg_time"][2]), value]  # fmt: skip
    *_, v_b = reference.crossing(exact(2.0), guess)
    assert kind == "crossing_sliding" and value == pytest.approx(float(v_b), **SAME)


def test_adding_sliding_where_the_friction_force_touches_its_bound(slow):
    branch = slow[1]
    value = specials(branch)[0][1]
    words = branch["word"].values
    apart = np.where(words == "stick lag stick", np.abs(branch["v_b"].values - value), np.inf)
    near = branch.isel(point=int(apart.argmin()))
    period = 2 * np.pi / 0.3
    entry = float(near["leg_time"][2]) - period
    guess = [entry, float(near["leg_states"][2, 0]), float(near["leg_time"][1]), value]
    # u is stationary where the force changes as fast as the belt moves the spring
    touch = -np.arcsin(value / 0.3) / 0.3
    *_, v_b, touch = reference.adding(exact(0.3), (*guess, touch))
    assert value == pytest.approx(float(v_b), **SAME)
    assert entry < float(touch) < guess[2]


def test_multipliers_of_an_orbit_that_sticks():
    """One direction is gone, the other one is the derivative of the return map of stick."""
    system = belt(v_b=0.64)
    orbit = ns.find_orbit(system, transient=20)
    assert orbit["word"].item() == "lag stick lag"
    values = orbit["multipliers"].values
    assert values[1] == 0.0
    there = exact(2.0, 0.64)
    entry, leave = orbit["leg_time"].values[1:3]
    with mp.workdps(reference.DIGITS):
        entry, x, leave = reference.solved(
            lambda *u: reference.stick_and_lag(there, *u),
            (entry, float(orbit["leg_states"][1, 0]), leave),
        )
        wanted = float(reference.multiplier(there, entry, x, leave))
    assert values[0] == pytest.approx(wanted, rel=1e-8, abs=1e-12)
    assert float(orbit["log_determinant"]) == -np.inf


@pytest.mark.slow
def test_curves_of_special_points(fast):
    """Over a second parameter: each end of the curve solves the equations of its kind there."""
    for number, kind in enumerate(("crossing_sliding", "switching_sliding", "grazing_sliding"), 1):
        branch = fast[1]
        assert branch["special_kind"].values[number] == kind
        curve = ns.continue_special(branch, number, "omega", (1.95, 2.0), direction="down")
        end = curve.isel(point=0)
        omega = float(end["omega"])
        assert omega == pytest.approx(1.95)
        times, x = end["leg_time"].values, end["leg_states"].sel(state="x").values
        start = (times[1], x[1], times[2], float(end["v_b"])) if kind != "grazing_sliding" else ()
        there = exact(omega)
        if kind == "crossing_sliding":
            *_, v_b = reference.crossing(there, start)
        elif kind == "switching_sliding":
            *_, v_b = reference.switching(there, start)
        else:
            v_b = reference.grazing(there)
        assert float(end["v_b"]) == pytest.approx(float(v_b), **SAME)


def friction() -> ns.System:
    return ns.System(
        states=["x", "v"],
        parameters={"mu": 0.2},
        period="2*pi/0.7",
        equations={"x": "v", "v": "cos(0.7*t) - x - 0.1*v - mu*sign(v)"},
    )


@pytest.mark.slow
def test_friction_from_no_stop_to_stops_and_to_stick_for_ever():
    branch = ns.continue_orbit(friction(), "mu", (0.0, 1.2), direction="up")
    assert branch.attrs["end_last"] == "bound"
    (first, stop), (last, stick) = specials(branch)
    assert (first, last) == ("crossing_sliding", "adding_sliding")
    *_, mu = reference.stops(0.7, 0.05, (1.067, 1.371, 0.638))
    assert stop == pytest.approx(float(mu), **SAME)
    # all of the force is held from mu = 1 on; the place it is held at is known to rounding over
    # 1 - mu where the last slip was solved for
    assert stick == pytest.approx(1.0, abs=1e-9)
    held = branch.isel(point=branch["mu"].values > 1.001)
    assert set(held["word"].values) == {"flow[0]"}
    assert np.ptp(held["x"].values) == 0.0
    assert np.all(held["multipliers"].values == [1.0, 0.0])
    assert not held["stable"].any()


@pytest.mark.slow
def test_three_changes_that_follow_a_graze_at_once_come_in_their_order():
    """A rubbing tip that stops touches the surface of no slip, and the part that slides is short.

    The excursion begins as a slide, comes to the surface later and later, and crosses it in the
    end: all within 0.013 of the parameter. Where a slide of the usual first length would be
    expected, the motion crosses already.
    """
    beam = ns.System(
        states=["q1", "p1", "q2", "p2"],
        parameters={"Omega": 54.4},
        period="2*pi/Omega",
        definitions={
            "tip": "2*q1 - 2*q2",
            "wall": "4e4*max(tip - 1, 0) + 4e5*max(tip - 1.3, 0)",
            "Q": "800*cos(Omega*t) - wall - 50*sign(slide)",
        },
        surfaces={"slide": ns.Surface("2*p1 - 2*p2")},
        equations={
            "q1": "p1",
            "p1": "-1.256*p1 - 62.8**2*q1 + 2*Q",
            "q2": "p2",
            "p2": "-7.88*p2 - 394**2*q2 - 2*Q",
        },
    )
    branch = ns.continue_orbit(
        beam, "Omega", (54.29, 54.4), period=2, transient=600, direction="down"
    )
    assert branch.attrs["end_first"] == "bound"
    assert np.all(np.diff(branch["Omega"].values) >= 0.0)  # it turns back nowhere
    kinds = branch["special_kind"].values.tolist()
    assert [kind for kind in kinds if "sliding" in kind] == [
        "crossing_sliding", "switching_sliding", "grazing_sliding",
    ]  # fmt: skip
    for value in (54.292, 54.3, 54.306, 54.35):
        near = branch.isel(point=int(np.abs(branch["Omega"].values - value).argmin()))
        parameters = {"Omega": float(near["Omega"])}
        run = ns.simulate(beam, near, periods=2, parameters=parameters)
        start = [float(near[name]) for name in beam.states]
        assert np.abs(run["end_state"].values - start).max() < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("phase", [0.0, 0.3])
@pytest.mark.parametrize("low", [2.5, 3.0])
def test_a_follower_lifts_off_its_cam(phase, low):
    """At phase 0 both are at rest at the strobe, and all states of the branch vanish there."""
    branch = ns.continue_orbit(cam_follower(phase), "w", (low, 4.5), transient=50)
    assert branch.attrs["end_last"] == "bound"
    grazes = branch["special_value"].values[branch["special_kind"].values == "grazing"]
    assert grazes[0] == pytest.approx(LIFT_OFF, abs=1e-9)
    for speed, word in zip(branch["w"].values, branch["word"].values.tolist(), strict=True):
        if abs(speed - LIFT_OFF) > 1e-6:
            assert ("air" in word) == (speed > LIFT_OFF)


@pytest.mark.few(1)
@pytest.mark.parametrize(("name", "between"), [("Om", (1.0, 120.0)), ("mu1", (0.0, 0.01))])
def test_a_slip_that_becomes_short_ends_at_the_border_of_what_sticks(name, between):
    """A disc on a shaft, driven by friction that falls with the slip: clutch judder.

    That the slip lasts no time solves its equations too, and long steps come upon that.
    """
    values = {"mu1": 0.006, "Om": 35.0}
    friction = "462*(0.38 - mu1*abs(slip))*sign(slip)"
    clutch = ns.System(
        states=["phi", "w"], parameters=values, initial={"w": 0.0},
        equations={"phi": "w", "w": f"(-620*phi - w/2 + {friction})/0.14"},
        surfaces={"slip": ns.Surface("Om - w", below="over", on="stick", above="under")},
    )  # fmt: skip
    branch = ns.continue_orbit(clutch, name, between, direction="down")
    border = branch["special_value"].values[branch["special_kind"].values == "switching_sliding"]

    def above(value: float) -> float:
        """How far phi is from the other border of what sticks where the motion comes back."""
        given = values | {name: value}
        speed, slope = given["Om"], given["mu1"]
        rate = np.array([[0.0, 1.0], [-620.0 / 0.14, (-0.5 + 462.0 * slope) / 0.14]])
        rest = 462.0 * (0.38 - slope * speed) / 620.0
        begin = np.array([(462.0 * 0.38 - 0.5 * speed) / 620.0 - rest, speed])

        def state(time: float) -> np.ndarray:
            return expm(rate * time) @ begin

        times = np.linspace(0.01, 0.2, 400)
        speeds = np.array([state(time)[1] for time in times]) - speed
        first = int(np.flatnonzero((speeds[:-1] < 0.0) & (speeds[1:] >= 0.0))[0])
        back = brentq(lambda t: state(t)[1] - speed, times[first], times[first + 1], xtol=1e-15)
        return state(back)[0] + rest + (462.0 * 0.38 + 0.5 * speed) / 620.0

    exact = brentq(above, *{"Om": (10.0, 30.0), "mu1": (0.002, 0.0045)}[name], xtol=1e-14)
    assert border == pytest.approx([exact], rel=1e-11)
