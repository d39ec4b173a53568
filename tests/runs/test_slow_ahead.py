"""Slow parameters in many periods at once: the same digits as period by period."""

import os
import signal
import warnings

import numpy as np
import pytest
from mpmath import mp, mpf

import nonsmooth as ns
from effort import each_call_of_ours
from nonsmooth.engine.lanes import run_lanes
from nonsmooth.runs import slow
from nonsmooth.system.slow import SlowParameters


def wall(text="0.5 - 0.1*sin(0.001*t)", **words):
    """A mass before a wall that moves from period to period."""
    given = {
        "states": ["x", "v"], "period": "2*pi/omega",
        "parameters": {"omega": 2.0, "wall": 0.5, "r": 0.8, "zeta": 0.02, "F": 2.0},
        "slow": {"wall": text}, "outputs": {"gap": "wall - x"},
        "modes": {"free": ns.Mode({"x": "v", "v": "-x - 2*zeta*v + F*cos(omega*t)"}, [
            ns.Exit("wall - x", reset={"v": "-r*v"}, name="impact")])},
    }  # fmt: skip
    return ns.System(**(given | words))


def one_by_one(monkeypatch, system, **options):
    with monkeypatch.context() as patch:
        patch.setattr(SlowParameters, "changes_clock", True)
        return ns.simulate(system, **options)


OPTIONS = {
    "periods": {"periods": 40},
    "part of a period": {"periods": 33.3, "samples_per_period": 7},
    "strobes of a late start": {"t_start": 5.0, "periods": 2500, "samples_per_period": 1},
    "end": {"t_end": 100.0},
    "times": {"times": np.sort(np.random.default_rng(1).uniform(0.0, 150.0, 200))},
    "times at strobes": {"times": np.pi * np.arange(50)},
    "a sample after many periods": {"times": [3.0, 2000.0]},
    "no events": {"periods": 3000, "samples_per_period": 1, "events": False},
}


@pytest.mark.few(1)
@pytest.mark.parametrize("name", OPTIONS)
def test_the_same_digits_as_period_by_period(monkeypatch, name):
    ahead = ns.simulate(wall(), **OPTIONS[name])
    single = one_by_one(monkeypatch, wall(), **OPTIONS[name])
    assert ahead.attrs["status"] == "completed"
    assert ahead.identical(single)


@pytest.mark.slow
def test_each_period_has_the_value_of_its_beginning():
    """The strobe map of a linear oscillator with a force that grows, to 30 digits."""
    system = ns.System(
        states=["x", "v"], period="2*pi/omega",
        parameters={"omega": 1.7, "F": 1.0}, slow={"F": "1 + t/100"},
        equations={"x": "v", "v": "-x - v/10 + F*cos(omega*t)"},
    )  # fmt: skip
    run = ns.simulate(system, periods=3000, samples_per_period=1)
    with mp.workdps(30):
        w, c = mpf(1.7), mpf(0.1)
        length = 2 * mp.pi / w
        root = mp.mpc(-c / 2, mp.sqrt(1 - c * c / 4))
        gain = 1 / (1 - w * w + 1j * w * c)
        turn, x, v = mp.exp(root * length), mpf(0), mpf(0)
        for k in range(3000):
            steady = (1 + k * length / 100) * gain
            dx, dv = x - mp.re(steady), v - mp.re(1j * w * steady)
            free = mp.mpc(dx, (dx * mp.re(root) - dv) / mp.im(root)) * turn
            x, v = mp.re(free + steady), mp.re(free * root + 1j * w * steady)
            error = max(abs(x - mpf(float(run["x"][k + 1]))), abs(v - mpf(float(run["v"][k + 1]))))
            # the force is known to some ulps of a time that is a sum of k periods
            assert error < mpf(1e-13) * (1 + k * length / 100)


def test_a_long_run_is_not_taken_for_impacts_that_accumulate():
    run = ns.simulate(wall(), periods=12_000, samples_per_period=1, events=False)
    assert run.attrs["status"] == "completed" and run.attrs["n_events"] > 10_000


def test_a_value_that_is_refused_ends_the_run_where_it_comes(monkeypatch):
    system = wall("0.5 - 0.001*t", require={"wall > 0.1": "the wall must stay off"})
    with pytest.warns(ns.RunWarning, match="the wall must stay off"):
        run = ns.simulate(system, periods=500, samples_per_period=1)
    with pytest.warns(ns.RunWarning, match="the wall must stay off"):
        single = one_by_one(monkeypatch, system, periods=500, samples_per_period=1)
    assert run.attrs["status"] == "refused" and run.identical(single)
    # the first period that begins with 0.001 k pi >= 0.4
    assert run.sizes["time"] == int(np.ceil(400.0 / np.pi)) + 1


