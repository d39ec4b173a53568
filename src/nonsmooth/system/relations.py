"""Slaved states of a mode that is not linear: expressions, or equations solved by Newton."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from nonsmooth.errors import ModelError
from nonsmooth.system.expressions import Expression
from nonsmooth.system.graph import Graph
from nonsmooth.system.linear import LinearForm, NotLinear, State
from nonsmooth.system.linear_mode import residual, solve_slaved
from nonsmooth.system.mode_equations import ModeEquations, is_relation

__all__ = ["Relations", "read_relations"]


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
