"""Switching functions of piecewise calls, in one spelling up to a factor.

``x - 1``, ``1 - x`` and ``2*x - 2`` change sign at the same place, so they are one surface.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.system.algebra.frequencies import monomials, rebuilt
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.surfaces import Surface
from nonsmooth.system.text.expressions import Expression, name_set, place_in_order

__all__ = [
    "Declared",
    "SurfaceKey",
    "Switch",
    "SwitchingSurface",
    "Undecided",
    "switching_function",
]

_DIGITS = 12  # in which the numbers of two spellings agree

SurfaceKey = frozenset[tuple[tuple[Expression, ...], str]]


@dataclass(frozen=True, slots=True)
class SwitchingSurface:
    """Place where a switching function vanishes; ``node`` is the function as first met."""

    key: SurfaceKey
    node: Expression


@dataclass(frozen=True, slots=True)
class Declared:
    """A declared surface as its mode meets it.

    ``turned`` where the declared function has the other sign than that of ``surface``.
    """

    name: str
    surface: SwitchingSurface
    turned: bool
    hold: Expression | None
    given: Surface

    def label(self, sign: int) -> str | None:
        """Name of a side, by the sign of ``surface``."""
        return (self.given.on, self.given.above, self.given.below)[-sign if self.turned else sign]


class Undecided(Exception):
    """A piecewise call whose switching function has no sign yet."""

    def __init__(self, surface: SwitchingSurface) -> None:
        super().__init__("a sign is needed")
        self.surface = surface


@dataclass(frozen=True, slots=True)
class Switch:
    """A switching function: ``sign`` times that of its surface, or a constant.

    The constant, where no state, no signal and no time is left in the function, is an expression
    of parameters.
    """

    surface: SwitchingSurface | None
    sign: float
    constant: Expression


def switching_function(graph: Graph, node: Expression) -> Switch:
    """SwitchingSurface of a switching function, up to a numeric factor."""
    if id(node) not in graph.surfaces:
        graph.surfaces[id(node)] = _canonical(graph, node)
    found: Switch = graph.surfaces[id(node)]
    return found


def _canonical(graph: Graph, node: Expression) -> Switch:
    terms = monomials(node)
    ranks = {factors: _rank(graph, factors) for factors in terms}
    fixed = len(graph.states) + 1 + len(graph.signals)
    moving = [factors for factors in terms if ranks[factors][0] < fixed]
    if not moving:
        return Switch(None, 1.0, graph.imported(rebuilt(terms)))
    leading = terms[min(moving, key=lambda factors: ranks[factors])]
    sign = 1.0 if leading > 0.0 else -1.0
    key = frozenset((f, f"{value / leading:.{_DIGITS}g}") for f, value in terms.items())
    return Switch(
        SwitchingSurface(key, node if sign > 0.0 else graph.negate(node)), sign, graph.zero
    )


def _rank(graph: Graph, factors: tuple[Expression, ...]) -> tuple[int, int, list[tuple[bool, str]]]:
    """What makes a product lead: the first state, time or signal in it, then few factors."""
    names = {name for factor in factors for name in name_set(factor)}
    moving = (*graph.states, "t", *graph.signals)
    places = [i for i, name in enumerate(moving) if name in names]
    first = min(places, default=len(moving))
    return first, len(factors), [place_in_order(factor) for factor in factors]