def test_an_interrupted_run_keeps_what_it_has_and_goes_on(monkeypatch):
    whole = ns.simulate(wall(), periods=300, samples_per_period=3)
    calls = []

    def impatient(*given):
        calls.append(given)
        done = run_lanes(*given)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return done

    with monkeypatch.context() as patch:
        patch.setattr(slow, "_AHEAD", 40)
        patch.setattr(slow, "run_lanes", impatient)
        with pytest.warns(ns.RunWarning, match="interrupted"):
            first = ns.simulate(wall(), periods=300, samples_per_period=3)
    assert first.attrs["status"] == "interrupted"
    # each time one period alone and 40 at once
    assert first.sizes["time"] == 1 + 3 * 4 * 41
    assert np.array_equal(first["x"], whole["x"][: first.sizes["time"]])
    rest = ns.simulate(wall(), first.isel(time=-1), t_end=whole.attrs["end_time"])
    # a point is a start of its own, with the time as one number
    assert np.allclose(rest["end_state"], whole["end_state"], atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("slow", [True, False])
def test_control_c_at_any_time_keeps_what_was_computed(slow, interrupts):
    """A signal at calls of functions that nothing in the run is tuned to."""
    system, options = (
        wall() if slow else wall(slow={}),
        {"periods": 12_000, "samples_per_period": 1},
    )
    calls, seen, moment = [], set(), 0

    def press(frame):
        calls.append(frame)
        if len(calls) == moment:
            os.kill(os.getpid(), signal.SIGINT)

    with each_call_of_ours(press):
        whole = ns.simulate(system, **options)
    for moment in np.linspace(1, len(calls), 15).astype(int):  # noqa: B007 - `press` looks at it
        calls.clear()
        try:
            with warnings.catch_warnings(), each_call_of_ours(press):
                warnings.simplefilter("ignore", ns.RunWarning)
                run = ns.simulate(system, **options)
        except KeyboardInterrupt:  # before the run or after it
            continue
        seen.add(run.attrs["status"])
        count = run.sizes["time"]
        assert np.array_equal(run["x"], whole["x"][:count])
        assert count == 12_001 or run.attrs["status"] == "interrupted"
        if count > 0:  # else it came before the first call of the engine
            assert float(run["time"][-1]) <= run.attrs.get("end_time", np.inf)
            assert float(run["event_time"][-1]) <= float(run["time"][-1]) + np.pi
    assert "interrupted" in seen


def test_control_c_in_the_last_call_keeps_the_run(monkeypatch, interrupts):
    """A run of one call: its results are there when the signal is looked at."""
    from nonsmooth.runs import runner

    system, original = wall(slow={}), runner.run_some
    whole = ns.simulate(system, periods=50)

    def interrupted(*given):
        os.kill(os.getpid(), signal.SIGINT)
        return original(*given)

    monkeypatch.setattr(runner, "run_some", interrupted)
    with pytest.warns(ns.RunWarning, match="interrupted"):
        run = ns.simulate(system, periods=50)
    assert run.attrs["status"] == "interrupted"
    assert np.array_equal(run["x"], whole["x"]) and np.array_equal(run["time"], whole["time"])


def test_the_number_of_periods_in_a_call_changes_no_digit(monkeypatch):
    whole = ns.simulate(wall(), periods=200, samples_per_period=3)
    for count in (1, 7, 64):
        with monkeypatch.context() as patch:
            patch.setattr(slow, "_AHEAD", count)
            assert ns.simulate(wall(), periods=200, samples_per_period=3).identical(whole)
    with monkeypatch.context() as patch:
        patch.setattr(slow, "_TOGETHER", 1)  # no memory for more than one
        assert ns.simulate(wall(), periods=200, samples_per_period=3).identical(whole)


@pytest.mark.parametrize("slow", [True, False])
def test_samples_are_found_by_the_times_asked_for(slow):
    system = wall() if slow else wall(slow={})
    times = np.sort(np.random.default_rng(2).uniform(0.0, 2000.0, 300))
    run = ns.simulate(system, times=times)
    assert np.array_equal(run["time"], times)
    assert run.sel(time=times[[3, 200]]).sizes["time"] == 2
    again = ns.simulate(system, times=times[:200])
    assert np.array_equal(again["x"], run["x"][:200])
