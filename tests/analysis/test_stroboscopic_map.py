import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import ModelError, OptionError, System


def forced(**words):
    return System(
        states=["x", "v"],
        parameters={"w": 0.7, "u": 1.9},
        equations={"x": "v", "v": "-x - 0.2*v + cos(w*t)"},
        **words,
    )


def steady(t):
    transfer = 1.0 / (1.0 - 0.49 + 0.14j)
    return (transfer * np.exp(0.7j * t)).real


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.9])
def test_strobes_of_a_settled_oscillation(phase):
    points = ns.stroboscopic_map(
        forced(period="2*pi/w"), {"x": 1.0}, transient=60, record=7, phase=phase
    )
    assert points.sizes["point"] == 7
    period = 2 * np.pi / 0.7
    assert points["time"].values == pytest.approx((60 + phase + np.arange(7)) * period, rel=1e-14)
    assert points["x"].values == pytest.approx(np.full(7, steady(phase * period)), abs=1e-11)


def test_strobes_of_another_length():
    """Strobed at another frequency, the steady state is seen at phases of its own."""
    for length in (2 * np.pi / 1.9, "2*pi/u"):
        points = ns.stroboscopic_map(forced(), transient=150, record=20, period=length)
        assert points["x"].values == pytest.approx(steady(points["time"].values), abs=1e-11)
        assert np.diff(points["time"].values) == pytest.approx(2 * np.pi / 1.9, rel=1e-12)


def test_the_points_are_those_of_the_run():
    model = ns.models.soft_impact()
    run = ns.simulate(model, {"x": 0.2}, periods=30, samples_per_period=1)
    points = ns.stroboscopic_map(model, {"x": 0.2}, transient=10, record=21)
    for name in (*model.states, *model.outputs, "mode"):
        assert np.array_equal(points[name].values, run[name].values[10:])


def test_a_start_after_the_phase_begins_with_the_next_period():
    points = ns.stroboscopic_map(forced(period="2*pi/w"), t_start=5.0, record=2, phase=0.25)
    period = 2 * np.pi / 0.7
    assert points["time"].values == pytest.approx([1.25 * period, 2.25 * period])


def test_a_run_that_ends_leaves_its_points():
    grow = System(states=["x"], period="1", equations={"x": "x**2"})
    with pytest.warns(ns.RunWarning, match="singular"):
        points = ns.stroboscopic_map(grow, {"x": 0.3}, record=10)
    assert points.attrs["status"] == "singular"
    assert points["x"].values == pytest.approx([0.3 / (1 - 0.3 * t) for t in range(4)])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "has no period"),
        ({"period": -1.0}, "must be positive"),
        ({"period": "2*pi/q"}, "'q'"),
        ({"period": 1.0, "phase": 1.5}, "phase = 1.5"),
        ({"period": 1.0, "record": 0}, "record"),
        ({"period": 1.0, "transient": -3}, "transient"),
    ],
)
def test_wrong_use(options, message):
    with pytest.raises((OptionError, ModelError), match=message):
        ns.stroboscopic_map(forced(), **options)
