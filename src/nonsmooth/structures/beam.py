r"""Beams and discs: the parts of a shaft, as matrices over the coordinates of their nodes.

Axes: the shaft lies along z and turns from x to y. In the plane of x the slope is ``ry``, in that
of y it is ``-rx``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import ModelError
from nonsmooth.real_numbers import finite_real, whole_number
from nonsmooth.structures.elements import (
    STEEL,
    PrismaticBeam,
    TorsionElement,
    positive,
    set_positive,
)

__all__ = ["Beam", "Disc", "RectangularBeam"]

Array = npt.NDArray[np.float64]

_PLANES = np.array([[0, 3, 4, 7], [1, 2, 5, 6]])  # of x, y, rx, ry of both ends
_SIGNS = np.array([[1.0, 1.0, 1.0, 1.0], [1.0, -1.0, 1.0, -1.0]])


@dataclass(frozen=True)
class Beam(PrismaticBeam):
    r"""Element of a round shaft, solid or hollow, by Timoshenko's theory.

    Parameters
    ----------
    length : float
        Length in m.
    diameter : float
        Outer diameter in m.
    inner_diameter : float, optional
        Diameter of the bore in m.
    youngs_modulus, density, poissons_ratio : float, optional
        Of the material, in Pa and kg/m^3; steel by default.
    shear : bool, optional
        Whether shear bends the beam too.
    rotary_inertia : bool, optional
        Whether sections resist tilting, which also makes them gyroscopic. Without this and shear
        the beam is that of Euler and Bernoulli.

    Raises
    ------
    ModelError
        When a value is not possible.

    See Also
    --------
    nonsmooth.structures.shaft : a structure of such elements.
    nonsmooth.structures.plane_beam : the same in one plane.
    nonsmooth.structures.torsional_shaft : the same in torsion.
    nonsmooth.structures.RectangularBeam : an element of a beam with a rectangular section.

    Notes
    -----
    The deflection is a cubic and the slope of a section the one that follows from it with a
    constant shear force [1]_; the mass is consistent with them. Cowper's shear coefficient of a
    hollow circle [2]_, with m the ratio of the diameters:

    .. math:: \kappa = \frac{6 (1+\nu) (1+m^2)^2}{(7+6\nu)(1+m^2)^2 + (20+12\nu) m^2}

    Deflections under forces and moments at the nodes are exact. Natural frequencies come from
    above, with an error that falls with the fourth power of the length of the elements; with shear,
    which is constant in an element, with its square.

    References
    ----------
    .. [1] H. D. Nelson, "A finite rotating shaft element using Timoshenko beam theory", Journal of
       Mechanical Design 102 (1980), 793-803.
    .. [2] G. R. Cowper, "The shear coefficient in Timoshenko's beam theory", Journal of Applied
       Mechanics 33 (1966), 335-340.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> beam = ns.structures.Beam(0.25, 0.05)
    >>> round(beam.mass, 3)
    3.853
    """

    length: float
    diameter: float
    inner_diameter: float = 0.0
    youngs_modulus: float = STEEL[0]
    density: float = STEEL[1]
    poissons_ratio: float = STEEL[2]
    shear: bool = True
    rotary_inertia: bool = True

    def __post_init__(self) -> None:
        for name in ("length", "diameter"):
            set_positive(self, name)
        bore = _bore("Beam", self.inner_diameter, self.diameter)
        object.__setattr__(self, "inner_diameter", bore)
        self._check_material()

    @property
    def area(self) -> float:
        """Area of the section in m^2."""
        return math.pi / 4.0 * (self.diameter**2 - self.inner_diameter**2)

    @property
    def second_moment(self) -> float:
        """Second moment of area about a diameter, in m^4."""
        return math.pi / 64.0 * (self.diameter**4 - self.inner_diameter**4)

    @property
    def _shear_coefficient(self) -> float:
        nu, m = self.poissons_ratio, (self.inner_diameter / self.diameter) ** 2
        whole = (1.0 + m) ** 2
        return 6.0 * (1.0 + nu) * whole / ((7 + 6 * nu) * whole + (20 + 12 * nu) * m)

    @property
    def _torsion(self) -> TorsionElement:
        """The element in torsion; the polar moment of a round section is twice the other."""
        polar = 2.0 * self.second_moment
        return TorsionElement(self.length, self.density * polar, self._shear_modulus * polar)

    def mass_matrix(self) -> Array:
        """Mass over x, y, rx, ry of both ends.

        Returns
        -------
        numpy.ndarray
            Eight by eight.

        Examples
        --------
        A beam that moves along x by one weighs what it weighs:

        >>> import numpy as np
        >>> import nonsmooth as ns
        >>> beam = ns.structures.Beam(0.25, 0.05)
        >>> move = np.array([1, 0, 0, 0, 1, 0, 0, 0])
        >>> bool(np.isclose(move @ beam.mass_matrix() @ move, beam.mass, rtol=1e-14))
        True
        """
        return _in_both_planes(self._bending.mass_matrix())

    def gyroscopic_matrix(self) -> Array:
        """Gyroscopic matrix at unit speed over x, y, rx, ry of both ends.

        Returns
        -------
        numpy.ndarray
            Eight by eight, skew-symmetric.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> G = ns.structures.Beam(0.25, 0.05).gyroscopic_matrix()
        >>> bool((G == -G.T).all())
        True
        """
        # the polar moment of a section is twice the other
        between = 2.0 * self._bending.tilting_matrix()
        matrix = np.zeros((8, 8))
        (x, y), (sx, sy) = _PLANES, _SIGNS
        matrix[np.ix_(x, y)] = between * np.outer(sx, sy)
        matrix[np.ix_(y, x)] = -between * np.outer(sy, sx)
        return matrix

    def stiffness_matrix(self) -> Array:
        """Stiffness over x, y, rx, ry of both ends.

        Returns
        -------
        numpy.ndarray
            Eight by eight.

        Examples
        --------
        Between a clamped end and a force at the free one:

        >>> import numpy as np
        >>> import nonsmooth as ns
        >>> beam = ns.structures.Beam(0.25, 0.05, shear=False)
        >>> K = beam.stiffness_matrix()[4:, 4:]
        >>> deflection = np.linalg.solve(K, [1.0, 0, 0, 0])[0]
        >>> bending = beam.youngs_modulus * beam.second_moment
        >>> bool(np.isclose(deflection, 0.25**3 / (3 * bending), rtol=1e-13))
        True
        """
        return _in_both_planes(self._bending.stiffness_matrix())


def _in_both_planes(matrix: Array) -> Array:
    whole = np.zeros((8, 8))
    for at, signs in zip(_PLANES, _SIGNS, strict=True):
        whole[np.ix_(at, at)] = matrix * np.outer(signs, signs)
    return whole


@dataclass(frozen=True)
class RectangularBeam(PrismaticBeam):
    r"""Element of a beam with a rectangular section, by Timoshenko's theory, in one plane.

    Parameters
    ----------
    length : float
        Length in m.
    width : float
        Width of the section in m, across the plane in which the beam bends.
    height : float
        Its height in m, along the deflection.
    youngs_modulus, density, poissons_ratio : float, optional
        Of the material, in Pa and kg/m^3; steel by default.
    shear : bool, optional
        Whether shear bends the beam too.
    rotary_inertia : bool, optional
        Whether sections resist tilting. Without this and shear the beam is that of Euler and
        Bernoulli.

    Raises
    ------
    ModelError
        When a value is not possible.

    See Also
    --------
    nonsmooth.structures.plane_beam : a structure of such elements.
    nonsmooth.structures.Beam : a round element, with the theory of both.

    Notes
    -----
    Cowper's shear coefficient of a rectangle [1]_ does not depend on its sides:

    .. math:: \kappa = \frac{10 (1+\nu)}{12 + 11 \nu}

    References
    ----------
    .. [1] G. R. Cowper, "The shear coefficient in Timoshenko's beam theory", Journal of Applied
       Mechanics 33 (1966), 335-340.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> strip = ns.structures.RectangularBeam(0.3, width=0.02, height=0.002)
    >>> round(strip.mass, 4), round(1e12 * strip.second_moment, 4)
    (0.0942, 13.3333)
    """

    length: float
    width: float
    height: float
    youngs_modulus: float = STEEL[0]
    density: float = STEEL[1]
    poissons_ratio: float = STEEL[2]
    shear: bool = True
    rotary_inertia: bool = True

    def __post_init__(self) -> None:
        for name in ("length", "width", "height"):
            set_positive(self, name)
        self._check_material()

    @property
    def area(self) -> float:
        """Area of the section in m^2."""
        return self.width * self.height

    @property
    def second_moment(self) -> float:
        """Second moment of area about the axis across the plane, in m^4."""
        return self.width * self.height**3 / 12.0

    @property
    def _shear_coefficient(self) -> float:
        nu = self.poissons_ratio
        return 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)


def _bore(kind: str, given: object, diameter: float) -> float:
    bore = finite_real(f"{kind}: inner_diameter", given, ModelError)
    if not 0.0 <= bore < diameter:
        raise ModelError(
            f"{kind}: inner_diameter = {bore:g} must lie between 0 and the diameter {diameter:g}"
        )
    return bore


@dataclass(frozen=True)
class Disc:
    """A rigid disc at a node of a shaft.

    Parameters
    ----------
    node : int
        Where it is, counted from 0.
    mass : float
        Mass in kg.
    diametral_inertia : float
        Moment of inertia about a diameter, in kg m^2.
    polar_inertia : float
        Moment of inertia about the axis of the shaft, in kg m^2; twice the other one if thin.

    Raises
    ------
    ModelError
        When a value is not possible.

    See Also
    --------
    Disc.from_geometry : a disc by its sizes.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.structures.Disc(3, 10.0, 0.05, 0.1).gyroscopic_matrix()[2:, 2:]
    array([[ 0. ,  0.1],
           [-0.1,  0. ]])
    """

    node: int
    mass: float
    diametral_inertia: float
    polar_inertia: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "node", whole_number("Disc: node", self.node, 0))
        set_positive(self, "mass")
        for name in ("diametral_inertia", "polar_inertia"):
            value = finite_real(f"Disc: {name}", getattr(self, name), ModelError)
            if value < 0.0:
                raise ModelError(f"Disc: {name} = {value:g} must not be negative")
            object.__setattr__(self, name, value)
        if self.polar_inertia > 2.0 * self.diametral_inertia * (1.0 + 1e-9):
            raise ModelError(
                f"Disc: polar_inertia = {self.polar_inertia:g} is more than twice the diametral"
                f" one, {self.diametral_inertia:g}, which no body has"
            )

    @classmethod
    @checked
    def from_geometry(
        cls,
        node: int,
        width: float,
        diameter: float,
        inner_diameter: float = 0.0,
        *,
        density: float = STEEL[1],
    ) -> Disc:
        """A disc that is a cylinder.

        Parameters
        ----------
        node : int
            Where it is, counted from 0.
        width : float
            Length along the shaft in m.
        diameter, inner_diameter : float
            Outer diameter, and that of the bore, in m.
        density : float, optional
            In kg/m^3; that of steel by default.

        Returns
        -------
        Disc

        Raises
        ------
        ModelError
            When a size is not possible.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> disc = ns.structures.Disc.from_geometry(3, 0.07, 0.28, 0.05)
        >>> round(disc.mass, 3), round(disc.polar_inertia, 5)
        (32.757, 0.33125)
        """
        for name, size in (("width", width), ("diameter", diameter), ("density", density)):
            positive(f"Disc: {name}", size)
        _bore("Disc", inner_diameter, diameter)
        whole = Beam(width, diameter, inner_diameter, density=density)
        squares = (diameter**2 + inner_diameter**2) / 8.0
        across = whole.mass * (squares / 2.0 + width**2 / 12.0)
        return cls(node, whole.mass, across, whole.mass * squares)

    def mass_matrix(self) -> Array:
        """Mass over x, y, rx, ry of the node.

        Returns
        -------
        numpy.ndarray
            Four by four.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> ns.structures.Disc(3, 10.0, 0.05, 0.1).mass_matrix().diagonal()
        array([10.  , 10.  ,  0.05,  0.05])
        """
        return np.diag([self.mass, self.mass, self.diametral_inertia, self.diametral_inertia])

    def gyroscopic_matrix(self) -> Array:
        """Gyroscopic matrix at unit speed over x, y, rx, ry of the node.

        Returns
        -------
        numpy.ndarray
            Four by four.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> ns.structures.Disc(3, 10.0, 0.05, 0.1).gyroscopic_matrix()[2, 3]
        np.float64(0.1)
        """
        matrix = np.zeros((4, 4))
        matrix[2, 3], matrix[3, 2] = self.polar_inertia, -self.polar_inertia
        return matrix
