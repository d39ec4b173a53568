"""What is looked at along a branch: folds, points where branches cross, and a user's tests."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from nonsmooth.continuation.bordered import Determinant
from nonsmooth.continuation.corrector import Corrector, Node, arc, turn
from nonsmooth.continuation.crossing import crossing_near, zero_directions
from nonsmooth.continuation.equations import DENSE_BELOW, call
from nonsmooth.continuation.options import OWN_NAMES, Options
from nonsmooth.continuation.point import (
    Array,
    Jump,
    NotConverged,
    OutsideDomain,
    PastBound,
    Point,
    Refused,
    SingularMatrix,
)
from nonsmooth.errors import OptionError, quote

__all__ = ["CurveSegment", "Mark", "Observer"]


_EPS = float(np.finfo(float).eps)
_NEAR = 1e-6  # of the segment: a bracket in which a refused trial no longer matters
_RISE = 1e3  # a value that grows by this much towards its change of sign has a pole there
_TRIALS = 80
_SMALL = 1e-3  # part of the end values below which a test is nearly zero
_CLEAR = 1e-6  # part of the slopes at the ends, above which one beside a crossing is no rounding
_STILL = 1e-10  # slopes of the parameter by the arclength that are rounding
# part of the step, within which a crossing is the one that was found along the branch
_NEAR_CROSSING = 0.05
_VANISHES = 0.1  # part of its larger end value that a determinant must fall to where it is zero


class CurveSegment:
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
        self, value: Callable[[Node], float], *, where_singular: str = ""
    ) -> tuple[float, Node] | None:
        """Fraction and point at which a value changes its sign; None if it is not found.

        Where the equations are singular it is not found, unless the value is "zero" there, or the
        "guess" is taken, where that makes the value small.
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

        def uncorrected(x: float, refusal: Refused) -> float:
            nodes[x] = self.uncorrected(x)
            if where_singular == "zero" and _believed(refusal, x, ends):
                return 0.0
            told = value(nodes[x]) if where_singular == "guess" else math.inf
            if not abs(told) <= _SMALL * max(abs(low), abs(high)):
                raise refusal
            return told

        def at(x: float) -> float:
            if x not in ends:
                try:
                    nodes[x] = self.trial(x)
                    ends[x] = value(nodes[x])
                except (SingularMatrix, NotConverged) as refusal:
                    ends[x] = uncorrected(x, refusal)
                if not math.isfinite(ends[x]):
                    raise Refused("a test has no value between two points")
            return ends[x]

        size = 1.0 + math.sqrt(float(self.start @ self.start))
        try:
            xtol = 2.0 * _EPS * size / self.length
            x = float(brentq(at, 0.0, 1.0, xtol=xtol, maxiter=_TRIALS, disp=False))
            at(x)
        except PastBound:  # it is one of `Refused`, and the caller ends the branch there
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


class Mark(NamedTuple):
    """A special point within a step: where on it, the point, its name, whether the branch ends."""

    x: float
    node: Node
    name: str
    last: bool = False


class _Asked(Mapping[str, float]):
    """Values of tests; those that are functions are called when they are asked for.

    That is done once, but again where they were nan: what is no number yet may become one.
    """

    def __init__(self, values: dict[str, float | Callable[[], float]]) -> None:
        self._values = values

    def __getitem__(self, name: str) -> float:
        value = self._values[name]
        if not callable(value):
            return value
        told = float(value())
        if not math.isnan(told):
            self._values[name] = told
        return told

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)


