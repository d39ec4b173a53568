"""Bounds on the work of a run: it stops where it is told to, keeps what it has, and goes on.

The clock of these tests is counted, one second for each look at it, so that no result depends on
how fast a machine is.
"""

import os
import signal
import warnings
from itertools import count

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.engine import lanes
from nonsmooth.errors import OptionError, RunWarning
from nonsmooth.runs import runner


def wall(**more):
    """An oscillator that hits a wall at x = 0.1 (about ten impacts in eleven periods)."""
    return ns.System(
        states=["x", "v"],
        period="2*pi/2.8",
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "cos(2.8*t) - 0.04*v - x"},
                exits=[ns.Exit("0.1 - x", reset={"v": "-0.8*v"}, name="impact")],
            )
        },
        **more,
    )


def curved():
    """A nonlinear flow with a wall."""
    return ns.System(
        states=["x", "v"],
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "-sin(x) - 0.01*v"},
                exits=[ns.Exit("1 - x", reset={"v": "-0.9*v"}, name="impact")],
            )
        },
    )


def fast():
    """x = cos(1e5 t), with a guard that it never reaches: 6e5 turns in one flight."""
    return ns.System(
        states=["x", "v"],
        period="2*pi",
        modes={"free": ns.Mode({"x": "v", "v": "-1e10*x"}, exits=[ns.Exit("2 - x", to="stop")])},
    )


def softening():
    return ns.System(
        states=["x", "v"],
        period=2.0,
        parameters={"k": 1.0},
        slow={"k": "1 + 0.01*t"},
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "-k*x + cos(pi*t)"},
                exits=[ns.Exit("0.1 - x", reset={"v": "-0.9*v"}, name="impact")],
            )
        },
    )


@pytest.fixture
def counted_clock(monkeypatch):
    """A clock that goes on by a second whenever it is looked at."""
    ticks = count()
    monkeypatch.setattr(runner.time, "monotonic", lambda: float(next(ticks)))


def short_calls(monkeypatch, work):
    """Let calls of the engine pause after so much work."""
    monkeypatch.setattr(lanes, "WORK", work)


def limited(*given, **options):
    with pytest.warns(RunWarning, match="work_limit"):
        return ns.simulate(*given, **options)


def same_ends(part, whole):
    """Whether the end of one run is that of another, bit for bit."""
    return np.array_equal(part["end_state"].values, whole["end_state"].values)


# ---------------------------------------------------------------- where calls pause


@pytest.mark.parametrize("work", [1, 1009, 100_003])
@pytest.mark.parametrize("system", [wall, curved, fast, softening])
def test_where_calls_pause_changes_no_digit(monkeypatch, system, work):
    if system is fast and work < 1000:
        work = 1009  # a call for each of ten thousand looks takes long
    options = {"initial": {"x": 0.0, "v": 0.3}, "t_end": 0.05 if system is fast else 20.0}
    whole = ns.simulate(system(), **options)
    short_calls(monkeypatch, work)
    assert ns.simulate(system(), **options).identical(whole)


def test_derivatives_do_not_depend_on_it_either(monkeypatch):
    options = {"initial": {"x": 0.0, "v": 0.3}, "periods": 5, "tangent": True}
    whole = ns.simulate(wall(), **options)
    short_calls(monkeypatch, 1)
    assert ns.simulate(wall(), **options).identical(whole)


# ---------------------------------------------------------------- number of events


@pytest.mark.parametrize("events", [True, False])
def test_a_run_ends_after_so_many_events(events):
    start = {"x": 0.0, "v": 0.0}
    whole = ns.simulate(wall(), start, periods=30)
    run = limited(wall(), start, periods=30, max_events=7, events=events)
    assert run.attrs["status"] == "work_limit" and run.attrs["n_events"] == 7
    end = float(whole["event_time"][7])
    assert float(run["time"][-1]) <= end
    assert np.array_equal(run["x"], whole["x"][: run.sizes["time"]])
    assert np.array_equal(run["end_state"], whole["state_after"][7])
    if events:
        assert np.array_equal(run["event_time"], whole["event_time"][:8])


