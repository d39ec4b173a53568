"""`edge_state`: saddles and borders in closed form, and one by scipy at a wall."""

import numpy as np
import pytest
from scipy.optimize import brentq, root

import nonsmooth as ns
from analysis.wells import forced_wells

ZETA, OMEGA, FORCE = 0.1, 1.3, 0.15


def double_well(**values):
    """A hill between -1 and 1 and a straight wall of a well on either side of it."""
    pull = "where(abs(x) < 1, x, 2*sign(x) - x)"
    return ns.System(
        name="double_well",
        states=["x", "v"],
        parameters={"zeta": ZETA, "omega": OMEGA, "F": FORCE} | values,
        period="2*pi/omega",
        equations={"x": "v", "v": f"{pull} - 2*zeta*v + F*cos(omega*t)"},
    )


def test_a_driven_saddle_on_a_hill():
    """On the hill the motion is that of a linear equation: its orbit and multipliers are known.

    x'' + 2 zeta x' - x = F cos(omega t) has the solution Re(A exp(i omega t)), and neighbours
    leave it as exp(s t) with s^2 + 2 zeta s = 1.
    """
    system = double_well()
    edge = ns.edge_state(system, {"x": -1.7}, {"x": 2.3})
    amplitude = FORCE / (-1.0 - OMEGA**2 + 2j * ZETA * OMEGA)
    assert edge["kind"].item() == "periodic" and edge["period"].item() == 1
    assert float(edge["x"].squeeze()) == pytest.approx(amplitude.real, abs=1e-12)
    assert float(edge["v"].squeeze()) == pytest.approx((1j * OMEGA * amplitude).real, abs=1e-12)
    rates = -ZETA + np.sqrt(ZETA**2 + 1.0) * np.array([1.0, -1.0])
    expected = np.exp(rates * 2.0 * np.pi / OMEGA)
    np.testing.assert_allclose(edge["multipliers"].values, expected, rtol=1e-11)
    # rounding of states of size one, times the multiplier of some 80
    assert edge["residual"].item() < 1e-12
    assert np.all(edge["width"].values <= edge.attrs["wide"])
    assert edge["outcome"].values.tolist() == ["periodic", "periodic"]


def test_the_border_of_a_linear_saddle_is_its_stable_line():
    """Motions on the line stay on the hill, so the segment crosses the border on that line."""
    system = double_well(F=0.0)
    slope = -ZETA - np.sqrt(ZETA**2 + 1.0)
    a, b = np.array([-0.5, 0.2]), np.array([0.4, 0.1])
    edge = ns.edge_state(system, dict(zip("xv", a, strict=True)), dict(zip("xv", b, strict=True)))
    part = (slope * a[0] - a[1]) / ((b - a)[1] - slope * (b - a)[0])
    scaled = edge["width"].values[0] * 4.0  # in states, whose spread is about that of the wells
    assert float(edge["crossing"]) == pytest.approx(part, abs=scaled)
    assert scaled < 1e-8
    assert np.abs(edge["x"].values).max() < 1e-12 and np.abs(edge["v"].values).max() < 1e-12


@pytest.mark.parametrize(
    "starts", [({"x": -1.7}, {"x": 2.3}), ({"x": -1.9, "v": 0.3}, {"x": 1.5, "v": -0.5})]
)
def test_the_distance_says_which_motion_is_nearer_whatever_the_starts(starts):
    """In the wells, 2 to either side, the same linear motion; v differs as much from both."""
    edge = ns.edge_state(double_well(), *starts)
    hill = FORCE / (-1.0 - OMEGA**2 + 2j * ZETA * OMEGA)
    well = FORCE / (1.0 - OMEGA**2 + 2j * ZETA * OMEGA)
    along = np.abs(np.array([-2.0, 2.0]) + (well - hill).real)
    expected = np.hypot(along / along.max(), 1.0)
    np.testing.assert_allclose(edge["distance"].values, expected, atol=1e-9)  # of the cycles