class Observer:
    """Tests of points, and the places where they vanish."""

    def __init__(self, corrector: Corrector, options: Options) -> None:
        self.corrector, self.options, self.tests = corrector, options, options.tests

    def point(self, node: Node, step: float, name: str = "") -> Point:
        """A point as users get it, tested."""
        return self._bare(node, self.tested(node), step, name)

    def tested(self, node: Node) -> Mapping[str, float]:
        """What the tests give at a point, asked once."""
        if node.tests is None:
            node.tests = self._asked(node) if self.tests else {}
        return node.tests

    def marks(self, segment: CurveSegment) -> list[Mark]:
        """All special points of a step, in order; `Jump` where it joins two branches."""
        found = [*self._branch_point(segment), *self._fold(segment), *self._tests(segment)]
        found += self._unknown_bound(segment)
        found.sort(key=lambda mark: mark.x)
        return sorted([*found, *self._folds_between(segment, found)], key=lambda mark: mark.x)

    def _branch_point(self, segment: CurveSegment) -> Iterator[Mark]:
        """Where the bordered determinant changes its sign and vanishes.

        Neighbouring curves have determinants of opposite signs. So a sign that changes without a
        zero is a jump from one to the other.
        """
        first, last = segment.first.determinant, segment.last.determinant
        if first.sign * last.sign >= 0.0:
            return
        size = max(first.log, last.log)

        def value(node: Node) -> float:
            return node.determinant.sign * math.exp(min(700.0, node.determinant.log - size))

        found = segment.locate(value, where_singular="zero")
        if found is None or abs(value(found[1])) > _VANISHES:
            raise Jump("the branch found has the other orientation")
        yield Mark(found[0], self._refined(segment, *found), "branch_point")

    def _refined(self, segment: CurveSegment, x: float, node: Node) -> Node:
        """The crossing itself: along the branch it is found to half of the digits only."""
        if self.corrector.equations.n > DENSE_BELOW:
            return node
        try:
            there = crossing_near(self.corrector.equations, node.u, node.p)
        except Refused:
            return node
        apart = self.corrector.scaled(there.u, there.p) - self.corrector.scaled(node.u, node.p)
        if math.sqrt(float(apart @ apart)) > _NEAR_CROSSING * segment.length:
            return node
        guess = segment.guess(x)[1]  # tangents of points near a crossing may be anywhere between
        along = max(zero_directions(there), key=lambda v: abs(float(v @ guess)), default=guess)
        along = along if float(along @ guess) > 0.0 else -along
        return replace(node, u=there.u, p=there.p, tangent=along, tests=None)

    def _fold(self, segment: CurveSegment) -> Iterator[Mark]:
        ends = (segment.first.tangent[-1], segment.last.tangent[-1])
        if max(map(abs, ends)) > _STILL:
            found = segment.locate(lambda node: float(node.tangent[-1]))
            if found:
                still = abs(float(found[1].tangent[-2])) < self.options.cusps
                yield Mark(*found, "cusp" if still else "fold")

    def _folds_between(self, segment: CurveSegment, marks: list[Mark]) -> Iterator[Mark]:
        """Folds that the ends of the step do not tell, since another one undoes them.

        A curve that turns back just before another one crosses it is left for that one: only the
        special points in between have its direction.
        """
        before = Mark(0.0, segment.first, "")
        clear = _CLEAR * max(abs(float(end.tangent[-1])) for end in (segment.first, segment.last))
        for mark in [*marks, Mark(1.0, segment.last, "")]:
            if mark.name in ("fold", "cusp", "branch_point"):
                return
            slopes = [float(each.node.tangent[-1]) for each in (before, mark)]
            if slopes[0] * slopes[1] < 0.0 and min(map(abs, slopes)) > clear:
                part = CurveSegment(segment.corrector, before.node, mark.node)
                for found in self._fold(part):
                    yield found._replace(x=before.x + found.x * (mark.x - before.x))
            before = mark

    def _unknown_bound(self, segment: CurveSegment) -> Iterator[Mark]:
        """Where the last unknown comes to a bound that it has."""
        for bound in self.options.unknown_bounds:
            if math.isfinite(bound):
                found = segment.locate(partial(_distance, bound))
                if found and (found[0] > 0.0):
                    found[1].u[-1] = bound
                    yield Mark(*found, "bound", last=True)

    def _tests(self, segment: CurveSegment) -> Iterator[Mark]:
        before, after = self.tested(segment.first), self.tested(segment.last)
        for name in after:
            if name in before and not before[name] * after[name] > 0.0:  # else nothing to locate
                found = segment.locate(self._named(name), where_singular="guess")
                if found:
                    yield Mark(*found, name)

    def _named(self, name: str) -> Callable[[Node], float]:
        return lambda node: self.tested(node).get(name, math.nan)

    def _asked(self, node: Node) -> Mapping[str, float]:
        assert self.tests is not None
        try:
            found = call(self.tests, self._bare(node, {}, node.step, ""))
        except OutsideDomain:
            return {}
        if not isinstance(found, Mapping):
            raise OptionError(
                f"tests returned {quote(found)}; it must return a mapping of names to numbers, such"
                " as {'zero': point.u[0]}"
            )
        for name in found:
            if name in OWN_NAMES or not isinstance(name, str) or not name:
                raise OptionError(
                    f"a test has the name {name!r}; names are texts, and {', '.join(OWN_NAMES)} are"
                    " taken by the continuation itself"
                )
        try:
            return _Asked(
                {name: value if callable(value) else float(value) for name, value in found.items()}
            )
        except (TypeError, ValueError, OverflowError):
            raise OptionError(
                f"tests returned {quote(dict(found))}; each value must be one real number, NaN"
                " where there is none"
            ) from None

    def _bare(self, node: Node, tests: Mapping[str, float], step: float, name: str) -> Point:
        scale = self.corrector.equations.scale
        return Point(
            node.u.copy(), node.p, node.tangent[:-1] * scale[:-1],
            float(node.tangent[-1] * scale[-1]), node.arclength, step, node.iterations,
            node.residual, tests, name,
        )  # fmt: skip


def _distance(bound: float, node: Node) -> float:
    return float(node.u[-1]) - bound
