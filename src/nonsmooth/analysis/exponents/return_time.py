"""How long a motion that nothing times takes to come back, for lengths that are not given.

A unit of time says nothing of a motion: a converter switches a million times in a second, and a
tank fills in a thousand. So a first look at the motion, ever longer, says how often each of its
states comes back. A record in which none does is one of a part of the way, whatever its length.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.first_mode import in_first_mode
from nonsmooth.runs.runner import Outcome, WorkLimits, run_plan
from nonsmooth.runs.start import Start
from nonsmooth.runs.whole_turns import periods_of_states
from nonsmooth.system.system import System

__all__ = ["never_returns", "return_time"]

Floats = npt.NDArray[np.float64]

_SAMPLES = 4096  # of a look
_LOOKS = [2.0**k for k in range(-33, 19, 3)]  # windows
_LONG = 2.0**6  # windows of a look behind which one more is worth it only where nothing is known
_MOST_EVENTS = 20_000  # of a look
_PASSES = 2  # through the mean of a state, in one direction: a state that only grows has one
_OFTEN = 64  # returns of one state in which others do not return: they run off
_RETURNS = 8  # of the state that returns most seldom, in the second half of a look
_OSCILLATIONS = 5.0  # in a window of the clock, which is 32 radians of the fastest one
_VARIES = 1e-9  # of its size: what a state must change by to count
_LASTS = 0.5  # of the spread before, of a state that does not die out


def return_time(system: System, tables: Tables, start: Start, tolerance: float) -> float:
    """Mean time between returns of the state that returns most seldom.

    An oscillation of the fastest natural motion where nothing returns: the motion rests, runs off
    or ends, or is slower than a hundred thousand of them.
    """
    found = None
    for windows in _LOOKS:
        outcome = _look(system, tables, start, windows, tolerance)
        states = outcome.records.sample_state[: outcome.n_samples]
        step = windows * tables.window / _SAMPLES
        counts = _returns(system, states[len(states) // 2 :])
        count = int(counts.min()) if counts.size else 0
        if count > 0:
            found = len(states) // 2 * step / count
        if count >= _RETURNS or outcome.status != Status.COMPLETED:
            break
        known = found is not None or counts.max(initial=0) >= _OFTEN
        if windows >= _LONG and (known or _rests(system, states)):
            break
    return tables.window / _OSCILLATIONS if found is None else found


def never_returns(system: System, states: Floats) -> bool:
    """Whether no state comes back in samples of a motion that neither rests nor dies out."""
    seen = _seen(system, states)
    early, late = np.array_split(seen[len(seen) // 2 :], 2)
    if len(early) < 2:
        return False
    lasts = np.ptp(late, axis=0) >= _LASTS * np.ptp(early, axis=0)
    lasts &= np.ptp(late, axis=0) > _VARIES * np.abs(seen).max(axis=0)
    passes = np.maximum(_rises(seen), _rises(-seen))
    return bool(lasts.any()) and not np.any(passes[lasts] >= _PASSES)


def _look(
    system: System, tables: Tables, start: Start, windows: float, tolerance: float
) -> Outcome:
    """Samples of so many windows from a start, as far as some thousand events lead."""
    window, begin = tables.window, start.instant
    since = begin.phase + np.arange(_SAMPLES + 1) * (windows * window / _SAMPLES)
    number = np.floor(since / window)
    phase = np.clip(since - number * window, 0.0, window)
    numbers = begin.number + number.astype(np.int64)
    plan = Plan(Instant(int(numbers[-1]), float(phase[-1])), numbers, phase)
    limits = WorkLimits(most_events=_MOST_EVENTS)
    run = partial(
        run_plan, tables, plan, tolerance, state=start.state, begin=begin, keep_events=False,
        limits=limits,
    )  # fmt: skip
    return in_first_mode(system, tables, start, run).unless_interrupted()


def _seen(system: System, states: Floats) -> Floats:
    """The states that may come back, an angle by its sine."""
    drifts = np.array([name in system.drift_states for name in system.states])
    turn = periods_of_states(system)
    angle = np.sin(2.0 * np.pi * states / np.where(turn > 0.0, turn, 1.0))
    return np.asarray(np.where(turn > 0.0, angle, states)[:, ~drifts | (turn > 0.0)])


def _rises(seen: Floats) -> npt.NDArray[np.int64]:
    """How often each state comes up through its mean."""
    above = seen > seen.mean(axis=0)
    return np.asarray(np.sum(above[1:] & ~above[:-1], axis=0))


def _returns(system: System, states: Floats) -> npt.NDArray[np.int64]:
    """How often each state comes up through its mean, once being no return; none at rest."""
    seen = _seen(system, states)
    early, late = np.array_split(seen, 2)
    if len(late) < _RETURNS:
        return np.zeros(0, np.int64)
    varies = np.ptp(seen, axis=0) > _VARIES * np.abs(seen).max(axis=0)
    if np.any(np.ptp(late, axis=0) < _LASTS * np.ptp(early, axis=0)):
        return np.zeros(0, np.int64)
    rises = _rises(seen[:, varies])
    return np.where(rises >= _PASSES, rises, 0)


def _rests(system: System, states: Floats) -> bool:
    """Whether nothing changes in the second half of some samples."""
    seen = _seen(system, states)
    late = seen[len(seen) // 2 :]
    return not np.any(np.ptp(late, axis=0) > _VARIES * np.abs(late).max(axis=0))
