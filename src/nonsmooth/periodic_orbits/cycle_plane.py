"""The plane on which a cycle without events begins, and how it moves along a branch.

A plane that stays where it is loses a cycle that moves away from it: the cycle touches the plane,
and beyond passes it nowhere, although nothing has happened to the cycle. So the plane is laid anew
through the orbit wherever the flow passes it at a flat angle. It holds the middle of the cycle too,
so that a cycle which shrinks to a point does so within its plane.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.newton import scale_of, solve_orbit
from nonsmooth.periodic_orbits.word import Word

__all__ = [
    "direction_on",
    "is_flat",
    "on_new_plane",
    "on_plane_of",
    "spread_of",
    "spread_of_cycle",
    "states_of_cycle",
]

Floats = npt.NDArray[np.float64]

_PLACES = 32  # along a cycle, at which it is looked at
_STILL = 1e-6  # of the largest spread: a state that varies less does not tell what is large
_FLAT = 0.7  # cosine between the flow and the normal of the plane, from which on it is laid anew
_ACROSS = 0.3  # of the flow: a normal that lies more along the plane does not hold the middle


def states_of_cycle(equations: OrbitEquations, unknowns: Floats) -> Floats:
    """States along a cycle, after equal times, drifts left out."""
    turn = equations.unpack(unknowns)
    word = Word(equations.word.modes[:1] * _PLACES, ((),) * _PLACES)
    ends = turn.instants[0] + np.arange(_PLACES) / _PLACES * turn.durations[0]
    begins = np.full(_PLACES, turn.instants[0])
    states = np.tile(turn.states[0], (_PLACES, 1))
    found = equations.legs.follow_each(word, states, begins, ends).ends
    return np.where(equations.drifting, 0.0, found)


def spread_of_cycle(equations: OrbitEquations, unknowns: Floats) -> Floats:
    """By how much each state varies, wherever the middle of the cycle is; (n,), positive."""
    return spread_of(states_of_cycle(equations, unknowns))


def spread_of(states: Floats) -> Floats:
    """By how much each of some states varies; (n,), positive."""
    spread = np.ptp(states, axis=0)
    largest = max(float(spread.max()), 1e-300)
    return np.where(spread > _STILL * largest, spread, largest)


def on_new_plane(equations: OrbitEquations, unknowns: Floats) -> OrbitEquations:
    """The equations of a cycle with the plane through its first state and its middle.

    Lengths are measured by how much each state varies, so that units do not matter.
    """
    states = states_of_cycle(equations, unknowns)
    spread = spread_of(states)
    turn = equations.unpack(unknowns)
    found = equations.legs.follow(equations.word, turn.states, turn.instants)
    flow = np.where(equations.drifting, 0.0, found.start_rates[0]) / spread
    away = (states[0] - states.mean(axis=0)) / spread
    normal = flow - (flow @ away) / max(float(away @ away), 1e-300) * away
    if np.linalg.norm(normal) < _ACROSS * np.linalg.norm(flow):
        normal = flow
    return equations.across(turn.states[0], normal / spread)


def on_plane_of(
    equations: OrbitEquations, other: OrbitEquations, unknowns: Floats
) -> Floats | None:
    """A cycle of other equations as one that begins on the plane of these; None where it does not.

    Where it passes the plane several times in the sense of the flow there, it is the passage that
    is nearest to where the plane was laid. The legs stand for the parameters of the cycle.
    """
    assert equations.reference is not None  # every plane is laid through one
    states = states_of_cycle(other, unknowns)
    height = (states - equations.reference) @ equations.normal
    behind = np.roll(height, -1)
    passes = np.flatnonzero((height <= 0.0) & (behind > 0.0))
    if not passes.size:
        return None
    share = (-height[passes] / (behind[passes] - height[passes]))[:, None]
    there = states[passes] + share * (np.roll(states, -1, axis=0)[passes] - states[passes])
    away = np.linalg.norm((there - equations.reference) / spread_of(states), axis=1)
    guess = np.append(there[np.argmin(away)], unknowns[other.legs.n :])
    found = solve_orbit(equations, guess)
    return found.unknowns if found.status == "completed" else None


def is_flat(equations: OrbitEquations, unknowns: Floats) -> bool:
    """Whether the flow passes the plane of a cycle at a flat angle."""
    states = states_of_cycle(equations, unknowns)
    spread = spread_of(states)
    turn = equations.unpack(unknowns)
    found = equations.legs.follow(equations.word, turn.states, turn.instants)
    flow = np.where(equations.drifting, 0.0, found.start_rates[0]) / spread
    normal = equations.normal * spread
    size = float(np.linalg.norm(flow) * np.linalg.norm(normal))
    return float(flow @ normal) < _FLAT * size


def direction_on(
    equations: OrbitEquations, unknowns: Floats, tangent: tuple[Floats, float],
    before: tuple[Floats, float],
) -> tuple[Floats, float]:  # fmt: skip
    """A tangent with the sign of the direction in which the branch was followed.

    The two planes cut neighbouring cycles at other instants, so their tangents differ by a part
    along the flow, which is left out.
    """
    turn, n = equations.unpack(unknowns), equations.legs.n
    scale = scale_of(equations, unknowns)
    found = equations.legs.follow(equations.word, turn.states, turn.instants)
    flow = np.where(equations.drifting, 0.0, found.start_rates[0]) / scale[:n]

    def apart(direction: tuple[Floats, float]) -> Floats:
        step = direction[0] / scale
        step[:n] -= (step[:n] @ flow) / max(float(flow @ flow), 1e-300) * flow
        whole = np.append(step, direction[1])
        return np.asarray(whole / max(float(np.linalg.norm(whole)), 1e-300))

    way = 1.0 if float(apart(tangent) @ apart(before)) >= 0.0 else -1.0
    return way * tangent[0], way * tangent[1]
