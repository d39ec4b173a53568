"""Guesses of orbits from motions: what a run visits in some periods, leg by leg."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine import records as at
from nonsmooth.engine.status import CURES, EventKind, Status
from nonsmooth.errors import OptionError, RunError
from nonsmooth.periodic.equations import Turn
from nonsmooth.periodic.word import Word, path_of_bits
from nonsmooth.simulation.clock import Instant, Plan
from nonsmooth.simulation.runner import NoMode, Outcome, build_tables, run_plan
from nonsmooth.simulation.start import explain_misfit, resolve_start, start_at_end
from nonsmooth.system.system import System

__all__ = ["Guess", "driven_guess", "legs_of_outcome"]

Floats = npt.NDArray[np.float64]


class Guess(NamedTuple):
    """A word with states and instants that nearly close."""

    word: Word
    turn: Turn


def driven_guess(
    system: System,
    initial: object,
    *,
    period: int,
    phase: float,
    transient: int,
    mode: str | None,
    tolerance: float,
) -> Guess:
    """Legs of ``period`` periods of the motion from a start, after a transient.

    Raises `RunError` where the motion ends before, `OptionError` where no mode admits the start.
    """
    tables = build_tables(system)
    window = float(tables.clock[0])
    start = resolve_start(system, tables, initial, None, mode, False)
    if start.anchor is not None:
        start = start_at_end(start)
    late = start.instant.phase > phase * window * (1.0 + 1e-14)
    begin = Instant(start.instant.number + late + transient, phase * window)
    end = Instant(begin.number + period, begin.phase)
    numbers = np.array([begin.number, end.number], np.int64)
    plan = Plan(end, numbers, np.full(2, begin.phase))
    fault: NoMode | None = None
    for number in start.modes:
        try:
            outcome = run_plan(
                tables, plan, tolerance, state=start.state, begin=start.instant, mode=number
            )
            break
        except NoMode as refused:
            fault = refused
    else:
        assert fault is not None
        raise OptionError(explain_misfit(system, tables, start, fault.z))
    if outcome.status != Status.COMPLETED:
        raise RunError(
            f"{system.name}: the motion from which the orbit is guessed ended at"
            f" t = {outcome.end_time:.6g}: {CURES.get(outcome.status, outcome.status.word)}",
            status=outcome.status.word,
            time=outcome.end_time,
        )
    return legs_of_outcome(system, outcome, begin, end)


def legs_of_outcome(system: System, outcome: Outcome, begin: Instant, end: Instant) -> Guess:
    """Legs of a run between two of its samples, the last two; times count from window zero."""
    window = outcome.window
    rows, values = outcome.event_integers, outcome.event_floats
    times = (rows[:, at.NUMBER] - begin.number) * window + (values[:, at.PHASE] - begin.phase)
    inside = (times > 0.0) & (times < (end.number - begin.number) * window)
    inside &= ~np.isin(rows[:, at.KIND], (EventKind.GRAZE, EventKind.START))
    n = len(system.states)
    records = outcome.records
    modes, paths = [int(records.sample_mode[-2])], []
    states = [np.array(records.sample_state[-2])]
    for row, value in zip(rows[inside], values[inside], strict=True):
        path = path_of_bits(int(row[at.PATH]), int(row[at.PASSES]))
        if path is None:
            raise RunError(
                f"{system.name}: more exits are passed at one instant than an orbit can hold",
                status=Status.EVENT_LIMIT.word,
                time=float(value[at.PHASE]),
            )
        paths.append(path)
        modes.append(int(row[at.TO]))
        states.append(value[at.EVENT_FLOATS + n :].copy())
    paths.append(())
    instants = np.concatenate([[0.0], times[inside], [(end.number - begin.number) * window]])
    return Guess(Word(tuple(modes), tuple(paths)), Turn(np.array(states), instants + begin.phase))
