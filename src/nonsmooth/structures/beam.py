r"""`Beam` and `Disc`: the parts of a shaft, as matrices over the coordinates of their nodes.

Axes: the shaft lies along z and turns from x to y. In one plane a beam has the displacement and the
slope of each of its two ends. In the plane of x the slope is ``ry``, in that of y it is ``-rx``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import ModelError
from nonsmooth.real_numbers import finite_real, whole_number

__all__ = ["Beam", "Disc"]

Array = npt.NDArray[np.float64]

_STEEL = 2.1e11, 7850.0, 0.3  # Young's modulus, density, Poisson's ratio
_PLANES = np.array([[0, 3, 4, 7], [1, 2, 5, 6]])  # of x, y, rx, ry of both ends
_SIGNS = np.array([[1.0, 1.0, 1.0, 1.0], [1.0, -1.0, 1.0, -1.0]])


@dataclass(frozen=True)
class Beam:
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
    youngs_modulus: float = _STEEL[0]
    density: float = _STEEL[1]
    poissons_ratio: float = _STEEL[2]
    shear: bool = True
    rotary_inertia: bool = True

    def __post_init__(self) -> None:
        for name in ("length", "diameter", "youngs_modulus", "density"):
            _set_positive(self, name)
        bore = _bore("Beam", self.inner_diameter, self.diameter)
        ratio = finite_real("Beam: poissons_ratio", self.poissons_ratio, ModelError)
        if not -1.0 < ratio <= 0.5:
            raise ModelError(f"Beam: poissons_ratio = {ratio:g} must lie between -1 and 0.5")
        object.__setattr__(self, "inner_diameter", bore)
        object.__setattr__(self, "poissons_ratio", ratio)
        for name in ("shear", "rotary_inertia"):
            if not isinstance(getattr(self, name), bool):
                raise ModelError(f"Beam: {name} = {getattr(self, name)!r:.60}: give True or False")

    @property
    def area(self) -> float:
        """Area of the section in m^2."""
        return math.pi / 4.0 * (self.diameter**2 - self.inner_diameter**2)

    @property
    def second_moment(self) -> float:
        """Second moment of area about a diameter, in m^4."""
        return math.pi / 64.0 * (self.diameter**4 - self.inner_diameter**4)

    @property
    def mass(self) -> float:
        """Mass in kg."""
        return self.density * self.area * self.length

    @property
    def shear_ratio(self) -> float:
        """Twelve times the bending over the shear stiffness and the length squared."""
        if not self.shear:
            return 0.0
        nu, m = self.poissons_ratio, (self.inner_diameter / self.diameter) ** 2
        whole = (1.0 + m) ** 2
        coefficient = 6.0 * (1.0 + nu) * whole / ((7 + 6 * nu) * whole + (20 + 12 * nu) * m)
        shear_stiffness = coefficient * self.youngs_modulus / (2.0 * (1.0 + nu)) * self.area
        bending = self.youngs_modulus * self.second_moment
        return 12.0 * bending / (shear_stiffness * self.length**2)

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
        return _in_both_planes(moving + self._tilting())

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
        between = 2.0 * self._tilting()  # the polar moment of a section is twice the other
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
        p, length = self.shear_ratio, self.length
        k1, k2 = 12.0, 6.0 * length
        k3, k4 = (4.0 + p) * length**2, (2.0 - p) * length**2
        bent = np.array(
            [[k1, k2, -k1, k2], [k2, k3, -k2, k4], [-k1, -k2, k1, -k2], [k2, k4, -k2, k3]]
        )
        bent *= self.youngs_modulus * self.second_moment / (length**3 * (1.0 + p))
        return _in_both_planes(bent)

    def _tilting(self) -> Array:
        """Rotary inertia of the sections in one plane."""
        if not self.rotary_inertia:
            return np.zeros((4, 4))
        p, length = self.shear_ratio, self.length
        r1, r2 = 36.0, (3.0 - 15.0 * p) * length
        r3 = (4.0 + 5.0 * p + 10.0 * p**2) * length**2
        r4 = (-1.0 - 5.0 * p + 5.0 * p**2) * length**2
        tilting = np.array(
            [[r1, r2, -r1, r2], [r2, r3, -r2, r4], [-r1, -r2, r1, -r2], [r2, r4, -r2, r3]]
        )
        return tilting * (self.density * self.second_moment / (30.0 * length * (1.0 + p) ** 2))


def _in_both_planes(matrix: Array) -> Array:
    whole = np.zeros((8, 8))
    for at, signs in zip(_PLANES, _SIGNS, strict=True):
        whole[np.ix_(at, at)] = matrix * np.outer(signs, signs)
    return whole


def _set_positive(thing: object, name: str) -> None:
    value = _positive(f"{type(thing).__name__}: {name}", getattr(thing, name))
    object.__setattr__(thing, name, value)


def _positive(where: str, given: object) -> float:
    value = finite_real(where, given, ModelError)
    if not value > 0.0:
        raise ModelError(f"{where} = {value:g} must be positive")
    return value


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
        _set_positive(self, "mass")
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
        density: float = _STEEL[1],
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
            _positive(f"Disc: {name}", size)
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
