"""Options that cannot be right are refused as `OptionError`, and right ones do what they say."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Mode, ModelError, OptionError, System

DECAY = System(states=["x"], modes={"m": Mode({"x": "-x"})})
FORCED = System(states=["x"], period="2*pi", modes={"m": Mode({"x": "cos(t)"})})


def options(words):
    return pytest.param(words, id=", ".join(f"{k}={v!r:.30}" for k, v in words.items()) or "none")


@pytest.mark.parametrize(
    "words",
    [
        options({}),
        options({"t_end": 1.0, "times": [1.0]}),
        options({"t_end": 0.0}),
        options({"t_end": -1.0}),
        options({"t_end": np.nan}),
        options({"t_end": np.inf}),
        options({"t_end": 1.0, "t_start": 2.0}),
        options({"t_end": 1.0, "t_start": np.nan}),
        options({"periods": 1}),
        options({"times": []}),
        options({"times": [[0.0, 1.0]]}),
        options({"times": [2.0, 1.0]}),
        options({"times": [-1.0, 1.0]}),
        options({"times": [0.0, np.nan]}),
        options({"times": [0.0, np.inf]}),
        options({"t_end": 1.0, "tolerance": 0.0}),
        options({"t_end": 1.0, "tolerance": -1e-9}),
        options({"t_end": 1.0, "tolerance": 0.1}),
        options({"t_end": 1.0, "tolerance": np.nan}),
        options({"t_end": 1.0, "samples_per_period": 0}),
        options({"t_end": 1.0, "tangent": 1.5}),
        options({"t_end": 1.0, "mode": "n"}),
        options({"t_end": 1e300}),
        options({"t_end": "5"}),
        options({"t_end": 1j}),
        options({"t_end": 1.0, "t_start": "a"}),
        options({"t_end": 1.0, "tolerance": "x"}),
        options({"t_end": 1.0, "mode": 3}),
        options({"t_end": 1.0, "parameters": [1]}),
        options({"times": "abc"}),
        options({"times": [None]}),
    ],
)
def test_without_a_period(words):
    with pytest.raises(OptionError):
        ns.simulate(DECAY, {"x": 1.0}, **words)


@pytest.mark.parametrize(
    "words",
    [
        options({"periods": 0}),
        options({"periods": -2}),
        options({"periods": np.nan}),
        options({"periods": np.inf}),
        options({"periods": 1, "t_end": 5.0}),
        options({"periods": 1, "samples_per_period": 0}),
        options({"periods": 1, "samples_per_period": -3}),
        options({"periods": 1, "samples_per_period": 2.5}),
        options({"periods": 1, "samples_per_period": "7"}),
        options({"periods": "3"}),
        options({"periods": 1e300}),
        options({"periods": 1, "samples_per_period": None}),
        options({"periods": 1, "samples_per_period": np.nan}),
        options({"periods": 1, "samples_per_period": np.inf}),
        options({"periods": 1, "samples_per_period": 10**13}),
    ],
)
def test_with_a_period(words):
    with pytest.raises(OptionError):
        ns.simulate(FORCED, **words)


@pytest.mark.parametrize("system", [None, "moling", 3])
def test_what_is_no_system(system):
    with pytest.raises(OptionError):
        ns.simulate(system, t_end=1.0)


def test_unknown_parameters_are_a_model_error():
    with pytest.raises(ModelError, match=r"unknown parameter 'beta'.*\(known: a, b"):
        ns.simulate(ns.models.moling(), periods=1, parameters={"beta": 1})


def test_messages_hint_at_the_way_out():
    with pytest.raises(OptionError, match="declare period= in the system, or give t_end="):
        ns.simulate(DECAY, periods=3)
    with pytest.raises(OptionError, match="t_end and times are given"):
        ns.simulate(DECAY, t_end=3, times=[1])
    with pytest.raises(OptionError, match="sort it"):
        ns.simulate(DECAY, times=[3, 1])
    with pytest.raises(OptionError, match="runs go forward only"):
        ns.simulate(DECAY, times=[-3, 1])


# ---------------------------------------------------------------- grids


@pytest.mark.parametrize(
    ("periods", "samples"),
    [
        (1, 1),
        (3, 7),
        (2, 1000),
        (1.37, 7),
        (0.01, 7),
        (5.1, 100),
    ],
)
def test_grid_of_periods(periods, samples):
    run = ns.simulate(FORCED, periods=periods, samples_per_period=samples)
    count = int(periods * samples * (1 + 1e-12)) + 1
    assert run.sizes["time"] == count
    # the grid is k T/samples: numbers and phases give it within an ulp of the time
    expected = np.arange(count) * 2 * np.pi / samples
    assert np.allclose(run["time"], expected, rtol=4e-16, atol=0)
    # x = sin t, at most 12 rad: a few ulps of one
    assert np.allclose(run["x"], np.sin(expected), rtol=0, atol=1e-14)


def test_period_numbers_and_phases():
    run = ns.simulate(FORCED, periods=3, samples_per_period=4)
    assert run["period_number"].values.tolist() == [0] * 4 + [1] * 4 + [2] * 4 + [3]
    assert np.allclose(run["phase"], np.resize([0.0, 0.5, 1.0, 1.5], 13) * np.pi, atol=1e-15)
    assert run.attrs["period"] == 2 * np.pi


def test_negative_start():
    run = ns.simulate(FORCED, t_start=-20.0, times=[-20.0, -3.0, 0.0, 4.0])
    # x = sin t - sin(-20)
    expected = np.sin([-20.0, -3.0, 0.0, 4.0]) + np.sin(20.0)
    assert np.allclose(run["x"], expected, rtol=0, atol=1e-14)


def test_times_may_repeat_and_may_be_one():
    run = ns.simulate(DECAY, {"x": 1.0}, times=[0.0, 0.0, 1.0, 1.0, 2.0])
    assert np.array_equal(run["x"][1:], run["x"].values[[0, 2, 2, 4]])
    assert ns.simulate(DECAY, {"x": 1.0}, times=[0.0]).sizes["time"] == 1
    assert float(ns.simulate(DECAY, {"x": 1.0}, times=1.0)["x"][0]) == pytest.approx(np.exp(-1))


def test_without_a_period_1001_times():
    run = ns.simulate(DECAY, {"x": 1.0}, t_end=2.0)
    assert np.allclose(run["time"], np.linspace(0, 2, 1001), rtol=4e-16)
    assert "phase" not in run.coords
