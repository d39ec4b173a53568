"""A reduced model in the coordinates that a machine has as states.

Natural modes are best: their stiffness is diagonal. A coordinate at which velocities jump or stick
is a state by itself, so that what happens there changes that state alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError
from nonsmooth.leading_entry import leading_entry
from nonsmooth.structures.state_names import state_name
from nonsmooth.structures.structure import Structure

__all__ = ["GeneralizedForm", "generalized_form"]

Floats = npt.NDArray[np.float64]


class ReducedModel(Protocol):
    """What a `ReducedStructure` is made of."""

    @property
    def structure(self) -> Structure: ...

    @property
    def basis(self) -> Floats: ...

    @property
    def squares(self) -> Floats: ...


@dataclass(frozen=True, eq=False)
class GeneralizedForm:
    """Matrices of a reduced model, and the displacements of the full one by its coordinates.

    The first coordinates are ``states`` of the structure. Bearings are in the stiffness as far as
    they are in that of the natural modes.
    """

    states: tuple[str, ...]
    coordinates: tuple[str, ...]
    basis: Floats
    mass: Floats
    stiffness: Floats
    damping: Floats
    gyroscopic: Floats


def generalized_form(model: ReducedModel, states: tuple[str, ...]) -> GeneralizedForm:
    """The form with some coordinates of the structure as states.

    Their shapes V have no inertia in common with the modes N that are left: with the rows B of
    the coordinates in the basis of unit masses, V = B' (B B')^-1 and B N = 0. So a force at one of
    these coordinates accelerates them alone.
    """
    structure = model.structure
    squares = model.squares
    turn, k = np.eye(squares.size), len(states)
    if states:
        from scipy.linalg import eigh, qr

        rows = model.basis[[structure.index(name) for name in states]]
        if np.linalg.matrix_rank(rows) < k:
            raise OptionError(
                f"modes: the reduced model cannot move {', '.join(states)} one by one; take more"
                " modes, or keep these coordinates"
            )
        shapes = np.linalg.solve(rows @ rows.T, rows).T
        held = qr(rows.T)[0][:, k:]
        modes = held @ eigh(held.T @ (squares[:, None] * held))[1]
        largest = leading_entry(modes)
        turn = np.hstack([shapes, modes * np.sign(modes[largest, np.arange(modes.shape[1])])])
    basis = model.basis @ turn
    if states:
        basis[[structure.index(name) for name in states]] = np.eye(k, squares.size)
    mass, stiffness = turn.T @ turn, turn.T @ (squares[:, None] * turn)
    mass[:k, k:] = mass[k:, :k] = 0.0
    mass[k:, k:] = np.eye(squares.size - k)
    size = np.sqrt(np.abs(np.diag(stiffness)))
    stiffness[np.abs(stiffness) <= 1e-15 * squares.size * np.outer(size, size)] = 0.0
    if not states:
        stiffness = np.diag(squares)
    skew = structure.stiffness - structure.stiffness.T
    if abs(skew).max() > 0.0:
        stiffness = stiffness + 0.5 * _projected(skew, basis)
    names = (*(state_name(name) for name in states),
             *(f"eta{i + 1}" for i in range(squares.size - k)))  # fmt: skip
    return GeneralizedForm(
        states,
        names,
        basis,
        mass,
        stiffness,
        _projected(structure.damping, basis),
        _projected(structure.gyroscopic, basis),
    )


def _projected(matrix: Any, basis: Floats) -> Floats:
    """B' M B with zeros where nothing but rounding is left of the sum."""
    found = np.array(basis.T @ (matrix @ basis))
    terms = np.abs(basis).T @ (abs(matrix) @ np.abs(basis))
    dust = np.abs(found) <= 1e-15 * terms
    np.fill_diagonal(dust, val=False)
    found[dust] = 0.0
    return found
