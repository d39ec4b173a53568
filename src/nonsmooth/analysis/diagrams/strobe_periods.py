"""Whether motions that were recorded side by side have settled: the periods that they show."""

from __future__ import annotations

import threading
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.exponents.interval_tangents import IntervalTangents
from nonsmooth.analysis.passed_events import PassedEvents
from nonsmooth.analysis.settle import Group, ParameterSets, settle
from nonsmooth.analysis.statistics.periodicity import REPEATS, scales, settled_periods
from nonsmooth.analysis.statistics.rest import comes_to_rest, floor_of, natural_sizes
from nonsmooth.engine.extremes import state_maxima, state_ranges
from nonsmooth.engine.status import Status
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.sweep_runner import Recorded, SweepRunner, Times
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["period_of_points", "said_of_restless", "strobe_periods"]

_STEPS = 16  # of a window, from one place where motions are looked at to the next
_LOOKS = np.array([1.0, 2.0])  # steps behind the last strobe

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def strobe_periods(
    group: Group, recorded: Recorded, passed: PassedEvents, match: float
) -> Integers:
    """Period of each of K motions in strobes, (K,); 0 where none shows or a motion ended early.

    Strobes that repeat at once beside the sizes that they have themselves do so beside any others.
    Of the other motions some states may rest, or pass through zero, and leave rounding there: they
    count beside their natural sizes.
    """
    done, drifting = recorded.statuses == Status.COMPLETED, group.drifting
    period, states = np.zeros(group.count, np.int64), recorded.states
    scale = scales(states, drifting)
    period[done] = settled_periods(states[done], drifting, match, scale[done])
    open_yet = done & (period != 1)
    if not np.any(open_yet):
        return period
    natural = _natural(group, recorded, passed, open_yet)
    floor = np.where(drifting, 0.0, floor_of(natural, match))
    which = np.flatnonzero(open_yet & np.any(scale < floor, axis=1))
    scale = np.maximum(scale, floor)
    period[which] = settled_periods(states[which], drifting, match, scale[which], natural[which])
    period[_resting(group, recorded, passed, match, done & (period != 1), natural)] = 1
    return period


def period_of_points(points: xr.Dataset, match: float) -> int:
    """Period that the points of `stroboscopic_map` show, in points, or 0.

    The motion runs through them once more, for natural sizes of its states.
    """
    attrs, count = points.attrs, points.sizes["point"]
    system = System.from_toml(attrs["system"])
    states = np.column_stack([points[name].values for name in system.states])
    length, phase = float(attrs["strobe_period"]), float(attrs["phase_of_period"])
    own = length == system.period_value
    chosen = StroboscopicMap(system, phase=phase, period=None if own else length)
    (period,), _ = settle(
        SweepRunner(system, float(attrs["tolerance"])),
        threading.Event(),
        sets=ParameterSets(chosen, {}, points.isel(point=0), None),
        times=lambda group: group.strobes(0, count),
        reduce=partial(_periods_of, states, match),
    )
    return int(period)


def _periods_of(states: Floats, match: float, group: Group, recorded: Recorded) -> list[int]:
    """Period of a motion from its states (K, n) as they were: strobes at events have two sides."""
    recorded = recorded._replace(states=states[None])
    passed = PassedEvents(group.system, recorded)
    return strobe_periods(group, group.fold(recorded), passed, match).tolist()


def said_of_restless(
    restless: int, motions: int, record: int, length: int, unit: str, option: str
) -> str:
    """How many motions show no period within ``length`` units, and the option that tells why."""
    return (
        f"{restless} of {motions} motions have not settled to a period of at most"
        f" {record // REPEATS} within {length} {unit}s: chaos, quasi-periodic motion, a"
        f" longer period or a long transient, which a larger {option}= or regime tells"
    )


def _natural(group: Group, recorded: Recorded, passed: PassedEvents, chosen: Bools) -> Floats:
    """Natural sizes of the states of some motions, (K, n): of drifts, those that they have."""
    still = ~group.drifting
    sizes = np.maximum(state_maxima(np.abs(recorded.states)), _begun(group, recorded))
    np.maximum.at(sizes, passed.motion, state_maxima(np.abs(recorded.event_states)))
    sizes = np.where(group.drifting, sizes, np.maximum(sizes, _moved(group, recorded, chosen)))
    blocks_over = partial(IntervalTangents(group).over_parts, recorded.last)
    sizes[:, still] = natural_sizes(sizes[:, still], chosen, blocks_over)
    return sizes


def _resting(
    group: Group,
    recorded: Recorded,
    passed: PassedEvents,
    match: float,
    open_yet: Bools,
    natural: Floats,
) -> Bools:
    """Which of some motions have died away, or without forcing come to rest, (K,).

    What decays to zero repeats to no part of its own size, and rounding has other periods.

    natural: (K, n)
    """
    still, found = ~group.drifting, np.zeros(open_yet.size, bool)
    if not np.any(open_yet) or not np.any(still):
        return found
    driven = group.runner.is_driven
    states, natural, begun = recorded.states[..., still], natural[:, still], _begun(group, recorded)
    ranges = state_ranges(states)
    left = state_maxima(np.abs(states)) if driven else ranges
    first = np.full(open_yet.size, -recorded.states.shape[1])
    events, _ = passed.counts(passed.between(first))
    found = np.any(begun[:, still] > 0.0, axis=1) & np.all(left <= match**2 * natural, axis=1)
    found &= open_yet
    if driven:
        return found
    maybe = open_yet & ~found & np.all(ranges <= match * natural, axis=1)
    known, blocks = IntervalTangents(group).over_part(recorded.last, 1.0, maybe)
    for i in np.flatnonzero(maybe).tolist():
        block = blocks[i] if known[i] else None
        found[i] = comes_to_rest(
            states[i], ranges[i], natural[i], block, match, passes=events[i] > 0
        )
    return found


def _moved(group: Group, recorded: Recorded, chosen: Bools) -> Floats:
    """What some motions would move by in a window, as they do just behind the last strobe, (K, n).

    A state that is zero at the strobes passes through zero there, as a base does that shakes as the
    sine of the phase: what is recorded of it is rounding, which repeats to no part of its own size.
    All states may do so, as those of a follower that rides on its cam, and rates may vanish there
    as well, so two steps are taken.
    """
    last, windows = recorded.last, group.windows
    since = last.phases[:, None] + _LOOKS / _STEPS * windows[:, None]
    more, phases = group.instants(since, chosen)
    times = Times(last.numbers[:, None] + more, phases)
    motions = group.runner.start(last, chosen)
    found = group.runner.run(motions, times, log=False, stop=group.stop)
    states = np.concatenate([last.states[:, None], found.states], axis=1)
    return np.nan_to_num(state_maxima(np.abs(np.diff(states, axis=1)))) * _STEPS


def _begun(group: Group, recorded: Recorded) -> Floats:
    """Sizes of the states at the start of each motion, (K, n)."""
    n = recorded.states.shape[2]
    states = [np.zeros(n) if each is None else each.state for each in group.starts]
    return np.nan_to_num(np.abs(np.array(states)))  # a state that is left out begins at rest
