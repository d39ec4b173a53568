"""How long a motion that nothing times takes to come back, for lengths that are not given.

A unit of time says nothing of a motion: a converter switches a million times in a second, and a
tank fills in a thousand. So a first look at the motion, ever longer, says how often each of its
states comes back.
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

__all__ = ["return_time"]

Floats = npt.NDArray[np.float64]

_SAMPLES = 4096  # of a look
_LOOKS = [2.0**k for k in range(-33, 7, 3)]  # windows
_MOST_EVENTS = 20_000  # of a look
_RETURNS = 8  # of the state that returns most seldom, in the second half of a look
_OSCILLATIONS = 5.0  # in a window of the clock, which is 32 radians of the fastest one
_VARIES = 1e-9  # of its size: what a state must change by to count
_LASTS = 0.5  # of the spread before, of a state that does not die out


def return_time(system: System, tables: Tables, start: Start, tolerance: float) -> float:
    """Mean time between returns of the state that returns most seldom.

    An oscillation of the fastest natural motion where nothing returns: the motion rests, runs off
    or ends, or is slower than a few hundred of them.
    """
    found = None
    for windows in _LOOKS:
        outcome = _look(system, tables, start, windows, tolerance)
        states = outcome.records.sample_state[: outcome.n_samples]
        step = windows * tables.window / _SAMPLES
        count = _returns(system, states)
        if count > 0:
            found = len(states) // 2 * step / count
        if count >= _RETURNS or outcome.status != Status.COMPLETED:
            break
    return tables.window / _OSCILLATIONS if found is None else found


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


def _returns(system: System, states: Floats) -> int:
    """How often each state comes up through its mean in the second half, at least."""
    drifts = np.array([name in system.drift_states for name in system.states])
    turn = periods_of_states(system)
    angle = np.sin(2.0 * np.pi * states / np.where(turn > 0.0, turn, 1.0))
    seen = np.where(turn > 0.0, angle, states)[:, ~drifts | (turn > 0.0)]
    early, late = np.array_split(seen[len(seen) // 2 :], 2)
    if len(late) < _RETURNS:
        return 0
    both = np.concatenate([early, late])
    size = np.abs(both).max(axis=0)
    varies = np.ptp(both, axis=0) > _VARIES * size
    if not varies.any() or np.any(np.ptp(late, axis=0) < _LASTS * np.ptp(early, axis=0)):
        return 0
    above = both[:, varies] > both[:, varies].mean(axis=0)
    return int(np.sum(above[1:] & ~above[:-1], axis=0).min())
