"""Modes in which an exit that rebounds is at rest: guard and guard rate stay zero.

The reaction acts along the jump of the reset. With the rate w of the guard g, the jump of a reset
is j(z), which vanishes with w; its direction d is -j for w = 1. So motion at rest has the rates
f + sum of l d, with reactions l such that each guard's second rate is zero, and goes on while they
push: l >= 0. Rebounds that accumulate end there, with the momentum that is left along d gone.
See A. Nordmark and P. Piiroinen, Simulation and stability analysis of impacting systems with
complete chattering, Nonlinear Dynamics 58, 2009.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nonsmooth.errors import ModelError
from nonsmooth.system.algebra.differentiate import derivative, rate_of_change
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.identities import simplified, substituted, vanishes
from nonsmooth.system.algebra.points import Points, put_on, quotient_where
from nonsmooth.system.algebra.rational import determinant
from nonsmooth.system.cells.cells import MOST_MODES
from nonsmooth.system.cells.sliding import solved_for
from nonsmooth.system.equations.mode_equations import ExitEquations, ModeEquations
from nonsmooth.system.equations.resolve import Resolver
from nonsmooth.system.text.expressions import Expression, Number

__all__ = ["Rest", "contacts_at_rest", "leaves_at_rest", "may_rest", "rest_of"]


@dataclass(frozen=True)
class _Contact:
    """An exit that rebounds: its guard, the guard's rate, and the direction of its jump."""

    exit: ExitEquations
    guard: Expression
    rate: Expression
    push: Mapping[str, Expression]


@dataclass(frozen=True)
class Rest:
    """Motion with some contacts at rest, in one cell.

    ``reactions`` are zero where a contact is released; ``arrival`` sets the states that a jump
    moves to what they are once the contacts are at rest.
    """

    rates: Mapping[str, Expression]
    relations: Mapping[str, Expression]
    reactions: Mapping[int, Expression]
    arrival: Mapping[str, Expression]


def contacts_at_rest(
    equations: ModeEquations, together: Callable[[tuple[int, ...]], bool]
) -> Iterator[tuple[int, ...]]:
    """Sets of exits of a mode that may be at rest together, by number, small ones first.

    ``together`` says whether two or more exits may. What two of them cannot do, no larger set with
    these two can: two walls of one mass, for one. `ModelError` where the sets are too many.
    """
    sticking = [i for i, way in enumerate(equations.exits) if way.sticks]
    sets: list[tuple[int, ...]] = [(i,) for i in sticking]
    count = len(sets)
    while sets:
        yield from sets
        known = set(sets)
        sets = [
            (*which, i)
            for which in sets
            for i in sticking
            if i > which[-1]
            and all((*which[:k], *which[k + 1 :], i) in known for k in range(len(which)))
            and together((*which, i))
        ]
        count += len(sets)
        if count > MOST_MODES:
            raise ModelError(
                f"modes[{equations.name!r}]: {len(sticking)} exits stick, and more than"
                f" {MOST_MODES} sets of them may be at rest together, each of which is a mode; let"
                " fewer of them stick"
            )


def may_rest(graph: Graph, equations: ModeEquations, free: Resolver, which: Sequence[int]) -> bool:
    """Whether some exits of a mode can be at rest together.

    Not two walls of one mass, and not where sliding on a surface holds the speed already.
    """
    try:
        contacts = {i: _contact(graph, free, equations.exits[i]) for i in which}
    except ModelError:
        return False
    matrix = _pushes(graph, contacts)
    divisor = determinant(graph, [[matrix[i, k] for k in which] for i in which])
    points = put_on(graph, [], solved_for(graph, equations, [contacts[which[0]].guard]))
    return not vanishes([divisor], [_diagonal(graph, matrix, which)], points)


def _diagonal(
    graph: Graph, matrix: Mapping[tuple[int, int], Expression], which: Sequence[int]
) -> Expression:
    """Product of what each contact's own push does, which a determinant stands beside."""
    return graph.multiply(*(matrix[i, i] for i in which)) if len(which) > 1 else graph.one


def rest_of(
    graph: Graph,
    equations: ModeEquations,
    free: Resolver,
    which: Sequence[int],
    leaf: Resolver | None = None,
) -> Rest:
    """Motion with some exits of a mode at rest; ``free`` are the nodes of the mode without.

    ``leaf`` are those beside the surfaces on which ``free`` slides: there all states are free.
    """
    contacts = {i: _contact(graph, leaf or free, equations.exits[i]) for i in which}
    matrix = _pushes(graph, contacts)
    pulls = {
        i: graph.negate(rate_of_change(graph, contact.rate, free.rate))
        for i, contact in contacts.items()
    }
    reactions = _solved(graph, which, matrix, pulls)
    impulses = _solved(graph, which, matrix, {i: graph.negate(contacts[i].rate) for i in which})
    rates, arrival = {}, {}
    for state in equations.flow:
        pushes = [(i, c.push[state]) for i, c in contacts.items() if state in c.push]
        terms = [graph.multiply(reactions[i], push) for i, push in pushes]
        rates[state] = simplified(graph, graph.add(free.rate(state), *terms))
        if pushes:
            terms = [graph.multiply(impulses[i], push) for i, push in pushes]
            arrival[state] = simplified(graph, graph.add(graph.name(state), *terms))
    for contact in contacts.values():  # slaved states that may jump do so here too
        named = (state for state in contact.exit.reset if state in equations.slaved)
        arrival |= {state: graph.name(state) for state in named}
    kept = [node for contact in contacts.values() for node in (contact.guard, contact.rate)]
    relations = solved_for(graph, equations, kept)
    rates = {
        state: simplified(graph, substituted(graph, rate, relations))
        for state, rate in rates.items()
        if state not in relations
    }
    # where one contact is at rest its reaction has the sign of what pulls at it
    shown = pulls if len(contacts) == 1 else reactions
    shown = {i: simplified(graph, substituted(graph, node, relations)) for i, node in shown.items()}
    return Rest(rates, relations, shown, arrival)


