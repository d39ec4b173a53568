"""The run behind a spectrum of Lyapunov exponents.

Transient and record do not take the path of `settle`: derivatives are carried through the transient
as well, so that they find their directions, and of those that are lost there some begin anew.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.exponents.growth import Growth
from nonsmooth.analysis.statistics.block_averages import block_averages
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables
from nonsmooth.progress import Progress
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.first_mode import in_first_mode
from nonsmooth.runs.impacts import impacts_of
from nonsmooth.runs.runner import Derivatives
from nonsmooth.runs.start import Start
from nonsmooth.runs.tangent_flow import TangentFlow
from nonsmooth.system.system import System

__all__ = [
    "LEAST_GROWTH",
    "ExponentProtocol",
    "ExponentRun",
    "duration_of",
    "is_chaotic",
    "largest_exponent",
    "rates_of",
    "run_exponents",
]

Floats = npt.NDArray[np.float64]

_STATES = 65_536  # that are kept of a record, or up to twice as many
_TOGETHER = 64  # intervals that are run at once, between which the progress is told
_ERRORS = 5.0  # standard errors between an exponent and zero
LEAST_GROWTH = 3.0  # times one over the duration: no record tells an exponent better


class ExponentProtocol(NamedTuple):
    """Lengths in windows of the clock, and the number of intervals of the record."""

    transient: float
    record: float
    interval: float
    parts: int


@dataclass(frozen=True)
class ExponentRun:
    """Growth of columns at the ends of intervals; the first row is the end of the transient."""

    status: Status
    times: npt.NDArray[np.float64]  # (N + 1,)
    growth: npt.NDArray[np.float64]  # (N + 1, k) logarithms, minus infinity for lost columns
    n_states: int
    n_events: int
    n_impacts: int
    n_uncertain: int
    n_estimated: int
    end_time: float  # of the run, which may have ended early
    end: Instant  # of the record
    end_state: npt.NDArray[np.float64]  # (n,)
    end_mode: int
    states: npt.NDArray[np.float64]  # (K, n) at ends of intervals of the record, evenly spaced


def run_exponents(
    system: System,
    tables: Tables,
    derivatives: Derivatives,
    start: Start,
    protocol: ExponentProtocol,
    count: int,
    tolerance: float,
    seed: int,
) -> ExponentRun:
    """Run the transient and the record from a start; what an interruption leaves is kept."""
    flow, status = _started(system, tables, derivatives, start, count, tolerance)
    growth = Growth(flow, count, seed)
    steps = _Ends(flow, start.instant, protocol)
    n_transient = steps.of_transient
    rows, done = [growth.at_anchor[None]], 0
    states, apart = [np.empty((0, flow.n))], max(1, protocol.parts // _STATES)
    first = last = flow.counts
    try:
        with Progress("exponents", steps.count) as progress:
            while status == Status.COMPLETED and done < steps.count:
                limit = n_transient if done < n_transient else steps.count
                status, part = growth.through(steps.part(done, min(done + _TOGETHER, limit)))
                rows.append(part)
                if done >= n_transient:
                    states.append(flow.states_at_ends[(n_transient - done) % apart :: apart].copy())
                done += len(part)
                if status == Status.COMPLETED and done <= n_transient and growth.renew_lost():
                    status, again = growth.through(steps.part(done - 1, done))
                    part[len(part) - len(again) :] = again  # it belongs to other columns now
                last = flow.counts
                first = last if done <= n_transient else first
                progress.update(done)
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    ends = steps.part(max(n_transient - 1, 0), done) if done >= n_transient else []
    ends = ends if n_transient else [start.instant, *ends]
    return ExponentRun(
        status=status,
        times=np.array([end.time(flow.window) for end in ends]),
        growth=np.concatenate(rows)[n_transient:],
        n_states=flow.n,
        n_events=last[0] - first[0],
        n_impacts=last[1] - first[1],
        n_uncertain=last[2] - first[2],
        n_estimated=last[3] - first[3],
        end_time=(growth.ended or flow.here).time(flow.window),
        end=ends[-1] if ends else start.instant,
        end_state=flow.end_state.copy(),
        end_mode=flow.mode,
        states=np.concatenate(states),
    )


def _started(
    system: System,
    tables: Tables,
    derivatives: Derivatives,
    start: Start,
    count: int,
    tolerance: float,
) -> tuple[TangentFlow, Status]:
    """Flow at its start, in the first of the modes that admits it."""

    def begin(mode: int) -> tuple[TangentFlow, Status]:
        flow = TangentFlow(tables, derivatives, count, tolerance, impacts_of(system))
        return flow, flow.start(start.state, start.instant, mode)

    return in_first_mode(system, tables, start, begin)


@dataclass(frozen=True)
class _Ends:
    """Ends of the intervals of transient and record, at phases without rounding.

    They are made as they are needed: of a long record there are millions.
    """

    flow: TangentFlow
    start: Instant
    protocol: ExponentProtocol

    @property
    def of_transient(self) -> int:
        """Number of those of the transient, which come first."""
        return math.ceil(self.protocol.transient / self.protocol.interval - 1e-9)

    @property
    def count(self) -> int:
        return self.of_transient + self.protocol.parts

    def part(self, first: int, last: int) -> list[Instant]:
        """Some of them, in order, without the last."""
        return [self._end(k) for k in range(first, last)]

    def _end(self, k: int) -> Instant:
        protocol, before = self.protocol, self.of_transient
        if k < before:
            length = protocol.transient * (k + 1) / before
        else:
            length = protocol.transient + protocol.record * (k + 1 - before) / protocol.parts
        whole = math.floor(length + 1e-12 * max(1.0, length))
        rest = max(0.0, length - whole)
        rest = 0.0 if rest < 1e-12 * max(1.0, length) else rest
        end = self.flow.after(self.start, rest * self.flow.window)
        return Instant(end.number + whole, end.phase)


def is_chaotic(run: ExponentRun) -> bool:
    """Whether the largest exponent is above zero."""
    rate, error = largest_exponent(rates_of(run))
    return rate > max(_ERRORS * error, LEAST_GROWTH / duration_of(run))


def duration_of(run: ExponentRun) -> float:
    """Time of the record."""
    return float(run.times[-1] - run.times[0])


def rates_of(run: ExponentRun) -> Floats:
    """Growth per unit time in each interval, of each column; minus infinity once it is lost."""
    with np.errstate(invalid="ignore"):  # of lost columns
        rates = np.diff(run.growth, axis=0) / np.diff(run.times)[:, None]
    return np.where(np.isneginf(run.growth[1:]), -np.inf, rates)


def sorted_exponents(rates: Floats) -> list[tuple[float, float]]:
    """Mean rates of some intervals that are finite, the largest first, with standard errors."""
    finite = rates[:, np.all(np.isfinite(rates), axis=0)]
    means, errors = finite.mean(axis=0), block_averages(finite).standard_error
    order = np.argsort(-means, kind="stable")
    return list(zip(means[order].tolist(), errors[order].tolist(), strict=True))


def largest_exponent(rates: Floats) -> tuple[float, float]:
    """Largest mean rate of some intervals, with its standard error."""
    means = rates.mean(axis=0) if len(rates) else np.full(rates.shape[1], -np.inf)
    column = rates[:, int(np.argmax(means))]
    if not np.all(np.isfinite(column)) or column.size < 2:
        return -np.inf, 0.0
    return float(column.mean()), float(block_averages(column[:, None]).standard_error[0])