def test_escape_is_an_outcome():
    """Over the hill at x = 2 motions run away to the right without end; beside it is a well."""
    system = ns.System(
        states=["x", "v"],
        parameters={"zeta": ZETA, "omega": OMEGA, "F": FORCE},
        period="2*pi/omega",
        equations={"x": "v", "v": "where(x < 1, -x, x - 2) - 2*zeta*v + F*cos(omega*t)"},
    )
    edge = ns.edge_state(system, {"x": 0.0}, {"x": 2.5, "v": 1.0})
    amplitude = FORCE / (-1.0 - OMEGA**2 + 2j * ZETA * OMEGA)
    assert float(edge["x"].squeeze()) == pytest.approx(2.0 + amplitude.real, abs=1e-12)
    assert float(edge["v"].squeeze()) == pytest.approx((1j * OMEGA * amplitude).real, abs=1e-12)
    assert edge["outcome"].values.tolist() == ["periodic", "ended early"]
    assert np.isnan(edge["distance"].values[1]) and edge["distance"].values[0] > 0.5


# ------------------------------------------------------------- an oscillator that hits a wall

WALL = {"zeta": 0.05, "omega": 1.7, "sigma": 1.5, "r": 0.9}


def flight(x, v, begin, times):
    """Free motion of the oscillator between impacts, in closed form: displacement, velocity."""
    zeta, omega = WALL["zeta"], WALL["omega"]
    gain = 1.0 / (1.0 - omega**2 + 2j * zeta * omega)
    steady = gain * np.exp(1j * omega * np.asarray(times))
    before = gain * np.exp(1j * omega * begin)
    x0, v0 = x - before.real, v - (1j * omega * before).real
    free = np.sqrt(1.0 - zeta**2)
    root_of = complex(-zeta, free)
    c = x0 - 1j * (v0 + zeta * x0) / free
    decay = c * np.exp(root_of * (np.asarray(times) - begin))
    return decay.real + steady.real, (root_of * decay).real + (1j * omega * steady).real


def strobe_by_scipy(state):
    """One period of the oscillator: flights in closed form, impacts by Brent's method."""
    end = 2.0 * np.pi / WALL["omega"]
    x, v, now = *state, 0.0
    while True:
        times = np.linspace(now, end, 4001)
        over = flight(x, v, now, times)[0] - WALL["sigma"]
        hits = np.flatnonzero((over[1:] > 0.0) & (over[:-1] <= 1e-12))
        if not hits.size:
            return np.array(flight(x, v, now, end))
        k = hits[0]

        def gap(t, x=x, v=v, now=now):
            return float(flight(x, v, now, t)[0]) - WALL["sigma"]

        low = times[k] if k or abs(over[0]) > 1e-12 else times[0] + 1e-9
        hit = brentq(gap, low, times[k + 1], xtol=1e-15, rtol=1e-15)
        x, v, now = WALL["sigma"], -WALL["r"] * float(flight(x, v, now, hit)[1]), hit


@pytest.fixture(scope="module")
def struck():
    system = ns.models.impact_oscillator(**WALL)
    found = ns.attractors(system, {"x": (-4.0, 1.5), "v": (-4.0, 4.0)}, samples=60)
    assert found.sizes["attractor"] == 2
    return system, found


def test_the_saddle_between_two_attractors_of_a_wall(struck):
    """The orbit of scipy is exact to some 1e-12 times its multiplier of 1.2."""
    system, found = struck
    edge = ns.edge_state(system, found.sel(attractor=1), found.sel(attractor=2))
    state = np.array([float(edge["x"].squeeze()), float(edge["v"].squeeze())])
    assert edge["kind"].item() == "periodic"
    other = root(lambda s: strobe_by_scipy(s) - s, state + 1e-3, tol=1e-14)
    np.testing.assert_allclose(state, other.x, atol=1e-10)
    steps = 1e-6 * np.eye(2)
    tangent = [(strobe_by_scipy(state + h) - strobe_by_scipy(state - h)) / 2e-6 for h in steps]
    multipliers = np.linalg.eigvals(np.array(tangent).T)
    expected = multipliers[np.argsort(-np.abs(multipliers))]
    np.testing.assert_allclose(edge["multipliers"].values, expected, atol=1e-7)
    orbit = ns.find_orbit(system, edge.isel(point=0))  # solved by legs, not by the strobe map
    np.testing.assert_allclose(state, [float(orbit["x"]), float(orbit["v"])], atol=1e-11)
    points = found["points"].isel(point=0).values
    near = edge["nearest"].values
    np.testing.assert_allclose(near, points, atol=1e-9)


