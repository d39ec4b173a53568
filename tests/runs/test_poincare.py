"""Return maps beside closed forms."""

import pickle

import mpmath
import numpy as np
import pytest

import nonsmooth as ns
from runs.balls import bouncing_ball, damped, forced, logistic_ball, rigid_wall


@pytest.mark.parametrize("side", ["before", "after"])
def test_impact_speeds_of_a_ball(side):
    bounce = ns.PoincareMap(bouncing_ball(0.8), "impact", side=side)
    points = bounce.iterate({"u": 1.0}, 4)
    factor = -1.0 if side == "before" else 0.8
    assert points["u"].values == pytest.approx(factor * 0.8 ** np.arange(4), rel=1e-14)
    assert points["time"].values == pytest.approx(2.0 * np.cumsum(0.8 ** np.arange(4)))


def test_the_tangent_of_a_ball():
    """A start at height h with speed u comes down at w = sqrt(u^2 + 2 g h)."""
    system = bouncing_ball(0.8)
    h, u = 0.5, 0.3
    w = np.sqrt(u**2 + 2.0 * h)
    for side, factor in (("before", -1.0), ("after", 0.8)):
        tangent = ns.PoincareMap(system, "impact", side=side).tangent({"h": h, "u": u})
        assert tangent.dims == ("state", "state_0")
        assert tangent.values == pytest.approx(
            factor * np.array([[0.0, 0.0], [1.0 / w, u / w]]), abs=1e-15
        )


def test_the_logistic_map():
    """Impact speeds w of the ball follow a w (1 - w); derivatives of 10 iterates by 30 digits."""
    logistic = ns.PoincareMap(logistic_ball(a=3.9), "impact", side="after")
    with mpmath.workdps(30):
        a = mpmath.mpf(3.9)
        w, slope, expected = mpmath.mpf(0.3), mpmath.mpf(1), []
        for _ in range(10):
            slope *= a * (1 - 2 * w)
            w = a * w * (1 - w)
            expected.append(float(w))
    points = logistic.iterate({"u": 0.3}, 10)
    assert points["u"].values == pytest.approx(expected, rel=1e-12)
    tangent = logistic.tangent({"u": 0.3}, 10)
    assert tangent.sel(state="u", state_0="u").item() == pytest.approx(float(slope), rel=1e-11)


def test_maxima_of_a_damped_oscillation():
    """Each is exp(-zeta T) of the one before, also for starts off the section."""
    zeta = 0.1
    frequency = np.sqrt(1.0 - zeta**2)
    decay = np.exp(-zeta * 2.0 * np.pi / frequency)
    top = ns.PoincareMap(damped(zeta), "v", direction=-1)
    points = top.iterate({"x": 1.0}, 3)  # the start is a maximum and no crossing
    assert points["x"].values == pytest.approx(decay ** np.arange(1, 4), rel=1e-13)
    assert top.tangent({"x": 1.0}, 3).values == pytest.approx(
        np.array([[decay**3, 0.0], [0.0, 0.0]]), abs=1e-14
    )
    assert top.tangent({"x": 0.3, "v": 0.7}).sel(state="v").values == pytest.approx(
        [0.0, 0.0], abs=1e-15
    )


def by_differences(cross, start, t_start, name, states):
    """Derivatives of the next point by one coordinate of the start, to the fourth order."""

    def image(shift):
        begin = {state: value + shift * (state == name) for state, value in start.items()}
        point = cross.iterate(begin, t_start=t_start + shift * (name == "time")).isel(point=0)
        return np.array([point[state].item() for state in states])

    def central(step):
        return (image(step) - image(-step)) / (2.0 * step)

    return (4.0 * central(1e-5) - central(2e-5)) / 3.0


@pytest.mark.parametrize("section", ["v", "x - 0.2*v", "x**2 - v - 0.1"])
def test_tangents_by_differences(section):
    cross = ns.PoincareMap(damped(), section, direction=1)
    start = {"x": 0.9, "v": 0.4}
    tangent = cross.tangent(start)
    for name in ("x", "v"):
        expected = by_differences(cross, start, 0.0, name, ("x", "v"))
        assert tangent.sel(state_0=name).values == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    ("section", "side"), [("impact", "after"), ("v", "before"), ("x + 0.3", "before")]
)
def test_with_forcing_time_is_a_coordinate(section, side):
    """States and time of the next point by states and time of the start."""
    cross = ns.PoincareMap(rigid_wall(), section, side=side)
    start, names = {"x": -0.4, "v": 0.25}, ["x", "v", "time"]
    tangent = cross.tangent(start, t_start=0.7)
    assert tangent["state"].values.tolist() == tangent["state_0"].values.tolist() == names
    for name in names:
        expected = by_differences(cross, start, 0.7, name, names)
        assert tangent.sel(state_0=name).values == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("side", ["before", "after"])
def test_the_multipliers_are_those_of_the_stroboscopic_map(side):
    """Section and strobe cut the same orbit: their eigenvalues agree but for a zero."""
    system = rigid_wall()
    hit = ns.PoincareMap(system, "impact", side=side)
    orbit = hit.iterate({"x": -0.5, "v": 0.3}, 400)
    assert orbit["time"].values[-1] - orbit["time"].values[-2] == pytest.approx(system.period_value)
    tangent = hit.tangent(orbit.isel(point=-1))
    found = np.sort_complex(np.linalg.eigvals(tangent.values))
    settled = ns.stroboscopic_map(system, {"x": -0.5, "v": 0.3}, transient=400, record=1)
    strobe = ns.StroboscopicMap(system).tangent(settled.isel(point=0))
    expected = np.sort_complex(np.append(np.linalg.eigvals(strobe.values), 0.0))
    assert found == pytest.approx(expected, abs=1e-8)
    # and their product is known: the area that an impact and damping leave
    product = 0.8**2 * np.exp(-0.04 * system.period_value)
    assert np.prod(found[np.abs(found) > 1e-6]).real == pytest.approx(product, rel=1e-7)


