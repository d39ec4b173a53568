"""What is looked at along a branch: folds, points where branches cross, and a user's tests."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from nonsmooth.continuation.corrector import Corrector, Node
from nonsmooth.continuation.crossing import crossing_near, zero_directions
from nonsmooth.continuation.equations import DENSE_BELOW, call
from nonsmooth.continuation.options import OWN_NAMES, Options
from nonsmooth.continuation.point import Point
from nonsmooth.continuation.refusals import Jump, OutsideDomain, Refused
from nonsmooth.continuation.segment import Segment
from nonsmooth.errors import OptionError

__all__ = ["Mark", "Observer"]

_STILL = 1e-10  # slopes of the parameter by the arclength that are rounding
_NEAR = 0.05  # of the step, within which a crossing is the one that was found along the branch
_VANISHES = 0.1  # part of its larger end value that a determinant must fall to where it is zero


class Mark(NamedTuple):
    """A special point within a step: where on it, the point, its name, whether the branch ends."""

    x: float
    node: Node
    name: str
    last: bool = False


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

    def marks(self, segment: Segment) -> list[Mark]:
        """All special points of a step, in order; `Jump` where it joins two branches."""
        found = [*self._branch_point(segment), *self._fold(segment), *self._tests(segment)]
        found += self._unknown_bound(segment)
        return sorted(found, key=lambda mark: mark.x)

    def _branch_point(self, segment: Segment) -> Iterator[Mark]:
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

        found = segment.locate(value, zero_where_singular=True)
        if found is None or abs(value(found[1])) > _VANISHES:
            raise Jump("the branch found has the other orientation")
        yield Mark(found[0], self._refined(segment, *found), "branch_point")

    def _refined(self, segment: Segment, x: float, node: Node) -> Node:
        """The crossing itself: along the branch it is found to half of the digits only."""
        if self.corrector.equations.n > DENSE_BELOW:
            return node
        try:
            there = crossing_near(self.corrector.equations, node.u, node.p)
        except Refused:
            return node
        apart = self.corrector.scaled(there.u, there.p) - self.corrector.scaled(node.u, node.p)
        if math.sqrt(float(apart @ apart)) > _NEAR * segment.length:
            return node
        guess = segment.guess(x)[1]  # tangents of points near a crossing may be anywhere between
        along = max(zero_directions(there), key=lambda v: abs(float(v @ guess)), default=guess)
        along = along if float(along @ guess) > 0.0 else -along
        return replace(node, u=there.u, p=there.p, tangent=along, tests=None)

    def _fold(self, segment: Segment) -> Iterator[Mark]:
        ends = (segment.first.tangent[-1], segment.last.tangent[-1])
        if max(map(abs, ends)) > _STILL:
            found = segment.locate(lambda node: float(node.tangent[-1]))
            if found:
                still = abs(float(found[1].tangent[-2])) < self.options.cusps
                yield Mark(*found, "cusp" if still else "fold")

    def _unknown_bound(self, segment: Segment) -> Iterator[Mark]:
        """Where the last unknown comes to a bound that it has."""
        for bound in self.options.unknown_bounds:
            if math.isfinite(bound):
                found = segment.locate(partial(_distance, bound))
                if found and (found[0] > 0.0):
                    found[1].u[-1] = bound
                    yield Mark(*found, "bound", last=True)

    def _tests(self, segment: Segment) -> Iterator[Mark]:
        before, after = self.tested(segment.first), self.tested(segment.last)
        for name in after:
            if name in before and not before[name] * after[name] > 0.0:  # else nothing to locate
                found = segment.locate(self._named(name))
                if found:
                    yield Mark(*found, name)

    def _named(self, name: str) -> Callable[[Node], float]:
        return lambda node: self.tested(node).get(name, math.nan)

    def _asked(self, node: Node) -> dict[str, float]:
        assert self.tests is not None
        try:
            found = call(self.tests, self._bare(node, {}, node.step, ""))
        except OutsideDomain:
            return {}
        if not isinstance(found, Mapping):
            raise OptionError(
                f"tests returned {found!r:.60}; it must return a mapping of names to numbers, such"
                " as {'zero': point.u[0]}"
            )
        for name in found:
            if name in OWN_NAMES or not isinstance(name, str) or not name:
                raise OptionError(
                    f"a test has the name {name!r}; names are texts, and {', '.join(OWN_NAMES)} are"
                    " taken by the continuation itself"
                )
        try:
            return {name: float(value) for name, value in found.items()}
        except (TypeError, ValueError, OverflowError):
            raise OptionError(
                f"tests returned {dict(found)!r:.80}; each value must be one real number, NaN where"
                " there is none"
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
