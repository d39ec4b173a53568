"""Values of all equations of one cell at many points, and the sizes of their terms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.value_tape import ValueTape, sizes_of, table
from nonsmooth.system.compile.mode_forms import ModeForms
from nonsmooth.system.compile.structure import SystemStructure
from nonsmooth.system.equations.slaved import Relations, partials
from nonsmooth.system.text.expressions import Expression

__all__ = ["CellValues", "ValuesAt", "cell_values"]

Floats = npt.NDArray[np.float64]

_NEWTON = 40  # steps onto relations that are solved for
_ON = 1e-15  # step, beside the states, at which Newton's method can do no more
_NEAR = 1e-11  # step of a point that lies on them: the next one would have twice the digits


@dataclass(frozen=True)
class ValuesAt:
    """Values at K points, or the sizes of their terms; nan where they have none."""

    rates: Floats  # (n, K), of all states
    relations: Floats  # (R, K): what is zero where the slaved states are as they should be
    guards: Floats  # (E, K)
    behind: Floats  # (E, n, K), the state behind each exit

    @property
    def finite(self) -> npt.NDArray[np.bool_]:
        """Points at which all of them are numbers, shape (K,)."""
        behind = self.behind.reshape(-1, self.rates.shape[1])
        rows = np.concatenate([self.rates, self.relations, self.guards, behind])
        return np.asarray(np.isfinite(rows).all(axis=0))


class CellValues:
    """The equations of one cell as a tape of numbers."""

    def __init__(self, graph: Graph, forms: ModeForms) -> None:
        self.forms = forms
        resolver, states = forms.resolver, graph.states
        self.relations: Relations = resolver.relations
        exits = forms.resolved.exits
        zeros = [
            graph.add(graph.name(state), graph.negate(node))
            for state, node in self.relations.explicit.items()
        ]
        zeros += self.relations.implicit.values()
        behind: list[Expression] = []
        for way in exits:
            reset = {state: equation.tree for state, equation in way.reset.items()}
            behind += [reset.get(state, graph.name(state)) for state in states]
        nodes = [resolver.rate(state) for state in states] + zeros
        nodes += [way.guard.tree for way in exits] + behind
        self._cuts = np.cumsum([len(states), len(zeros), len(exits)])
        self._shape = len(exits), len(states)
        self._tape = ValueTape(nodes)
        self._explicit = ValueTape(self.relations.explicit.values())
        unknowns = self.relations.implicit
        gradients = [node for row in partials(graph, self.relations) for node in row]
        self._implicit = ValueTape([*unknowns.values(), *gradients])

    def at(self, point: Mapping[str, Any], count: int) -> tuple[ValuesAt, ValuesAt]:
        """Values at some points, and the sizes of their terms."""
        parts = self._tape.run(point)
        values = [parts[i] for i in self._tape.results]
        return self._cut(table(values, count)), self._cut(table(sizes_of(self._tape, parts), count))

    def _cut(self, rows: Floats) -> ValuesAt:
        rates, relations, guards, behind = np.split(rows, self._cuts)
        return ValuesAt(rates, relations, guards, behind.reshape(*self._shape, rows.shape[1]))

    def put_on_relations(self, point: dict[str, Any], count: int) -> None:
        """Let the slaved states of some points follow from their equations; nan where none do."""
        explicit, implicit = list(self.relations.explicit), list(self.relations.implicit)
        k = len(implicit)
        for _ in range(_NEWTON if k else 1):
            for _ in explicit:  # they may depend on each other, without a circle
                point |= zip(explicit, table(self._explicit.values(point), count), strict=True)
            if not k:
                return
            rows = table(self._implicit.values(point), count)
            gaps, matrices = rows[:k].T, rows[k:].T.reshape(count, k, k)
            step = _solved(matrices, gaps).T
            for state, change in zip(implicit, step, strict=True):
                point[state] = point[state] - change
            size = np.abs([point[state] for state in implicit]).max(axis=0)
            if not np.any(np.abs(step).max(axis=0) > _ON * size):
                break
        lost = ~(np.abs(step).max(axis=0) <= _NEAR * size)
        for state in implicit:
            point[state] = np.where(lost, np.nan, point[state])
        for _ in explicit:
            point |= zip(explicit, table(self._explicit.values(point), count), strict=True)


@lru_cache(maxsize=32)  # a structure is shared by systems, and so are these
def cell_values(structure: SystemStructure) -> tuple[CellValues, ...]:
    """Equations of each cell that runs, in order."""
    return tuple(CellValues(structure.graph, forms) for forms in structure.running)


def _solved(matrices: Floats, right: Floats) -> Floats:
    """Solutions of small systems of equations, nan where there is none."""
    found = np.full(right.shape, np.nan)
    for k, (matrix, values) in enumerate(zip(matrices, right, strict=True)):
        try:
            found[k] = np.linalg.solve(matrix, values)
        except np.linalg.LinAlgError:
            continue
    return found
