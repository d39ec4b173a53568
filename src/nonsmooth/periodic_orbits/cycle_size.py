"""How large a change of a cycle is: the cycle as a whole moves, and it becomes another one.

Where nothing drives a system, a cycle may be small beside the states that it lies at: the ripple of
a converter beside its voltage, or any cycle that shrinks to a point. What is large for its shape is
then nothing for its place. So the middle of a cycle is measured by the sizes of the states, and its
shape about the middle by how much they vary along it.

A branch has one size for each state. Its square is the mean of both squares, by how much of the
change along the branch is one of the place and one of the shape: then steps are as long as both
measures together say. Where a cycle only moves, states count by their sizes, as in a driven system;
where it shrinks, by how much they vary.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.branch_tests import states_along
from nonsmooth.periodic_orbits.cycle_plane import spread_of, states_of_cycle
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.legs import LegError

__all__ = ["CycleSize", "scale_of_cycle", "size_of_cycle"]

Floats = npt.NDArray[np.float64]

_SMALL = 1e-6  # of a cycle: the step along the branch by which its change is told
_HARDLY = 1e-3  # of the largest change of a state: less is none


@dataclass(frozen=True)
class CycleSize:
    """States along a cycle, at the same places of its legs for each cycle of one word."""

    states: Floats  # (K, n)
    spread: Floats  # (n,), positive: by how much each state varies
    size: Floats  # (n,), not below that

    def change_to(self, other: CycleSize) -> tuple[Floats, Floats]:
        """How far the middle moves, beside the states; how much the shape changes, beside it; (n,).

        Nothing where the cycles cannot be compared.
        """
        if other.states.shape != self.states.shape:
            return np.zeros_like(self.spread), np.zeros_like(self.spread)
        change = other.states - self.states
        moved = change.mean(axis=0)
        shape = np.sqrt(np.mean((change - moved) ** 2, axis=0))
        return np.abs(moved) / self.size, shape / self.spread

    def scale(self, place: Floats, form: Floats) -> Floats:
        """What counts as large for each state where a cycle changes by these, (n,).

        A state that hardly changes counts by how much it varies: what changes it may be rounding.
        """
        form = np.maximum(form, max(_HARDLY * float(np.hypot(place, form).max()), 1e-300))
        share = place / form
        larger = self.size / self.spread
        return np.asarray(self.spread * np.sqrt(((share * larger) ** 2 + 1.0) / (share**2 + 1.0)))


def size_of_cycle(equations: OrbitEquations, unknowns: Floats) -> CycleSize:
    """Size of a cycle of a system that nothing drives; its legs stand for the parameters."""
    if equations.is_smooth_cycle:
        states = states_of_cycle(equations, unknowns)
    else:
        states = states_along(equations, equations.unpack(unknowns))
    spread = spread_of(states)
    return CycleSize(states, spread, np.maximum(spread, np.abs(states).max(axis=0)))


def scale_of_cycle(
    equations: OrbitEquations, unknowns: Floats, value: float, direction: tuple[Floats, float],
    bounds: tuple[float, float], set_parameter: Callable[[float], None],
) -> Floats:  # fmt: skip
    """What counts as large for each state as a cycle changes along a branch, (n,).

    ``direction`` is that of the branch. Where the cycle cannot be passed beside it, states count by
    how much they vary.
    """
    set_parameter(value)
    here = size_of_cycle(equations, unknowns)
    if np.array_equal(here.size, here.spread):
        return here.spread
    low, high = bounds
    count = len(equations.word)
    length = abs(float(equations.unpack(unknowns).instants[-1]))
    units = np.concatenate([np.tile(here.spread, count), np.full(equations.n_instants, length)])
    most = max(float(np.abs(direction[0] / units).max()), abs(direction[1]) / (high - low))
    step = _SMALL / max(most, 1e-300)
    if not low <= value + step * direction[1] <= high:
        step = -step
    try:
        set_parameter(value + step * direction[1])
        beside = size_of_cycle(equations, unknowns + step * direction[0])
    except LegError:
        return here.spread
    finally:
        set_parameter(value)
    return here.scale(*here.change_to(beside))
