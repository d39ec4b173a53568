"""Whether expressions agree identically, seen at random points.

Two analytic expressions that agree at a few random points agree everywhere, but for a set of
points of measure zero. Symbolic simplification would have to know all identities instead.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache

import numpy as np

from nonsmooth.system.evaluate import evaluate_shared
from nonsmooth.system.expressions import ZERO, Call, Expression, Name
from nonsmooth.system.graph import Graph
from nonsmooth.system.linear import CONSTANT, LinearForm, NotLinear, linear_form
from nonsmooth.system.relations import form_of_node
from nonsmooth.system.sizes import size_at

__all__ = ["random_point", "simplified", "substituted", "value_at", "vanishes"]

_POINTS = 4
_TRIES = 12  # points at which a root is negative or a logarithm has no value are passed over
_ZERO = 1e-9  # of the sizes of what cancels

Point = Mapping[str, float]


class _Values(dict[str, float]):
    """A random value for each name that is asked for."""

    def __init__(self, seed: int) -> None:
        super().__init__()
        self._random = np.random.default_rng(seed)

    def __missing__(self, name: str) -> float:
        self[name] = float(self._random.uniform(0.3, 1.7))
        return self[name]


def random_point(seed: int) -> _Values:
    """Values of all names, made as they are asked for."""
    return _Values(seed)


def value_at(node: Expression, point: Point) -> float:
    """Value of an expression; nan where it has none."""
    try:
        value = float(evaluate_shared(node, point, {}, lambda _: None))
    except (ArithmeticError, TypeError, ValueError):
        return math.nan
    return value if math.isfinite(value) else math.nan


def vanishes(
    nodes: Sequence[Expression],
    beside: Sequence[Expression] = (),
    place: Callable[[_Values], bool] = lambda _: True,
) -> bool:
    """Whether all of some expressions are zero, up to rounding of their terms, or beside others.

    ``place`` moves a random point to where it matters, and says whether it could. Where no point
    gives values, nothing vanishes.
    """
    seen = 0
    for seed in range(_TRIES):
        point = random_point(seed)
        # a place that is found by steps is left with what is small beside the sizes elsewhere
        sizes = [abs(value_at(node, point)) for node in beside]
        if not place(point):
            continue
        sizes += [abs(value_at(node, point)) for node in beside]
        least = max(sizes, default=0.0)
        values = [value_at(node, point) for node in nodes]
        terms = [max(least, size_at(node, point)) for node in nodes]
        if any(map(math.isnan, (*values, *terms))):
            continue
        if any(abs(v) > _ZERO * size for v, size in zip(values, terms, strict=True)):
            return False
        seen += 1
        if seen >= _POINTS:
            break
    return seen > 0


def simplified(graph: Graph, node: Expression) -> Expression:
    """The same expression; what is linear without the terms that cancel."""
    try:
        form = linear_form(node, lambda part: form_of_node(graph, part))
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

    def of(part: Expression) -> Expression:
        if isinstance(part, Name):
            return others.get(part.name, part)
        if not isinstance(part, Call) or not graph.moves(part) or graph.signal_of(part):
            return part
        if id(part) not in known:
            known[id(part)] = graph.call(part.function, *map(of, part.arguments))
        return known[id(part)]

    return of(node)
