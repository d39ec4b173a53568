"""Newton's method from a predicted point to the curve, across a given direction; judging the step.

The length of a step follows how far it turned and bent, and how fast Newton's method converged:
Allgower and Georg, Introduction to Numerical Continuation Methods (2003), chapter 6.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from nonsmooth.continuation.bordered import Determinant, solve_bordered
from nonsmooth.continuation.equations import Equations, Linearised
from nonsmooth.continuation.point import Array, NotConverged, Refused

__all__ = ["Corrector", "Node", "arc", "effort", "turn"]


_ROUNDING = 1e3  # times the tolerance: steps this small that no longer shrink are rounding
_SHRINK = 0.25  # of a Newton step by the next one, above which it no longer does
_NOISE = 1e-3  # of the reach: longer steps that rounding makes spoil the step along the curve
_ROUNDINGS = 1e4  # in the terms of a residual that no step makes smaller
_EPS = float(np.finfo(float).eps)
# What a step of the right length has; twice the effort is refused.
_TURN = 0.15  # angle between the tangents at its ends
_BEND = (
    0.015  # angle between its chord and the mean of these tangents: a jump bends and does not turn
)
_CONTRACTION = 0.15  # second Newton step by the first
_ITERATIONS = 4


@dataclass(slots=True)
class Node:
    """A point of the curve while it is worked on; the tangent is a unit vector in scaled terms."""

    u: Array
    p: float
    tangent: Array
    determinant: Determinant
    iterations: int
    residual: float
    contraction: float
    arclength: float = 0.0
    step: float = 0.0
    curvature: Array | None = None  # of the step that came here
    tests: Mapping[str, float] | None = None  # not asked yet

    def turned(self, along: Array) -> Node:
        """The same with its tangent on the side of another direction."""
        if float(self.tangent @ along) < 0.0:
            self.tangent = -self.tangent
            self.determinant = Determinant(-self.determinant.sign, self.determinant.log)
        return self


@dataclass(slots=True)
class Corrector:
    """Newton's method on the bordered equations."""

    equations: Equations
    tolerance: float
    max_newton: int

    def across(self, u: Array, p: float, border: Array, reach: float = np.inf) -> Node:
        """The solution in the plane through a point at right angles to ``border``.

        `Refused` when there is none within ``reach`` that Newton's method comes to.
        """
        return self._newton(u, p, border, reach, fixed=False)

    def at_parameter(self, u: Array, p: float, reach: float = np.inf) -> Node:
        """The solution at exactly this parameter; its tangent points to larger ones."""
        border = np.zeros(self.equations.n + 1)
        border[-1] = 1.0
        return self._newton(u, p, border, reach, fixed=True)

    def onto_bound(self, node: Node) -> Node:
        """The solution on a bound that is no farther than rounding; else the same.

        Newton's method moves the parameter by rounding, and what is left of the way to the bound
        has no direction by which a step could be judged.
        """
        near = self.tolerance * (1.0 + self.length(node.u, node.p))
        for bound in self.equations.bounds:
            if 0.0 < abs(node.p - bound) <= near * float(self.equations.scale[-1]):
                with suppress(Refused):  # as where it turns back before it
                    found = self.at_parameter(node.u, bound, _ROUNDING * near)
                    return replace(found.turned(node.tangent), iterations=node.iterations)
        return node

    def _newton(self, u: Array, p: float, border: Array, reach: float, fixed: bool) -> Node:
        scale = self.equations.scale
        n, before, contraction, gone = self.equations.n, math.inf, 0.0, 0.0
        size = 1.0 + self.length(u, p)
        for iteration in range(1, self.max_newton + 1):
            at = self.equations.linearised(u, p)
            step, tangent, determinant = solve_bordered(at, border, scale)
            u = u - step[:n] * scale[:n]
            if not fixed:
                p = p - float(step[n]) * float(scale[n])
            length = math.sqrt(float(step @ step))
            gone += length
            if iteration == 2:
                contraction = length / before if before > 0.0 else 0.0
            small = length <= self.tolerance * size
            floor = length <= _ROUNDING * self.tolerance * size
            noise = length <= _NOISE * reach < math.inf
            if not small and length > _SHRINK * before and (floor or noise):
                # a nearly singular system makes long steps of rounding, which are no contraction
                rounding = self._is_rounding(at, u, p)
                contraction = 0.0 if rounding else contraction
                small = floor or rounding
            if small:
                residual = float(np.abs(at.r).max())
                return Node(u, p, tangent, determinant, iteration, residual, contraction)
            if gone > reach or length > 2.0 * before:
                break
            before = length
        raise NotConverged("Newton's method does not settle")

    def _is_rounding(self, at: Linearised, u: Array, p: float) -> bool:
        """Whether a residual is what rounding of its terms leaves."""
        large = np.maximum(self.equations.sizes, np.abs(np.append(u, p)))
        terms = abs(at.J_u) @ large[:-1] + abs(at.J_p) * large[-1]
        return bool(np.all(np.abs(at.r) <= _ROUNDINGS * _EPS * terms))

    def length(self, u: Array, p: float) -> float:
        """Distance from the origin in scaled terms."""
        y = self.scaled(u, p)
        return math.sqrt(float(y @ y))

    def scaled(self, u: Array, p: float) -> Array:
        """Unknowns and parameter in units of their scales."""
        scale = self.equations.scale
        y = np.empty(scale.size)
        np.divide(u, scale[:-1], out=y[:-1])
        y[-1] = p / scale[-1]
        return y


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
