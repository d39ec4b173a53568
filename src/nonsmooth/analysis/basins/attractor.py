"""An attractor as a set of points, and what is known of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.cycles import inside_circle

__all__ = ["Attractor", "canonical", "in_order", "renumbered"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Attractor:
    """Points of an attractor in the order in which they are visited."""

    points: Floats  # (K, n)
    modes: Integers  # (K,)
    period: int  # number of points of a cycle, 0 for a set that does not repeat
    drift: Floats  # (n,): change of each state per iterate
    kind: str = "aperiodic"
    multipliers: npt.NDArray[np.complex128] | None = None  # of a cycle
    residual: float = np.nan  # of a cycle, beside the scale
    radius: float = np.nan  # around points of a cycle, beside the scale: all starts return
    exponent: float = np.nan  # largest, per unit time, of a set that does not repeat
    exponent_error: float = np.nan
    word: str = ""
    image: int = 0  # number of the mirror image, from 1; 0 where none of those found is it

    @property
    def is_cycle(self) -> bool:
        """Whether its points repeat."""
        return self.period > 0

    @property
    def stable(self) -> bool:
        """Whether it is a cycle, and a stable one."""
        return self.multipliers is not None and inside_circle(self.multipliers)


def canonical(attractor: Attractor) -> Attractor:
    """The same cycle from the point with the least first state on."""
    if not attractor.is_cycle:
        return attractor
    first = int(np.argmin(attractor.points[:, 0]))
    return replace(
        attractor,
        points=np.roll(attractor.points, -first, axis=0),
        modes=np.roll(attractor.modes, -first),
    )


def in_order(attractors: list[Attractor]) -> list[int]:
    """Numbers of attractors in the order in which they are shown.

    Cycles by period, then sets that do not repeat, then by the mean of the first state, which
    depends neither on the starts nor on the order in which they were found.
    """

    def rank(i: int) -> tuple[float, float]:
        one = attractors[i]
        return (one.period or np.inf, float(np.mean(one.points[:, 0])))

    return sorted(range(len(attractors)), key=rank)


def renumbered(attractors: list[Attractor], label: Integers) -> tuple[list[Attractor], Integers]:
    """Attractors in the order in which they are shown, and labels that go with it."""
    order = in_order(attractors)
    number = np.zeros(len(order) + 1, np.int64)
    number[np.array(order, dtype=np.int64) + 1] = np.arange(1, len(order) + 1)
    return [attractors[i] for i in order], np.where(label > 0, number[np.maximum(label, 0)], label)
