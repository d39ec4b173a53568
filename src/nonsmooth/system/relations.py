"""Slaved states of a mode that is not linear, each by an expression of the others."""

from __future__ import annotations

from collections.abc import Mapping

from nonsmooth.errors import ModelError
from nonsmooth.system.expressions import Expression, Name
from nonsmooth.system.grammar import point_at
from nonsmooth.system.graph import Graph
from nonsmooth.system.linear import Input, LinearForm, NotLinear, Power, State, linear_form
from nonsmooth.system.linear_mode import LinearReader, NonlinearText, residual, solve_slaved
from nonsmooth.system.mode_equations import ModeEquations, is_relation

__all__ = ["explicit_relations"]


def explicit_relations(
    graph: Graph, equations: ModeEquations, trees: Mapping[str, Expression]
) -> dict[str, Expression]:
    """Expressions of the slaved states from their equations.

    Those that are linear are solved together; the others stand as they are written, so
    they need to give their state explicitly and without a circle.
    """
    residuals: dict[str, LinearForm] = {}
    found: dict[str, Expression] = {}
    for state, tree in trees.items():
        equation = equations.slaved[state]
        try:
            form = linear_form(tree, lambda node: _form_of(graph, node))
            residuals[state] = residual(state, equation, form)
        except NotLinear:
            if is_relation(equation.text):
                raise ModelError(_implicit(graph, equations, state)) from None
            found[state] = tree
    solved = solve_slaved(equations.name, equations.slaved, residuals)
    found |= {state: graph.from_form(form) for state, form in solved.items()}
    _check_circles(graph, equations, found)
    return {state: found[state] for state in trees}


def _form_of(graph: Graph, node: Expression) -> LinearForm:
    signal = graph.signal_of(node)
    if signal is not None:
        return LinearForm.of(Input(*signal))
    assert isinstance(node, Name)  # rates were put in
    if node.name == "t":
        return LinearForm.of(Power(1))
    if node.name in graph.states:
        return LinearForm.of(State(node.name))
    return LinearForm.constant(node)


def _implicit(graph: Graph, equations: ModeEquations, state: str) -> str:
    equation = equations.slaved[state]
    reason, at = "it is piecewise", -1
    try:
        LinearReader(graph, equations).form(equation)
    except NonlinearText as fault:
        reason, at = fault.reason, fault.at if fault.equation is equation else -1
    message = (
        f"{equation.where}: {reason}, and an equation with '=' is solved only where it is linear;"
        f" write {state!r} as an expression of the other states"
    )
    return point_at(equation.text, at, message)


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