def _pushes(graph: Graph, contacts: Mapping[int, _Contact]) -> dict[tuple[int, int], Expression]:
    """What the push of each contact adds to the second rate of each guard."""
    return {
        (i, k): simplified(graph, _along(graph, contacts[i].rate, contacts[k].push))
        for i in contacts
        for k in contacts
    }


def _contact(graph: Graph, free: Resolver, way: ExitEquations) -> _Contact:
    guard = free.tree(way.guard)
    rate = simplified(graph, rate_of_change(graph, guard, free.rate))
    moved = {state: e for state, e in way.reset.items() if state in free.equations.flow}
    slopes = {
        state: simplified(graph, _slope(graph, rate, state))
        for state in moved
        if state in graph.states_in(rate)
    }
    # what a surface holds does not jump: what holds it there takes the push
    held = free.relations.explicit if len(moved) < len(way.reset) else {}
    jumps = {
        state: simplified(
            graph,
            substituted(graph, graph.add(free.tree(e), graph.negate(graph.name(state))), held),
        )
        for state, e in moved.items()
    }
    moving: list[str] = []  # states that the reset changes where the guard rests
    # by the state on which the rate depends in the plainest way: a slope may vanish somewhere
    for state, slope in sorted(
        slopes.items(), key=lambda item: (not isinstance(item[1], Number), graph.moves(item[1]))
    ):
        if slope is graph.zero:
            continue
        push = {
            other: simplified(
                graph, graph.negate(graph.call("/", _slope(graph, jump, state), slope))
            )
            for other, jump in jumps.items()
        }
        push = {other: node for other, node in push.items() if node is not graph.zero}
        if not push:
            continue

        def stops(
            some: Mapping[str, Expression], by: str = state, slope: Expression = slope
        ) -> bool:
            points = put_on(graph, [guard], solved_for(graph, free.equations, [guard]))
            return _stops(graph, some, points, rate, by, slope)

        if stops(jumps):
            return _Contact(way, guard, rate, push)
        if stops({state: jumps[state]}):
            moving = [other for other, jump in jumps.items() if not stops({other: jump})]
    raise ModelError(
        f"{way.guard.where.removesuffix('.guard')}: sticks={way.sticks!r} needs a reset that"
        " changes nothing where the guard rests, and moves a state that its rate depends on, such"
        " as 'v': '-r*v' for a guard of x; a reset with the speed of a moving wall is -r*v +"
        f" (1 + r)*speed{_blamed(moving)}"
    )


def _blamed(moving: Sequence[str]) -> str:
    """Which states a reset would go on changing at rest, where that alone is the fault."""
    if not moving:
        return ""
    shown = " and ".join(repr(state) for state in moving)
    return (
        f". Here the reset of {shown} still changes it at rest: let that change vanish with the"
        " speed of the impact, as that of friction does, which is a part of its impulse"
    )


def _stops(
    graph: Graph,
    jumps: Mapping[str, Expression],
    points: Points,
    rate: Expression,
    state: str,
    slope: Expression,
) -> bool:
    """Whether jumps vanish where guard and rate do; ``points`` on the guard are moved there."""
    for _ in range(2):  # once would do, but for a rate that is not linear
        speed, steepness = points.of([rate, slope])
        points.able &= np.isfinite(speed) & np.isfinite(steepness) & (steepness != 0.0)
        points[state] = points[state] - quotient_where(points.able, speed, steepness)
    sizes = [graph.one, *(graph.name(other) for other in jumps)]
    return vanishes(list(jumps.values()), sizes, points)


def leaves_at_rest(
    graph: Graph, equations: ModeEquations, free: Resolver, which: Sequence[int], other: int
) -> bool:
    """Whether the reset of another exit does not move what is at rest."""
    resets = {state: free.tree(e) for state, e in equations.exits[other].reset.items()}
    contacts = [_contact(graph, free, equations.exits[i]) for i in which]
    kept = [node for contact in contacts for node in (contact.guard, contact.rate)]
    changes = [graph.add(substituted(graph, node, resets), graph.negate(node)) for node in kept]
    points = put_on(graph, kept, solved_for(graph, equations, kept))
    return vanishes(changes, [graph.one], points)


def _slope(graph: Graph, node: Expression, state: str) -> Expression:
    return derivative(graph, node, lambda name: graph.one if name == state else graph.zero)


def _along(graph: Graph, node: Expression, push: Mapping[str, Expression]) -> Expression:
    """Derivative of an expression along a direction of states."""
    return derivative(graph, node, lambda name: push.get(name, graph.zero))


def _solved(
    graph: Graph,
    which: Sequence[int],
    matrix: Mapping[tuple[int, int], Expression],
    right: Mapping[int, Expression],
) -> dict[int, Expression]:
    """Solution of a few linear equations by Cramer's rule."""
    rows = [[matrix[i, k] for k in which] for i in which]
    divisor = determinant(graph, rows)
    found = {}
    for place, k in enumerate(which):
        replaced = [
            [*row[:place], right[i], *row[place + 1 :]] for i, row in zip(which, rows, strict=True)
        ]
        found[k] = graph.call("/", determinant(graph, replaced), divisor)
    return found
