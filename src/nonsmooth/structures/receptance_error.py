"""How far the receptance of a reduced model is from that of the full one, over the frequency."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["RESOLUTION", "frequencies_between", "full_receptance", "reduced_receptance",
           "relative_error"]  # fmt: skip

Floats = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]
Matrices = tuple[Any, Any, Any]
"""Mass, damping and stiffness at one speed."""

RESOLUTION = 0.01
"""Real over imaginary part of the frequency at which receptances are compared.

It is what a damping ratio of one per cent does, and keeps an undamped resonance finite."""
_POINTS = 160


def frequencies_between(lowest: float, highest: float, natural: Floats) -> Floats:
    """Frequencies of a band, more of them beside natural frequencies."""
    even = np.linspace(lowest, highest, _POINTS)
    inside = natural[(natural >= lowest) & (natural <= highest)]
    near = np.concatenate([inside * (1.0 + shift) for shift in (-RESOLUTION, 0.0, RESOLUTION)])
    both = np.unique(np.concatenate([even, near]))
    return both[(both >= lowest) & (both <= highest)]


def full_receptance(matrices: Matrices, frequencies: Floats, at: npt.NDArray[np.intp]) -> Complex:
    """Displacements of some coordinates by unit forces on each of them, by the frequency."""
    mass, damping, stiffness = matrices
    solve = _sparse_solver if _is_sparse(matrices) else _dense_solver
    forces = np.zeros((mass.shape[0], len(at)), dtype=complex)
    forces[at, np.arange(len(at))] = 1.0
    found = np.empty((len(frequencies), len(at), len(at)), dtype=complex)
    for i, s in enumerate((1j + RESOLUTION) * frequencies):
        found[i] = solve(s**2 * mass + s * damping + stiffness)(forces)[at]
    return found


def reduced_receptance(matrices: Matrices, frequencies: Floats, rows: Floats) -> Complex:
    """The same of a reduced model; rows of its basis stand for coordinates."""
    mass, damping, stiffness = matrices
    s = ((1j + RESOLUTION) * frequencies)[:, None, None]
    return np.asarray(rows @ np.linalg.solve(s**2 * mass + s * damping + stiffness, rows.T))


def relative_error(full: Complex, reduced: Complex, outputs: int) -> Floats:
    """Size of the difference over that of the receptance, by the frequency.

    The first ``outputs`` rows count. Coordinates may have units that differ, so each is measured
    by the root mean square of its own receptance over the band.
    """
    own = np.sqrt(np.mean(np.abs(np.diagonal(full, axis1=1, axis2=2)) ** 2, axis=0))
    scale = np.sqrt(np.outer(own, own))[:outputs]
    size = np.linalg.norm(full[:, :outputs] / scale, axis=(1, 2))
    difference = (reduced - full)[:, :outputs] / scale
    return np.asarray(np.linalg.norm(difference, axis=(1, 2)) / size)


def _is_sparse(matrices: Matrices) -> bool:
    return any(hasattr(matrix, "tocsc") for matrix in matrices)


def _dense_solver(matrix: Any) -> Callable[[Complex], Complex]:
    return lambda right: np.asarray(np.linalg.solve(matrix, right))


def _sparse_solver(matrix: Any) -> Callable[[Complex], Complex]:
    from scipy.sparse.linalg import splu

    solve: Callable[[Complex], Complex] = splu(matrix.tocsc()).solve
    return solve
