"""Stroboscopic maps beside closed forms."""

import pickle

import numpy as np
import pytest
from scipy.linalg import expm

import nonsmooth as ns
from runs.balls import bouncing_ball, damped, forced, rigid_wall


def exact_image(system, x0, duration, start=0.0):
    """State of the forced linear oscillator, by one matrix exponential with the forcing in it."""
    omega, zeta = (system.parameter_values[name] for name in ("omega", "zeta"))
    a = np.zeros((4, 4))
    a[0, 1] = 1.0
    a[1] = [-1.0, -2.0 * zeta, 1.0, 0.0]
    a[2, 3], a[3, 2] = -omega, omega
    forcing = [np.cos(omega * start), np.sin(omega * start)]
    return (expm(a * duration) @ [*x0, *forcing])[:2]


def states(points):
    return np.column_stack([points["x"].values, points["v"].values])


@pytest.mark.parametrize("phase", [0.0, 0.25])
def test_images_of_a_linear_oscillator(phase):
    system = forced()
    period = system.period_value
    images = ns.StroboscopicMap(system, phase=phase).iterate({"x": 0.4, "v": -1.0}, 3)
    expected = [exact_image(system, [0.4, -1.0], k * period, phase * period) for k in (1, 2, 3)]
    assert states(images) == pytest.approx(np.array(expected), abs=1e-13)
    assert images["time"].values == pytest.approx((phase + np.arange(1, 4)) * period)
    assert images["point"].values.tolist() == [1, 2, 3]


def test_the_tangent_of_a_linear_oscillator_is_a_matrix_exponential():
    system = damped()
    tangent = ns.StroboscopicMap(system, period=1.7).tangent({"x": 3.0}, 2)
    assert tangent.dims == ("state", "state_0")
    expected = expm(np.array([[0.0, 1.0], [-1.0, -0.2]]) * 3.4)
    assert tangent.values == pytest.approx(expected, abs=1e-14)
    assert tangent.sel(state="x", state_0="v").item() == pytest.approx(expected[0, 1])


def test_a_power_is_the_map_applied_again():
    once = ns.StroboscopicMap(rigid_wall())
    start = {"x": -0.3, "v": 0.4}
    six = once.iterate(start, 6)
    for square in (once**2, once.power(2)):
        assert np.array_equal(states(square.iterate(start, 3)), states(six)[1::2])
    assert (once**2) ** 3 == once**6
    assert np.array_equal((once**3).tangent(start, 2), once.tangent(start, 6))


def test_the_chain_rule_through_impacts():
    once = ns.StroboscopicMap(rigid_wall(), phase=0.1)
    start = {"x": -0.3, "v": 0.4}
    images = once.iterate(start, 3)
    product = np.eye(2)
    for point in (start, images.isel(point=0), images.isel(point=1)):
        product = once.tangent(point).values @ product
    assert once.tangent(start, 3).values == pytest.approx(product, rel=1e-10)


def test_an_impact_contracts_areas_by_the_square_of_its_restitution():
    """With n impacts in a time t the determinant is r^2n exp(-2 zeta t)."""
    system = rigid_wall()
    r, zeta = 0.8, 0.02
    once = ns.StroboscopicMap(system)
    start = {"x": -0.3, "v": 0.4}
    count = ns.simulate(system, start, periods=20).attrs["n_events"]
    assert count > 10
    determinant = np.linalg.det(once.tangent(start, 20).values)
    expected = r ** (2 * count) * np.exp(-2.0 * zeta * 20 * system.period_value)
    assert determinant == pytest.approx(expected, rel=1e-9)


def test_the_tangent_is_the_limit_of_differences():
    once = ns.StroboscopicMap(rigid_wall()) ** 2
    tangent = once.tangent({"x": -0.3, "v": 0.4}).values
    step = 1e-5
    for i, name in enumerate(("x", "v")):
        sides = []
        for sign in (1.0, -1.0):
            start = {"x": -0.3, "v": 0.4}
            start[name] += sign * step
            sides.append(states(once.iterate(start))[0])
        difference = (sides[0] - sides[1]) / (2.0 * step)
        assert tangent[:, i] == pytest.approx(difference, abs=1e-7)


def test_a_point_goes_on_where_it_was_taken():
    once = ns.StroboscopicMap(rigid_wall(), phase=0.3)
    whole = once.iterate({"x": -0.3}, 8)
    rest = once.iterate(whole.isel(point=3), 4)
    assert states(rest) == pytest.approx(states(whole)[4:], abs=1e-12)
    assert np.array_equal(rest["time"], whole["time"][4:])


def test_a_point_between_strobes_comes_to_the_next_one():
    system = forced()
    run = ns.simulate(system, {"x": 0.4}, periods=1, samples_per_period=4)
    image = ns.StroboscopicMap(system).iterate(run.isel(time=3))
    assert states(image)[0] == pytest.approx(
        exact_image(system, [0.4, 0.0], system.period_value), abs=1e-13
    )
    twice = (ns.StroboscopicMap(system) ** 2).iterate(run.isel(time=3))
    assert twice["time"].item() == pytest.approx(2 * system.period_value)


