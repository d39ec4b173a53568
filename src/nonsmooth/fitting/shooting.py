"""Multiple shooting: records as equations for one set of unknowns, with continuity as equations.

Each record is cut into segments. The state at the start of each segment is unknown, so each run is
short and an error of the parameters cannot grow over the whole record, nor can a chaotic motion
lose it. That the end of a segment is the start of the next one, up to whole turns of angles, is an
equation, which the solver brings to hold (`nonsmooth.fitting.solver`). In the end a segment also
begins in the mode in which the one before has ended, which counts where its state fits several
modes. The last segment of a steady motion ends where the first one begins.

Unknowns are counted in units of their ranges: first the head, which has the parameters and what is
free of the sensors, then the states of all segments. Records share the entries of the head but for
those that are private to each.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.fitting.channels import Range
from nonsmooth.fitting.course import Course
from nonsmooth.fitting.record_equations import RecordEquations
from nonsmooth.fitting.residuals import Residuals, joined
from nonsmooth.runs.whole_turns import whole_turns

__all__ = ["Evaluation", "Shooting"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_UNIT = 0.02  # of the size of a state: what a gap between segments is measured in
_GROWTH = 10.0  # of an error in segments that become one, at most
_UNKNOWNS = 100  # few: decomposing a matrix of that size costs less than the runs


class Evaluation(NamedTuple):
    """Residuals of all data, and the gaps between segments; G gaps, h unknowns of the head."""

    rows: Residuals
    gap: Floats  # (G, n): end of a segment less the start of the next
    gap_head: Floats  # (G, n, h)
    gap_state: Floats  # (G, n, n), by the start of the segment
    modes: list[int]  # in which each segment is to begin: that in which the one before has ended


class Shooting:
    """Records as equations for parameters, what their sensors do, and states."""

    def __init__(
        self,
        records: Sequence[RecordEquations],
        free: Sequence[Range],
        labels: Sequence[str],
        private: Collection[str] = (),
    ) -> None:
        self.records, self.labels = list(records), list(labels)
        self.free, self.private = list(free), sorted(private)
        first = self.records[0]
        self.system, self.n, self.p = first.system, first.n, first.p
        self.channels = [channel for record in records for channel in record.channels]
        self._check_private(private)
        self.names: list[str] = []
        self.ranges: list[Range] = []
        self._places = [
            self._enter(record, free, label, private)
            for record, label in zip(records, labels, strict=True)
        ]
        self.h = len(self.ranges)
        self._origin = np.array([r.low if np.isfinite(r.low) else r.guess for r in self.ranges])
        self._units = np.array([r.scale for r in self.ranges])
        self._first_channel = np.cumsum([0, *(len(record.channels) for record in records)])
        self._count_segments()

    def _count_segments(self) -> None:
        """Places of the segments among the unknowns, and which of them belong together."""
        counts = [record.n_segments for record in self.records]
        self._first_segment = np.cumsum([0, *counts])
        self.n_segments = int(self._first_segment[-1])
        self.links = np.concatenate([self._links(r) for r in range(len(self.records))])
        self.size = self.h + self.n_segments * self.n

    def _enter(
        self, record: RecordEquations, free: Sequence[Range], label: str, private: Collection[str]
    ) -> Integers:
        """Places in the head of what a record has in its own; what is new is entered."""
        ranges = [*free, *(record.range_of(each) for each in record.nuisances)]
        places = []
        for name, each in zip(record.names, ranges, strict=True):
            called = f"{label} {name}" if name in private and label else name
            if called not in self.names:
                self.names.append(called)
                self.ranges.append(each)
            places.append(self.names.index(called))
        return np.array(places, np.int64)

    def _check_private(self, private: Collection[str]) -> None:
        known = {name for record in self.records for name in record.names}
        for name in private:
            if name not in known:
                raise OptionError(f"private: {unknown_name('name of what is found', name, known)}")

    def _links(self, r: int) -> Integers:
        """Segments of a record that must end where another one begins, and which, (G, 2)."""
        record, first = self.records[r], self._first_segment[r]
        before = np.arange(record.n_gaps)
        return first + np.stack([before, (before + 1) % record.n_segments], axis=1)

    # ------------------------------------------------------------ unknowns

    @property
    def n_gaps(self) -> int:
        """Number of places where a segment must end where another one begins."""
        return len(self.links)

    @property
    def n_spent(self) -> int:
        """Number of unknowns that only the data determine: a cycle has no free start."""
        return self.h + sum(0 if record.is_cycle else self.n for record in self.records)

    def n_free_data(self, found: Evaluation) -> float:
        """How many data are more than the unknowns, at least one."""
        return float(max(1, found.rows.residual.size - self.n_spent))

    @property
    def limits(self) -> tuple[Floats, Floats]:
        """Least and largest values of the unknowns."""
        low, high = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        for k, each in enumerate(self.ranges):
            if np.isfinite(each.low):
                low[k], high[k] = 0.0, 1.0
        return low, high

    @property
    def scales(self) -> Floats:
        """Sizes of the states, in which they are counted."""
        return self.records[0].scales

    def tell(self, course: Course) -> None:
        """Let each motion move the bar of a course."""
        for record in self.records:
            record.course = course

    def scale_states(self, sizes: Floats) -> None:
        """Take the sizes of the states."""
        for record in self.records:
            record.scales = sizes

    @property
    def bounds(self) -> Floats:
        """Starts of all segments."""
        return np.concatenate([record.bounds[:-1] for record in self.records])

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

    @property
    def is_spread(self) -> npt.NDArray[np.bool_]:
        """Which entries of the head are spread over their ranges by starts: no gains and the like.

        Those are as well from any start; parameters and the shift of a clock are not.
        """
        found = np.zeros(self.h, bool)
        for record, places in zip(self.records, self._places, strict=True):
            found[places[: self.p]] = True
            for place, (c, _) in zip(places[self.p :], record.nuisances, strict=True):
                found[place] |= c < 0
        return found

    def values_in(self, r: int, values: Floats) -> Floats:
        """What a record has in its head, of the values of all."""
        own: Floats = values[self._places[r]]
        return own

    def noise_in(self, r: int, noise: Floats) -> Floats:
        """Noise of the channels of a record."""
        return noise[self._first_channel[r] : self._first_channel[r + 1]]

    def channels_in(self, r: int) -> range:
        """Which of all channels are those of a record."""
        return range(self._first_channel[r], self._first_channel[r + 1])

    @property
    def record_of_channel(self) -> Integers:
        """Number of the record of each channel."""
        return np.repeat(np.arange(len(self.records)), np.diff(self._first_channel))

    def segments_in(self, r: int) -> slice:
        """Which of all segments are those of a record."""
        return slice(self._first_segment[r], self._first_segment[r + 1])

    def join(self, head: Floats, states: Floats) -> Floats:
        """All unknowns; states (M, n) in their own units."""
        return np.concatenate([head, (states / self.scales).ravel()])

    def states_of(self, u: Floats) -> Floats:
        """States at the starts of the segments, (M, n)."""
        states: Floats = u[self.h :].reshape(self.n_segments, self.n) * self.scales
        return states

    @property
    def whole_segments(self) -> Integers:
        """Segments that are left where the parts of each become one."""
        first = self._first_segment
        return np.concatenate(
            [
                np.arange(first[r], first[r + 1], record.together)
                for r, record in enumerate(self.records)
            ]
        )

    def calm_segments(self, found: Evaluation) -> Integers:
        """Segments that are left where neighbours become one, as long as no error grows in them.

        No more become one than it takes to have few unknowns: short segments lead a search well.
        """
        kept: list[int] = []
        longest = -(-self.size // _UNKNOWNS)
        growth = dict(zip(self.links[:, 0], _UNIT * found.gap_state, strict=True))
        for r, record in enumerate(self.records):
            begun, own, grown = -1, np.eye(self.n), np.eye(self.n)
            for m in range(self._first_segment[r], self._first_segment[r + 1]):
                own = growth.get(m, own)  # the last one, which ends at no start, as that before
                grown = own @ grown
                calm = record.may_join and np.linalg.norm(grown, 2) <= _GROWTH
                if begun < 0 or not calm or m - begun >= longest:
                    begun, grown = m, own
                    kept.append(m)
        return np.array(kept, np.int64)

    def join_segments(self, u: Floats, kept: Integers) -> Floats:
        """Let some segments reach as far as the next of them, without the states between them."""
        states = self.states_of(u)[kept]
        for r, record in enumerate(self.records):
            here = self.segments_in(r)
            record.join_segments(kept[(kept >= here.start) & (kept < here.stop)] - here.start)
        self._count_segments()
        return self.join(u[: self.h], states)

    def set_up(self, head: Floats) -> bool:
        """Take the parameters of the head; whether the system admits them."""
        values = self.head_values(head)
        return all(
            record.set_up(self.values_in(r, values)) for r, record in enumerate(self.records)
        )

    @property
    def gap_unit(self) -> float:
        """What a gap between segments is measured in, as a part of the size of a state."""
        return _UNIT

    def begin_as(self, found: Evaluation) -> None:
        """Let first segments, and those with modes of their own, begin as in an evaluation."""
        for first, record in zip(self._first_segment, self.records, strict=False):
            record.first_mode = found.modes[first]
            record.own_modes = {m: found.modes[first + m] for m in record.own_modes}

    def carry_modes(self) -> None:
        """Let each segment begin in the mode in which the one before has ended."""
        for record in self.records:
            record.own_modes = {}

    def forget_plans(self) -> None:
        """Read the data anew at the next evaluation."""
        for record in self.records:
            record.forget_plans()

    # ------------------------------------------------------------ residuals

    def evaluate(self, u: Floats, noise: Floats) -> Evaluation | None:
        """Residuals and gaps with their derivatives; None where a segment ends early."""
        if not self.set_up(u):
            return None
        parts = []
        for r in range(len(self.records)):
            part = self._evaluate_record(r, u, noise)
            if part is None:
                return None
            parts.append(part)
        rows = joined([part.rows for part in parts])
        return Evaluation(
            rows,
            np.concatenate([part.gap for part in parts]),
            np.concatenate([part.gap_head for part in parts]),
            np.concatenate([part.gap_state for part in parts]),
            [mode for part in parts for mode in part.modes],
        )

    def _evaluate_record(self, r: int, u: Floats, noise: Floats) -> Evaluation | None:
        record, values = self.records[r], self.values_in(r, self.head_values(u))
        states, plans = self.states_of(u)[self.segments_in(r)], record.plans(values)
        motion = record.fly_all(states, plans)
        if motion is None:
            return None
        flown, modes = motion
        rows = record.rows(
            list(range(record.n_segments)), flown, plans, values, self.noise_in(r, noise)
        )
        if rows is None:
            return None
        unit = _UNIT * self.scales
        followed = flown[: record.n_gaps]
        ends = np.array([flight.samples.states[-1] for flight in followed]).reshape(-1, self.n)
        columns = np.array([flight.columns[-1] for flight in followed])
        columns = columns.reshape(-1, self.n, self.n + self.p) / unit[:, None]
        starts = np.roll(states, -1, axis=0)[: record.n_gaps]
        ends -= whole_turns(ends - starts, record.angle_periods)
        by_own = np.zeros((len(ends), self.n, record.h))
        by_own[:, :, : self.p] = columns[:, :, self.n :]
        return Evaluation(
            rows._replace(
                head=self._spread(r, rows.head),
                channel=rows.channel + self._first_channel[r],
                segment=rows.segment + self._first_segment[r],
            ),
            (ends - starts) / unit,
            self._spread(r, by_own),
            columns[:, :, : self.n] * self.scales,
            modes,
        )

    def _spread(self, r: int, by_own: Floats) -> Floats:
        """Derivatives by the head, in units of the solver, from those by what a record has."""
        found = np.zeros((*by_own.shape[:-1], self.h))
        found[..., self._places[r]] = by_own
        found *= self._units
        return found

    def multipliers(self, found: Evaluation) -> list[npt.NDArray[np.complex128]]:
        """Multipliers (n,) of each cycle: how disturbances have grown after it."""
        multipliers = []
        for r, record in enumerate(self.records):
            if record.is_cycle:
                growth = np.eye(self.n)
                here = np.isin(self.links[:, 0], np.arange(self.n_segments)[self.segments_in(r)])
                for each in found.gap_state[here]:
                    growth = _UNIT * each @ growth
                multipliers.append(np.linalg.eigvals(growth).astype(complex))
        return multipliers