def test_it_goes_on_bit_for_bit():
    start = {"x": 0.0, "v": 0.0}
    whole = ns.simulate(wall(), start, periods=30)
    run, times = start, []
    for _ in range(whole.attrs["n_events"] // 5):
        run = limited(wall(), run, t_end=30 * whole.attrs["period"], max_events=5)
        times += run["event_time"].values[1:].tolist()
    run = ns.simulate(wall(), run, t_end=30 * whole.attrs["period"])
    times += run["event_time"].values[1:].tolist()
    assert np.array_equal(times, whole["event_time"].values[1:])
    assert same_ends(run, whole)


def test_as_many_events_as_there_are_are_no_limit():
    whole = ns.simulate(wall(), {"x": 0.0, "v": 0.0}, periods=30)
    number = whole.attrs["n_events"]
    run = ns.simulate(wall(), {"x": 0.0, "v": 0.0}, periods=30, max_events=number + 1)
    assert run.attrs["status"] == "completed" and same_ends(run, whole)


def test_of_slow_parameters():
    start = {"x": 0.0, "v": 0.0}
    whole = ns.simulate(softening(), start, periods=40)
    run = limited(softening(), start, periods=40, max_events=9)
    assert run.attrs["n_events"] == 9
    rest = ns.simulate(softening(), run, t_end=80.0)
    times = [*run["event_time"].values, *rest["event_time"].values[1:]]
    assert np.array_equal(times, whole["event_time"])
    assert same_ends(rest, whole)


# ---------------------------------------------------------------- time of the clock


@pytest.mark.parametrize("system", [wall, curved, softening])
def test_a_run_ends_when_its_time_is_up(monkeypatch, counted_clock, system):
    start = {"x": 0.0, "v": 0.3}
    whole = ns.simulate(system(), start, t_end=60.0)
    with monkeypatch.context() as patch:
        short_calls(patch, 2000)
        run = limited(system(), start, t_end=60.0, max_seconds=5.0)
    kept = run.sizes["time"]
    assert 0 < kept < whole.sizes["time"]
    assert np.array_equal(run["x"], whole["x"][:kept])
    assert np.array_equal(run["event_time"], whole["event_time"][: run.sizes["event"]])
    rest = ns.simulate(system(), run, t_end=60.0)
    assert rest.attrs["status"] == "completed" and same_ends(rest, whole)


def test_within_one_flight(monkeypatch, counted_clock):
    """The search for an impact that never comes is left where it is; samples stay."""
    times = np.linspace(0.0, 6.0, 6001)
    whole = ns.simulate(fast(), {"x": 1.0, "v": 0.0}, times=times)
    with monkeypatch.context() as patch:
        short_calls(patch, 100_000)
        run = limited(fast(), {"x": 1.0, "v": 0.0}, times=times, max_seconds=20.0)
    kept, end = run.sizes["time"], run.attrs["end_phase"]
    assert 1 < kept < 6001 and run.attrs["end_number"] == 0
    assert times[kept - 1] <= end < times[kept]
    # the phase 1e5 t is rounded to some units, t < 6
    rounding = 8 * np.finfo(float).eps * 1e5 * 6
    assert np.abs(run["x"].values - np.cos(1e5 * run["time"].values)).max() < rounding
    assert abs(float(run["end_state"][0]) - np.cos(1e5 * end)) < rounding
    assert np.array_equal(run["x"], whole["x"][:kept])
    rest = ns.simulate(fast(), run, times=times[kept:])
    assert np.array_equal(rest["x"], whole["x"][kept:])


def test_many_samples_of_one_flight_are_left_too(monkeypatch, counted_clock):
    times = np.linspace(0.0, 1.0, 20_001)
    free = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x"})
    with monkeypatch.context() as patch:
        short_calls(patch, 1000)
        run = limited(free, {"x": 1.0, "v": 0.0}, times=times, max_seconds=9.0)
    kept = run.sizes["time"]
    assert 0 < kept < 20_001 and float(run["time"][-1]) == run.attrs["end_phase"]
    assert np.abs(run["x"].values - np.cos(times[:kept])).max() < 1e-15
    rest = ns.simulate(free, run, times=times[kept:])
    assert np.abs(rest["x"].values - np.cos(times[kept:])).max() < 1e-15


def test_a_run_that_goes_on_and_does_not_come_far(monkeypatch, counted_clock):
    """The search is at a place before the start of the run, which stays where it is."""
    first = ns.simulate(fast(), {"x": 1.0, "v": 0.0}, t_end=5.0)
    with monkeypatch.context() as patch:
        short_calls(patch, 1000)
        run = limited(fast(), first, t_end=6.0, max_seconds=2.0)
    assert run["time"].values.tolist() == [5.0]
    assert same_ends(run, first)
    assert same_ends(ns.simulate(fast(), run, t_end=6.0), ns.simulate(fast(), first, t_end=6.0))


def test_control_c_is_answered_by_the_next_call(monkeypatch, interrupts):
    """However long a flight is searched: a call of the engine does a bounded amount of work."""
    calls, original = [], runner.run_some

    def interrupted(*given):
        calls.append(given)
        if len(calls) == 3:
            os.kill(os.getpid(), signal.SIGINT)
        return original(*given)

    monkeypatch.setattr(runner, "run_some", interrupted)
    short_calls(monkeypatch, 100_000)
    with pytest.warns(RunWarning, match="interrupted"):
        run = ns.simulate(fast(), {"x": 1.0, "v": 0.0}, t_end=6.0)
    assert len(calls) == 3 and run.attrs["status"] == "interrupted"
    assert run.sizes["time"] > 0
    monkeypatch.undo()
    rest = ns.simulate(fast(), run, t_end=6.0)
    assert same_ends(rest, ns.simulate(fast(), {"x": 1.0, "v": 0.0}, t_end=6.0))


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("max_seconds", 0.0), ("max_seconds", -1.0), ("max_seconds", np.nan), ("max_seconds", "1"),
        ("max_seconds", 10**400), ("max_events", 0), ("max_events", 1.5), ("max_events", True),
        ("max_events", 10**400),
    ],
)  # fmt: skip
def test_limits_that_make_no_sense(option, value):
    with pytest.raises(OptionError, match=f"^{option} = "):
        ns.simulate(wall(), periods=1, **{option: value})


