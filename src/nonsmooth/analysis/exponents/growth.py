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

__all__ = ["Growth"]

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
        # any directions but the axes, which may belong to invariant subspaces
        self._generator = np.random.default_rng(seed)
        mixed = np.linalg.qr(self._generator.standard_normal((flow.n, flow.n)))[0][:count]
        self._begin(mixed @ flow.first_columns, _rank(flow.first_columns))

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
        rank = 0 if of_mode is None else min(len(tangent.growth), _rank(of_mode))
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

    def _begin(self, columns: Matrix, rank: int) -> None:
        """Put an orthonormal basis of some columns at the anchor; ``rank`` of them are left."""
        left = list(range(len(columns)))
        while True:
            basis, triangle = np.linalg.qr(columns.T)
            diagonal = np.abs(np.diag(triangle))
            if len(left) <= rank and not np.any(diagonal == 0.0):
                break
            lost = int(np.argmin(diagonal))
            self._tangent.growth[left.pop(lost)] = -math.inf
            columns = np.delete(columns, lost, axis=0)
        self.columns[left] = basis.T


def _rank(columns: Matrix) -> int:
    size = np.sqrt((columns * columns).sum(axis=1, keepdims=True))
    values = np.linalg.svd(columns / np.maximum(size, 1.0), compute_uv=False)
    return int(np.count_nonzero(values > _LOSS))
