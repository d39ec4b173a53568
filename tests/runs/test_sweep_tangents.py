"""Columns of a group of motions: those of each alone, and of the variational equations by scipy."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.analysis.exponents.growth import Growth, begin_columns
from nonsmooth.engine import sweeps
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.crew import Stopped
from nonsmooth.runs.first_mode import in_first_mode
from nonsmooth.runs.runner import build_derivatives, build_tables
from nonsmooth.runs.start import resolve_start
from nonsmooth.runs.sweep_runner import SweepRunner, SweepStarts, Times
from nonsmooth.runs.sweep_tangents import SweepTangents
from nonsmooth.runs.tangent_flow import TangentFlow

_TOLERANCE = 1e-12
_SEED = 3

# closed forms, series, impacts that wipe out nothing, a drift, and sticking, which wipes out one
_GROUPS = [
    (ns.models.soft_impact(zeta=0.03), "omega", (0.72, 0.8, 0.905)),
    (ns.models.duffing(), "gamma", (0.25, 0.4, 0.5)),
    (ns.models.impact_oscillator(), "omega", (2.0, 2.7, 3.1)),
    (ns.models.moling(), "a", (0.3, 0.6, 0.9)),
    (ns.models.friction_oscillator(), "f", (0.1, 0.3, 0.6)),
]
_NAMES = [system.name for system, _, _ in _GROUPS]


class _Alone:
    """One motion with its columns, by the runs that carry one motion."""

    def __init__(self, system: ns.System) -> None:
        tables = build_tables(system)
        start = resolve_start(system, tables, None, None, None)
        derivatives = build_derivatives(system, tables, ())
        n = len(system.states)

        def begin(mode: int) -> TangentFlow:
            flow = TangentFlow(tables, derivatives, n, _TOLERANCE)
            assert flow.start(start.state, start.instant, mode) == Status.COMPLETED
            self.mode = flow.mode
            return flow

        self.flow = in_first_mode(system, tables, start, begin)
        self.state = start.state
        self.flow.set_columns(self.flow.first_columns)


def _group(
    system: ns.System, name: str, values: tuple[float, ...]
) -> tuple[list[_Alone], SweepTangents]:
    """Motions at some values of a parameter, one by one and as a group."""
    systems = [system.with_parameters(**{name: value}) for value in values]
    alone = [_Alone(each) for each in systems]
    runner = SweepRunner(system, _TOLERANCE)
    rows = np.array([list(each.parameter_values.values()) for each in systems])
    assert np.all(runner.set_up(rows))
    zero = np.zeros(len(values), np.int64)
    starts = SweepStarts(
        np.array([each.state for each in alone]),
        np.array([each.mode for each in alone]),
        zero, zero.astype(float),
    )  # fmt: skip
    return alone, SweepTangents(runner, starts, np.ones(len(values), bool))


def _times(count: int, last: int) -> Times:
    numbers = np.tile(np.arange(1, last + 1), (count, 1))
    return Times(numbers, np.zeros(numbers.shape))


@pytest.mark.parametrize(("system", "name", "values"), _GROUPS, ids=_NAMES)
@pytest.mark.parametrize("work", [sweeps.WORK, 20_000])
def test_columns_of_a_group_are_those_of_each_motion(monkeypatch, system, name, values, work):
    """To the last digit, however often the engine pauses."""
    monkeypatch.setattr(sweeps, "WORK", work)
    alone, group = _group(system, name, values)
    times = _times(len(values), 4)
    found, _ = group.run(times, group.columns)
    for k, each in enumerate(alone):
        for number, columns in zip(times.numbers[k].tolist(), found[k], strict=True):
            assert each.flow.run_to(Instant(number, 0.0)) == Status.COMPLETED
            np.testing.assert_array_equal(columns, each.flow.columns_at_end)
        assert group.statuses[k] == Status.COMPLETED


@pytest.mark.parametrize(("system", "name", "values"), _GROUPS, ids=_NAMES)
def test_growth_of_a_group_is_that_of_each_motion(system, name, values):
    """With as many columns as states, in two goes; a column that is lost has no growth."""
    alone, group = _group(system, name, values)
    n = len(system.states)
    begun = begin_columns(group.columns, n, np.random.default_rng(_SEED))
    times = _times(len(values), 30)
    _, first = group.run(times.at(slice(0, 17)), *begun)
    _, second = group.run(times.at(slice(17, None)), group.columns, group.growth)
    found = np.concatenate([first, second], axis=1)
    for k, each in enumerate(alone):
        growth = Growth(each.flow, n, _SEED)
        status, rows = growth.through([Instant(number, 0.0) for number in range(1, 31)])
        assert status == group.statuses[k] == Status.COMPLETED
        np.testing.assert_array_equal(found[k], rows)
        np.testing.assert_array_equal(group.growth[k], growth.at_anchor)


@pytest.mark.parametrize("together", [1, 7, 40, 1000])
@pytest.mark.parametrize("work", [sweeps.WORK, 20_000])
def test_a_column_that_is_divided_grows_as_an_orthonormal_one(monkeypatch, together, work):
    """However often it is divided by its size, and however often the engine pauses."""
    monkeypatch.setattr(sweeps, "WORK", work)
    system, name, values = _GROUPS[0]
    alone, group = _group(system, name, values)
    columns, _ = begin_columns(group.columns, 1, np.random.default_rng(_SEED))
    sizes = np.ones((len(values), -(-120 // together)))
    division = sweeps.Division(sizes, np.zeros(2, bool), together)
    found, _ = group.run(_times(len(values), 120), columns, division=division)
    divided = np.zeros(sizes.shape)
    divided[:, 1:] = np.cumsum(np.log(sizes), axis=1)[:, :-1]
    lengths = np.log(np.linalg.norm(found[:, :, 0], axis=2))
    lengths += np.repeat(divided, together, axis=1)[:, :120]
    for k, each in enumerate(alone):
        growth = Growth(each.flow, 1, _SEED)
        _, rows = growth.through([Instant(number, 0.0) for number in range(1, 121)])
        # some hundred segments, each of which rounds a column of length one by some 1e-16
        np.testing.assert_allclose(lengths[k], rows[:, 0], atol=1e-11)


def test_columns_solve_the_variational_equations():
    """Of Duffing's equation at three amplitudes, by DOP853 at 1e-12, over two periods."""
    values = (0.25, 0.4, 0.5)
    _, group = _group(ns.models.duffing(), "gamma", values)
    found, _ = group.run(_times(3, 2), group.columns)

    def rates(t, y, gamma):
        x, v, flow = y[0], y[1], y[2:].reshape(2, 2)
        slope = np.array([[0.0, 1.0], [1.0 - 3.0 * x * x, -0.3]])
        own = [v, gamma * np.cos(1.2 * t) - 0.3 * v + x - x**3]
        return np.concatenate([own, (slope @ flow).ravel()])

    begin = np.concatenate([np.zeros(2), np.eye(2).ravel()])
    for k, gamma in enumerate(values):
        run = solve_ivp(
            rates, (0.0, 4.0 * np.pi / 1.2), begin, method="DOP853", args=(gamma,),
            rtol=1e-12, atol=1e-12,
        )  # fmt: skip
        # columns grow to some ten times their size, and so do the errors of both
        np.testing.assert_allclose(found[k, -1].T, run.y[2:, -1].reshape(2, 2), atol=1e-9)