def test_the_saddle_is_on_the_branch_of_unstable_orbits(struck):
    """The branch of the motion with impacts turns at a fold and comes back unstable to omega."""
    system, found = struck
    edge = ns.edge_state(system, found.sel(attractor=2), found.sel(attractor=1))
    hits = [bool(float(found["points"].sel(attractor=k, state="x")[0]) < -2.0) for k in (1, 2)]
    point = found["points"].sel(attractor=1 + hits.index(True)).isel(point=0)
    orbit = ns.find_orbit(system, dict(zip("xv", point.values.tolist(), strict=True)))
    assert orbit["stable"] and np.hypot(*(point.values - edge["nearest"].values).T).min() < 1e-8
    branch = ns.continue_orbit(system, "omega", (1.6, 2.6), initial=orbit, largest_step=0.05)
    values, stable = branch["omega"].values, branch["stable"].values.astype(bool)
    behind = np.flatnonzero(~stable & branch["admissible"].values)
    assert behind.size
    near = behind[np.argmin(np.abs(values[behind] - WALL["omega"]))]
    there = ns.find_orbit(system, branch.isel(point=near), parameters={"omega": WALL["omega"]})
    for name in "xv":
        assert float(edge[name].squeeze()) == pytest.approx(float(there[name]), abs=1e-10)


@pytest.mark.slow
def test_sections_and_several_turns():
    """Circles of radius 1, 2 and 3, the middle one unstable: the multiplier is exp(2 pi g').

    r' = r g(r) with g = -k (r - 1)(r - 2)(r - 3), so that at r = 2 neighbours leave as
    exp(2 k t), and phi' = 1.
    """
    k = 0.03
    grow = f"-{k}*(r - 1)*(r - 2)*(r - 3)"
    system = ns.System(
        states=["x", "y"],
        definitions={"r": "sqrt(x**2 + y**2)", "g": grow},
        equations={"x": "x*g - y", "y": "y*g + x"},
    )
    section = ns.PoincareMap(system, "y")
    edge = ns.edge_state(section, {"x": 0.7}, {"x": 2.9}, record=2000)
    assert edge["kind"].item() == "periodic"
    assert float(edge["x"].squeeze()) == pytest.approx(2.0, abs=1e-11)
    largest = edge["multipliers"].values[0]
    assert largest == pytest.approx(np.exp(2.0 * np.pi * 2.0 * k), rel=1e-9)


def relay():
    """Two modes with the same states: which basin a start is in depends on the mode as well.

    x' = -x + clip(5 (x - c), -1, 1) has a saddle at 5 c/4, and c is 0.2 or -0.2.
    """
    return ns.System(
        name="relay",
        states=["x", "y"],
        period=1.0,
        modes={
            name: ns.Mode({"x": f"-x + clip(5*(x - {c}), -1, 1)", "y": "-y"})
            for name, c in (("up", 0.2), ("down", -0.2))
        },
    )


@pytest.mark.parametrize(("mode", "place"), [("up", 0.25), ("down", -0.25)])
def test_the_mode_of_the_starts_counts(mode, place):
    edge = ns.edge_state(relay(), {"x": -0.9}, {"x": 0.9}, mode=mode)
    assert edge["kind"].item() == "periodic"
    assert float(edge["x"].squeeze()) == pytest.approx(place, abs=1e-13)
    np.testing.assert_allclose(edge["multipliers"].values, np.exp([4.0, -1.0]), rtol=1e-11)


@pytest.mark.slow
def test_a_border_at_which_two_flows_part_has_no_saddle():
    """Where x + y = 0 the flow jumps away to both sides: the track is right, the map is not smooth.

    On it d = x - y comes to (2 cos t + sin t)/5, which is 2/5 at the strobes.
    """
    edge = ns.edge_state(forced_wells(), {"x": -0.5, "y": -0.4}, {"x": 0.6, "y": 0.5}, iterates=40)
    assert edge["kind"].item() == "unresolved" and "no saddle there" in edge.attrs["message"]
    x, y = edge["track"].values[-1]
    assert abs(x + y) < 1e-8
    assert x - y == pytest.approx(0.4, abs=1e-8)
    assert np.isnan(edge["multipliers"].values).all()


