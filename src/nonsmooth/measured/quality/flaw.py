"""What a check finds: kinds of flaws, one flaw, and the samples of one channel."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.measured.clock import usual_step
from nonsmooth.measured.quality.noise import Noise

__all__ = ["FLAGS", "KINDS", "Flaw", "Readings", "stretches"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Places = npt.NDArray[np.int64]

# Flaws of samples, with the bit that a mask has for each.
FLAGS = {"missing": 1, "frozen": 2, "clipped": 4, "spike": 8}

# All that is looked for; what has no bit concerns a whole channel, or the time.
KINDS = (*FLAGS, "constant", "drift", "runaway", "hum", "gap", "uneven", "marks")


class Flaw(NamedTuple):
    """One flaw; ``places`` are the numbers of its samples, where it is one of samples."""

    channel: str
    kind: str
    begin: float
    end: float
    n_samples: int
    size: float
    sentence: str
    places: Places | None = None
    doubtful: bool = True  # False for what the reader should know, and what is no flaw by itself


class Readings(NamedTuple):
    """One channel: its readings over time, their noise, and what the limits are made for."""

    name: str
    times: Floats
    values: Floats
    units: str
    noise: Noise
    rate: float  # false alarms that one test of this channel may give

    @property
    def span(self) -> tuple[float, float]:
        """First and last time."""
        return float(self.times[0]), float(self.times[-1])

    @property
    def step(self) -> float:
        """Usual time between samples."""
        return usual_step(self.times)

    def size(self, value: float) -> str:
        """A value with its units."""
        return f"{value:.4g} {self.units}".rstrip()


def stretches(mask: Mask) -> Iterator[tuple[int, int]]:
    """First sample of each stretch of a mask, and the one behind its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    for first, last in edges.reshape(-1, 2):
        yield int(first), int(last)
