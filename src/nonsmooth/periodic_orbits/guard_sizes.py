"""How large guards are along an orbit, and what rounding leaves of their sign."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.orbits import LegResults
from nonsmooth.engine.tables import DERIVATIVES
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.word import Word

__all__ = ["GuardSizes", "guard_sizes", "largest_along"]

Floats = npt.NDArray[np.float64]

_WITHIN = 8  # places in each leg at which states are looked at for their size
_EPS = float(np.finfo(float).eps)
# roundings in the terms of a guard: those of the flow, and of the equations that are solved. Up to
# 20 were seen in guards that are zero by construction
_ROUNDINGS = 500.0


class GuardSizes(NamedTuple):
    """Numbers for each guard of each leg; shapes (L, e)."""

    value: Floats  # what it comes to for states as large as those of the orbit
    rounding: Floats  # what rounding leaves of it where it should be zero


def guard_sizes(
    equations: OrbitEquations, turn: Turn, found: LegResults, largest: Floats
) -> GuardSizes:
    """Sizes for states of a given size and legs that are passed."""
    tables, n = equations.legs.tables, equations.legs.n
    guards = DERIVATIVES * tables.sizes.exits
    rows = np.abs(tables.affine[equations.word.mode_array, :guards:DERIVATIVES])
    sizes = rows[:, :, :n] @ largest
    # with 1 and the harmonics; an orbit has no powers of time, and signals count for nothing
    first, last = n + 1 + tables.sizes.powers, tables.sizes.first_of_signals
    terms = sizes + rows[:, :, n] + rows[:, :, first:last].sum(axis=2)
    rate = np.einsum("kgi,ki->kg", rows[:, :, :n], np.abs(found.end_rates))
    late = float(np.abs(turn.instants).max())
    rounding = _EPS * (_ROUNDINGS * terms + late * rate)
    # a guard of time alone, and an orbit that rests
    sizes = np.where(sizes > 0.0, sizes, max(float(largest.max(initial=0.0)), 1e-300))
    return GuardSizes(sizes, rounding)


def largest_along(equations: OrbitEquations, turn: Turn) -> Floats:
    """Largest size of each state along an orbit, within the legs too, drifts left out."""
    legs, count = equations.legs, len(equations.word)
    leg = np.repeat(np.arange(count), _WITHIN)
    begins = turn.instants[leg]
    ends = begins + np.tile(np.arange(1, _WITHIN + 1) / _WITHIN, count) * turn.durations[leg]
    open_word = Word(tuple(equations.word.modes[k] for k in leg), ((),) * leg.size)
    states = turn.states
    try:
        within = legs.follow_each(open_word, turn.states[leg], begins, ends).ends
        states = np.concatenate([states, within])
    except LegError:  # those at the events have to do
        pass
    apart: Floats = np.abs(states - np.where(equations.drifting, turn.states[0], 0.0))
    return apart.max(axis=0)
