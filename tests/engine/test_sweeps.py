"""Motions of a sweep are those that single runs make, however often the engine pauses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.engine import sweeps
from nonsmooth.engine.lanes import ANY
from nonsmooth.engine.status import Status
from nonsmooth.runs import sweep_runner
from nonsmooth.runs.sweep_runner import Recorded, SweepRunner, SweepStarts, Times

_OMEGAS = (0.72, 0.8, 0.86, 0.93)
_TRANSIENT, _RECORDED = 20, 30


def _sweep(system: ns.System, omegas: tuple[float, ...], follows: bool = False) -> Recorded:
    """Motions from rest for some frequencies, strobed once per period."""
    runner = SweepRunner(system, 1e-12)
    values = [list((system.parameter_values | {"omega": omega}).values()) for omega in omegas]
    usable = runner.set_up(np.array(values))
    count = len(omegas)
    starts = SweepStarts(
        np.zeros((count, 2)), np.full(count, ANY), np.zeros(count, np.int64), np.zeros(count)
    )
    numbers = np.tile(np.arange(_TRANSIENT, _TRANSIENT + _RECORDED + 1), (count, 1))
    times = Times(numbers, np.zeros(numbers.shape))
    at_once = Times(np.zeros((count, 1), np.int64), np.zeros((count, 1)))
    motions = runner.start(starts, usable)
    return runner.run(motions, times, follows=at_once if follows else None)


def _same(recorded: Recorded, k: int, run: Any) -> None:
    """Motion k has the samples and the events of a run from the same start, to the last digit."""
    assert recorded.statuses[k] == Status.COMPLETED
    for i, name in enumerate(("x", "v")):
        np.testing.assert_array_equal(recorded.states[k, :, i], run[name].values[_TRANSIENT:])
    own = slice(recorded.logs[k], recorded.logs[k + 1])
    rows = recorded.rows[own]
    since = run["event_time"].values > _TRANSIENT * run.attrs["period"]
    time = rows["number"] * recorded.windows[k] + rows["phase"]
    np.testing.assert_array_equal(time, run["event_time"].values[since])
    after = run["state_after"].values[since]
    np.testing.assert_array_equal(recorded.event_states[own, 1], after)


def _run(system: ns.System, omega: float, start: dict[str, float]) -> Any:
    return ns.simulate(
        system.with_parameters(omega=omega), start,
        periods=_TRANSIENT + _RECORDED, samples_per_period=1,
    )  # fmt: skip


@pytest.mark.parametrize(("work", "room"), [(sweeps.WORK, 4096), (3000, 2), (50_000, 64)])
def test_each_motion_is_a_run(monkeypatch: pytest.MonkeyPatch, work: int, room: int) -> None:
    """Pauses, and logs that have to grow, change no digit."""
    monkeypatch.setattr(sweeps, "WORK", work)
    monkeypatch.setattr(sweep_runner, "_FIRST_EVENTS", room)
    system = ns.models.soft_impact()
    recorded = _sweep(system, _OMEGAS)
    for k, omega in enumerate(_OMEGAS):
        _same(recorded, k, _run(system, omega, {"x": 0.0, "v": 0.0}))


def test_a_motion_that_follows_begins_where_the_last_one_ended() -> None:
    system = ns.models.soft_impact()
    start, recorded = {"x": 0.0, "v": 0.0}, _sweep(system, _OMEGAS, follows=True)
    for k, omega in enumerate(_OMEGAS):
        run = _run(system, omega, start)
        _same(recorded, k, run)
        start = {name: float(run[name][-1]) for name in start}


@pytest.mark.parametrize("first", [(0, 0.1), (1, 0.6), (4, 0.6)])
def test_impacts_accumulate_across_the_first_sample(first: tuple[int, float]) -> None:
    """The ball comes to rest in every period, after impacts of which the sweep logs the last."""
    system = ns.models.bouncing_ball(Gamma=1.2, r=0.5)
    runner = SweepRunner(system, 1e-12)
    runner.set_up(np.array([list(system.parameter_values.values())]))
    window = float(runner.windows[0])
    starts = SweepStarts(
        np.array([[0.5, 0.0]]), np.array([ANY]), np.zeros(1, np.int64), np.zeros(1)
    )
    times = Times(np.array([[first[0], 8]]), np.array([[first[1] * window, 0.0]]))
    recorded = runner.run(runner.start(starts, np.ones(1, bool)), times)
    run = ns.simulate(system, {"y": 0.5, "v": 0.0}, periods=8, samples_per_period=1)
    counts = recorded.rows["count"]
    assert counts.size > 20 and counts.max() > 10
    assert np.array_equal(counts, run["event_count"].values[-counts.size :])


def test_values_without_tables_are_refused_and_not_followed() -> None:
    """omega = 0 has no period; the motion behind it begins anew."""
    system = ns.models.soft_impact()
    recorded = _sweep(system, (0.8, 0.0, 0.86), follows=True)
    assert recorded.statuses[1] == Status.REFUSED
    assert np.isnan(recorded.windows[1]) and np.all(np.isnan(recorded.states[1]))
    assert recorded.logs[1] == recorded.logs[2]
    _same(recorded, 0, _run(system, 0.8, {"x": 0.0, "v": 0.0}))
    _same(recorded, 2, _run(system, 0.86, {"x": 0.0, "v": 0.0}))


def test_a_motion_that_ends_early_says_so() -> None:
    """x'' = 0.12 x grows beyond 1e30 at about t = 200, in the 26th period."""
    system = ns.System(
        name="growing", states=["x", "v"], period="2*pi/omega", parameters={"omega": 0.8},
        modes={"only": ns.Mode({"x": "v", "v": "0.12*x + sin(omega*t)"})},
    )  # fmt: skip
    recorded = _sweep(system, (0.8,))
    assert recorded.statuses[0] == Status.DIVERGED
    assert 4 <= np.isfinite(recorded.states[0, :, 0]).sum() <= 8


@pytest.mark.parametrize("period", [1, 3, 7, 10, 0])
def test_periods_are_the_smallest_numbers_of_steps(period: int) -> None:
    """Points of a known period, a drift beside them, and noise below and above what may differ."""
    steps, match = 21, 1e-6
    turn = 2.0 * np.pi * np.arange(steps)
    never = np.cos(turn * (5.0**0.5 - 1.0) / 2.0)
    wave = np.cos(turn / period) if period else never
    noise = 0.4 * match * never  # differences below what may differ; ten times as much is not
    points = np.stack([wave + noise, 3.0 * np.arange(steps) + 0.3 * wave], axis=1)
    both = np.stack([points, points + np.array([1.0, 0.0]) * 10.0 * noise[:, None]])
    found = sweeps.primitive_periods(both, np.array([False, True]), match)
    assert found.tolist() == [period, 0]


@pytest.mark.parametrize("name", ["moling", "soft_impact", "impact_oscillator"])
def test_motions_with_columns_have_the_digits_of_those_without(name: str) -> None:
    """Those without run in a build of the engine of their own, which knows closed forms only."""
    system = getattr(ns.models, name)()
    values = np.array([list(system.parameter_values.values())], float)
    n = len(system.states)
    numbers = np.arange(10, 60)[np.newaxis]
    found = []
    for carries in (False, True):
        runner = SweepRunner(system, 1e-12)
        usable = runner.set_up(values)
        begin = np.zeros(1, np.int64)
        rest = np.array([[system.open_state[state] for state in system.states]])
        motions = runner.start(SweepStarts(rest, np.full(1, ANY), begin, np.zeros(1)), usable)
        columns = runner.columns(np.eye(n)[np.newaxis], numbers.size) if carries else None
        times = Times(numbers, np.zeros(numbers.shape))
        found.append(runner.run(motions, times, columns=columns))
    assert found[0].statuses[0] == Status.COMPLETED
    assert found[0].rows.size > 0
    for one, other in zip(found[0], found[1], strict=True):
        np.testing.assert_array_equal(one, other)
