"""Slaved states of a mode that is not linear: expressions, or equations solved by Newton."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from nonsmooth.errors import ModelError
from nonsmooth.system.expressions import Expression, Name
from nonsmooth.system.graph import Graph
from nonsmooth.system.linear import Input, LinearForm, NotLinear, Power, State, linear_form
from nonsmooth.system.linear_mode import residual, solve_slaved
from nonsmooth.system.mode_equations import ModeEquations, is_relation

__all__ = ["Relations", "form_of_node", "read_relations"]

_MOST_SOLVED = 6  # states that are solved for together: their rates are quotients of determinants


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
            form = linear_form(tree, lambda node: form_of_node(graph, node))
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
    if len(implicit) > _MOST_SOLVED:
        raise ModelError(
            f"modes[{equations.name!r}].slaved: {len(implicit)} equations with '=' that are not"
            f" linear ({', '.join(implicit)}); at most {_MOST_SOLVED} are solved together: write"
            " some of these states as expressions of the others"
        )
    return Relations({state: found[state] for state in trees if state in found}, implicit)


def form_of_node(graph: Graph, node: Expression) -> LinearForm:
    """Linear form of a name, or of a signal or its rate, where rates of states were put in."""
    signal = graph.signal_of(node)
    if signal is not None:
        return LinearForm.of(Input(*signal))
    assert isinstance(node, Name)  # rates were put in
    if node.name == "t":
        return LinearForm.of(Power(1))
    if node.name in graph.states:
        return LinearForm.of(State(node.name))
    return LinearForm.constant(node)


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
