r"""Elements of beams in one plane and in torsion, which sections of any shape have in common.

In one plane an element has the displacement and the slope of each of its two ends, in torsion the
angles of these.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, quote
from nonsmooth.real_numbers import finite_real

__all__ = [
    "STEEL",
    "BendingElement",
    "PrismaticBeam",
    "TorsionElement",
    "positive",
    "set_positive",
]

Array = npt.NDArray[np.float64]

STEEL = 2.1e11, 7850.0, 0.3  # Young's modulus, density, Poisson's ratio


@dataclass(frozen=True)
class BendingElement:
    """A beam by Timoshenko's theory, as matrices over displacement and slope of both ends."""

    length: float
    mass: float
    stiffness: float
    """Young's modulus times second moment of area."""
    rotary_inertia: float
    """Of the sections, per length."""
    shear_ratio: float
    """Twelve times the bending over the shear stiffness and the length squared."""

    def mass_matrix(self) -> Array:
        """Mass, that of the tilting sections included."""
        p, length = self.shear_ratio, self.length
        m1 = 156.0 + 294.0 * p + 140.0 * p**2
        m2 = (22.0 + 38.5 * p + 17.5 * p**2) * length
        m3 = 54.0 + 126.0 * p + 70.0 * p**2
        m4 = -(13.0 + 31.5 * p + 17.5 * p**2) * length
        m5 = (4.0 + 7.0 * p + 3.5 * p**2) * length**2
        m6 = -(3.0 + 7.0 * p + 3.5 * p**2) * length**2
        moving = np.array(
            [[m1, m2, m3, m4], [m2, m5, -m4, m6], [m3, -m4, m1, -m2], [m4, m6, -m2, m5]]
        )
        moving *= self.mass / (420.0 * (1.0 + p) ** 2)
        return moving + self.tilting_matrix()

    def tilting_matrix(self) -> Array:
        """Rotary inertia of the sections."""
        p, length = self.shear_ratio, self.length
        r1, r2 = 36.0, (3.0 - 15.0 * p) * length
        r3 = (4.0 + 5.0 * p + 10.0 * p**2) * length**2
        r4 = (-1.0 - 5.0 * p + 5.0 * p**2) * length**2
        tilting = np.array(
            [[r1, r2, -r1, r2], [r2, r3, -r2, r4], [-r1, -r2, r1, -r2], [r2, r4, -r2, r3]]
        )
        return tilting * (self.rotary_inertia / (30.0 * length * (1.0 + p) ** 2))

    def stiffness_matrix(self) -> Array:
        """Stiffness against bending and shear."""
        p, length = self.shear_ratio, self.length
        k1, k2 = 12.0, 6.0 * length
        k3, k4 = (4.0 + p) * length**2, (2.0 - p) * length**2
        bent = np.array(
            [[k1, k2, -k1, k2], [k2, k3, -k2, k4], [-k1, -k2, k1, -k2], [k2, k4, -k2, k3]]
        )
        return bent * (self.stiffness / (length**3 * (1.0 + p)))


@dataclass(frozen=True)
class TorsionElement:
    """A beam in torsion, as matrices over the angles of both ends; the twist is constant in it."""

    length: float
    inertia: float
    """Polar moment of inertia per length."""
    stiffness: float
    """Torque per twist."""

    def mass_matrix(self) -> Array:
        """Polar inertia."""
        return np.array([[2.0, 1.0], [1.0, 2.0]]) * (self.inertia * self.length / 6.0)

    def stiffness_matrix(self) -> Array:
        """Stiffness against torsion."""
        return np.array([[1.0, -1.0], [-1.0, 1.0]]) * (self.stiffness / self.length)


def positive(where: str, given: object) -> float:
    """A number above zero."""
    value = finite_real(where, given, ModelError)
    if not value > 0.0:
        raise ModelError(f"{where} = {value:g} must be positive")
    return value


def set_positive(thing: object, name: str) -> None:
    """Check a number of a frozen value, and keep it as a float."""
    value = positive(f"{type(thing).__name__}: {name}", getattr(thing, name))
    object.__setattr__(thing, name, value)


class PrismaticBeam(ABC):
    """A beam with one section along its length, whose fields a dataclass has."""

    length: float
    youngs_modulus: float
    density: float
    poissons_ratio: float
    shear: bool
    rotary_inertia: bool

    @property
    @abstractmethod
    def area(self) -> float:
        """Area of the section in m^2."""

    @property
    @abstractmethod
    def second_moment(self) -> float:
        """Second moment of area about the axis of bending, in m^4."""

    @property
    @abstractmethod
    def _shear_coefficient(self) -> float:
        """Part of the area that carries shear."""

    @property
    def mass(self) -> float:
        """Mass in kg."""
        return self.density * self.area * self.length

    @property
    def shear_ratio(self) -> float:
        """Twelve times the bending over the shear stiffness and the length squared."""
        if not self.shear:
            return 0.0
        sheared = self._shear_coefficient * self._shear_modulus * self.area
        return 12.0 * self.youngs_modulus * self.second_moment / (sheared * self.length**2)

    @property
    def _shear_modulus(self) -> float:
        return self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio))

    @property
    def _bending(self) -> BendingElement:
        """The element in one plane."""
        return BendingElement(
            self.length,
            self.mass,
            self.youngs_modulus * self.second_moment,
            self.density * self.second_moment if self.rotary_inertia else 0.0,
            self.shear_ratio,
        )

    def _check_material(self) -> None:
        """Check the material, and what the theory counts."""
        kind = type(self).__name__
        for name in ("youngs_modulus", "density"):
            set_positive(self, name)
        ratio = finite_real(f"{kind}: poissons_ratio", self.poissons_ratio, ModelError)
        if not -1.0 < ratio <= 0.5:
            raise ModelError(f"{kind}: poissons_ratio = {ratio:g} must lie between -1 and 0.5")
        object.__setattr__(self, "poissons_ratio", ratio)
        for name in ("shear", "rotary_inertia"):
            if not isinstance(getattr(self, name), bool):
                given = f"{quote(getattr(self, name))}"
                raise ModelError(f"{kind}: {name} = {given}: give True or False")