def test_a_motion_that_no_mode_takes_is_told_and_the_others_go_on():
    """The soft impact oscillator is free below x = 1, and the second start lies above."""
    system = ns.models.soft_impact()
    free = system.mode_names.index("free") if "free" in system.mode_names else 0
    runner = SweepRunner(system, _TOLERANCE)
    runner.set_up(np.tile(list(system.parameter_values.values()), (3, 1)))
    starts = SweepStarts(
        np.array([[0.0, 0.0], [5.0, 0.0], [0.1, 0.0]]), np.full(3, free), np.zeros(3, np.int64),
        np.zeros(3),
    )  # fmt: skip
    group = SweepTangents(runner, starts, np.array([True, True, False]))
    assert group.has_mode.tolist()[:2] == [True, False]
    assert group.goes_on.tolist() == [True, False, False]
    np.testing.assert_array_equal(group.columns[0], np.eye(2))


class _SoonSet(threading.Event):
    """A stop that comes after so many looks at it."""

    def __init__(self, looks: int) -> None:
        super().__init__()
        self.looks = looks

    def is_set(self) -> bool:
        self.looks -= 1
        return self.looks < 0


def test_a_stop_is_seen_at_every_pause_of_the_engine(monkeypatch):
    """A tenth of a second of work lies between two looks; here it is far less."""
    monkeypatch.setattr(sweeps, "WORK", 20_000)
    system, stop = ns.models.soft_impact(), _SoonSet(20)
    runner = SweepRunner(system, _TOLERANCE)
    runner.set_up(np.array([list(system.parameter_values.values())]))
    zero = np.zeros(1, np.int64)
    starts = SweepStarts(np.zeros((1, 2)), zero, zero, np.zeros(1))
    group = SweepTangents(runner, starts, np.ones(1, bool), stop)
    with pytest.raises(Stopped):
        group.run(_times(1, 100_000), group.columns)
    assert stop.looks < 0


def test_directions_that_the_start_has_wiped_out_are_lost():
    """Ranks of what is left, by hand: three of three states, one of them, none, and two."""
    first = np.array(
        [
            np.eye(3),
            np.diag([1.0, 0.0, 0.0]),
            np.zeros((3, 3)),
            np.array([[1.0, 1.0, 0.0], [2.0, 2.0, 0.0], [0.0, 0.0, 4.0]]),
        ]
    )
    for count, left in ((1, (1, 1, 0, 1)), (2, (2, 1, 0, 2)), (3, (3, 1, 0, 2))):
        columns, growth = begin_columns(first, count, np.random.default_rng(_SEED))
        assert tuple(np.count_nonzero(growth == 0.0, axis=1)) == left
        for k in range(len(first)):
            kept = growth[k] == 0.0
            assert np.all(np.isneginf(growth[k, ~kept])) and np.all(columns[k, ~kept] == 0.0)
            gram = columns[k, kept] @ columns[k, kept].T
            np.testing.assert_allclose(gram, np.eye(left[k]), atol=1e-14)
            # they lie in what the rows of the derivatives span
            span = np.linalg.pinv(first[k]) @ first[k]
            np.testing.assert_allclose(columns[k] @ span, columns[k], atol=1e-14)
