"""The equations of a fit near a minimum: gaps, and the directions in which they stay closed."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.linalg import lstsq, null_space

from nonsmooth.fitting.shooting import Evaluation, Shooting

__all__ = ["closed_derivatives", "free_jacobian", "gap_matrix", "spent_on"]

Floats = npt.NDArray[np.float64]

_NONE = 1e-13  # singular value of the gaps, as a part of the largest, that is none


def gap_matrix(shooting: Shooting, found: Evaluation) -> Floats:
    """Derivatives of the gaps by all unknowns."""
    h, n = shooting.h, shooting.n
    matrix = np.zeros((found.gap.size, shooting.size))
    for g, (m, next_one) in enumerate(shooting.links):
        rows, own = slice(g * n, (g + 1) * n), h + m * n
        matrix[rows, :h] = found.gap_head[g]
        matrix[rows, own : own + n] = found.gap_state[g]
        following = h + next_one * n
        # taken away from what is there, since a cycle of one segment follows itself
        matrix[rows, following : following + n] -= np.eye(n) / shooting.gap_unit
    return matrix


def data_jacobian(shooting: Shooting, found: Evaluation) -> Floats:
    """Derivatives (N, size) of the data by all unknowns."""
    rows = found.rows
    jacobian = np.zeros((rows.residual.size, shooting.size))
    jacobian[:, : shooting.h] = rows.head
    columns = shooting.h + rows.segment[:, None] * shooting.n + np.arange(shooting.n)
    np.put_along_axis(jacobian, columns, rows.state, axis=1)
    return jacobian


def free_jacobian(shooting: Shooting, found: Evaluation) -> tuple[Floats, Floats]:
    """Derivatives (N, f) of the data in directions that keep gaps closed, and these (size, f)."""
    basis = np.eye(shooting.size)
    if shooting.n_gaps:
        basis = null_space(gap_matrix(shooting, found), rcond=_NONE)
    return data_jacobian(shooting, found) @ basis, basis


def closed_derivatives(
    shooting: Shooting, found: Evaluation, chosen: npt.NDArray[np.int64]
) -> Floats:
    """Derivatives (N, m) of the data by some entries of the head, where the rest closes the gaps.

    Which of many ways the rest does that is all the same: they differ by what a fit can change.
    """
    jacobian = data_jacobian(shooting, found)
    if not shooting.n_gaps:
        return jacobian[:, chosen]
    gaps, rest = gap_matrix(shooting, found), np.setdiff1d(np.arange(shooting.size), chosen)
    follow = lstsq(gaps[:, rest], -gaps[:, chosen], cond=_NONE)[0]
    closed: Floats = jacobian[:, chosen] + jacobian[:, rest] @ follow
    return closed


def spent_on(shooting: Shooting, found: Evaluation) -> Floats:
    """How many unknowns each channel has determined: sums of leverages, (C,).

    A residual is smaller than its noise by the root of one less its leverage.
    """
    free, _ = free_jacobian(shooting, found)
    leverage = (np.linalg.qr(free)[0] ** 2).sum(axis=1)
    spent: Floats = np.bincount(found.rows.channel, leverage, len(shooting.channels)).astype(float)
    return spent
