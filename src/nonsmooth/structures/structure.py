r"""`Structure`: a linear structure by its matrices, of any size, which may rotate."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable
from dataclasses import InitVar, dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import ModelError, ResultWarning, quote
from nonsmooth.structures.bearing import Bearing
from nonsmooth.structures.coordinates import coordinate_names, place_of, places_of
from nonsmooth.structures.matrices import (
    MATRICES,
    frozen,
    is_sparse,
    placed,
    read_matrices,
    read_structure,
    scaled,
)
from nonsmooth.structures.units import factors_of

__all__ = ["Structure"]

Matrix: TypeAlias = Any
"""An array of numpy, or one of scipy.sparse in columns."""
_SHOWN = 6  # names in the text of a structure
_ROUNDING = 1e-9  # of the largest entry: what assembly of elements leaves in a symmetric matrix


@dataclass(frozen=True, eq=False, repr=False)
class Structure:
    r"""A linear structure of any size, such as a finite-element shaft or frame.

    .. math:: M \ddot q + (C + \Omega G + C_b(\Omega)) \dot q + (K + K_b(\Omega)) q = f

    with the speed :math:`\Omega` of a shaft in rad/s, and :math:`K_b, C_b` those of its bearings.

    Parameters
    ----------
    mass, stiffness : array_like or path
        M and K, square. An array, one of scipy.sparse, which stays sparse, or a file: ``.npy``,
        ``.csv`` (commas, no header), ``.mtx`` (Matrix Market), ``.npz`` of `scipy.sparse.save_npz`.
    damping, gyroscopic : array_like or path, optional
        C, and G at unit speed, which is skew-symmetric; zero by default.
    coordinates : list of str, optional
        Names of the degrees of freedom; ``q0 q1 ...`` by default. A name that consists of a node
        and one of the directions ``x y z rx ry rz``, such as ``3x`` or ``node 3 rx``, tells what
        the coordinate is: `campbell` finds the sense of whirl from x and y of a node, and
        `unbalance_response` takes nodes. A shaft turns from x to y.
    bearings : sequence of Bearing, optional
        What holds the structure beyond ``stiffness``.
    units : str, list or mapping, optional
        Units of all numbers given, bearings included, such as ``"mm, N, kg, s"``, or a mapping of
        ``length``, ``mass``, ``force``, ``time`` and ``speed`` to names. The structure itself is
        in SI. Angles are in radians; a coordinate whose direction begins with ``r`` is one. Of
        mass and force, one may follow from the other.

    Raises
    ------
    ModelError
        When a file cannot be read, shapes do not fit, a number is not finite, M is not symmetric,
        G is not skew-symmetric, or a name is unknown.

    Warns
    -----
    ResultWarning
        When the spline of a bearing gives a direct coefficient a sign that its table has nowhere.

    See Also
    --------
    nonsmooth.structures.shaft : a structure made of beams, discs and bearings.
    nonsmooth.structures.Bearing : stiffness and damping that may depend on the speed.

    Notes
    -----
    If any matrix is sparse, all are. Nothing is copied into dense form but for what needs it, which
    the functions that do so say.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> chain = ns.Structure(np.eye(3), 2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1))
    >>> chain
    Structure(3 coordinates: q0, q1, q2)
    >>> shaft = ns.Structure(
    ...     np.diag([2.0, 2.0]),
    ...     np.zeros((2, 2)),
    ...     coordinates=["1x", "1y"],
    ...     bearings=[ns.structures.Bearing(["1x", "1y"], 50.0, 0.1)],
    ...     units="kg, N, mm, s",
    ... )
    >>> M, C, K = shaft.at_speed(100.0)
    >>> K
    array([[50000.,     0.],
           [    0., 50000.]])
    """

    mass: Matrix
    stiffness: Matrix
    damping: Matrix = field(default=None, kw_only=True)
    gyroscopic: Matrix = field(default=None, kw_only=True)
    coordinates: tuple[str, ...] = field(default=(), kw_only=True)
    bearings: tuple[Bearing, ...] = field(default=(), kw_only=True)
    units: InitVar[Any] = field(default=None, kw_only=True)

    def __post_init__(self, units: Any) -> None:
        matrices = read_matrices({name: getattr(self, name) for name in MATRICES})
        _check_symmetry(matrices)
        names = coordinate_names(self.coordinates, matrices["mass"].shape[0])
        bearings, places = _bearings(self.bearings, names)
        for each in bearings:
            _warn_of_overshoot(each)
        factors = factors_of(units, names)
        if factors is not None:
            matrices = {
                name: scaled(each, getattr(factors, name), factors.levers)
                for name, each in matrices.items()
            }
            arms = [np.outer(factors.levers[rows], factors.levers[rows]) for rows, _ in places]
            bearings = tuple(
                each.scaled(factors.stiffness * arm, factors.damping * arm, factors.speed)
                for each, arm in zip(bearings, arms, strict=True)
            )
        for name, matrix in matrices.items():
            frozen(matrix)
            object.__setattr__(self, name, matrix)
        object.__setattr__(self, "coordinates", names)
        object.__setattr__(self, "bearings", bearings)
        object.__setattr__(self, "_places", places)

    def __repr__(self) -> str:
        listed = ", ".join(self.coordinates[:_SHOWN]) + (", ..." if self.size > _SHOWN else "")
        held = f"; {len(self.bearings)} bearings" if self.bearings else ""
        return f"Structure({self.size} coordinates: {listed}{held})"

    @classmethod
    @checked
    def from_files(
        cls,
        path: str | os.PathLike[str],
        *,
        coordinates: Any = None,
        bearings: Any = (),
        units: Any = None,
    ) -> Structure:
        """Read all matrices from one file, or from one folder.

        Parameters
        ----------
        path : str or path
            File ``.npz`` of `numpy.savez`, or ``.mat`` of MATLAB up to version 7, with arrays
            ``mass`` and ``stiffness``, and if there are any ``damping``, ``gyroscopic`` and the
            names ``coordinates``; ``M K C G`` mean the same. Or a folder with a file of one of
            these names for each matrix, ``.npy``, ``.csv``, ``.mtx`` or sparse ``.npz``.
        coordinates, bearings, units : optional
            As for `Structure`; names in the file are used where none are given.

        Returns
        -------
        Structure

        Raises
        ------
        ModelError
            When a matrix is missing, an array has no meaning, or the matrices do not fit.

        Examples
        --------
        >>> import tempfile
        >>> from pathlib import Path
        >>> import numpy as np
        >>> import nonsmooth as ns
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = Path(folder) / "frame.npz"
        ...     np.savez(file, M=np.eye(2), K=4 * np.eye(2), coordinates=["1x", "2x"])
        ...     frame = ns.Structure.from_files(file)
        >>> frame
        Structure(2 coordinates: 1x, 2x)
        """
        found = read_structure(Path(path))
        named = found.pop("coordinates", None)
        return cls(
            **found,
            coordinates=named if coordinates is None else coordinates,
            bearings=bearings,
            units=units,
        )

    @classmethod
    @checked
    def from_ross(
        cls,
        rotor: Any,
        *,
        coordinates: Literal["lateral", "all"] = "lateral",
        tables: Literal["spline", "monotone", "ross"] = "spline",
    ) -> Structure:
        """Take over a rotor that was described for ROSS, a library of rotor dynamics.

        Parameters
        ----------
        rotor : ross.Rotor
            The rotor.
        coordinates : {"lateral", "all"}, optional
            Whether to leave out axial motion and torsion, which a shaft is free to make.
        tables : {"spline", "monotone", "ross"}, optional
            What goes through the coefficients of bearings that depend on the speed: an
            ``interpolation`` of `Bearing`, through each of them, or the smooth curve of ROSS.

        Returns
        -------
        Structure
            With coordinates ``0x 0y 0z 0rx 0ry 0rz 1x ...`` by node and direction, of which
            ``lateral`` has no z and rz, and the bearings and seals as its bearings.

        Raises
        ------
        ModelError
            When the object is no rotor of ROSS 2 or later, or lateral motion is coupled with the
            rest, as by gears.

        Notes
        -----
        M, C, G and K are those of ROSS without its bearings. The mass of a bearing is added to M.

        ROSS smooths coefficients: the sum of the squares of what its spline is off may be as large
        as the number of speeds, in N/m and N s/m. For dampings of some hundred this is seen, and
        there ``"ross"`` gives what ROSS computes with.

        Needs ``ross-rotordynamics``, which the extra ``ross`` installs.

        References
        ----------
        R. Timbó, R. Martins, G. Bachmann, F. Rangel, J. Mota, J. Valério and T. G. Ritto, "ROSS -
        Rotordynamic Open Source Software", Journal of Open Source Software 5 (2020), 2120.

        Examples
        --------
        ::

            import ross

            structure = ns.Structure.from_ross(ross.rotor_example())
        """
        from nonsmooth.structures.ross import parts_of

        return cls(**parts_of(rotor, coordinates, tables))

    @staticmethod
    def _cure(value: Any) -> str:
        """What to do with a value that a structure can be made of; see `nonsmooth.arguments`."""
        from_ross = type(value).__module__.partition(".")[0] == "ross"
        return ", which Structure.from_ross makes of a rotor of ROSS" if from_ross else ""

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)

    @property
    def sparse(self) -> bool:
        """Whether the matrices are sparse."""
        return is_sparse(self.mass)

    @property
    def constant(self) -> bool:
        """Whether the matrices are the same at all speeds."""
        still = not (self.gyroscopic != 0.0).sum()
        return bool(still) and all(each.constant for each in self.bearings)

    @property
    def speed_range(self) -> tuple[float, float]:
        """Least and largest speed at which all bearings are known, in rad/s."""
        limits = [each.speed_range for each in self.bearings if each.speed_range is not None]
        return (
            max((low for low, _ in limits), default=-np.inf),
            min((high for _, high in limits), default=np.inf),
        )

    def index(self, name: str | int) -> int:
        """Place of a coordinate in the matrices.

        Parameters
        ----------
        name : str or int
            Its name; a number that is a place already stays as it is.

        Returns
        -------
        int
            Its place, counted from 0.

        Raises
        ------
        OptionError
            When there is no such coordinate.

        Examples
        --------
        >>> import numpy as np
        >>> import nonsmooth as ns
        >>> ns.Structure(np.eye(2), np.eye(2), coordinates=["1x", "1y"]).index("1y")
        1
        """
        return place_of(name, self.coordinates, "name")

    def fixed(self, coordinates: Any) -> Structure:
        """The structure with some coordinates that do not move, as at a rigid support.

        Parameters
        ----------
        coordinates : str, int or list of these
            Those that stay at zero.

        Returns
        -------
        Structure
            Without them; bearings keep what acts on the others.

        Raises
        ------
        OptionError
            When there is no such coordinate.
        ModelError
            When no coordinate is left.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> beam = ns.structures.shaft([ns.structures.Beam(1.0, 0.05)])
        >>> beam.fixed(["0x", "0y", "0rx", "0ry"])
        Structure(4 coordinates: 1x, 1y, 1rx, 1ry)
        """
        still = set(places_of(coordinates, self.coordinates, "coordinates"))
        kept = [i for i in range(self.size) if i not in still]
        if not kept:
            raise ModelError("coordinates: all are fixed; leave at least one")
        bearings = []
        for each in self.bearings:
            places = places_of(each.coordinates, self.coordinates, "bearings")
            moving = [i for i, place in enumerate(places) if place not in still]
            if moving:
                named = replace(
                    each, coordinates=tuple(self.coordinates[place] for place in places)
                )
                bearings.append(named.at(moving))
        return Structure(
            **{name: getattr(self, name)[kept][:, kept] for name in MATRICES},
            coordinates=tuple(self.coordinates[i] for i in kept),
            bearings=tuple(bearings),
        )

    @checked
    def at_speed(self, speed: float) -> tuple[Matrix, Matrix, Matrix]:
        """Matrices at a speed, with the bearings in them.

        Parameters
        ----------
        speed : float
            Speed of the shaft in rad/s.

        Returns
        -------
        tuple
            M, C + Omega G + C_b and K + K_b; sparse where those of the structure are.

        Raises
        ------
        OptionError
            When the speed lies outside the table of a bearing.

        Examples
        --------
        >>> import numpy as np
        >>> import nonsmooth as ns
        >>> disc = ns.Structure(np.eye(2), 4 * np.eye(2), gyroscopic=[[0.0, 0.3], [-0.3, 0.0]])
        >>> disc.at_speed(10.0)[1]
        array([[ 0.,  3.],
               [-3.,  0.]])
        """
        damping = self.damping + float(speed) * self.gyroscopic
        stiffness = self.stiffness
        for bearing, at in zip(self.bearings, self._places, strict=True):  # type: ignore[attr-defined]  # set where it is made
            held, damped = bearing.at_speed(speed)
            stiffness = placed(stiffness, held, at)
            damping = placed(damping, damped, at)
        return self.mass, damping, stiffness


def _warn_of_overshoot(bearing: Bearing) -> None:
    found = bearing.overshoot()
    if found is not None:
        warnings.warn(
            f"bearings: {found} by the spline through the table of {bearing.name or 'a bearing'} at"
            f" {', '.join(map(str, bearing.coordinates))}, and the table has no such sign; give"
            " interpolation='monotone', or more speeds there",
            ResultWarning,
            stacklevel=4,
        )


def _check_symmetry(matrices: dict[str, Matrix]) -> None:
    mass, gyroscopic = matrices["mass"], matrices["gyroscopic"]
    if abs(mass - mass.T).max() > _ROUNDING * abs(mass).max():
        raise ModelError("mass is not symmetric; that of a structure in inertial axes is")
    lacks = np.flatnonzero(mass.diagonal() < 0.0)
    if lacks.size:
        raise ModelError(f"mass[{lacks[0]}, {lacks[0]}] is negative; every inertia is positive")
    if abs(gyroscopic + gyroscopic.T).max() > _ROUNDING * abs(gyroscopic).max():
        raise ModelError(
            "gyroscopic is not skew-symmetric, so it would change the energy; put the rest into"
            " damping"
        )


def _bearings(given: Any, names: tuple[str, ...]) -> tuple[tuple[Bearing, ...], tuple[Any, ...]]:
    """Bearings, and the rows and columns that each one acts on."""
    listed = (given,) if isinstance(given, Bearing) else given
    if isinstance(listed, str) or not isinstance(listed, Iterable):
        raise ModelError(f"bearings = {quote(given)}: give a list of Bearing")
    bearings = tuple(listed)
    for each in bearings:
        if not isinstance(each, Bearing):
            raise ModelError(
                f"bearings: {quote(each)} is none; make it by nonsmooth.structures.Bearing"
            )
    places = [
        places_of(each.coordinates, names, f"bearings[{i}]", ModelError)
        for i, each in enumerate(bearings)
    ]
    return bearings, tuple(np.ix_(at, at) for at in places)
