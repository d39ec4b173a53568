"""The plane on which a cycle without events begins, and how it moves along a branch.

A plane that stays where it is loses a cycle that moves away from it: the cycle touches the plane,
and beyond passes it nowhere, although nothing has happened to the cycle. So it goes along: it says
how far the start of the cycle is ahead of the state half a turn later, in one direction. Along a
cycle that number changes its sign after half a turn, so every cycle begins on such a plane. Through
both states, it holds what a cycle shrinks to. Where the flow passes a plane at a flat angle, it is
laid anew through the orbit.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
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
    """The equations of a cycle with a plane through its first state and that half a turn later.

    The plane goes along with the cycle. Of one that comes back whole turns of an angle later, or
    passes it too flat, it goes through the middle and stays where it is. Lengths are measured by
    how much each state varies, so that units do not matter.
    """
    states = states_of_cycle(equations, unknowns)
    spread = spread_of(states)
    turn = equations.unpack(unknowns)
    if not np.any(equations.angle_periods > 0.0):
        half_later = states[_PLACES // 2]
        goes_along = equations.across(turn.states[0], np.ones_like(spread), half_later)
        flow = _flow(goes_along, turn) / spread
        normal = _across(flow, (states[0] - half_later) / spread)
        if float(flow @ normal) >= _FLAT * float(np.linalg.norm(flow) * np.linalg.norm(normal)):
            return equations.across(turn.states[0], normal / spread, half_later)
    stays = equations.across(turn.states[0], np.ones_like(spread))
    normal = _across(_flow(stays, turn) / spread, (states[0] - states.mean(axis=0)) / spread)
    return equations.across(turn.states[0], normal / spread)


def _flow(equations: OrbitEquations, turn: Turn) -> Floats:
    """Rates at which the start of a cycle passes its plane, drifts left out, (n,)."""
    found = equations.legs.follow(equations.word, turn.states, turn.instants)
    rates = equations.passing(turn, found.start_rates[0].copy())
    return np.where(equations.drifting, 0.0, rates)


def _across(flow: Floats, away: Floats) -> Floats:
    """The normal nearest to a flow of a plane that holds a direction, if that is not the flow's."""
    normal = flow - (flow @ away) / max(float(away @ away), 1e-300) * away
    return flow if np.linalg.norm(normal) < _ACROSS * np.linalg.norm(flow) else normal


def on_plane_of(
    equations: OrbitEquations, other: OrbitEquations, unknowns: Floats
) -> Floats | None:
    """A cycle of other equations as one that begins on the plane of these; None where it does not.

    Where it passes the plane several times in the sense of the flow there, it is the passage that
    is nearest to where the plane was laid. The legs stand for the parameters of the cycle.
    """
    assert equations.reference is not None  # every plane is laid through one
    states = states_of_cycle(other, unknowns)
    height = equations.heights(states)
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
    flow = _flow(equations, equations.unpack(unknowns)) / spread
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
