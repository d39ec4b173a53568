"""Events of motions that were recorded side by side, counted and told between their samples."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from nonsmooth.runs.clock import rounding_of_events
from nonsmooth.runs.impacts import happened, impacts_of
from nonsmooth.runs.sweep_runner import Recorded
from nonsmooth.runs.words import rebounds_of, word_of_modes
from nonsmooth.system.system import System

__all__ = ["PassedEvents"]

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


class PassedEvents:
    """Events of K motions, r in all; tangencies are none."""

    def __init__(self, system: System, recorded: Recorded) -> None:
        self._system, self._recorded = system, recorded
        self.motion = np.repeat(np.arange(recorded.statuses.size), np.diff(recorded.logs))
        self._happened = happened(recorded.rows)
        self._impacts = impacts_of(system).in_rows(recorded.rows)
        self._rounding = rounding_of_events(
            recorded.rows["number"], recorded.rows["phase"], recorded.windows[self.motion]
        )
        self._words: dict[bytes, str] = {}

    def between(self, first: Integers, last: Integers | None = None) -> Bools:
        """Which rows are events from one sample of each motion on, (K,), before another one.

        An event at the instant of a sample, or a rounding before it, comes behind it: it has not
        changed its state.
        """
        within = self._happened & (self._since(first) >= -self._rounding)
        if last is not None:
            within &= self._since(last) < -self._rounding
        return np.asarray(within)

    def counts(self, rows: Bools) -> tuple[Floats, Floats]:
        """Events among some rows, and impacts among them, of each motion."""
        count = self._recorded.statuses.size
        motion, weights = self.motion[rows], self._impacts[rows]
        events = np.bincount(motion, minlength=count)
        impacts = np.bincount(motion, weights, minlength=count)
        return np.asarray(events, float), np.asarray(impacts, float)

    def words(self, first: Integers, rows: Bools, wanted: Bools) -> list[str]:
        """Modes from one sample of each motion on, through some events; "" where not wanted."""
        recorded = self._recorded
        counts = np.bincount(self.motion[rows], minlength=wanted.size)
        passed = recorded.rows[rows]
        entered, rebounds = passed["to_mode"], rebounds_of(passed)
        ends = np.cumsum(counts).tolist()
        return [
            self._word(np.append(recorded.modes[k, first[k]], entered[a:b]), rebounds[a:b])
            if wanted[k]
            else ""
            for k, (a, b) in enumerate(pairwise([0, *ends]))
        ]

    def _word(self, modes: Integers, rebounds: Integers) -> str:
        key = modes.tobytes() + rebounds.tobytes()  # of one length for each number of modes
        if key not in self._words:
            self._words[key] = word_of_modes(self._system, modes, rebounds)
        return self._words[key]

    def _since(self, sample: Integers) -> Floats:
        """Time of each row since a sample of its motion."""
        recorded, motion = self._recorded, self.motion
        rows, origin = recorded.rows, (motion, sample[motion])
        since = (rows["number"] - recorded.numbers[origin]) * recorded.windows[motion]
        since += rows["phase"] - recorded.phases[origin]
        return np.asarray(since)
