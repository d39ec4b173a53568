"""Determinants of a few expressions."""

from __future__ import annotations

from collections.abc import Sequence

from nonsmooth.system.expressions import Expression
from nonsmooth.system.graph import Graph

__all__ = ["determinant"]


def determinant(graph: Graph, rows: Sequence[Sequence[Expression]]) -> Expression:
    """Determinant by expansion along the rows; equal minors are one node."""
    known: dict[tuple[int, ...], Expression] = {(): graph.one}

    def minor(columns: tuple[int, ...]) -> Expression:
        """Determinant of the last rows in some columns."""
        if columns not in known:
            row = rows[len(rows) - len(columns)]
            terms = []
            for k, column in enumerate(columns):
                if row[column] is not graph.zero:
                    rest = minor(columns[:k] + columns[k + 1 :])
                    term = graph.multiply(row[column], rest)
                    terms.append(graph.negate(term) if k % 2 else term)
            known[columns] = graph.add(*terms)
        return known[columns]

    return minor(tuple(range(len(rows))))
