"""States that keep the time of a system in which time itself does not stand.

Such a clock grows at one rate in every mode, and an exit whose guard reads nothing else sets it
back. What a forcing is to other systems, the clock is to these.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.compile.structure import SystemStructure
from nonsmooth.system.equations.mode_equations import ModeEquations
from nonsmooth.system.text.expressions import Expression

__all__ = ["clock_states"]


@lru_cache(maxsize=128)  # a structure is shared by systems, and so is the answer
def clock_states(structure: SystemStructure) -> dict[str, Expression]:
    """Rates of the clocks of a system, expressions of parameters, by their states."""
    graph, modes = structure.graph, [forms.resolved for forms in structure.modes.values()]
    found: dict[str, Expression] = {}
    for state in structure.states:
        rates = {id(mode.flow[state].tree) if state in mode.flow else None for mode in modes}
        if len(rates) > 1 or None in rates or graph.moves(modes[0].flow[state].tree):
            continue
        resets = list(_resets(modes, state))
        if resets and all(_reads_only(graph, node, state) for node in resets):
            found[state] = modes[0].flow[state].tree
    return found


def _resets(modes: list[ModeEquations], state: str) -> Iterator[Expression]:
    """Guards and resets of the exits that set a state."""
    for mode in modes:
        for way in mode.exits:
            if state in way.reset:
                yield way.guard.tree
                yield way.reset[state].tree


def _reads_only(graph: Graph, node: Expression, state: str) -> bool:
    """Whether neither time nor any other state stands in a node."""
    others = [name for name in graph.states if name != state]
    return not graph.reads(["t", *others, *graph.signals])(node)
