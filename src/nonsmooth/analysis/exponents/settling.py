"""Whether exponents are those of a motion that has settled, or of a transient."""

from __future__ import annotations

import threading
from functools import partial

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.exponents.exponent_run import ExponentRun
from nonsmooth.analysis.settle import Group, ParameterSets, settle
from nonsmooth.analysis.statistics.block_averages import block_averages
from nonsmooth.analysis.statistics.periodicity import primitive_period, scales
from nonsmooth.engine.lanes import SAME
from nonsmooth.engine.status import Status
from nonsmooth.runs.start import Start
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.sweep_runner import Recorded, SweepRunner
from nonsmooth.system.system import System

__all__ = ["halves_differ", "is_chaotic", "said_of_later"]

Floats = npt.NDArray[np.float64]

_ERRORS = 5.0  # standard errors between two halves of a record, or between an exponent and zero
_LEAST = 3.0  # times one over the duration: no record tells an exponent better
_RECORD, _MATCH = 100, 1e-6  # strobes at the end of the later motion, and how they repeat


def is_chaotic(run: ExponentRun) -> bool:
    """Whether the largest exponent is above zero."""
    rate, error = _largest(_rates(run))
    return rate > max(_ERRORS * error, _LEAST / _duration(run))


def halves_differ(run: ExponentRun) -> str:
    """What the largest exponent is in each half of the record, "" where both agree."""
    parts = np.array_split(_rates(run), 2)
    if min(len(part) for part in parts) < 2:
        return ""
    (first, error), (second, other) = map(_largest, parts)
    if first == second == -np.inf:
        return ""
    least = 2.0 * _LEAST / _duration(run)
    if abs(first - second) <= max(_ERRORS * float(np.hypot(error, other)), least):
        return ""
    return (
        f"the motion had not settled: its largest exponent is {first:.3g} in the first half of the"
        f" record and {second:.3g} in the second; raise transient="
    )


def said_of_later(
    system: System, run: ExponentRun, length: float | None, tolerance: float, confirm: int
) -> str:
    """What becomes of a motion after so many more strobes, "" where it does not settle or end."""
    start = Start(run.end_state, run.end, (SAME - run.end_mode,))
    (said,), _ = settle(
        SweepRunner(system, tolerance),
        threading.Event(),
        sets=ParameterSets(StroboscopicMap(system, period=length), {}, start, None),
        times=lambda group: group.strobes(confirm, 2 * _RECORD + 1),
        reduce=partial(_said_of_end, confirm),
        log=False,
    )
    return said


def _said_of_end(confirm: int, group: Group, recorded: Recorded) -> list[str]:
    """What a motion has become after so many strobes."""
    status, states, drifting = Status(int(recorded.statuses[0])), recorded.states[0], group.drifting
    if group.is_misfit[0]:
        return [""]  # rounding has taken the state at the end of the record out of its mode
    if status != Status.COMPLETED:
        return [f"the motion ends later ({status.word}): these are exponents of a transient"]
    period = primitive_period(states, drifting, scales(states, drifting), _MATCH)
    if period == 0:
        return [""]
    return [
        f"{confirm} strobes later the motion repeats with period {period}: these are exponents of a"
        " transient; raise transient="
    ]


def _duration(run: ExponentRun) -> float:
    return float(run.times[-1] - run.times[0])


def _rates(run: ExponentRun) -> Floats:
    """Growth per unit time in each interval, of each column; minus infinity once it is lost."""
    with np.errstate(invalid="ignore"):  # of lost columns
        rates = np.diff(run.growth, axis=0) / np.diff(run.times)[:, None]
    return np.where(np.isneginf(run.growth[1:]), -np.inf, rates)


def _largest(rates: Floats) -> tuple[float, float]:
    """Largest mean rate of some intervals, with its standard error."""
    means = rates.mean(axis=0) if len(rates) else np.full(rates.shape[1], -np.inf)
    column = rates[:, int(np.argmax(means))]
    if not np.all(np.isfinite(column)) or column.size < 2:
        return -np.inf, 0.0
    return float(column.mean()), float(block_averages(column[:, None]).standard_error[0])
