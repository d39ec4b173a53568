"""Bases of reduced models: natural modes, and static shapes that complete them.

All bases are real and do not depend on the speed, so that matrices which do are projected once.
Each has unit masses and diagonal stiffness: in sums of large numbers that cancel, as other forms
have them, the slow motions of a fine mesh would lose their digits.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError
from nonsmooth.leading_entry import leading_entry
from nonsmooth.structures.matrices import check_definite, dense, is_sparse

__all__ = ["Bases", "CraigBampton", "FreeInterface", "NaturalModes"]

Floats = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]
_DENSE = 800  # coordinates up to which a dense solver finds all modes at once
_NOTHING = 1e-20  # of the inertia of a deflection: what modes leave of it by rounding
_ROUNDING = 1e-14  # of the largest eigenvalue, times the size: what is below may be zero


class NaturalModes:
    """Natural modes of a symmetric stiffness and mass matrix, found as more of them are wanted."""

    def __init__(self, stiffness: Any, mass: Any) -> None:
        check_definite(mass)
        self._stiffness, self._mass = stiffness, mass
        self.size = int(mass.shape[0])
        self._squares = np.empty(0)
        self._shapes = np.empty((self.size, 0))

    def first(self, count: int) -> tuple[Floats, Floats]:
        """Squares of the lowest natural frequencies, and shapes of unit modal mass."""
        count = min(count, self.size)
        if count > self._squares.size:
            few = self.size <= _DENSE or 2 * count > self.size
            squares, shapes = self._all() if few else self._lowest(count)
            largest = leading_entry(shapes)
            self._shapes = shapes * np.sign(shapes[largest, np.arange(squares.size)])
            self._squares = np.maximum(squares, 0.0)
        return self._squares[:count], self._shapes[:, :count]

    def up_to(self, frequency: float) -> int:
        """How many natural frequencies lie below a frequency."""
        count = min(16, self.size)
        while count and self.first(count)[0][-1] < frequency**2 and count < self.size:
            count = min(2 * count, self.size)
        return int(np.count_nonzero(self.first(count)[0] < frequency**2))

    def _all(self) -> tuple[Floats, Floats]:
        """All modes: by the inverse problem, whose largest eigenvalues are the slow modes."""
        from scipy.linalg import eigh

        stiffness, mass = dense(self._stiffness), dense(self._mass)
        squares = eigh(stiffness, mass, eigvals_only=True)
        nothing = _ROUNDING * self.size * abs(squares[-1])
        if squares[0] < -nothing:
            raise ModelError(
                "stiffness: the structure buckles: the square of its lowest frequency is"
                f" {squares[0]:.3g} (rad/s)^2; what pushes, such as a seal, can be a Bearing, which"
                " is no part of the basis"
            )
        rigid = squares <= nothing
        shift = float(squares[~rigid][0]) if rigid.any() and not rigid.all() else 0.0
        if rigid.all():
            shift = 1.0
        inverses, shapes = eigh(mass, stiffness + shift * mass)
        inverses, shapes = inverses[::-1], shapes[:, ::-1]
        squares = 1.0 / inverses - shift
        squares[rigid] = 0.0
        return squares, shapes / np.sqrt(inverses)

    def _lowest(self, count: int) -> tuple[Floats, Floats]:
        """Modes nearest to a frequency a little below zero, where the pencil has an inverse."""
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import eigsh

        stiffness, mass = csc_array(self._stiffness), csc_array(self._mass)
        shift = -1e-10 * float(stiffness.diagonal().sum() / mass.diagonal().sum())
        start = np.ones(self.size)  # so that the digits are the same each time
        squares, shapes = eigsh(stiffness, count, mass, sigma=shift, v0=start)
        order = np.argsort(squares)
        return squares[order], shapes[:, order]


class Bases(Protocol):
    """Bases of one kind with more and more modes."""

    modes: NaturalModes

    def basis(self, count: int) -> tuple[Floats, Floats]:
        """Basis with a number of modes beside the static shapes, and its diagonal stiffness."""


class FreeInterface:
    """Natural modes of the whole structure, and residual attachment modes of an interface.

    The latter are the deflections under unit forces less what the modes hold of them. They have
    neither mass nor stiffness in common with the modes.
    """

    def __init__(self, stiffness: Any, mass: Any, interface: Places) -> None:
        self._mass = mass
        self.modes = NaturalModes(stiffness, mass)
        forces = np.zeros((self.modes.size, len(interface)))
        forces[interface, np.arange(len(interface))] = 1.0
        self._forces = forces
        squares = self.modes.first(16)[0]
        free = squares <= 1e-9 * squares[-1]
        self._shift = 0.0
        if free.any():  # what moves freely has its inertia in place of a support
            self._shift = 0.1 * float(squares[~free][0]) if not free.all() else 1.0
        self._deflections = _solved(stiffness + self._shift * mass, forces)

    def basis(self, count: int) -> tuple[Floats, Floats]:
        """Basis with a number of modes beside the static shapes, and its diagonal stiffness."""
        squares, shapes = self.modes.first(count)
        if squares.size == self.modes.size:
            return shapes, squares
        residual = self._deflections
        for _ in range(2):  # once more takes what rounding has left
            residual = residual - shapes @ (shapes.T @ (self._mass @ residual))
        whole = self._deflections.T @ (self._mass @ self._deflections)
        inertia = residual.T @ (self._mass @ residual)
        real = np.diag(inertia) > _NOTHING * np.diag(whole)
        residual, inertia = residual[:, real], inertia[np.ix_(real, real)]
        # (K + shift M) residual is what the modes leave of the forces
        stiff = residual.T @ self._forces[:, real] - self._shift * inertia
        more, more_squares = _modal(residual, inertia, stiff)
        return np.hstack([shapes, more]), np.concatenate([squares, more_squares])


class CraigBampton:
    """Constraint modes of an interface, and natural modes with the interface held."""

    def __init__(self, stiffness: Any, mass: Any, interface: Places) -> None:
        self._stiffness, self._mass, self._interface = stiffness, mass, interface
        self._inside = np.setdiff1d(np.arange(mass.shape[0]), interface)
        inside = np.ix_(self._inside, self._inside)
        self.modes = NaturalModes(_part(stiffness, inside), _part(mass, inside))
        across = dense(_part(stiffness, np.ix_(self._inside, interface)))
        self._shapes = -_solved(_part(stiffness, inside), across)
        between = dense(_part(stiffness, np.ix_(interface, interface)))
        self._condensed = between + across.T @ self._shapes

    def basis(self, count: int) -> tuple[Floats, Floats]:
        """Basis with a number of modes beside the static shapes, and its diagonal stiffness."""
        squares, fixed = self.modes.first(count)
        k = len(self._interface)
        basis = np.zeros((self._mass.shape[0], k + squares.size))
        basis[self._interface, :k] = np.eye(k)
        basis[self._inside, :k] = self._shapes
        basis[self._inside, k:] = fixed
        stiff = np.zeros((k + squares.size,) * 2)
        stiff[:k, :k] = 0.5 * (self._condensed + self._condensed.T)
        stiff[k:, k:] = np.diag(squares)
        return _modal(basis, basis.T @ (self._mass @ basis), stiff)


def _modal(shapes: Floats, inertia: Floats, stiffness: Floats) -> tuple[Floats, Floats]:
    """Combinations of shapes with unit masses and diagonal stiffness, slow ones first.

    Shapes that others make up already, but for rounding, are left out.
    """
    from scipy.linalg import eigh

    lengths = np.sqrt(np.diag(inertia))
    scale = np.where(lengths > 0.0, lengths, 1.0)
    values, vectors = eigh(0.5 * (inertia + inertia.T) / np.outer(scale, scale))
    kept = values > 1e-11 * max(float(values[-1]), 0.0)
    turn = (vectors[:, kept] / np.sqrt(values[kept])) / scale[:, None]
    stiff = turn.T @ stiffness @ turn
    squares, more = eigh(0.5 * (stiff + stiff.T))
    return shapes @ (turn @ more), np.maximum(squares, 0.0)


def _solved(matrix: Any, right: Floats) -> Floats:
    """Solution of a static problem."""
    if is_sparse(matrix):
        from scipy.sparse.linalg import splu

        try:
            solved = splu(matrix.tocsc()).solve(right)
        except RuntimeError:
            solved = np.full(right.shape, np.nan)
    else:
        try:
            solved = np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:
            solved = np.full(right.shape, np.nan)
    if right.size and not np.abs(matrix @ solved - right).max() <= 1e-3 * np.abs(right).max():
        raise ModelError(
            "stiffness: with the kept coordinates and those of the bearings held, a part of the"
            " structure may still move freely; keep a coordinate of that part too, or take"
            " method='free-interface'"
        )
    return np.asarray(solved, dtype=float)


def _part(matrix: Any, places: Any) -> Any:
    if is_sparse(matrix):
        rows, columns = places
        return matrix.tocsr()[rows.ravel()][:, columns.ravel()].tocsc()
    return matrix[places]
