"""Units of the matrices that are given, and their factors to SI.

A table of some twenty names is enough: a structure has length, mass, force, time and speed, and
the powers in which they enter its matrices are known. A library of units would check no more.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, quote, unknown_name
from nonsmooth.structures.coordinates import is_rotation

__all__ = ["UnitFactors", "factors_of"]

_UNITS = {
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254, "ft": 0.3048},
    "mass": {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": 0.45359237, "slug": 14.593902937206364},
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3, "MN": 1e6, "lbf": 4.4482216152605},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
    "speed": {"rad/s": 1.0, "rpm": math.pi / 30.0, "Hz": 2.0 * math.pi},
}


class UnitFactors(NamedTuple):
    """What numbers in some units are multiplied by to be in SI."""

    mass: float
    damping: float
    gyroscopic: float
    stiffness: float
    levers: npt.NDArray[np.float64]
    """For each coordinate: one of a displacement, the unit of length of an angle.

    An entry over two angles has the unit of one over two displacements times the square of a
    length, and an entry over both has that times the length.
    """
    speed: float
    """Of the speeds in tables of bearings."""


def factors_of(units: Any, names: tuple[str, ...]) -> UnitFactors | None:
    """UnitFactors for matrices over some coordinates; None where numbers are in SI."""
    if units is None:
        return None
    size = _sizes(_named(units))
    stiffness = size["force"] / size["length"]
    levers = np.array([size["length"] if is_rotation(name) else 1.0 for name in names])
    mass = size["mass"]
    return UnitFactors(mass, stiffness * size["time"], mass, stiffness, levers, size["speed"])


def _named(units: Any) -> dict[str, str]:
    """Name of the unit of each quantity that was given one."""
    if isinstance(units, Mapping):
        pairs = list(units.items())
    else:
        texts = units.replace(",", " ").split() if isinstance(units, str) else units
        if not isinstance(texts, Iterable):
            raise ModelError(f"units = {quote(units)}: give names such as 'mm, N, kg, s'")
        pairs = [(_quantity(text), text) for text in texts]
    if not pairs:
        raise ModelError("units: there is none; leave units= out where numbers are in SI")
    found: dict[str, str] = {}
    for quantity, name in pairs:
        if quantity not in _UNITS:
            raise ModelError(f"units: {unknown_name('quantity', quantity, _UNITS)}")
        if name not in _UNITS[quantity]:
            raise ModelError(
                f"units: {unknown_name(f'unit of {quantity}', name, _UNITS[quantity])}"
            )
        if quantity in found:
            raise ModelError(f"units: {quantity} is both {found[quantity]} and {name}; give one")
        found[quantity] = name
    return found


def _quantity(name: Any) -> str:
    for quantity, known in _UNITS.items():
        if isinstance(name, str) and name in known:
            return quantity
    every = [each for known in _UNITS.values() for each in known]
    raise ModelError(f"units: {unknown_name('unit', name, every)}")


def _sizes(named: dict[str, str]) -> dict[str, float]:
    """Sizes in SI; of mass and force one follows from the other where it is not given."""
    size = {quantity: _UNITS[quantity][name] for quantity, name in named.items()}
    length, seconds = size.setdefault("length", 1.0), size.setdefault("time", 1.0)
    per_mass = length / seconds**2
    if "mass" not in size and "force" not in size:
        if per_mass != 1.0:
            raise ModelError(
                "units: give that of mass or of force, such as 'kg' or 'N'; length and time leave"
                " them open"
            )
        size["mass"] = 1.0
    size.setdefault("force", size.get("mass", 1.0) * per_mass)
    size.setdefault("mass", size["force"] / per_mass)
    size.setdefault("speed", 1.0)
    return size
