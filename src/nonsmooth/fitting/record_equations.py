"""One record as equations: residuals of its data and their derivatives, segment by segment.

The head of a record has the parameters that are found and what is free of its sensors, in their own
units. Samples are residuals of observed quantities; picked events are residuals of the instants
at which the motion has such an event.

A steady motion repeats itself after a cycle. All data are folded into the first cycle, so that one
cycle is run however long the record is.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import ANY
from nonsmooth.fitting.channels import ObservedChannel, Range
from nonsmooth.fitting.course import Course
from nonsmooth.fitting.event_instants import EventInstants
from nonsmooth.fitting.event_residuals import residuals_of_events
from nonsmooth.fitting.flights import Flight, Flights
from nonsmooth.fitting.observation import MotionSamples, Observation
from nonsmooth.fitting.residuals import (
    Residuals,
    SegmentData,
    in_order_of_segments,
    joined,
    no_residuals,
)
from nonsmooth.runs.whole_turns import periods_of_states, whole_turns
from nonsmooth.system.system import System

__all__ = ["RecordEquations"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

NO_SHIFT = Range(0.0, 0.0, 0.0)
_NUISANCES = ("gain", "offset", "delay")
_PASSES = 4  # of a cycle: each mode of two, as those of a latch, twice
_LOOKS = 16  # samples at which it is seen how far a quantity goes in a turn of an angle
_INSTANT = 1e-12  # of a cycle: samples that lie closer after folding are at one instant


class RecordEquations:
    """A record as equations for parameters, what its sensors do, and states of its segments."""

    def __init__(
        self,
        system: System,
        free: Sequence[str],
        channels: Sequence[ObservedChannel],
        times: Floats,
        bounds: Floats,
        tolerance: float,
        shift: Range = NO_SHIFT,
        *,
        is_cycle: bool = False,
        together: int = 1,
        may_join: bool = False,
    ) -> None:
        self.system, self.channels, self.times, self.bounds = system, channels, times, bounds
        self.free, self.shift = tuple(free), shift
        self.together = together  # parts of a segment, with which a search begins
        self.may_join = may_join  # whether segments may become one where no error grows
        self.is_cycle = is_cycle  # whether the motion repeats itself after the last segment
        self.nuisances = [
            (c, key)
            for c, channel in enumerate(channels)
            for key in _NUISANCES
            if getattr(channel, key).is_free
        ]
        self.nuisances += [(-1, "shift")] if shift.is_free else []
        self._sampled = [c for c, channel in enumerate(channels) if not channel.shows_events]
        self._picked = [c for c, channel in enumerate(channels) if channel.shows_events]
        events = [channels[c].text for c in self._picked]
        self.flights = Flights(system, self.free, tolerance, events)
        self._moves = any(key in ("delay", "shift") for _, key in self.nuisances)
        texts = {channels[c].name: channels[c].text for c in self._sampled}
        self.observation = Observation(system, texts, self.free, rates=self._moves)
        self.step = float(np.median(np.diff(times))) if times.size > 1 else 1.0
        self.n, self.p = len(system.states), len(self.free)
        self.h = self.p + len(self.nuisances)
        self.scales = np.ones(self.n)  # of the states
        self.first_mode = ANY  # in which the first segment is to begin
        # of segments that fit several modes, as long as they are not to join; the others begin in
        # the mode in which the one before has ended
        self.own_modes: dict[int, int] = {}
        self._plans: list[SegmentData] | None = None
        self._turns: Floats | None = None
        self.angle_periods = periods_of_states(system)
        self.course: Course | None = None  # that is told of each motion

    @property
    def n_segments(self) -> int:
        """Number of segments."""
        return self.bounds.size - 1

    def join_segments(self, kept: Integers) -> None:
        """Let some segments reach as far as the next of them; the first one is among them."""
        self.bounds, self.together = np.append(self.bounds[kept], self.bounds[-1]), 1
        self.forget_plans()

    @property
    def n_gaps(self) -> int:
        """Number of places where a segment must end where another one begins."""
        return self.n_segments - (0 if self.is_cycle else 1)

    def range_of(self, nuisance: tuple[int, str]) -> Range:
        """Bounds of something that is free of the sensors."""
        c, key = nuisance
        found: Range = self.shift if c < 0 else getattr(self.channels[c], key)
        return found

    @property
    def names(self) -> list[str]:
        """Names of all entries of the head, such as ``a1 gain``."""
        sensors = [key if c < 0 else f"{self.channels[c].name} {key}" for c, key in self.nuisances]
        return [*self.free, *sensors]

    def nuisance(self, c: int, key: str, head: Floats) -> float:
        """Gain, offset or delay of a channel; the shift of the clock for channel -1."""
        if (c, key) in self.nuisances:
            return float(head[self.p + self.nuisances.index((c, key))])
        return float(self.range_of((c, key)).guess)

    def period(self, head: Floats) -> float | None:
        """Period of the forcing with the parameters of the head."""
        values = dict(zip(self.free, map(float, head[: self.p]), strict=True))
        return self.system.with_parameters(**values).period_value

    def set_up(self, head: Floats) -> bool:
        """Take the parameters of the head; whether the system admits them."""
        return self.flights.set_up(dict(zip(self.free, map(float, head), strict=False)))

    def limit_work(self, initial: Floats) -> None:
        """Let runs end early that need far more work than a motion through the data."""
        count = sum(int(np.isfinite(channel.values).sum()) for channel in self.channels)
        begin, end = float(self.bounds[0]), float(self.bounds[-1])
        self.flights.limit_work(initial, begin, end, max(1, count))

    def fly(self, m: int, state: Floats, plan: SegmentData, mode: int = ANY) -> Flight | None:
        """Run through a segment from a mode on; its end is the last sample."""
        if self.course is not None:
            self.course.move(1.0 / self.n_segments)
        times, begin = np.append(plan.times, self.bounds[m + 1]), float(self.bounds[m])
        return self.flights.fly(state, begin, times, mode, events=bool(self._picked))

    def fly_all(
        self, states: Floats, plans: Sequence[SegmentData]
    ) -> tuple[list[Flight], list[int]] | None:
        """Run through all segments, each from the mode in which the one before has ended.

        Those of a cycle are run again until the first one begins in the mode of the end. Also
        returned are the modes in which they were to begin.
        """
        flown: list[Flight] = []
        begun: list[int] = []
        mode = self.first_mode
        for _ in range(_PASSES if self.is_cycle else 1):
            for m, plan in enumerate(plans):
                mode = self.own_modes.get(m, mode)
                if m < len(flown) and begun[m] == mode:
                    break  # from here on nothing changes
                flight = self.fly(m, states[m], plan, mode)
                if flight is None:
                    return None
                flown[m : m + 1], begun[m : m + 1] = [flight], [mode]
                mode = flight.last_mode
            mode = flown[-1].last_mode
            if self.own_modes.get(0, mode) == begun[0]:
                break
        return flown, begun

    def without_events_before(self, flight: Flight, plan: SegmentData) -> Flight:
        """A flight without events before the first picked one, of which a part was picked only."""
        events = flight.events
        if events is None:
            none = EventInstants(np.zeros(0), np.zeros(0, np.int64), np.zeros((0, self.n + self.p)))
            return flight._replace(events=none)
        late = events.times > plan.event_time[0] - self.wait
        kept = EventInstants(events.times[late], events.name[late], events.columns[late])
        return flight._replace(events=kept)

    @property
    def wait(self) -> float:
        """How far an event of the motion may be from the picked one that it is, at most."""
        return max((self.channels[c].spread for c in self._picked), default=0.0)

    # ------------------------------------------------------------ data

    def plans(self, head: Floats) -> list[SegmentData]:
        """Data of each segment, for the delays of the head."""
        if self._plans is None or self._moves:
            values = [channel.values for channel in self.channels]
            self._plans = self.plans_of(values, head, self.bounds[-1])
        return self._plans

    def forget_plans(self) -> None:
        """Read the data anew at the next evaluation."""
        self._plans = None

    def plans_of(self, values: Sequence[Floats], head: Floats, last: float) -> list[SegmentData]:
        """Data that are numbers, by segment; times beyond the last one are cut to it."""
        late = [
            self.nuisance(c, "delay", head) - self.nuisance(-1, "shift", head)
            for c in range(len(values))
        ]
        first = self.bounds[0]
        samples = np.array([values[c] for c in self._sampled])
        samples = samples.reshape(len(self._sampled), self.times.size)
        row, place = np.nonzero(np.isfinite(samples))
        of = np.array(self._sampled, np.int64)[row]
        when = self._folded(self.times[place] - np.array(late)[of])
        segment = np.searchsorted(self.bounds[1:-1], when, side="right")
        when = np.clip(when, first, last)
        data = samples[row, place]
        picks = [np.flatnonzero(np.isfinite(values[c])) for c in self._picked]
        event_place = np.concatenate([*picks, np.zeros(0, np.int64)])
        event_of = np.repeat(np.array(self._picked, np.int64), [each.size for each in picks])
        happened = [values[c][here] - late[c] for c, here in zip(self._picked, picks, strict=True)]
        event_time = self._folded(np.concatenate([*happened, np.zeros(0)]))
        order = np.argsort(event_time, kind="stable")
        event_time, event_of, event_place = event_time[order], event_of[order], event_place[order]
        event_segment = np.searchsorted(self.bounds[1:-1], event_time, side="right")
        plans = []
        for m in range(self.n_segments):
            here, there = np.flatnonzero(segment == m), np.flatnonzero(event_segment == m)
            times, instant = np.unique(when[here], return_inverse=True)
            plans.append(
                SegmentData(
                    times, instant, of[here], data[here], place[here],
                    event_of[there], event_time[there], event_place[there],
                )
            )  # fmt: skip
        return plans

    def _folded(self, when: Floats) -> Floats:
        """Times in the first cycle, where the motion repeats itself."""
        if not self.is_cycle:
            return when
        first, length = self.bounds[0], self.bounds[-1] - self.bounds[0]
        part = np.mod((when - first) / length, 1.0)
        folded: Floats = first + length * (np.round(part / _INSTANT) * _INSTANT)
        return folded

    # ------------------------------------------------------------ residuals

    def rows(
        self,
        segments: Sequence[int],
        flown: Sequence[Flight],
        plans: Sequence[SegmentData],
        head: Floats,
        noise: Floats,
    ) -> Residuals | None:
        """Residuals of the data of some segments; None where a quantity is no finite number."""
        parts = [self._of_samples(segments, flown, plans, head, noise)]
        if self._picked:
            together = zip(segments, flown, plans, strict=True)
            parts += [self._of_events(m, flight, plan, head, noise)
                      for m, flight, plan in together]  # fmt: skip
        found = joined(parts)
        if not (np.isfinite(found.residual).all() and np.isfinite(found.head).all()):
            return None
        return in_order_of_segments(found) if self._picked else found

    def _of_samples(
        self,
        segments: Sequence[int],
        flown: Sequence[Flight],
        plans: Sequence[SegmentData],
        head: Floats,
        noise: Floats,
    ) -> Residuals:
        """Residuals of samples."""
        seen_at = [flight.samples for flight in flown]
        samples = MotionSamples(
            np.concatenate([each.number[:-1] for each in seen_at]),
            np.concatenate([each.phase[:-1] for each in seen_at]),
            np.concatenate([each.modes[:-1] for each in seen_at]),
            np.concatenate([each.states[:-1] for each in seen_at]),
        )
        if not self._sampled:
            return no_residuals(self.h, self.n, 0)
        values = self.flights.values
        seen = self.observation.look(samples, self.flights.window, values, self.step)
        turns = self._turns_of_channels(samples)
        first = np.cumsum([0, *(plan.times.size for plan in plans)])
        at = np.concatenate([plan.instant + first[i] for i, plan in enumerate(plans)])
        of = np.concatenate([plan.channel for plan in plans])
        row = np.searchsorted(self._sampled, of)
        columns = np.concatenate([flight.columns[:-1] for flight in flown])[at]
        gain, offset, _ = (
            np.array([self.nuisance(c, key, head) for c in range(len(self.channels))])[of]
            for key in _NUISANCES
        )
        weight = gain / noise[of]
        data = np.concatenate([plan.data for plan in plans])
        apart = gain * seen.values[row, at] + offset - data
        over = whole_turns(apart, np.abs(gain) * turns[row])
        turned = np.divide(over, gain, out=np.zeros_like(over), where=gain != 0.0)
        moved = np.einsum("kn,knc->kc", seen.by_state[row, at], columns)
        by_head = np.zeros((at.size, self.h))
        by_head[:, : self.p] = moved[:, self.n :] + seen.by_parameter[row, at]
        by_head[:, : self.p] *= weight[:, None]
        for k, (c, key) in enumerate(self.nuisances, start=self.p):
            own = of == c if c >= 0 else np.ones(of.size, bool)
            here = row[own], at[own]
            if key in ("gain", "offset"):
                by = seen.values[here] - turned[own] if key == "gain" else 1.0
                by_head[own, k] = by / noise[c]
            else:
                by = weight[own] * seen.in_time[here]
                by_head[own, k] = by if key == "shift" else -by
        return no_residuals(self.h, self.n, 0)._replace(
            residual=(apart - over) / noise[of],
            head=by_head,
            state=moved[:, : self.n] * weight[:, None] * self.scales,
            channel=of,
            place=np.concatenate([plan.place for plan in plans]),
            segment=np.repeat(segments, [plan.channel.size for plan in plans]),
            matched=np.ones(of.size, bool),
        )

    def _turns_of_channels(self, samples: MotionSamples) -> Floats:
        """The way of each sampled quantity over one turn, where whole turns of it do not count.

        So it is where a sensor gives an angle within one turn, and where a motion repeats itself up
        to whole turns. Otherwise data go on with the angle, and how far they go counts.
        """
        if self._turns is None:
            if samples.phase.size == 0:  # of a segment without data, which tells nothing
                return np.zeros(len(self._sampled))
            turns = self.ways_of_turns(samples)
            counts = [
                self.is_cycle or self.channels[c].is_within(abs(self.channels[c].gain.guess) * turn)
                for c, turn in zip(self._sampled, turns, strict=True)
            ]
            self._turns = np.where(counts, turns, 0.0)
        return self._turns

    def ways_of_turns(self, samples: MotionSamples) -> Floats:
        """How far each sampled quantity goes while an angle turns once, zero of others."""
        at = np.unique(np.linspace(0, samples.phase.size - 1, _LOOKS).astype(int))
        some = MotionSamples(*(each[at] for each in samples))
        flights = self.flights
        return self.observation.turns(some, flights.window, flights.values, self.angle_periods)

    def _of_events(
        self, m: int, flight: Flight, plan: SegmentData, head: Floats, noise: Floats
    ) -> Residuals:
        """Residuals of the events that were picked in a segment."""
        assert flight.events is not None
        waits = [self.channels[c].spread for c in self._picked]
        found = residuals_of_events(
            flight.events, plan, self._picked, waits, noise, self.h, self.n, repeats=self.is_cycle
        )
        for k, (c, key) in enumerate(self.nuisances, start=self.p):
            if key in ("delay", "shift"):
                own = found.matched & ((plan.event_channel == c) | (c < 0))
                sign = 1.0 if key == "delay" else -1.0
                found.head[own, k] = sign / noise[plan.event_channel[own]]
        return found._replace(state=found.state * self.scales, segment=np.full(found.place.size, m))
