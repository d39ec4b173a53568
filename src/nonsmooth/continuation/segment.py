"""The curve between two of its points, and where along it something vanishes."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from nonsmooth.continuation.arrays import Array
from nonsmooth.continuation.bordered import Determinant
from nonsmooth.continuation.corrector import Corrector, Node
from nonsmooth.continuation.refusals import NotConverged, PastBound, Refused, SingularMatrix
from nonsmooth.continuation.steps import arc, turn

__all__ = ["Segment"]

_EPS = float(np.finfo(float).eps)
_NEAR = 1e-6  # of the segment: a bracket in which a refused trial no longer matters
_RISE = 1e3  # a value that grows by this much towards its change of sign has a pole there
_TRIALS = 80
_SMALL = 1e-3  # part of the end values below which a determinant is nearly zero


class Segment:
    """A cubic through two points with their tangents, as the guess for trials between them."""

    def __init__(self, corrector: Corrector, first: Node, last: Node) -> None:
        self.corrector, self.first, self.last = corrector, first, last
        self.start = corrector.scaled(first.u, first.p)
        self.chord = corrector.scaled(last.u, last.p) - self.start
        self.length = arc(
            math.sqrt(float(self.chord @ self.chord)), turn(first.tangent, last.tangent)
        )

    def guess(self, x: float) -> tuple[Array, Array]:
        """Scaled point and unit direction at a fraction of the segment."""
        a, b, c = self.first.tangent * self.length, self.last.tangent * self.length, self.chord
        # cubic a x + (3c - 2a - b) x^2 + (a + b - 2c) x^3
        two, three = 3.0 * c - 2.0 * a - b, a + b - 2.0 * c
        slope = a + x * (2.0 * two + 3.0 * x * three)
        return self.start + x * (a + x * (two + x * three)), slope / math.sqrt(float(slope @ slope))

    def trial(self, x: float) -> Node:
        """The point of the curve at a fraction of the segment."""
        y, along = self.guess(x)
        return self.placed(self.corrector.across(*self.unscaled(y), along, 0.5 * self.length))

    def uncorrected(self, x: float) -> Node:
        """The guess itself, in place of a point where branches cross, which has no correction."""
        y, along = self.guess(x)
        u, p = self.unscaled(y)
        left = float(np.abs(self.corrector.equations.value(u, p)).max())
        return self.placed(Node(u, p, along, Determinant(0.0, -math.inf), 0, left, 0.0))

    def placed(self, node: Node) -> Node:
        """With its arclength from the start of the branch."""
        away = self.corrector.scaled(node.u, node.p) - self.start
        chord = math.sqrt(float(away @ away))
        node.step = arc(chord, turn(self.first.tangent, node.tangent))
        node.arclength = self.first.arclength + node.step
        return node

    def unscaled(self, y: Array) -> tuple[Array, float]:
        """Unknowns and parameter of a scaled point."""
        scale = self.corrector.equations.scale
        return y[:-1] * scale[:-1], float(y[-1] * scale[-1])

    def locate(
        self, value: Callable[[Node], float], *, zero_where_singular: bool = False
    ) -> tuple[float, Node] | None:
        """Fraction and point at which a value changes its sign; None if it is not found.

        `PastBound` goes through: the curve leaves the bounds in between.
        """
        ends = {0.0: value(self.first), 1.0: value(self.last)}
        low, high = ends[0.0], ends[1.0]
        if not (math.isfinite(low) and math.isfinite(high)) or low == 0.0:
            return None
        if high != 0.0 and (low > 0.0) == (high > 0.0):  # their product might underflow
            return None
        if high == 0.0:
            return 1.0, self.last
        nodes: dict[float, Node] = {0.0: self.first, 1.0: self.last}

        def at(x: float) -> float:
            if x not in ends:
                try:
                    nodes[x] = self.trial(x)
                    ends[x] = value(nodes[x])
                except (SingularMatrix, NotConverged) as refusal:
                    if not (zero_where_singular and _believed(refusal, x, ends)):
                        raise
                    nodes[x], ends[x] = self.uncorrected(x), 0.0
                if not math.isfinite(ends[x]):
                    raise Refused("a test has no value between two points")
            return ends[x]

        size = 1.0 + math.sqrt(float(self.start @ self.start))
        try:
            xtol = 2.0 * _EPS * size / self.length
            x = float(brentq(at, 0.0, 1.0, xtol=xtol, maxiter=_TRIALS, disp=False))
            at(x)
        except PastBound:
            raise
        except Refused:
            x = _best(ends)
        if x == 0.0 or abs(ends[x]) > _RISE * max(abs(low), abs(high)):
            return None
        return x, nodes[x]


def _believed(refusal: Refused, x: float, values: dict[float, float]) -> bool:
    """Whether a trial that failed is at a zero: singular, or with small values about it."""
    if isinstance(refusal, SingularMatrix):
        return True
    near = min(values, key=lambda other: abs(other - x))
    return abs(values[near]) < _SMALL * max(abs(values[0.0]), abs(values[1.0]))


def _best(values: dict[float, float]) -> float:
    """The place of the smallest value of those found; the first end if they are far apart."""
    below = max((x for x, v in values.items() if v * values[0.0] > 0.0), default=0.0)
    above = min(x for x, v in values.items() if x > below)
    if above - below > _NEAR:
        return 0.0
    return min(below, above, key=lambda x: abs(values[x]))
