"""Whether expressions agree identically, seen at random points.

Two analytic expressions that agree at a few random points agree everywhere, but for a set of
points of measure zero. Symbolic simplification would have to know all identities instead.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np

from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.linear import CONSTANT, LinearForm, NotLinear
from nonsmooth.system.algebra.points import COUNT, Points
from nonsmooth.system.algebra.value_tape import ValueTape, sizes_of, table
from nonsmooth.system.text.expressions import ZERO, Call, Expression, Name

__all__ = ["is_rounding", "simplified", "substituted", "vanishes"]

_ENOUGH = 4  # points at which there are values
_ZERO = 1e-9  # of the sizes of what cancels
_ROUNDING = 1e-12  # of the largest part of an expression
_HUGE = 1e12  # what parts come to that divide by rounding


def vanishes(
    nodes: Sequence[Expression],
    beside: Sequence[Expression] = (),
    points: Points | None = None,
) -> bool:
    """Whether all of some expressions are zero, up to rounding of their terms, or beside others.

    ``points`` are where it matters, anywhere unless they are given. Where no point gives values,
    nothing vanishes.
    """
    points = Points() if points is None else points
    tape = ValueTape(nodes)
    parts = tape.run(points)
    values = table([parts[i] for i in tape.results], COUNT)
    sizes = table(sizes_of(tape, parts), COUNT)
    if beside:
        # points that are found by steps are left with what is small beside the sizes elsewhere
        others = np.abs([Points().of(beside), points.of(beside)]).max(axis=(0, 1))
        sizes = np.maximum(sizes, others)
    able = points.able & np.isfinite(values).all(axis=0) & np.isfinite(sizes).all(axis=0)
    looked_at = np.flatnonzero(able)[:_ENOUGH]
    small = np.abs(values) <= _ZERO * sizes
    return len(looked_at) > 0 and bool(small[:, looked_at].all())


def is_rounding(node: Expression) -> bool:
    """Whether an expression is no more than rounding of its largest part, wherever it has values.

    In a long expression the terms add up to sizes of which even plain values are a small part.
    Points at which something divides by rounding tell nothing.
    """
    tape = ValueTape([node])
    parts = np.abs(table(tape.run(Points()), COUNT))
    able = (parts < _HUGE).all(axis=0)
    value, largest = parts[tape.results[0], able], parts[:, able].max(axis=0)
    return bool(able.any()) and bool((value <= _ROUNDING * largest).all())


def simplified(graph: Graph, node: Expression) -> Expression:
    """The same expression; what is linear without the terms that cancel."""
    try:
        form = graph.form(node)
    except NotLinear:
        return node
    kept = {b: c for b, c in form.terms.items() if not _cancels(c)}
    if len(kept) == len(form.terms) and set(kept) - {CONSTANT}:
        return node
    return graph.from_form(LinearForm(kept))


@lru_cache(maxsize=4096)
def _cancels(coefficient: Expression) -> bool:
    """Whether a coefficient is zero for all values of the parameters."""
    return coefficient == ZERO or (isinstance(coefficient, Call) and vanishes([coefficient]))


def substituted(graph: Graph, node: Expression, others: Mapping[str, Expression]) -> Expression:
    """Expression with some states replaced."""
    known: dict[int, Expression] = {}
    has_replaced = graph.reads(others)

    def of(part: Expression) -> Expression:
        if not has_replaced(part):
            return part
        if isinstance(part, Name):
            return others[part.name]
        if id(part) not in known:
            assert isinstance(part, Call)  # a number has no states
            known[id(part)] = graph.call(part.function, *map(of, part.arguments))
        return known[id(part)]

    return of(node)
