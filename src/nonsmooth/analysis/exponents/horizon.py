"""Whether exponents are those of a transient, and for how long chaos was seen.

Two halves of the record are compared. A chaotic motion is run on without derivatives, and its
largest exponent is taken once more at the end: a motion that has escaped by then, to whatever it
escapes, no longer has the exponent of the chaos. It is run on from a point beside its last one,
since machines in step never part in rounding that is the same for all of them.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.strobe_periods import strobe_periods
from nonsmooth.analysis.exponents.exponent_run import (
    LEAST_GROWTH,
    ExponentProtocol,
    ExponentRun,
    duration_of,
    is_chaotic,
    largest_exponent,
    rates_of,
    sorted_exponents,
)
from nonsmooth.analysis.exponents.return_time import never_returns
from nonsmooth.analysis.passed_events import PassedEvents
from nonsmooth.analysis.settle import Group, ParameterSets, settle
from nonsmooth.analysis.statistics.block_averages import means_differ
from nonsmooth.engine.lanes import SAME
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.start import Start
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.sweep_runner import Recorded, SweepRunner
from nonsmooth.system.columns import with_error
from nonsmooth.system.system import System

__all__ = ["Horizon", "find_horizon"]

_TRANSIENT = "these are exponents of a transient, or of a motion that its neighbours leave for ever"
_CURE = "raise transient=, or begin elsewhere"
_NO_RETURN = (
    "the motion does not come back in the record: these are exponents of a part of its way;"
    " raise record= and transient="
)
_RECORD, _MATCH = 100, 1e-6  # strobes at the end of the later motion, and how they repeat
_TURNING = 0.25  # of the later record, before it: derivatives find their directions

Floats = npt.NDArray[np.float64]
RunFrom = Callable[[Start, ExponentProtocol], ExponentRun]


@dataclass(frozen=True)
class Horizon:
    """Why a motion had not settled, "" where nothing says so, and windows of chaos without end."""

    unsettled: str = ""
    chaotic_for: float = 0.0


@dataclass(frozen=True)
class _Later:
    """A motion that was run on: why it is no longer what it was, or where it goes on."""

    said: str = ""
    start: Start | None = None


def find_horizon(
    system: System,
    run: ExponentRun,
    protocol: ExponentProtocol,
    run_from: RunFrom,
    *,
    length: float | None,
    window: float,
    tolerance: float,
    confirm: int,
) -> Horizon:
    """What a completed run tells of the motion, and what becomes of it after so many strobes.

    ``length`` between strobes, None for that of a ``window``. No escape lies before the second half
    of a record both halves of which are chaotic, nor before a later record that is.
    """
    if run.status != Status.COMPLETED:
        return Horizon()
    differ = _halves_differ(run)
    if system.period_value is None and not system.signals and never_returns(system, run.states):
        return Horizon(_NO_RETURN)
    if not is_chaotic(run):
        return Horizon(differ)
    half = 0.5 * protocol.record
    if not confirm:
        return Horizon(differ, 0.0 if differ else half)
    later = _run_on(system, run, length, tolerance, confirm)
    if later.said or differ or later.start is None:
        return Horizon(later.said or differ, 0.0 if later.said or differ else half)
    parts = max(2, protocol.parts // 2)
    again = ExponentProtocol(_TURNING * half, half, half / parts, parts)
    after = run_from(later.start, again)
    if after.status == Status.INTERRUPTED:
        raise KeyboardInterrupt  # what is kept are the exponents of the record
    if after.status != Status.COMPLETED:
        return Horizon(chaotic_for=half)
    changed = _changed(run, after)
    if changed:
        return Horizon(f"{_counted(system, confirm)} later {changed}: {_TRANSIENT}; {_CURE}")
    if not is_chaotic(after):
        return Horizon(chaotic_for=half)
    strobes = (confirm + 2 * _RECORD) * (length or window) / window
    return Horizon(chaotic_for=protocol.record + strobes + again.transient)


def _changed(run: ExponentRun, after: ExponentRun) -> str:
    """Which exponent is another one in a later record, "" where none is.

    Neighbours may leave a chaotic motion for another one that is as chaotic, as those of equal
    machines in step do: a smaller exponent tells it then.
    """
    before, now = rates_of(run), rates_of(after)
    first, later = largest_exponent(before), largest_exponent(now)
    least = 2.0 * LEAST_GROWTH / duration_of(after)
    if means_differ(first, later, least):
        return f"the largest exponent is {with_error(*later, 3, 2)}"
    pairs = zip(sorted_exponents(before), sorted_exponents(now), strict=False)
    for number, (one, other) in enumerate(pairs, 1):
        if means_differ(one, other, least):
            return (
                f"exponent {number} is {with_error(*other, 3, 2)}, and"
                f" {with_error(*one, 3, 2)} in the record"
            )
    return ""


def _halves_differ(run: ExponentRun) -> str:
    """What the largest exponent is in each half of the record, "" where both agree."""
    parts = np.array_split(rates_of(run), 2)
    if min(len(part) for part in parts) < 2:
        return ""
    first, second = map(largest_exponent, parts)
    if not means_differ(first, second, 2.0 * LEAST_GROWTH / duration_of(run)):
        return ""
    return (
        f"the motion had not settled: its largest exponent is {first[0]:.3g} in the first half of"
        f" the record and {second[0]:.3g} in the second; raise transient="
    )


def _counted(system: System, confirm: int) -> str:
    """So many strobes, or returns where nothing says when to look, in words."""
    return f"{confirm} {'returns' if system.period_value is None else 'strobes'}"


def _run_on(
    system: System, run: ExponentRun, length: float | None, tolerance: float, confirm: int
) -> _Later:
    """What becomes of a motion after so many more strobes, without derivatives.

    It goes on from a point beside its last one, as far as its mode takes that.
    """
    start = Start(run.end_state, run.end, (SAME - run.end_mode,))
    (later,), _ = settle(
        SweepRunner(system, tolerance),
        threading.Event(),
        sets=ParameterSets(StroboscopicMap(system, period=length), {}, start, None),
        times=lambda group: group.strobes(0, 1),
        reduce=partial(_later, confirm, np.abs(run.states).max(axis=0)),
        log=False,
    )
    return later


def _later(confirm: int, sizes: Floats, group: Group, recorded: Recorded) -> list[_Later]:
    """What a motion has become so many strobes behind its start; sizes (n,) of its states."""
    if group.is_misfit[0]:
        return [_Later()]  # rounding has taken the state at the end out of its mode
    if recorded.statuses[0] == Status.COMPLETED:
        group.go_beside(np.ones(1, bool), sizes[None])
        recorded = group.run(group.strobes(confirm, 2 * _RECORD + 1), log=False)
    status, states = Status(int(recorded.statuses[0])), recorded.states[0]
    if status != Status.COMPLETED:
        return [_Later(f"the motion ends later ({status.word}): {_TRANSIENT}")]
    passed = PassedEvents(group.system, recorded)
    period = int(strobe_periods(group, recorded, passed, _MATCH)[0])
    if period:
        counted = _counted(group.system, confirm)
        said = f"{counted} later the motion repeats with period {period}: {_TRANSIENT}"
        return [_Later(f"{said}; {_CURE}")]
    instant = Instant(int(recorded.numbers[0, -1]), float(recorded.phases[0, -1]))
    return [_Later(start=Start(states[-1], instant, (SAME - int(recorded.modes[0, -1]),)))]
