"""Whether motions that were recorded side by side have settled: the periods that they show."""

from __future__ import annotations

from functools import partial

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.exponents.interval_tangents import IntervalTangents
from nonsmooth.analysis.passed_events import PassedEvents
from nonsmooth.analysis.settle import Group
from nonsmooth.analysis.statistics.periodicity import REPEATS, scales, settled_periods
from nonsmooth.analysis.statistics.rest import comes_to_rest, natural_sizes
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.outputs import StateRates
from nonsmooth.runs.sweep_runner import Recorded

__all__ = ["said_of_restless", "strobe_periods"]

_MAYBE_ROUNDING = 1e-9  # size of all states from which their rates are looked at
_STEPS = 16  # of a window, from one place where rates are looked at to the next

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def strobe_periods(
    group: Group, recorded: Recorded, passed: PassedEvents, match: float
) -> Integers:
    """Period of each of K motions in strobes, (K,); 0 where none shows or a motion ended early."""
    done = recorded.statuses == Status.COMPLETED
    period = np.zeros(group.count, np.int64)
    scale = scales(recorded.states, group.drifting)
    for i in np.flatnonzero(done).tolist():
        scale[i] = _passing_zero(group, recorded, i, scale[i], match)
    period[done] = settled_periods(recorded.states[done], group.drifting, match, scale[done])
    period[_resting(group, recorded, passed, match, done & (period != 1))] = 1
    return period


def said_of_restless(
    restless: int, motions: int, record: int, length: int, unit: str, option: str
) -> str:
    """How many motions show no period within ``length`` units, and the option that tells why."""
    return (
        f"{restless} of {motions} motions have not settled to a period of at most"
        f" {record // REPEATS} within {length} {unit}s: chaos, quasi-periodic motion, a"
        f" longer period or a long transient, which a larger {option}= or regime tells"
    )


def _resting(
    group: Group, recorded: Recorded, passed: PassedEvents, match: float, open_yet: Bools
) -> Bools:
    """Which of some motions have died away, or without forcing come to rest, (K,).

    What decays to zero repeats to no part of its own size, and rounding has other periods.
    """
    still, found = ~group.drifting, np.zeros(open_yet.size, bool)
    if not np.any(open_yet) or not np.any(still):
        return found
    driven = group.runner.is_driven
    states, tangents = recorded.states[..., still], IntervalTangents(group)
    begun = _begun(group, recorded)[:, still]
    ranges, largest = np.ptp(states, axis=1), np.abs(states).max(axis=1)
    sizes, left = np.maximum(largest, begun), largest if driven else ranges
    first = np.full(open_yet.size, -recorded.states.shape[1])
    events, _ = passed.counts(passed.between(first))
    # states that began with a size say whether it may be so, their rates afterwards
    faded = np.any(begun > 0.0, axis=1) & np.all(
        (left <= match**2 * sizes) | (begun == 0.0), axis=1
    )
    maybe = faded | (np.any(ranges <= match * sizes, axis=1) & (not driven))
    for i in np.flatnonzero(open_yet & maybe).tolist():
        block_over = partial(tangents.over_part, i, recorded.last)
        natural = natural_sizes(sizes[i], block_over)
        found[i] = faded[i] and bool(np.all(left[i] <= match**2 * natural))
        if not driven and not found[i]:
            found[i] = comes_to_rest(
                states[i], ranges[i], natural, block_over(1.0), match, passes=events[i] > 0
            )
    return found


def _passing_zero(group: Group, recorded: Recorded, i: int, scale: Floats, match: float) -> Floats:
    """Scales of the states of a motion; of one that is zero at the strobes, what it moves by.

    Such a state passes through zero there, as a base does that shakes as the sine of the phase:
    what is recorded of it is rounding, which repeats to no part of its own size. All states may do
    so, as those of a follower that rides on its cam, and rates may vanish there as well.
    """
    states = np.abs(recorded.states[i]).max(axis=0)
    largest = states.max(initial=0.0)
    tiny = ~group.drifting & ((states <= match**2 * largest) | (largest <= _MAYBE_ROUNDING))
    if not np.any(tiny):
        return scale
    moved = _moved(group, recorded, i)
    return np.where(tiny & (states <= match**2 * moved), moved, scale)


def _moved(group: Group, recorded: Recorded, i: int) -> Floats:
    """What a motion moves by in a window, from its rates at the last strobe and behind it."""
    window = float(recorded.windows[i])
    number, phase = int(recorded.numbers[i, -1]), float(recorded.phases[i, -1])
    mode, state = int(recorded.modes[i, -1]), recorded.states[i, -1]
    rates = StateRates(group.system, group.runner.tables(i))
    here = rates.at(Instant(number, phase), mode, state)
    step = window / _STEPS
    behind = rates.at(Instant(number, phase + step), mode, state + here * step)
    return np.asarray(np.maximum(np.abs(here), np.abs(behind)) * window)


def _begun(group: Group, recorded: Recorded) -> Floats:
    """Sizes of the states at the start of each motion, (K, n)."""
    n = recorded.states.shape[2]
    states = [np.zeros(n) if each is None else each.state for each in group.starts]
    return np.nan_to_num(np.abs(np.array(states)))  # a state that is left out begins at rest
