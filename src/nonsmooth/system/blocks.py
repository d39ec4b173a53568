"""Equations and unknowns in blocks, each of which is solved with the blocks before it known."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["Block", "blocks_of"]

Pattern = npt.NDArray[np.bool_]


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