# ---------------------------------------------------------------- the start is always there


def test_a_run_that_ends_at_once_has_its_start():
    """x' = (1 + x)^1000 is infinite at t = 1/999; whatever its end, it begins at zero."""
    system = ns.System(states=["x"], equations={"x": "(1 + x)**1000"})
    with pytest.warns(RunWarning):
        run = ns.simulate(system, {"x": 0.0}, t_end=1.0)
    assert run.attrs["status"] == "singular"
    assert (float(run["time"][0]), float(run["x"][0])) == (0.0, 0.0)
    assert float(run["time"][-1]) <= 1.0 / 999.0


@pytest.mark.parametrize(
    ("flow", "start", "status"),
    [("-sqrt(x)", 0.0, "singular"), ("1/x", 0.0, "singular"), ("sign(x)", 0.0, "nonunique")],
)
def test_the_start_of_a_run_that_cannot_begin(flow, start, status):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)
        run = ns.simulate(ns.System(states=["x"], equations={"x": flow}), {"x": start}, t_end=1.0)
    assert run.attrs["status"] == status
    assert (run["time"].values.tolist(), run["x"].values.tolist()) == ([0.0], [start])


# ---------------------------------------------------------------- memory


@pytest.mark.slow
def test_a_log_for_which_there_is_no_memory_is_refused_before_the_run_fills_it(monkeypatch):
    """About nine impacts in ten periods, so 9e7 in 1e8; a row takes at least 100 bytes."""
    run = ns.simulate(wall(), periods=1000, samples_per_period=1)
    per_period = run.attrs["n_events"] / 1000
    monkeypatch.setattr("nonsmooth.runs.event_log.free_memory", lambda: 10**9)
    with pytest.raises(OptionError, match=r"log of about .* of memory are free.*events=False") as e:
        ns.simulate(wall(), times=[0.0, 1e8 * 2 * np.pi / 2.8])
    told = float(str(e.value).split("about ")[1].split()[0])
    assert told == pytest.approx(1e8 * per_period, rel=0.1)
    # so many events fit, and none are kept of more; a run that the clock may end is not foreseen
    assert ns.simulate(wall(), periods=1000, samples_per_period=1).attrs["n_events"] > 100
    monkeypatch.setattr("nonsmooth.runs.event_log.free_memory", lambda: 10**5)
    options = {"times": [0.0, 3e5 * 2 * np.pi / 2.8]}
    assert ns.simulate(wall(), events=False, **options).attrs["n_events"] > 10_000
    with pytest.raises(OptionError, match="log of about"):
        ns.simulate(wall(), **options)
    with pytest.warns(RunWarning, match="max_seconds"):
        ns.simulate(wall(), max_seconds=0.3, times=[0.0, 1e12])


@pytest.mark.parametrize("end", [{"periods": 5000}, {"t_end": 11000.0}])
def test_samples_for_which_there_is_no_memory_are_refused(monkeypatch, end):
    monkeypatch.setattr("nonsmooth.runs.options.free_memory", lambda: 10**7)
    with pytest.raises(OptionError, match=r"samples take .* and 10 MB of memory are free; lower"):
        ns.simulate(wall(), **end)
    assert ns.simulate(wall(), samples_per_period=1, **end).attrs["status"] == "completed"
