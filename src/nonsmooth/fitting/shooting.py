"""Multiple shooting: residuals of a record and their derivatives, with continuity as equations.

The record is cut into segments. The state at the start of each segment is unknown, so each run is
short and an error of the parameters cannot grow over the whole record, nor can a chaotic motion
lose it. That the end of a segment is the start of the next one is an equation, which the solver
brings to hold (`nonsmooth.fitting.solver`).

A steady motion repeats itself after a cycle. All samples are folded into the first cycle, and the
last segment ends where the first one begins, so that one cycle is run however long the record is.

Unknowns are counted in units of their ranges: first the head, which has the parameters and what is
free of gain, offset and delay, then the states of all segments.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import ANY
from nonsmooth.fitting.channels import ObservedChannel, Range
from nonsmooth.fitting.flights import Flight, Flights
from nonsmooth.fitting.observation import MotionSamples, Observation
from nonsmooth.system.system import System

__all__ = ["Evaluation", "Shooting"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_NUISANCES = ("gain", "offset", "delay")
_UNIT = 0.02  # of the size of a state: what a gap between segments is measured in
_INSTANT = 1e-12  # of a cycle: samples that lie closer after folding are at one instant


class SegmentData(NamedTuple):
    """Which samples of which channel lie in a segment; those of one instant are run once."""

    times: Floats  # (K,)
    instant: Integers  # (N,) of each datum
    channel: Integers  # (N,)
    data: Floats  # (N,)
    place: Integers  # (N,): sample of the record


class Residuals(NamedTuple):
    """Residuals of data in order, in units of each channel, with derivatives."""

    residual: Floats  # (N,)
    head: Floats  # (N, h)
    state: Floats  # (N, n), by the state at the start of the own segment
    channel: Integers  # (N,)
    place: Integers  # (N,)
    segment: Integers  # (N,)


class Evaluation(NamedTuple):
    """Residuals of all data, and the gaps between segments; G gaps, h unknowns of the head."""

    rows: Residuals
    gap: Floats  # (G, n): end of a segment less the start of the next
    gap_head: Floats  # (G, n, h)
    gap_state: Floats  # (G, n, n), by the start of the segment
    modes: list[int]  # in which each segment is to begin: that in which the one before has ended


class Shooting:
    """A record as equations for parameters, nuisances and states."""

    def __init__(
        self,
        system: System,
        free: Mapping[str, Range],
        channels: Sequence[ObservedChannel],
        times: Floats,
        bounds: Floats,
        tolerance: float,
        *,
        is_cycle: bool = False,
        together: int = 1,
    ) -> None:
        self.system, self.channels, self.times, self.bounds = system, channels, times, bounds
        self.together = together  # segments that may become one
        self.is_cycle = is_cycle  # whether the motion repeats itself after the last segment
        self.free = dict(free)
        self.nuisances = [
            (c, key)
            for c, channel in enumerate(channels)
            for key in _NUISANCES
            if getattr(channel, key).is_free
        ]
        self.ranges = [*free.values(), *(getattr(channels[c], key) for c, key in self.nuisances)]
        self.names = [*free, *(f"{channels[c].name} {key}" for c, key in self.nuisances)]
        self.flights = Flights(system, tuple(free), tolerance)
        moves = any(channel.delay.is_free for channel in channels)
        self.observation = Observation(
            system, {c.name: c.text for c in channels}, tuple(free), rates=moves
        )
        self.step = float(np.median(np.diff(times)))
        self.n, self.p, self.h = len(system.states), len(free), len(self.ranges)
        self.n_segments = bounds.size - 1
        self.size = self.h + self.n_segments * self.n
        self.scales = np.ones(self.n)  # of the states
        self._origin = np.array([r.low if np.isfinite(r.low) else r.guess for r in self.ranges])
        self._units = np.array([r.scale for r in self.ranges])
        self._plans: list[SegmentData] | None = None
        self._fixed_plans = not moves

    # ------------------------------------------------------------ unknowns

    @property
    def n_gaps(self) -> int:
        """Number of places where a segment must end where the next one begins."""
        return self.n_segments - (0 if self.is_cycle else 1)

    @property
    def n_spent(self) -> int:
        """Number of unknowns that only the data determine: a cycle has no free start."""
        return self.h + (0 if self.is_cycle else self.n)

    @property
    def limits(self) -> tuple[Floats, Floats]:
        """Least and largest values of the unknowns."""
        low, high = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        for k, each in enumerate(self.ranges):
            if np.isfinite(each.low):
                low[k], high[k] = 0.0, 1.0
        return low, high

    def head_values(self, head: Floats) -> Floats:
        """Parameters and nuisances in their own units."""
        values: Floats = self._origin + self._units * head[: self.h]
        return values

    def head_units(self) -> Floats:
        """Units in which parameters and nuisances are counted."""
        return self._units

    def head_of(self, values: Floats) -> Floats:
        """The head with parameters and nuisances given in their own units."""
        head: Floats = (values - self._origin) / self._units
        return head

    def guess(self) -> Floats:
        """Parameters and nuisances to begin with, in their own units."""
        return np.array([each.guess for each in self.ranges])

    def join(self, head: Floats, states: Floats) -> Floats:
        """All unknowns; states (M, n) in their own units."""
        return np.concatenate([head, (states / self.scales).ravel()])

    def states_of(self, u: Floats) -> Floats:
        """States at the starts of the segments, (M, n)."""
        states: Floats = u[self.h :].reshape(self.n_segments, self.n) * self.scales
        return states

    def join_segments(self, u: Floats) -> Floats:
        """Make segments that belong together one, and leave out the states between them."""
        states = self.states_of(u)[:: self.together]
        self.bounds, self.together = self.bounds[:: self.together], 1
        self.n_segments = len(states)
        self.size = self.h + self.n_segments * self.n
        self.forget_plans()
        return self.join(u[: self.h], states)

    def set_up(self, head: Floats) -> bool:
        """Take the parameters of the head; whether the system admits them."""
        values = self.head_values(head)[: self.p]
        return self.flights.set_up(dict(zip(self.free, map(float, values), strict=True)))

    @property
    def gap_unit(self) -> float:
        """What a gap between segments is measured in, as a part of the size of a state."""
        return _UNIT

    # ------------------------------------------------------------ residuals

    def evaluate(self, u: Floats, noise: Floats) -> Evaluation | None:
        """Residuals and gaps with their derivatives; None where a segment ends early."""
        if not self.set_up(u):
            return None
        states, plans = self.states_of(u), self.plans(u)
        flown: list[Flight] = []
        modes = [ANY]
        for m, plan in enumerate(plans):
            flight = self.fly(m, states[m], plan, modes[m])
            if flight is None:
                return None
            flown.append(flight)
            modes.append(flight.last_mode)
        rows = self.rows(list(range(self.n_segments)), flown, plans, u, noise)
        if rows is None:
            return None
        unit = _UNIT * self.scales
        followed = flown[: self.n_gaps]
        ends = np.array([flight.samples.states[-1] for flight in followed]).reshape(-1, self.n)
        columns = np.array([flight.columns[-1] for flight in followed])
        columns = columns.reshape(-1, self.n, self.n + self.p) / unit[:, None]
        starts = np.roll(states, -1, axis=0)[: self.n_gaps]
        by_head = np.zeros((len(ends), self.n, self.h))
        by_head[:, :, : self.p] = columns[:, :, self.n :] * self._units[: self.p]
        return Evaluation(
            rows, (ends - starts) / unit, by_head, columns[:, :, : self.n] * self.scales, modes[:-1]
        )

    def fly(self, m: int, state: Floats, plan: SegmentData, mode: int = ANY) -> Flight | None:
        """Run through a segment from a mode on; its end is the last sample."""
        times = np.append(plan.times, self.bounds[m + 1])
        return self.flights.fly(state, float(self.bounds[m]), times, mode)

    def plans(self, u: Floats) -> list[SegmentData]:
        """Data of each segment, for the delays of the head."""
        if self._plans is not None and self._fixed_plans:
            return self._plans
        values = np.array([each.values for each in self.channels])
        self._plans = self.plans_of(values, u, self.bounds[-1])
        return self._plans

    def plans_of(self, values: Floats, u: Floats, last: float) -> list[SegmentData]:
        """Data (C, K) that are numbers, by segment; times beyond the last one are cut to it."""
        of, where = np.nonzero(np.isfinite(values))
        delays = np.array([self.nuisance(c, "delay", u) for c in range(len(self.channels))])
        when = self.times[where] - delays[of]
        first = self.bounds[0]
        if self.is_cycle:
            length = self.bounds[-1] - first
            part = np.mod((when - first) / length, 1.0)
            when = first + length * (np.round(part / _INSTANT) * _INSTANT)
        segment = np.searchsorted(self.bounds[1:-1], when, side="right")
        when = np.clip(when, first, last)
        plans = []
        for m in range(self.n_segments):
            here = np.flatnonzero(segment == m)
            times, instant = np.unique(when[here], return_inverse=True)
            data = values[of[here], where[here]]
            plans.append(SegmentData(times, instant, of[here], data, where[here]))
        return plans

    def multipliers(self, found: Evaluation) -> npt.NDArray[np.complex128]:
        """Multipliers (n,) of a cycle: how disturbances have grown after it."""
        growth = np.eye(self.n)
        for each in found.gap_state:
            growth = _UNIT * each @ growth
        multipliers: npt.NDArray[np.complex128] = np.linalg.eigvals(growth).astype(complex)
        return multipliers

    def forget_plans(self) -> None:
        """Read the data anew at the next evaluation."""
        self._plans = None

    def nuisance(self, c: int, key: str, u: Floats) -> float:
        """Gain, offset or delay of a channel."""
        if (c, key) in self.nuisances:
            k = self.p + self.nuisances.index((c, key))
            return float(self._origin[k] + self._units[k] * u[k])
        return float(getattr(self.channels[c], key).guess)

    def rows(
        self,
        segments: Sequence[int],
        flown: Sequence[Flight],
        plans: Sequence[SegmentData],
        u: Floats,
        noise: Floats,
    ) -> Residuals | None:
        """Residuals of the data of some segments; None where a quantity is no finite number."""
        seen_at = [flight.samples for flight in flown]
        samples = MotionSamples(
            np.concatenate([each.number[:-1] for each in seen_at]),
            np.concatenate([each.phase[:-1] for each in seen_at]),
            np.concatenate([each.modes[:-1] for each in seen_at]),
            np.concatenate([each.states[:-1] for each in seen_at]),
        )
        values = self.flights.values
        seen = self.observation.look(samples, self.flights.window, values, self.step)
        first = np.cumsum([0, *(plan.times.size for plan in plans)])
        at = np.concatenate([plan.instant + first[i] for i, plan in enumerate(plans)])
        of = np.concatenate([plan.channel for plan in plans])
        columns = np.concatenate([flight.columns[:-1] for flight in flown])[at]
        gain, offset, _ = (
            np.array([self.nuisance(c, key, u) for c in range(len(self.channels))])[of]
            for key in _NUISANCES
        )
        weight = gain / noise[of]
        moved = np.einsum("kn,knc->kc", seen.by_state[of, at], columns)
        head = np.zeros((at.size, self.h))
        head[:, : self.p] = moved[:, self.n :] + seen.by_parameter[of, at]
        head[:, : self.p] *= weight[:, None]
        for k, (c, key) in enumerate(self.nuisances, start=self.p):
            own = of == c
            here = at[own]
            by = {"gain": seen.values[c, here], "offset": 1.0, "delay": -gain[own] *
                  seen.in_time[c, here]}[key]  # fmt: skip
            head[own, k] = by / noise[c]
        head *= self._units
        data = np.concatenate([plan.data for plan in plans])
        residual = (gain * seen.values[of, at] + offset - data) / noise[of]
        state = moved[:, : self.n] * weight[:, None] * self.scales
        if not (np.isfinite(residual).all() and np.isfinite(head).all()):
            return None
        place = np.concatenate([plan.place for plan in plans])
        segment = np.repeat(segments, [plan.channel.size for plan in plans])
        return Residuals(residual, head, state, of, place, segment)