@pytest.mark.parametrize("section", ["impact", "v"])
@pytest.mark.parametrize("side", ["before", "after"])
def test_the_chain_rule(section, side):
    cross = ns.PoincareMap(rigid_wall(), section, side=side)
    start = {"x": -0.3, "v": 0.4}
    points = cross.iterate(start, 3)
    product = np.eye(3)
    for point in (start, points.isel(point=0), points.isel(point=1)):
        product = cross.tangent(point).values @ product
    assert cross.tangent(start, 3).values == pytest.approx(product, abs=1e-10)


def test_a_power_is_the_map_applied_again():
    once = ns.PoincareMap(rigid_wall(), "impact", side="after")
    start = {"x": -0.3, "v": 0.4}
    six = once.iterate(start, 6)
    cube = (once**3).iterate(start, 2)
    assert np.array_equal(cube["v"], six["v"].values[2::3])
    assert np.array_equal(cube["time"], six["time"].values[2::3])
    assert cube.attrs["n_points"] == 2 and cube.attrs["message"] == "completed"
    assert (once**3) ** 2 == once.power(6)
    assert np.array_equal((once**3).tangent(start, 2), once.tangent(start, 6))


@pytest.mark.parametrize("section", ["impact", "v"])
@pytest.mark.parametrize("side", ["before", "after"])
def test_a_point_goes_on_where_it_was_taken(section, side):
    cross = ns.PoincareMap(rigid_wall(), section, side=side)
    whole = cross.iterate({"x": -0.3, "v": 0.4}, 8)
    rest = cross.iterate(whole.isel(point=3), 4)
    assert rest["time"].values == pytest.approx(whole["time"].values[4:], abs=1e-10)
    assert rest["v"].values == pytest.approx(whole["v"].values[4:], abs=1e-10)


def test_a_system_that_reads_no_time_has_none_among_its_coordinates():
    assert ns.PoincareMap(damped(), "v").tangent({"x": 1.0}).shape == (2, 2)
    assert ns.PoincareMap(forced(), "v").tangent({"x": 1.0}).shape == (3, 3)
    rising = ns.PoincareMap(damped(), "x - 0.01*t")
    assert rising.tangent({"x": -1.0}).shape == (3, 3)


def test_maps_are_values():
    once = ns.PoincareMap(rigid_wall(), "v = 0", direction=-1)
    again = pickle.loads(pickle.dumps(once))
    assert once == again and hash(once) == hash(again)
    assert once != ns.PoincareMap(rigid_wall(), "v = 0")
    assert once.with_parameters(r=0.7).system.parameter_values["r"] == 0.7
    with pytest.raises(AttributeError):
        once.side = "after"


def test_a_section_that_is_never_crossed():
    far = ns.PoincareMap(damped(), "x - 5")
    with pytest.warns(ns.RunWarning, match="nothing crosses section = 'x - 5'"):
        points = far.iterate({"x": 1.0}, 3, t_end=100.0)
    assert points.sizes["point"] == 0
    with pytest.raises(ns.RunError, match="0 of 1 points on section = 'x - 5'") as failed:
        far.tangent({"x": 1.0})
    assert failed.value.status == "time_limit"


def test_a_motion_that_comes_to_rest_has_no_tangent():
    with pytest.raises(ns.RunError, match="impacts accumulate") as failed:
        ns.PoincareMap(bouncing_ball(), "impact").tangent({"u": 1.0}, 100_000)
    assert failed.value.status == "event_limit"


@pytest.mark.parametrize(
    ("section", "options", "message"),
    [
        ("v", {"every": 0}, "every = 0"),
        ("v", {"direction": 2}, "direction = 2"),
        ("v", {"side": "left"}, "side = 'left'"),
        ("impact", {"direction": 1}, "has no direction"),
        ("hit", {}, "unknown variable or event 'hit'"),
        ("x + y", {}, "'y'"),
        ("omega - 1", {}, "does not change along the motion"),
        ("", {}, "give an expression"),
        (3, {}, "give an expression"),
    ],
)
def test_wrong_options(section, options, message):
    with pytest.raises(ns.OptionError, match=message):
        ns.PoincareMap(rigid_wall(), section, **options)


def test_wrong_use():
    cross = ns.PoincareMap(rigid_wall(), "v")
    for power in (0, -1):
        with pytest.raises(ns.OptionError, match="give a whole number of at least 1"):
            cross**power
    with pytest.raises(ns.OptionError, match="count = 0"):
        cross.tangent({}, 0)
    for verb in (cross.iterate, cross.tangent):
        with pytest.raises(ns.OptionError, match="unknown state 'y'"):
            verb({"y": 1.0})
        with pytest.raises(ns.OptionError, match="fits no mode of 'wall'"):
            verb({"x": 1.0})
        with pytest.raises(ns.OptionError, match="unknown mode 'contact'"):
            verb({}, mode="contact")
    slow = ns.System(
        states=["x", "v"], parameters={"k": 1.0}, period="2*pi", slow={"k": "1 + 0.01*t"},
        equations={"x": "v", "v": "cos(t) - k*x"},
    )  # fmt: skip
    with pytest.raises(ns.OptionError, match="varies slowly"):
        ns.PoincareMap(slow, "v")