@pytest.mark.slow
def test_a_chaotic_set_on_the_border():
    """A tent map drives the border, so both exponents are logarithms of slopes.

    y is tripled next to the border at y = 0, and goes to 1 or -1; x follows the tent map of
    slope 1.9, whose orbits of any period are unstable as well.
    """
    kick = ns.Exit(
        "1 - clock",
        reset={"clock": "clock - 1", "x": "0.95 - 1.9*abs(x - 0.5)", "y": "clip(3*y, -1, 1)"},
        name="kick",
    )
    system = ns.System(
        states=["x", "y", "clock"],
        modes={"hold": ns.Mode({"x": "0", "y": "0", "clock": "1"}, exits=[kick])},
    )
    section = ns.PoincareMap(system, "kick", side="after")
    # the motions on both sides are chaotic too, so `record` says how long they are looked at
    edge = ns.edge_state(
        section, {"x": 0.3, "y": -0.8}, {"x": 0.4, "y": 0.7}, iterates=150, record=1000, cells=16
    )
    assert edge["kind"].item() == "chaotic" and edge["period"].item() == 0
    np.testing.assert_allclose(edge["exponent"].values, np.log([3.0, 1.9]), atol=1e-9)
    assert np.abs(edge["y"].values).max() < 2e-4
    assert edge["outcome"].values.tolist() == ["chaotic", "chaotic"]
    x = edge["x"].values
    assert x.min() >= 0.0 and x.max() <= 0.95 and float(edge["deviation"].sel(state="x")) > 0.1


@pytest.mark.slow
def test_chaos_on_a_fractal_border_shrinks_areas_as_damping_does():
    """The exponents of both directions add up to -2 zeta T, whatever the springs do (Liouville)."""
    system = ns.models.soft_impact(omega=0.8)
    edge = ns.edge_state(system, {"x": -1.2}, {"x": 0.5, "v": 1.0}, iterates=400)
    assert edge["kind"].item() == "chaotic"
    period = 2.0 * np.pi / 0.8
    expected = -2.0 * system.parameter_values["zeta"] * period
    # the frame turns through ten iterates before it counts; a product of two factors has no error
    assert float(edge["exponent"].sum()) == pytest.approx(expected, abs=1e-9)
    assert edge["exponent"].values[0] > 5.0 * edge["exponent_error"].values[0]
    assert sorted(edge["outcome_period"].values.tolist()) == [1, 5]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"start_b": {"x": -2.1}}, "both come to one attractor"),
        ({"narrow": 1e-3}, "narrow = 0.001 and wide = 0.0001"),
        ({"narrow": 1e-20}, "must grow"),
        ({"start_a": {"z": 1.0}}, "start_a: unknown state 'z'"),
        ({"start_a": 3.0}, "start_a = 3.0"),
        ({"points": 0}, "points"),
        ({"mode": "up"}, "mode"),
        ({"completion": {"z": 0.0}}, "unknown state 'z'"),
    ],
)
def test_wrong_use(change, message):
    given = {"start_a": {"x": -1.7}, "start_b": {"x": 2.3}} | change
    with pytest.raises(ns.OptionError, match=message):
        ns.edge_state(double_well(), **given)


def test_several_attractors_at_once_are_refused(struck):
    system, found = struck
    with pytest.raises(ns.OptionError, match=r"start_a: the dataset has several attractors"):
        ns.edge_state(system, found, found.sel(attractor=1))


def test_one_start_per_level_is_plain_bisection():
    """However many run side by side, the saddle is the same, and more of them take fewer levels."""
    many = ns.edge_state(double_well(), {"x": -1.7}, {"x": 2.3})
    one = ns.edge_state(double_well(), {"x": -1.7}, {"x": 2.3}, points=1)
    np.testing.assert_allclose(many["x"], one["x"], atol=1e-13)
    assert one.attrs["levels"] > 3 * many.attrs["levels"]
