"""Slaved states: their equations are read, checked, solved where they are linear, and derived.

The equations of a mode that are linear are solved together here. The engine solves the others,
G(u, z, t) = 0 for the slaved states u, by Newton's method. As they hold all the time, the rates of
u solve G_u u' = -G_z z' - G_t. Equations that depend on each other form a block, and Cramer's rule
gives the rates of each block with one divisor, a determinant of G_u. It is zero only where the
equations do not determine u.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError
from nonsmooth.system.algebra.differentiate import derivative, rate_of_change
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.linear import LinearForm, NotLinear, State
from nonsmooth.system.algebra.rational import determinant
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.equations.mode_equations import ModeEquations, is_relation
from nonsmooth.system.text.expressions import ZERO, Expression, Number, divide, negate, written_out

__all__ = ["Relations", "implicit_rates", "partials", "read_relations", "residual", "solve_slaved"]

_MOST_NODES = 250_000  # of slaved states that are solved together
_MOST_SOLVED = 6  # states that depend on each other: the terms of a determinant are many

_Row = Sequence[Expression]
Pattern = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Relations:
    """Slaved states of a mode.

    ``explicit`` ones are given by expressions; ``implicit`` ones by as many expressions that
    vanish, which the engine solves together.
    """

    explicit: dict[str, Expression] = field(default_factory=dict)
    implicit: dict[str, Expression] = field(default_factory=dict)


def read_relations(
    graph: Graph, equations: ModeEquations, trees: Mapping[str, Expression]
) -> Relations:
    """Slaved states from their equations.

    Those that are linear are solved together. The others stand as they are written:
    expressions, without a circle, and equations with ``=`` to be solved for.
    """
    residuals: dict[str, LinearForm] = {}
    found: dict[str, Expression] = {}
    implicit: dict[str, Expression] = {}
    for state, tree in trees.items():
        equation = equations.slaved[state]
        try:
            form = graph.form(tree)
            residuals[state] = residual(state, equation, form)
        except NotLinear:
            (implicit if is_relation(equation.text) else found)[state] = tree
    if implicit:  # what does not tell its own state may help to tell the others
        for state in [s for s, form in residuals.items() if State(s) not in form.terms]:
            implicit[state] = trees[state]
            del residuals[state]
    solved = solve_slaved(equations.name, equations.slaved, residuals)
    found |= {state: graph.from_form(form) for state, form in solved.items()}
    _check_circles(graph, equations, found)
    return Relations({state: found[state] for state in trees if state in found}, implicit)


def _check_circles(
    graph: Graph, equations: ModeEquations, relations: Mapping[str, Expression]
) -> None:
    done: set[str] = set()

    def follow(state: str, path: list[str]) -> None:
        if state in path:
            circle = " -> ".join([*path[path.index(state) :], state])
            raise ModelError(
                f"{equations.slaved[state].where}: {circle} goes in a circle; slaved states that"
                " are not linear are given by states that do not depend on them"
            )
        if state in done:
            return
        for other in relations:
            if other in graph.states_in(relations[state]):
                follow(other, [*path, state])
        done.add(state)

    for state in relations:
        follow(state, [])


# ---------------------------------------------------------------- linear equations


def residual(state: str, equation: Equation, form: LinearForm) -> LinearForm:
    """Form that vanishes: left - right of a relation, state - expression otherwise."""
    if is_relation(equation.text):
        return form
    return LinearForm.of(State(state)).plus(form.scaled(Number(-1.0)))


def solve_slaved(
    mode: str, equations: Mapping[str, Equation], residuals: Mapping[str, LinearForm]
) -> dict[str, LinearForm]:
    """Explicit forms of slaved states: their equations solved together.

    Gauss elimination on coefficients that are expressions of parameters; a pivot that
    vanishes for some values shows as a coefficient that is not finite.
    """
    solved: dict[str, LinearForm] = {}
    for state, given in residuals.items():
        open_ = given.with_replaced(solved)
        pivot = open_.coefficient(State(state))
        if pivot == ZERO:
            equation = equations[state]
            raise ModelError(f"{equation.where}: {state!r} does not appear in {equation.text!r}")
        others = {b: c for b, c in open_.terms.items() if b != State(state)}
        explicit = LinearForm({b: negate(divide(c, pivot)) for b, c in others.items()})
        solved = {k: form.with_replaced({state: explicit}) for k, form in solved.items()}
        solved[state] = explicit
        parts = (value for form in solved.values() for value in form.terms.values())
        if written_out(parts) > _MOST_NODES:
            raise ModelError(
                f"modes[{mode!r}].slaved: solved together, the equations of"
                f" {', '.join(list(solved)[:8])} have more than {_MOST_NODES:,} parts; write"
                " each slaved state by states that are not slaved"
            )
    return solved


# ---------------------------------------------------------------- blocks of equations


class Block(NamedTuple):
    """Equations that are solved together, and the unknowns for which they are, by number."""

    rows: tuple[int, ...]
    columns: tuple[int, ...]


def blocks_of(pattern: Pattern) -> list[Block] | None:
    """Blocks of equations in an order in which they can be solved.

    ``pattern`` says which unknown stands in which equation, (n, n). Each unknown is given to an
    equation in which it stands; equations that need each other's unknowns are one block, a strongly
    connected component (A. L. Dulmage and N. S. Mendelsohn, Canadian Journal of Mathematics 10,
    1958). None where some unknown has no equation.
    """
    columns = _matched(pattern)
    if columns is None:
        return None
    reaches = pattern[:, columns] | np.eye(len(pattern), dtype=bool)
    for k in range(len(pattern)):  # through equation k too
        reaches |= reaches[:, k : k + 1] & reaches[k]
    together = reaches & reaches.T
    blocks = {tuple(np.flatnonzero(row).tolist()) for row in together}
    # what reaches fewer equations needs none of those that reach more
    order = sorted(blocks, key=lambda rows: (int(reaches[rows[0]].sum()), rows))
    return [Block(rows, tuple(columns[i] for i in rows)) for rows in order]


def _matched(pattern: Pattern) -> list[int] | None:
    """An unknown of its own for each equation, by augmenting paths; None where some has none."""
    owner = [-1] * len(pattern)  # equation of each unknown

    def give(row: int, tried: set[int]) -> bool:
        """Find an unknown for an equation; others may have to take another one."""
        for column in np.flatnonzero(pattern[row]).tolist():
            if column in tried:
                continue
            tried.add(column)
            if owner[column] < 0 or give(owner[column], tried):
                owner[column] = row
                return True
        return False

    if not all(give(row, set()) for row in range(len(pattern))):
        return None
    return [owner.index(row) for row in range(len(pattern))]


# ---------------------------------------------------------------- rates of implicit states


def implicit_rates(
    graph: Graph,
    equations: ModeEquations,
    relations: Relations,
    rate: Callable[[str], Expression],
) -> dict[str, Expression]:
    """Rates of the implicit slaved states, from the rates of all others."""
    unknowns = tuple(relations.implicit)
    rows = partials(graph, relations)

    def rate_of_others(state: str) -> Expression:
        if state in relations.implicit:
            return graph.zero
        if state in relations.explicit:
            return rate_of_change(graph, relations.explicit[state], rate_of_others)
        return rate(state)

    pushed = [
        graph.negate(rate_of_change(graph, node, rate_of_others))
        for node in relations.implicit.values()
    ]
    found: dict[str, Expression] = {}
    for block in _blocks(graph, equations, rows, unknowns):
        right = [
            graph.add(
                pushed[i],
                *(
                    graph.negate(graph.multiply(rows[i][j], found[state]))
                    for j, state in enumerate(unknowns)
                    if state in found and rows[i][j] is not graph.zero
                ),
            )
            for i in block.rows
        ]
        inner = [[rows[i][j] for j in block.columns] for i in block.rows]
        names = [unknowns[j] for j in block.columns]
        found |= _by_cramers_rule(graph, equations, inner, right, names)
    return {state: found[state] for state in unknowns}


def _blocks(
    graph: Graph, equations: ModeEquations, rows: Sequence[_Row], unknowns: Sequence[str]
) -> list[Block]:
    """Equations that have to be solved together, those first on which others depend."""
    pattern = np.array([[node is not graph.zero for node in row] for row in rows], dtype=bool)
    blocks = blocks_of(pattern)
    if blocks is None:
        raise ModelError(_untold(equations, unknowns))
    for block in blocks:
        if len(block.rows) > _MOST_SOLVED:
            names = [unknowns[j] for j in block.columns]
            raise ModelError(
                f"modes[{equations.name!r}].slaved: {len(names)} equations with '=' that are not"
                f" linear depend on each other ({', '.join(names)}); at most {_MOST_SOLVED} are"
                " solved together: write some of these states as expressions of the others"
            )
    return blocks


def _by_cramers_rule(
    graph: Graph, equations: ModeEquations, rows: Sequence[_Row], right: _Row, names: Sequence[str]
) -> dict[str, Expression]:
    divisor = determinant(graph, rows)
    if divisor is graph.zero:
        raise ModelError(_untold(equations, names))
    rates = {}
    for j, state in enumerate(names):
        replaced = [[*row[:j], b, *row[j + 1 :]] for row, b in zip(rows, right, strict=True)]
        rates[state] = graph.call("/", determinant(graph, replaced), divisor)
    return rates


def _untold(equations: ModeEquations, names: Sequence[str]) -> str:
    return (
        f"modes[{equations.name!r}].slaved: the equations with '=' of {', '.join(names)}"
        " cannot be solved for these states, whatever their values; each of them must stand"
        " in an equation, and no two equations may say the same"
    )


def partials(graph: Graph, relations: Relations) -> list[list[Expression]]:
    """Derivatives of the implicit equations, row by row, by the states for which they are solved.

    States that follow from these by expressions move with them.
    """
    return [
        [_partial(graph, relations, node, state) for state in relations.implicit]
        for node in relations.implicit.values()
    ]


def _partial(graph: Graph, relations: Relations, node: Expression, state: str) -> Expression:
    """Derivative by one implicit state, those that follow from it by expressions included."""

    def seed(name: str) -> Expression:
        if name in relations.explicit:
            return derivative(graph, relations.explicit[name], seed)
        return graph.one if name == state else graph.zero

    return derivative(graph, node, seed)
