"""Likelihood of parameters and noise alone: the states are integrated out.

For given parameters the motion that fits best is found with all segments joined, by the method of
Gauss and Newton with the gaps as equations. Near it the sum of squares is taken as quadratic in the
states, so that the integral over them is that of a normal density (the method of Laplace). It is
exact where the motion is linear in its start. A transient has one free state, that at the first
sample, on which a uniform density stands; a cycle has none.

The matrix of a step is that of the equations of Lagrange, sparse and banded. Its determinant is
that of the second derivatives by the first state, times a constant: the start of a segment stands
in its gap by itself. One factorisation therefore gives the step and the integral.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.sparse import block_array, block_diag, coo_array
from scipy.sparse.linalg import splu

from nonsmooth.errors import OptionError
from nonsmooth.fitting.linearised import gap_matrix
from nonsmooth.fitting.shooting import Evaluation, Shooting

__all__ = ["Marginal"]

Floats = npt.NDArray[np.float64]

_STEPS = 10  # to the best motion
_SETTLED = 0.05  # change of the logarithm of the likelihood by a step that needs no other one


class Marginal:
    """Logarithm of the likelihood of the head and of the noise."""

    def __init__(self, shooting: Shooting, u: Floats, noise: Floats) -> None:
        self.shooting, self.u = shooting, u
        found = shooting.evaluate(u, noise)
        states = None if found is None else _States.of(shooting, found)
        if found is None or states is None:
            raise OptionError(
                "found: its states cannot be computed again, or the record does not determine them"
            )
        h, rows = shooting.h, found.rows
        # how the best states move with the head, and with them the residuals
        self._slopes = states.best(rows.head, states.gaps[:, :h])
        moved = rows.head + states.moved(self._slopes)
        self.information: Floats = moved.T @ moved
        self.counts = np.bincount(rows.channel, minlength=noise.size)
        self.n_lost = 0  # heads for which no motion was found

    def __call__(self, head: Floats, noise: Floats) -> float:
        """Up to a constant; minus infinity where no motion can be computed or none fits."""
        shooting = self.shooting
        h = shooting.h
        low, high = (each[:h] for each in shooting.limits)
        if np.any(head < low) or np.any(head > high):
            return -np.inf
        at = np.concatenate([head, self.u[h:] + self._slopes @ (head - self.u[:h])])
        for _ in range(_STEPS):
            found = shooting.evaluate(at, noise)
            states = None if found is None else _States.of(shooting, found)
            if found is None or states is None:
                break
            residual = found.rows.residual
            step = states.best(residual[:, None], found.gap.reshape(-1, 1))
            left = residual + states.moved(step)[:, 0]
            cost = 0.5 * float(left @ left)
            if abs(cost - 0.5 * float(residual @ residual)) < _SETTLED:
                surplus = found.rows.surplus  # of events that the data do not have
                cost += 0.5 * float(surplus @ surplus)
                return -cost - float(self.counts @ np.log(noise)) - 0.5 * states.determinant
            at[h:] += step[:, 0]
        self.n_lost += 1
        return -np.inf


class _States:
    """Residuals and gaps to first order: which states fit best, and how well they are known."""

    def __init__(self, shooting: Shooting, found: Evaluation) -> None:
        self.rows, self.shape = found.rows, (shooting.n_segments, shooting.n)
        self.gaps = gap_matrix(shooting, found)
        rows, n = found.rows, shooting.n
        squares = np.zeros((shooting.n_segments, n, n))
        np.add.at(squares, rows.segment, rows.state[:, :, None] * rows.state[:, None, :])
        self._parts = []  # of each record: its states, its gaps, the factors, whether it is a cycle
        for r, record in enumerate(shooting.records):
            segments = np.arange(shooting.n_segments)[shooting.segments_in(r)]
            own = (segments[:, None] * n + np.arange(n)).ravel()
            links = np.flatnonzero(np.isin(shooting.links[:, 0], segments))
            gaps = (links[:, None] * n + np.arange(n)).ravel()
            blocks: Any = [[block_diag([coo_array(square) for square in squares[segments]])]]
            if gaps.size:
                closing = self.gaps[np.ix_(gaps, shooting.h + own)]
                blocks = [[blocks[0][0], closing.T], [closing, None]]
            factors = splu(block_array(blocks, format="csc"))
            self._parts.append((own, gaps, factors, record.is_cycle))

    @classmethod
    def of(cls, shooting: Shooting, found: Evaluation) -> _States | None:
        """States that the data determine; None where they do not."""
        try:
            return cls(shooting, found)
        except RuntimeError:  # of a matrix that is exactly singular
            return None

    @property
    def determinant(self) -> float:
        """Logarithm of the determinant of the second derivatives by the first states."""
        free = [factors for _, _, factors, is_cycle in self._parts if not is_cycle]
        return float(sum(np.log(np.abs(each.U.diagonal())).sum() for each in free))

    def best(self, residual: Floats, gap: Floats) -> Floats:
        """States (M n, k) that close the gaps and make k residuals least, all to first order."""
        rows, (count, n) = self.rows, self.shape
        by_segment = np.zeros((count, n, residual.shape[1]))
        np.add.at(by_segment, rows.segment, rows.state[:, :, None] * residual[:, None, :])
        slopes = by_segment.reshape(count * n, -1)
        found = np.empty_like(slopes)
        for own, gaps, factors, _ in self._parts:
            found[own] = factors.solve(-np.concatenate([slopes[own], gap[gaps]]))[: own.size]
        return found

    def moved(self, states: Floats) -> Floats:
        """What k states (M n, k) add to the residuals."""
        own = states.reshape(*self.shape, -1)[self.rows.segment]
        found: Floats = np.einsum("rn,rnk->rk", self.rows.state, own)
        return found
