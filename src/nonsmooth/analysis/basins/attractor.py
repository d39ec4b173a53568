"""An attractor as a set of points; cycles of a map, refined by Newton's method."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

__all__ = ["Attractor", "Cycle", "canonical", "in_order", "refine", "renumbered"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_MOST_STEPS = 12  # Newton doubles the digits in each
_EXACT = 1e-13  # residual, beside the scale, that rounding reaches
_ON_CIRCLE = 1e-6  # beside a multiplier: nearer to the circle it is one of a family of cycles
_FAR = 0.05  # a step longer than this, beside the scale, leaves the cycle that was meant


class TangentMap(Protocol):
    """A map with its derivative."""

    def images(
        self, state: Floats, mode: int, count: int
    ) -> tuple[Floats, Integers, Floats] | None:
        """Images (count, n) with their modes (count,), and the derivative (n, n) of the last one.

        None where the motion ends before, or there is no finite derivative.
        """


def inside_circle(multipliers: npt.NDArray[np.complex128]) -> bool:
    """Whether all multipliers lie inside the unit circle, and not next to it."""
    return bool(np.all(np.abs(multipliers) < 1.0 - _ON_CIRCLE))


@dataclass(frozen=True)
class Cycle:
    """Points that a map takes to each other."""

    points: Floats  # (p, n)
    modes: Integers  # (p,)
    drift: Floats  # (n,): change of each state along the cycle; zero but for drifting ones
    multipliers: npt.NDArray[np.complex128]  # of the states that do not drift, largest first
    residual: float  # largest distance of a point from its return, beside the scale
    step: float  # that Newton's method would take from here, beside the scale: what is in doubt

    @property
    def stable(self) -> bool:
        """Whether all multipliers lie inside the unit circle, and not next to it."""
        return inside_circle(self.multipliers)


def refine(
    tangent_map: TangentMap,
    state: Floats,
    mode: int,
    period: int,
    free: npt.NDArray[np.bool_],
    scale: Floats,
) -> Cycle | None:
    """Cycle of a period near a state; ``free`` states must return, the others may drift.

    None where Newton's method leaves the neighbourhood or the motion ends.

    shapes: state, free, scale (n,)
    """
    best: Cycle | None = None
    state = np.array(state)
    for _ in range(_MOST_STEPS):
        found = tangent_map.images(state, mode, period)
        if found is None:
            break
        images, modes, derivative = found
        gap = np.where(free, images[-1] - state, 0.0)
        residual = float(np.max(np.abs(gap[free]) / scale[free], initial=0.0))
        if best is not None and not residual < best.residual:
            break
        points = np.vstack([state, images[:-1]])
        inner = derivative[np.ix_(free, free)]
        multipliers = np.linalg.eigvals(inner).astype(complex)
        order = np.argsort(-np.abs(multipliers), kind="stable")
        drift = np.where(free, 0.0, images[-1] - state)
        cycle_modes = np.concatenate([modes[-1:], modes[:-1]])
        step: npt.NDArray[np.floating[Any]] = np.zeros(len(inner))
        if residual > _EXACT:
            try:
                step = np.linalg.solve(inner - np.eye(len(inner)), -gap[free])
            except np.linalg.LinAlgError:
                step = np.full(len(inner), np.inf)
        length = float(np.max(np.abs(step) / scale[free], initial=0.0))
        best = Cycle(points, cycle_modes, drift, multipliers[order], residual, length)
        if residual <= _EXACT or not length <= _FAR:
            break
        state[free] += step
        mode = int(modes[-1])
    return best


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
    exponent: float = np.nan  # largest, per iterate, of a set that does not repeat
    exponent_error: float = np.nan
    chaotic_for: int = 0  # iterates for which chaos was seen, without an end
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
