"""A Markov chain of cells: its closed classes, and the probability to end in each.

C. S. Hsu, Journal of Applied Mechanics 48, 634-642 (1981): generalised cell mapping.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

__all__ = ["closed_classes", "end_shares", "transitions"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def transitions(source: Integers, image: Integers, count: int) -> sparse.csr_array:
    """Matrix of the shares of each cell's points that go to each cell, (count, count).

    shapes: source, image (K,), a pair for each point
    """
    points = np.bincount(source, minlength=count).astype(float)
    share = 1.0 / points[source]
    return sparse.csr_array(sparse.coo_array((share, (source, image)), shape=(count, count)))


def closed_classes(matrix: sparse.csr_array) -> Integers:
    """Number of the closed class in which each cell lies, -1 where it is left for good.

    A class is closed where no point of it leaves it; a cell without points is in none.
    """
    count, number = connected_components(matrix, directed=True, connection="strong")
    rows, columns = matrix.nonzero()
    leaves = np.zeros(count, bool)
    leaves[number[rows[number[rows] != number[columns]]]] = True
    leaves[number[np.diff(matrix.indptr) == 0]] = True
    kept = np.cumsum(~leaves) - 1
    return np.where(leaves[number], -1, kept[number]).astype(np.int64)


def end_shares(matrix: sparse.csr_array, ends: Floats) -> Floats:
    """Probability of each end for every cell.

    ``ends`` (N, E) has it for the cells of closed classes, and zero elsewhere: (I - Q) X = R with Q
    the chain among the other cells. What goes nowhere is missing from the sum.
    """
    passing = np.flatnonzero(ends.sum(axis=1) == 0.0)
    shares = ends.copy()
    if passing.size:
        rows = matrix[passing]
        inner = sparse.eye_array(passing.size) - rows[:, passing]
        shares[passing] = splu(sparse.csc_array(inner)).solve(rows @ ends)
    return shares
