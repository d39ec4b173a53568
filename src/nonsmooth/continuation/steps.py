"""Judging a step: how far it turned and bent, how fast Newton's method converged.

After Allgower and Georg, Introduction to Numerical Continuation Methods (2003), chapter 6.
"""

from __future__ import annotations

import math

from nonsmooth.continuation.arrays import Array
from nonsmooth.continuation.corrector import Node

__all__ = ["arc", "effort", "turn"]

# What a step of the right length has; twice the effort is refused.
_TURN = 0.15  # angle between the tangents at its ends
_BEND = (
    0.015  # angle between its chord and the mean of these tangents: a jump bends and does not turn
)
_CONTRACTION = 0.15  # second Newton step by the first
_ITERATIONS = 4


def turn(first: Array, second: Array) -> float:
    """Angle between two unit vectors."""
    apart = first - second
    return 2.0 * math.asin(min(1.0, 0.5 * math.sqrt(float(apart @ apart))))


def arc(chord: float, angle: float) -> float:
    """Length of the circular arc over a chord whose ends differ in direction by an angle."""
    return chord if angle < 1e-8 else chord * 0.5 * angle / math.sin(0.5 * angle)


def effort(before: Node, after: Node, chord: Array) -> float:
    """How hard a step was, 1 for one of the right length; above 2 it is not to be believed.

    Turn and contraction go as the step, the bend of a smooth curve as its square.
    """
    length = math.sqrt(float(chord @ chord))
    if length == 0.0:
        return math.inf
    middle = before.tangent + after.tangent
    size = math.sqrt(float(middle @ middle))
    if size < 1.0:  # more than 120 degrees apart
        return math.inf
    bend = turn(chord / length, middle / size)
    return max(
        turn(before.tangent, after.tangent) / _TURN,
        math.sqrt(bend / _BEND),
        math.sqrt(after.contraction / _CONTRACTION),
        2.0 ** ((after.iterations - _ITERATIONS) / 3.0) if after.iterations > _ITERATIONS else 0.0,
    )


def next_step(step: float, effort: float, largest: float) -> float:
    """The length to try next."""
    return min(largest, step / min(2.0, max(0.5, effort)))
