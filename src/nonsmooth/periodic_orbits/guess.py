"""Guesses of orbits from motions: what a run visits in some periods, leg by leg."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import CURES, EventKind, Status
from nonsmooth.engine.tables import Tables
from nonsmooth.errors import OptionError, RunError
from nonsmooth.periodic_orbits.equations import Turn
from nonsmooth.periodic_orbits.word import Word, path_of_bits
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.first_mode import in_first_mode
from nonsmooth.runs.runner import Outcome, build_tables, run_plan
from nonsmooth.runs.start import Start, resolve_start, start_at_end
from nonsmooth.system.system import System

__all__ = ["Guess", "driven_guess", "legs_of_outcome", "run_for_guess", "strobe_of_start"]

Floats = npt.NDArray[np.float64]

_LATER = 20  # stretches of a motion that are tried


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

    Where they end in another mode than they begin in, a stretch some periods later is taken.
    Raises `RunError` where the motion ends before, `OptionError` where no mode admits the start.
    """
    for later in range(_LATER):
        guess = _stretch(system, initial, period, phase, transient + later, mode, tolerance)
        closed = _closed(guess)
        if closed is None and transient + later == 0:
            closed = _from_last_cell(system, initial, period, phase, tolerance, guess)
        if closed is not None:
            return closed
    raise RunError(
        f"{system.name}: at phase {phase:g} the motion is in another mode than {period} periods"
        f" before, {_LATER} times in a row, so no orbit of period {period} is near it; give another"
        " period=, or transient= for a motion that has settled",
        status="no_orbit",
    )


def _from_last_cell(
    system: System, initial: object, period: int, phase: float, tolerance: float, guess: Guess
) -> Guess | None:
    """The same stretch begun in the cell in which it ends, if the start lies there too.

    What has decayed lies on a border of cells, and in any of them.
    """
    running = system.structure.running
    first, last = (running[guess.word.modes[k]] for k in (0, -1))
    if first.parent != last.parent:
        return None
    try:
        return _closed(_stretch(system, initial, period, phase, 0, last.name, tolerance))
    except (OptionError, RunError):
        return None


def strobe_of_start(
    system: System, initial: object, *, phase: float, transient: int, mode: str | None,
    tolerance: float,
) -> Floats:  # fmt: skip
    """State at the section to which a start comes first, after a transient."""
    return _stretch(system, initial, 1, phase, transient, mode, tolerance).turn.states[0]


def _stretch(
    system: System, initial: object, period: int, phase: float, transient: int, mode: str | None,
    tolerance: float,
) -> Guess:  # fmt: skip
    """Legs of a motion, wherever they end."""
    tables = build_tables(system)
    window = tables.window
    start = resolve_start(system, tables, initial, None, mode, True)
    if start.anchor is not None:
        start = start_at_end(start)
    late = start.instant.phase > phase * window * (1.0 + 1e-14)
    begin = Instant(start.instant.number + late + transient, phase * window)
    end = Instant(begin.number + period, begin.phase)
    numbers = np.array([begin.number, end.number], np.int64)
    plan = Plan(end, numbers, np.full(2, begin.phase))
    outcome = run_for_guess(system, tables, start, plan, tolerance)
    return legs_of_outcome(system, outcome, begin, end)


def run_for_guess(
    system: System, tables: Tables, start: Start, plan: Plan, tolerance: float
) -> Outcome:
    """The motion from a start, in the first mode that admits it; `RunError` where it ends early."""

    def run(mode: int) -> Outcome:
        return run_plan(tables, plan, tolerance, state=start.state, begin=start.instant, mode=mode)

    outcome = in_first_mode(system, tables, start, run)
    if outcome.status != Status.COMPLETED:
        raise RunError(
            f"{system.name}: the motion from which the orbit is guessed ended at"
            f" t = {outcome.end_time:.6g}: {CURES.get(outcome.status, outcome.status.word)}",
            status=outcome.status.word,
            time=outcome.end_time,
        )
    return outcome


def _closed(guess: Guess) -> Guess | None:
    """A guess that ends in the mode in which it begins, an event next to the section left out."""
    word, turn = guess
    if word.modes[0] == word.modes[-1]:
        return guess
    found = []
    if word.modes[-2] == word.modes[0]:
        paths = (*word.paths[:-2], ())
        instants = np.delete(turn.instants, -2)
        new = Guess(Word(word.modes[:-1], paths), Turn(turn.states[:-1], instants))
        found.append((float(turn.durations[-1]), new))
    if word.modes[1] == word.modes[-1]:
        instants = np.delete(turn.instants, 1)
        new = Guess(Word(word.modes[1:], word.paths[1:]), Turn(turn.states[1:], instants))
        found.append((float(turn.durations[0]), new))
    return min(found, key=lambda pair: pair[0])[1] if found else None


def legs_of_outcome(system: System, outcome: Outcome, begin: Instant, end: Instant) -> Guess:
    """Legs of a run between two of its samples, the last two; times count from window zero."""
    window = outcome.window
    rows, after = outcome.events, outcome.event_states[:, 1]
    times = (rows["number"] - begin.number) * window + (rows["phase"] - begin.phase)
    inside = (times > 0.0) & (times < (end.number - begin.number) * window)
    inside &= ~np.isin(rows["kind"], (EventKind.GRAZE, EventKind.START))
    records = outcome.records
    modes, paths = [int(records.sample_mode[-2])], []
    states = [np.array(records.sample_state[-2])]
    for row, state in zip(rows[inside], after[inside], strict=True):
        path = path_of_bits(int(row["path"]), int(row["passes"]))
        if path is None:
            raise RunError(
                f"{system.name}: more exits are passed at one instant than an orbit can hold",
                status=Status.EVENT_LIMIT.word,
                time=float(row["phase"]),
            )
        paths.append(path)
        modes.append(int(row["to_mode"]))
        states.append(state.copy())
    paths.append(())
    instants = np.concatenate([[0.0], times[inside], [(end.number - begin.number) * window]])
    return Guess(Word(tuple(modes), tuple(paths)), Turn(np.array(states), instants + begin.phase))
