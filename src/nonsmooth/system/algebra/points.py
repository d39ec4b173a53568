"""Random points at which expressions are compared, and how they come onto surfaces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from zlib import crc32

import numpy as np
import numpy.typing as npt

from nonsmooth.system.algebra.differentiate import derivative
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.value_tape import Array, ValueTape, table
from nonsmooth.system.text.expressions import Expression

__all__ = ["COUNT", "Points", "put_on", "quotient_where"]

COUNT = 12  # some are of no use: where a root is negative or a logarithm has no value
_NEWTON = 40  # steps in looking for a point of a surface
_ON = 1e-12  # of the function at such a point


class Points(dict[str, Array]):
    """A random value at each point for each name that is asked for.

    ``able`` are the points that lie where they should.
    """

    def __init__(self) -> None:
        super().__init__()
        self.able: npt.NDArray[np.bool_] = np.ones(COUNT, dtype=bool)

    def __missing__(self, name: str) -> Array:
        return _somewhere(name)

    def of(self, nodes: Sequence[Expression]) -> Array:
        """Values of expressions, a row for each; nan where they have none."""
        return table(ValueTape(nodes).values(self), COUNT)


def quotient_where(able: npt.NDArray[np.bool_], above: Array, below: Array) -> Array:
    """Quotient at some points; zero at the others."""
    with np.errstate(all="ignore"):
        return np.where(able, above / below, 0.0)


@lru_cache(maxsize=1024)
def _somewhere(name: str) -> Array:
    """Values of a name: the same ones whenever it is asked for."""
    values = np.random.default_rng(crc32(name.encode())).uniform(0.3, 1.7, COUNT)
    values.flags.writeable = False
    return values


def put_on(
    graph: Graph,
    nodes: Sequence[Expression],
    relations: Mapping[str, Expression],
    first: str | None = None,
) -> Points:
    """Random points on surfaces: by the states that follow from them, or by Newton's method.

    Where a surface has several branches, the state that is moved ``first`` says which is found.
    """
    points = Points()
    if relations:
        states = list(relations)
        points |= zip(states, points.of(list(relations.values())), strict=True)
        return points
    for node in nodes:
        points.able &= _moved(graph, node, points, first)
    return points


def _moved(
    graph: Graph, node: Expression, points: Points, first: str | None
) -> npt.NDArray[np.bool_]:
    """Move one coordinate of each point to where an expression is zero; whether that was found."""
    found = np.zeros(COUNT, dtype=bool)
    for state in sorted(graph.states_in(node), key=lambda name: (name != first, name)):

        def seed(name: str, state: str = state) -> Expression:
            return graph.one if name == state else graph.zero

        tape = ValueTape([node, derivative(graph, node, seed)])
        kept, going = points[state], ~found
        for _ in range(_NEWTON):
            value, slope = table(tape.values(points), COUNT)
            found |= going & (np.abs(value) <= _ON)
            going &= ~found & np.isfinite(value) & np.isfinite(slope) & (slope != 0.0)
            if not going.any():
                break
            points[state] = points[state] - quotient_where(going, value, slope)
        points[state] = np.where(found, points[state], kept)
        if found.all():
            break
    return found
