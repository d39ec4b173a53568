"""Motions in which orbits are looked for: points of a section, and the legs between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.record import columns
from nonsmooth.engine.status import EventKind, Status
from nonsmooth.engine.tables import Tables
from nonsmooth.periodic_orbits.equations import Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.orbit import OrbitRequest
from nonsmooth.periodic_orbits.word import Word, path_of_bits
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.first_mode import in_first_mode
from nonsmooth.runs.runner import Outcome, run_plan
from nonsmooth.runs.start import resolve_start, start_at_end

__all__ = ["Motion", "first_motion", "motion_from"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Motion:
    """A motion as points: strobes of a driven one, states behind events of any other.

    Times count from the first window in which points are kept. Points of one ``kind`` lie on one
    section.
    """

    points: Floats  # (P, n)
    kinds: Integers  # (P,)
    times: Floats  # (P,)
    modes: Integers  # (P,) behind each point
    driven: bool
    phase: float  # time of the points since their windows began, 0 where they are events
    event_rows: Integers  # (E, 3): path, exits passed, mode behind
    event_times: Floats  # (E,)
    event_states: Floats  # (E, n) behind each event
    status: Status

    def between(self, i: int, j: int) -> slice:
        """Events behind point i; those of a driven motion before point j, else up to it."""
        side: Literal["left", "right"] = "left" if self.driven else "right"
        low = np.searchsorted(self.event_times, self.times[i], side="right")
        high = np.searchsorted(self.event_times, self.times[j], side=side)
        return slice(int(low), int(high))

    def word_key(self, i: int, j: int) -> bytes:
        """What tells the word from point i to point j from others."""
        return bytes([self.modes[i] & 255]) + self.event_rows[self.between(i, j)].tobytes()

    def guess(
        self, i: int, j: int, origin: Floats, drifting: npt.NDArray[np.bool_]
    ) -> Guess | None:
        """Legs from point i to point j, drifts shifted to those of an origin.

        None where more exits are passed at one instant than a word can hold.
        """
        part = self.between(i, j)
        rows, inner = self.event_rows[part], self.event_times[part]
        paths = [path_of_bits(int(bits), int(passes)) for bits, passes, _ in rows]
        if any(path is None for path in paths):
            return None
        kept = [path for path in paths if path is not None]
        modes = [int(self.modes[i]), *(int(row[2]) for row in rows)]
        states = np.vstack([self.points[i], self.event_states[part]])
        instants = np.concatenate([[self.times[i]], inner, [self.times[j]]])
        if self.driven:
            kept.append(())
        else:  # the last event is point j itself
            modes, states, instants = modes[:-1], states[:-1], instants[:-1]
        states = states - np.where(drifting, self.points[i] - origin, 0.0)
        return Guess(
            Word(tuple(modes), tuple(kept)), Turn(states, instants - instants[0] + self.phase)
        )


def first_motion(wanted: OrbitRequest, tables: Tables, periods: int, driven: bool) -> Motion:
    """Motion from the start that is given, some periods after its transient."""
    system = wanted.system
    window = tables.window
    start = resolve_start(system, tables, wanted.initial, None, wanted.mode, True)
    if start.anchor is not None:
        start = start_at_end(start)
    late = start.instant.phase > wanted.phase * window * (1.0 + 1e-14)
    first = start.instant.number + int(late) + wanted.transient

    def run(mode: int) -> Motion:
        return motion_from(wanted, tables, start.state, start.instant, first, periods, driven, mode)

    return in_first_mode(system, tables, start, run)


def motion_from(
    wanted: OrbitRequest, tables: Tables, state: Floats, begin: Instant, first: int, periods: int,
    driven: bool, mode: int = -1,
) -> Motion:  # fmt: skip
    """Motion from a state, its points from window ``first`` on; `NoMode` where none admits it."""
    phase = wanted.phase * tables.window
    numbers = first + np.arange(periods + 1, dtype=np.int64)
    plan = Plan(Instant(int(numbers[-1]), phase), numbers, np.full(periods + 1, phase))
    outcome = run_plan(tables, plan, wanted.tolerance, state=state, begin=begin, mode=mode)
    return _points(outcome, first, phase, driven)


def _points(outcome: Outcome, first: int, phase: float, driven: bool) -> Motion:
    rows, window = outcome.events, outcome.window
    keep = ~np.isin(rows["kind"], (EventKind.GRAZE, EventKind.START))
    since: Floats = (rows["number"] - first) * window + (rows["phase"] - phase)
    keep &= since > 0.0
    rows, states, times = rows[keep], outcome.event_states[keep, 1], since[keep]
    reached = outcome.n_samples
    kept = columns(rows, "path", "passes", "to_mode")
    if driven:
        return Motion(
            outcome.records.sample_state[:reached], np.zeros(reached, np.int64),
            np.arange(reached, dtype=float) * window, outcome.records.sample_mode[:reached], True,
            phase, kept, times, states, outcome.status,
        )  # fmt: skip
    tell = columns(rows, "from_mode", "path", "to_mode")
    _, kinds = np.unique(tell, axis=0, return_inverse=True)
    return Motion(
        states, kinds.reshape(-1), times, kept[:, 2], False, 0.0, kept, times, states,
        outcome.status,
    )  # fmt: skip
