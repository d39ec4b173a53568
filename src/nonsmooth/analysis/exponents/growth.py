"""How much columns of derivatives grow along a motion.

The engine replaces the columns by an orthonormal basis of what they span before they have turned
towards one direction, and adds up the logarithms of what they are divided by (G. Benettin,
L. Galgani, A. Giorgilli and J.-M. Strelcyn, Meccanica 15, 9-20, 1980); see ``growth.hpp``. A
direction that an event wipes out, as where a state becomes slaved or sticks, is lost for good: its
column is zero and its growth minus infinity. What is lost in a transient may begin anew behind it,
since the motion that follows may never pass such an event again.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import allocate_columns
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.tangent_flow import Saved, TangentFlow

__all__ = ["Growth", "begin_columns"]

_LOSS = 1e-13  # of a singular value, beside one

Matrix = npt.NDArray[np.float64]


@dataclass(frozen=True)
class _Before:
    """What growth is measured from, so that it can be measured again."""

    flow: Saved
    columns: Matrix
    growth: Matrix


class Growth:
    """Logarithms of the growth of some columns along a run, in the order of their directions."""

    def __init__(self, flow: TangentFlow, count: int, seed: int) -> None:
        self.flow = flow
        self.ended: Instant | None = None  # where the run has ended early
        self._tangent = allocate_columns(flow.tables.sizes, count, 0, measures=True)
        self._generator = np.random.default_rng(seed)
        columns, growth = begin_columns(flow.first_columns[None], count, self._generator)
        self.columns[:], self._tangent.growth[:] = columns[0], growth[0]

    @property
    def at_anchor(self) -> Matrix:
        """Growth up to the anchor of the flow."""
        return self._tangent.growth.copy()

    @property
    def columns(self) -> Matrix:
        """Orthonormal columns at the anchor of the flow, zero where they are lost."""
        return self._tangent.columns[:, : self.flow.n]

    @property
    def n_left(self) -> int:
        """Number of columns that are not lost."""
        return int(np.count_nonzero(~np.isneginf(self._tangent.growth)))

    def through(self, ends: Sequence[Instant]) -> tuple[Status, Matrix]:
        """Run on through some instants, in order; the growth up to each that is reached.

        Where the run ends early, the events counted by the flow are those up to the last of them.
        """
        before = _Before(self.flow.save(), self._tangent.columns.copy(), self.at_anchor)
        status, rows = self._run(ends)
        if status != Status.COMPLETED:
            self.ended = self.flow.reached
            self.flow.restore(before.flow)
            self._tangent.columns[:], self._tangent.growth[:] = before.columns, before.growth
            if len(rows):
                self._run(ends[: len(rows)])
        return status, rows

    def renew_lost(self) -> bool:
        """Let lost directions begin anew at the anchor, behind those that are left.

        They begin anywhere in the directions that the mode at the anchor has, with the growth
        zero; where it has no more than are left, as in stick, nothing changes. Returns whether any
        began anew.
        """
        tangent = self._tangent
        left = np.flatnonzero(~np.isneginf(tangent.growth))
        if len(left) == len(tangent.growth):
            return False
        of_mode = self.flow.columns_of_mode()
        rank = 0 if of_mode is None else min(len(tangent.growth), int(_ranks(of_mode)))
        if of_mode is None or rank <= len(left):
            return False
        kept, growth = self.columns[left], tangent.growth[left]
        fresh = self._generator.standard_normal((rank - len(left), self.flow.n)) @ of_mode
        basis = np.linalg.qr(np.concatenate([kept, fresh]).T)[0].T
        tangent.columns[:], tangent.growth[:], tangent.ready[:] = 0.0, -math.inf, 0
        self.columns[:rank] = np.concatenate([kept, basis[len(left) :]])
        tangent.growth[:rank] = np.concatenate([growth, np.zeros(rank - len(left))])
        return True

    def _run(self, ends: Sequence[Instant]) -> tuple[Status, Matrix]:
        shape = len(ends), *self.columns.shape
        tangent = self._tangent.replace(samples=np.empty(shape), growth_samples=np.empty(shape[:2]))
        status, reached = self.flow.run_with(tangent, ends)
        return status, tangent.growth_samples[:reached]


def begin_columns(
    first: Matrix, count: int, generator: np.random.Generator
) -> tuple[Matrix, Matrix]:
    """Orthonormal columns at the starts of K motions, and their growth: zero, or where lost -inf.

    They span what any directions have become there, of which some may be wiped out by then.

    shapes: first (K, n, n) derivatives by the initial states; returns (K, count, n) and (K, count)
    """
    n = first.shape[2]
    # any directions but the axes, which may belong to invariant subspaces
    mixed = np.linalg.qr(generator.standard_normal((n, n)))[0][:count]
    columns, ranks = mixed @ first, _ranks(first)
    growth = np.zeros(columns.shape[:2])
    basis, triangle = np.linalg.qr(columns.transpose(0, 2, 1))
    whole = np.all(np.diagonal(triangle, axis1=1, axis2=2) != 0.0, axis=1) & (count <= ranks)
    for k in np.flatnonzero(~whole).tolist():
        growth[k] = _losses(columns[k], int(ranks[k]))
        left = np.isfinite(growth[k])
        columns[k, left], columns[k, ~left] = np.linalg.qr(columns[k, left].T)[0].T, 0.0
    columns[whole] = basis[whole].transpose(0, 2, 1)
    return columns, growth


def _losses(columns: Matrix, rank: int) -> Matrix:
    """Growth of columns (C, n) of which so many are left: those that add least are lost."""
    growth = np.zeros(len(columns))
    left = list(range(len(columns)))
    while left:
        diagonal = np.abs(np.diag(np.linalg.qr(columns[left].T)[1]))
        if len(left) <= rank and not np.any(diagonal == 0.0):
            break
        growth[left.pop(int(np.argmin(diagonal)))] = -math.inf
    return growth


def _ranks(columns: Matrix) -> npt.NDArray[np.int64]:
    """Rank of each of K sets of columns, (K, C, n)."""
    size = np.sqrt((columns * columns).sum(axis=-1, keepdims=True))
    values = np.linalg.svd(columns / np.maximum(size, 1.0), compute_uv=False)
    return np.asarray(np.count_nonzero(values > _LOSS, axis=-1))
