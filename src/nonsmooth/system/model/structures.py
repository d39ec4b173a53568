"""Systems from mass, damping and stiffness: M x'' + C x' + K x = f as x' = A x + b.

Equations are solved for the accelerations in doubles. Forces stay texts, each times the numbers by
which it accelerates the degrees of freedom.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError
from nonsmooth.system.model.matrices import by_mode, mode_names, numbers, offsets, square

__all__ = ["first_order"]

Floats = npt.NDArray[np.float64]
_WORST = 1e14  # condition of a mass matrix from which its inverse has no digit left


def first_order(
    mass: Any, damping: Any, stiffness: Any, force: Any, exits: Any
) -> tuple[Any, Any, int]:
    """Matrix and offset of the states (positions, velocities), and how many positions there are.

    Both are mappings of modes where one of the arguments is a mapping.
    """
    if mass is None or stiffness is None:
        missing = "mass" if mass is None else "stiffness"
        raise ModelError(
            f"{missing}: give mass= and stiffness= together, for M x'' + C x' + K x = f; damping="
            " and force= are zero where they are not given"
        )
    force = tuple(force) if isinstance(force, Iterator) else force
    given = {"mass": mass, "stiffness": stiffness, "damping": damping, "force": force}
    modes = mode_names(**given, exits=exits)
    in_modes = {key: by_mode(key, value, modes) for key, value in given.items()}
    n = _count(in_modes["mass"])
    matrix, offset = {}, {}
    for mode in modes:
        parts = {key: found.get(mode, ("", None)) for key, found in in_modes.items()}
        matrix[mode], offset[mode] = _of_mode(parts, mode, n)
    if not any(isinstance(value, Mapping) for value in given.values()):
        return matrix[modes[0]], offset[modes[0]], n
    return matrix, offset, n


def _count(masses: Mapping[str, tuple[str, Any]]) -> int:
    """Number of degrees of freedom."""
    where, value = next(iter(masses.values()))
    return len(square(value, where))


def _of_mode(parts: Mapping[str, tuple[str, Any]], mode: str, n: int) -> tuple[Floats, list[Any]]:
    """Matrix and offset of one mode."""
    names = tuple(f"x{i + 1}" for i in range(n))
    arrays = {}
    for key in ("mass", "stiffness", "damping"):
        where, value = parts[key]
        if value is None and key == "damping":
            arrays[key] = np.zeros((n, n))
            continue
        if value is None:
            raise ModelError(f"{key}: the mode {mode!r} has none; give one for each mode")
        entries = square(value, where)
        if len(entries) != n:
            raise ModelError(
                f"{where} is {len(entries)} x {len(entries)} and mass is {n} x {n}; both have a"
                " row for each degree of freedom"
            )
        arrays[key] = np.array(numbers(entries, where, names))
    where, given = parts["force"]
    forces = offsets(given, where, names, "degree of freedom") or [0.0] * n
    forward = np.hstack([-arrays["stiffness"], -arrays["damping"], np.eye(n)])
    below = _over_mass(arrays["mass"], forward, parts["mass"][0])
    top = np.hstack([np.zeros((n, n)), np.eye(n)])
    accelerations = [_accelerated(row, forces) for row in below[:, 2 * n :]]
    return np.vstack([top, below[:, : 2 * n]]), [0.0] * n + accelerations


def _over_mass(mass: Floats, right: Floats, where: str) -> Floats:
    """The inverse of M times what stands on the right; quotients where M is diagonal."""
    diagonal = np.diag(mass)
    if np.array_equal(mass, np.diag(diagonal)) and np.all(diagonal != 0.0):
        found: Floats = right / diagonal[:, np.newaxis]
        return found
    with np.errstate(all="ignore"):
        condition = float(np.linalg.cond(mass))
    if not condition < _WORST:
        raise ModelError(
            f"{where} has no inverse, so some degree of freedom has no acceleration; leave those"
            " without mass out, by static condensation for example"
        )
    solved: Floats = np.asarray(np.linalg.solve(mass, right), dtype=float)
    return solved


def _accelerated(row: Floats, forces: list[float | str]) -> float | str:
    """A row of the inverse of M times the forces, as a number or a text."""
    constant, terms = 0.0, []
    for factor, force in zip(row.tolist(), forces, strict=True):
        if factor == 0.0:
            continue
        if isinstance(force, str):
            terms.append(f"({force})" if factor == 1.0 else f"{factor!r}*({force})")
        else:
            constant += factor * force
    if not terms:
        return constant
    return " + ".join([*terms, *([repr(constant)] if constant else [])])