def test_another_period_may_be_an_expression_of_parameters():
    system = forced(omega=2.0)
    third = ns.StroboscopicMap(system, period="2*pi/(3*omega)")
    assert third.length == pytest.approx(np.pi / 3)
    assert third.with_parameters(omega=1.0).length == pytest.approx(2 * np.pi / 3)
    image = third.iterate({"x": 0.4}, 2)
    assert states(image)[1] == pytest.approx(
        exact_image(system, [0.4, 0.0], 2 * np.pi / 3), abs=1e-13
    )


def test_the_runner_gives_the_points_of_iterate():
    once = ns.StroboscopicMap(rigid_wall(), phase=0.2, every=2)
    starts = np.array([[-0.3, 0.4], [-0.1, 0.0], [0.5, 0.0]])
    runner = once.runner(1e-12)
    lanes = runner.start(starts)
    first, _ = runner.iterate(lanes, 2)
    second, modes = runner.iterate(lanes, 2)
    found = np.concatenate([first, second], axis=1)
    for i in (0, 1):
        expected = once.iterate(dict(zip(("x", "v"), starts[i], strict=True)), 4)
        assert np.array_equal(found[i], states(expected))
    assert np.all(np.isnan(found[2])) and np.all(modes[2] == -1)  # beyond the wall


def test_maps_are_values():
    once = ns.StroboscopicMap(rigid_wall())
    again = pickle.loads(pickle.dumps(once))
    assert once == again and hash(once) == hash(again)
    assert once != ns.StroboscopicMap(rigid_wall(), phase=0.5)
    assert once.with_parameters(r=0.7).system.parameter_values["r"] == 0.7
    with pytest.raises(AttributeError):
        once.phase = 0.5


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"every": 0}, "every = 0"),
        ({"every": 1.5}, "every = 1.5"),
        ({"phase": 1.0}, "phase = 1"),
        ({"period": -1.0}, "period = -1 must be positive"),
        ({"period": "2*pi/w"}, "'w' is no parameter of 'wall'; known are omega"),
        ({"period": [1.0]}, "period"),
    ],
)
def test_wrong_options(options, message):
    with pytest.raises((ns.OptionError, ns.ModelError), match=message):
        ns.StroboscopicMap(rigid_wall(), **options)


def test_wrong_use():
    with pytest.raises(ns.OptionError, match="'damped' has no period to strobe at"):
        ns.StroboscopicMap(damped())
    with pytest.raises(ns.OptionError, match="is not a System"):
        ns.StroboscopicMap("wall")
    once = ns.StroboscopicMap(rigid_wall())
    for power in (0, -2):
        with pytest.raises(ns.OptionError, match="give a whole number of at least 1"):
            once**power
    with pytest.raises(ns.OptionError, match="count = 0"):
        once.iterate({}, 0)
    with pytest.raises(ns.OptionError, match="unknown state 'y'"):
        once.tangent({"y": 1.0})
    with pytest.raises(ns.OptionError, match="fits no mode"):
        once.iterate({"x": 1.0})
    with pytest.raises(ns.ModelError, match="unknown parameter 'q'"):
        once.with_parameters(q=1.0)


def test_a_motion_that_ends_has_no_tangent():
    """Impacts of a ball accumulate."""
    rest = ns.StroboscopicMap(bouncing_ball(), period=0.7)
    with pytest.raises(ns.RunError, match="impacts accumulate") as failed:
        rest.tangent({"u": 1.0}, 30)
    assert failed.value.status == "event_limit"
    with pytest.warns(ns.RunWarning, match="event_limit"):
        points = rest.iterate({"u": 1.0}, 30)
    assert points.sizes["point"] == 14  # the flights last 2 (1 + 0.8 + ...) = 10


def test_exponents_of_a_map():
    """Iterates take the place of periods; exponents stay those per unit time."""
    system = rigid_wall(omega=3.2)
    options = {"transient": 20, "seed": 3}
    plain = ns.lyapunov_spectrum(system, {"x": -0.5}, record=60, **options | {"transient": 60})
    cube = ns.StroboscopicMap(system) ** 3
    found = ns.lyapunov_spectrum(cube, {"x": -0.5}, record=20, **options)
    assert found.attrs["duration"] == pytest.approx(60 * system.period_value)
    assert found.sizes["time"] == 20
    name = "lyapunov_exponent"
    assert found[name].values == pytest.approx(plain[name].values, abs=1e-9)
    free = ns.StroboscopicMap(damped(0.1), period=1.7)
    spectrum = ns.lyapunov_spectrum(free, {"x": 1.0}, transient=100, record=300)
    assert spectrum[name].values == pytest.approx([-0.1, -0.1], abs=1e-2)
    assert spectrum["exponent_sum"].item() == pytest.approx(-0.2, abs=1e-9)
    with pytest.raises(ns.OptionError, match="give the system of the map"):
        ns.lyapunov_spectrum(ns.PoincareMap(system, "v"))
