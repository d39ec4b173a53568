"""Cells where two surfaces of a mode meet and motion slides on both.

Between the four fields there is a bilinear combination, by one control for each surface, with
which both functions stay zero. Where friction at one surface does not depend on the other it is
the only one; where it does, four fields have more combinations than one, and this is a choice
(L. Dieci and L. Lopez, Sliding motion on discontinuity surfaces of high co-dimension, 2011).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, product

from nonsmooth.system.algebra.differentiate import rate_of_change
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.identities import simplified, substituted, vanishes
from nonsmooth.system.algebra.points import put_on
from nonsmooth.system.algebra.rational import quotient, signed_sum
from nonsmooth.system.cells.cells import Cell, SplitMode
from nonsmooth.system.cells.sliding import Slide, attract, cell_on, have_place, sides_on, solved_for
from nonsmooth.system.equations.switching import SurfaceKey
from nonsmooth.system.text.expressions import Expression

__all__ = ["meetings_of"]

_CORNERS = tuple(product((1, -1), repeat=2))
_Parts = tuple[Expression, Expression, Expression, Expression]


def meetings_of(graph: Graph, mode: SplitMode, jumping: Sequence[SurfaceKey]) -> Iterator[Slide]:
    """Motion where two of the surfaces meet across which the field jumps."""
    for keys in combinations(dict.fromkeys(jumping), 2):
        done: list[Cell] = []
        tried: list[list[Cell]] = []
        for first in mode.cells:
            corners = _corners(mode, keys, first)
            if corners is None or corners in tried:
                continue
            if any(cell.agrees(_others(first, keys)) for cell in done):
                continue
            tried.append(corners)
            slide = _meeting(graph, mode, keys, corners)
            if slide is not None:
                done.append(slide.cell)
                yield slide


def _others(cell: Cell, keys: tuple[SurfaceKey, ...]) -> dict[SurfaceKey, int]:
    return {key: sign for key, sign in cell.signs.items() if key not in keys}


def _corners(mode: SplitMode, keys: tuple[SurfaceKey, ...], first: Cell) -> list[Cell] | None:
    """The four cells around a meeting, one of which is given; None where one does not exist.

    What the signs of one corner allow elsewhere may be impossible in another one: they do not meet.
    """
    if any(key not in first.signs for key in keys):
        return None
    found, elsewhere = [], _others(first, keys)
    for signs in _CORNERS:
        corner = mode.leaf({**first.signs, **dict(zip(keys, signs, strict=True))})
        if any(corner.signs.get(k) != s for k, s in zip(keys, signs, strict=True)):
            return None
        if not corner.agrees(elsewhere):
            return None
        found.append(corner)
    return found


def _meeting(
    graph: Graph, mode: SplitMode, keys: tuple[SurfaceKey, ...], corners: list[Cell]
) -> Slide | None:
    surfaces = [next(s for s in corners[0].surfaces if s.key == key) for key in keys]
    nodes = [surface.node for surface in surfaces]
    relations = solved_for(graph, mode.equations, nodes)
    sides = [mode.resolver(cell.signs) for cell in corners]

    def on_both(node: Expression) -> Expression:
        return simplified(graph, substituted(graph, node, relations))

    def parts(values: list[Expression]) -> _Parts:
        """Mean of four corners, and what each control and their product add."""
        weights = ((1, 1, 1, 1), (1, 1, -1, -1), (1, -1, 1, -1), (1, -1, -1, 1))
        found = []
        for signs in weights:
            total = simplified(graph, signed_sum(graph, values, signs))
            found.append(graph.zero if vanishes([total], points=points) else total)
        a, b, c, e = found
        return a, b, c, e

    if not have_place([sides_on(graph, cell, nodes, on_both) for cell in corners]):
        return None
    around = [[on_both(rate_of_change(graph, node, side.rate)) for side in sides] for node in nodes]
    if not all(attract(graph, mode, nodes, rates_around) for rates_around in around):
        return None
    points = put_on(graph, nodes, relations)
    solved = _controls(graph, *map(parts, around))
    if solved is None:
        return None
    u, w = solved
    both = graph.multiply(u, w)
    quarter = graph.number(0.25)
    rates = {}
    for state in mode.equations.flow:
        if state not in relations:
            a, b, c, e = parts([on_both(side.rate(state)) for side in sides])
            total = graph.add(
                a, graph.multiply(b, u), graph.multiply(c, w), graph.multiply(e, both)
            )
            rates[state] = graph.multiply(quarter, total)
    guards = {}
    for key, control in zip(keys, (u, w), strict=True):
        declared = mode.declared.get(key)
        hold = graph.one if declared is None or declared.hold is None else declared.hold
        guards[key, 1] = simplified(graph, graph.add(hold, graph.negate(control)))
        guards[key, -1] = simplified(graph, graph.add(hold, control))
    controls = dict(zip(keys, (u, w), strict=True))
    return Slide(cell_on(mode, tuple(corners), keys), rates, controls, relations, guards)


def _controls(graph: Graph, first: _Parts, second: _Parts) -> tuple[Expression, Expression] | None:
    """Controls with which two bilinear forms a + b u + c w + e u w are zero.

    With u = -(a1 + c1 w)/(b1 + e1 w) the second one is A w**2 + B w + C, whose root belongs to the
    linear one where e is zero and B, the determinant, is positive.
    """
    a1, b1, c1, e1 = first
    a2, b2, c2, e2 = second

    def minor(p: Expression, q: Expression, r: Expression, s: Expression) -> Expression:
        """p q - r s."""
        return simplified(
            graph, graph.add(graph.multiply(p, q), graph.negate(graph.multiply(r, s)))
        )

    square = minor(c2, e1, e2, c1)
    slope = simplified(graph, graph.add(minor(a2, e1, e2, a1), minor(c2, b1, b2, c1)))
    rest = minor(a2, b1, b2, a1)
    if slope is graph.zero:
        return None
    if square is graph.zero:
        w = quotient(graph, graph.negate(rest), slope)
    else:
        under = graph.add(
            graph.multiply(slope, slope),
            graph.negate(graph.multiply(graph.number(4.0), square, rest)),
        )
        below = graph.add(slope, graph.call("sqrt", under))
        w = quotient(graph, graph.multiply(graph.number(-2.0), rest), below)
    above = graph.negate(graph.add(a1, graph.multiply(c1, w)))
    below = graph.add(b1, graph.multiply(e1, w))
    if below is graph.zero:
        return None
    return quotient(graph, above, below), w
