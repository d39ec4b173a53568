r"""Structures made of beams, discs and bearings, and of other structures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import ModelError, OptionError, quote
from nonsmooth.real_numbers import finite_numbers
from nonsmooth.structures.beam import Beam, Disc, RectangularBeam
from nonsmooth.structures.bearing import Bearing
from nonsmooth.structures.coordinates import places_of
from nonsmooth.structures.matrices import MATRICES
from nonsmooth.structures.structure import Structure

__all__ = ["assemble", "plane_beam", "shaft", "torsional_shaft"]

Blocks = dict[str, list[tuple[int, Any]]]
"""For each matrix: the first row and column of a part, and the part."""


@checked
def shaft(
    elements: Sequence[Beam],
    *,
    discs: Sequence[Disc] = (),
    bearings: Sequence[Bearing] = (),
    damping: tuple[float, float] = (0.0, 0.0),
    sparse: bool = False,
) -> Structure:
    r"""A shaft of beams in a row, with discs, in bearings.

    Parameters
    ----------
    elements : sequence of Beam
        The elements from the first node to the last. Node 0 is the free end of the first one; n
        elements have n + 1 nodes.
    discs : sequence of Disc, optional
        Rigid discs at nodes.
    bearings : sequence of Bearing, optional
        What holds the shaft. Without any it floats.
    damping : tuple of float, optional
        Factors a and b of Rayleigh's damping :math:`a M + b K` of the elements, not negative. It
        acts in the axes that stand still. Damping inside a turning shaft, which may make it
        unstable, is something else.
    sparse : bool, optional
        Whether the matrices are those of scipy.sparse.

    Returns
    -------
    Structure
        Coordinates ``0x 0y 0rx 0ry 1x ...``: displacements in m and angles in rad. The shaft lies
        along z and turns from x to y.

    Raises
    ------
    ModelError
        When there is no such node or coordinate.
    OptionError
        When a factor of the damping is negative.

    See Also
    --------
    Beam : the element, with its theory.
    Structure.from_ross : a shaft that was described for ROSS.

    References
    ----------
    M. I. Friswell, J. E. T. Penny, S. D. Garvey and A. W. Lees, Dynamics of Rotating Machines,
    Cambridge University Press 2010, Chapter 5.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.structures import Beam, Bearing, Disc, shaft
    >>> rotor = shaft(
    ...     [Beam(0.25, 0.05)] * 6,
    ...     discs=[
    ...         Disc.from_geometry(2, 0.07, 0.28, 0.05),
    ...         Disc.from_geometry(4, 0.07, 0.35, 0.05),
    ...     ],
    ...     bearings=[Bearing(["0x", "0y"], 1e6), Bearing(["6x", "6y"], 1e6)],
    ... )
    >>> rotor
    Structure(28 coordinates: 0x, 0y, 0rx, 0ry, 1x, 1y, ...; 2 bearings)
    """
    blocks, rayleigh = _blocks(), _rayleigh_factors(damping)
    per = 4
    for i, beam in enumerate(elements):
        _add(blocks, per * i, beam.mass_matrix(), beam.stiffness_matrix(), rayleigh)
        blocks["gyroscopic"].append((per * i, beam.gyroscopic_matrix()))
    for disc in _at_nodes(discs, elements):
        blocks["mass"].append((per * disc.node, disc.mass_matrix()))
        blocks["gyroscopic"].append((per * disc.node, disc.gyroscopic_matrix()))
    return _in_a_row(elements, ("x", "y", "rx", "ry"), blocks, bearings, sparse)


@checked
def plane_beam(
    elements: Sequence[Beam | RectangularBeam],
    *,
    discs: Sequence[Disc] = (),
    bearings: Sequence[Bearing] = (),
    damping: tuple[float, float] = (0.0, 0.0),
    sparse: bool = False,
) -> Structure:
    r"""Beams in a row that bend in one plane and do not turn, such as a cantilever.

    Parameters
    ----------
    elements : sequence of Beam or RectangularBeam
        The elements from the first node to the last; n elements have n + 1 nodes, counted from 0.
    discs : sequence of Disc, optional
        Rigid bodies at nodes, by their mass and their moment of inertia about a diameter.
    bearings : sequence of Bearing, optional
        Springs and dampers. Without any, and unless `Structure.fixed` holds it, the beam floats.
    damping : tuple of float, optional
        Factors a and b of Rayleigh's damping :math:`a M + b K` of the elements, not negative.
    sparse : bool, optional
        Whether the matrices are those of scipy.sparse.

    Returns
    -------
    Structure
        Coordinates ``0x 0ry 1x 1ry ...``: deflections in m, and slopes in rad.

    Raises
    ------
    ModelError
        When there is no such node or coordinate.
    OptionError
        When a factor of the damping is negative.

    See Also
    --------
    RectangularBeam, Beam : the elements, with their theory.
    shaft : the same in two planes, turning.

    Examples
    --------
    The lowest natural frequency of a cantilever, beside the closed form of Euler and Bernoulli:

    >>> import nonsmooth as ns
    >>> from nonsmooth.structures import RectangularBeam, natural_modes, plane_beam
    >>> strip = RectangularBeam(0.02, width=0.02, height=0.002)
    >>> blade = plane_beam([strip] * 15).fixed(["0x", "0ry"])
    >>> round(float(natural_modes(blade, count=1)["natural_frequency"][0]), 2)
    116.66
    >>> bending = strip.youngs_modulus * strip.second_moment
    >>> round(1.8751040687**2 * (bending / (strip.density * strip.area * 0.3**4)) ** 0.5, 2)
    116.66
    """
    blocks, rayleigh = _blocks(), _rayleigh_factors(damping)
    for i, beam in enumerate(elements):
        element = beam._bending
        _add(blocks, 2 * i, element.mass_matrix(), element.stiffness_matrix(), rayleigh)
    for disc in _at_nodes(discs, elements):
        blocks["mass"].append((2 * disc.node, np.diag([disc.mass, disc.diametral_inertia])))
    return _in_a_row(elements, ("x", "ry"), blocks, bearings, sparse)


@checked
def torsional_shaft(
    elements: Sequence[Beam],
    *,
    discs: Sequence[Disc] = (),
    bearings: Sequence[Bearing] = (),
    damping: tuple[float, float] = (0.0, 0.0),
    sparse: bool = False,
) -> Structure:
    r"""A shaft in torsion, with discs such as flywheels, gears and rotors of motors.

    Parameters
    ----------
    elements : sequence of Beam
        The elements from the first node to the last; n elements have n + 1 nodes, counted from 0.
    discs : sequence of Disc, optional
        Rigid discs at nodes, by their polar moment of inertia.
    bearings : sequence of Bearing, optional
        Torsional springs and dampers, in N m/rad and N m s/rad: couplings, and drag. Without any,
        and unless `Structure.fixed` holds it, the shaft turns freely.
    damping : tuple of float, optional
        Factors a and b of Rayleigh's damping :math:`a M + b K` of the elements, not negative.
    sparse : bool, optional
        Whether the matrices are those of scipy.sparse.

    Returns
    -------
    Structure
        Coordinates ``0rz 1rz ...``: angles in rad beyond those of steady rotation. Forces on them
        are torques in N m.

    Raises
    ------
    ModelError
        When there is no such node or coordinate.
    OptionError
        When a factor of the damping is negative.

    See Also
    --------
    shaft : the same in bending.
    assemble : two shafts beside each other, to be coupled by gears.

    Notes
    -----
    The twist is constant in an element, the inertia consistent with that. Deflections under torques
    at the nodes are exact; natural frequencies come from above, with an error that falls with the
    square of the length of the elements: about 1/24 of the square of the phase that the wave of the
    mode advances along one. The shear modulus is E/(2 (1 + Poisson's ratio)).

    Examples
    --------
    A flywheel on a shaft that is held at its other end:

    >>> import nonsmooth as ns
    >>> from nonsmooth.structures import Beam, Disc, natural_modes, torsional_shaft
    >>> wheel = Disc.from_geometry(4, 0.05, 0.4, 0.04)
    >>> drive = torsional_shaft([Beam(0.1, 0.04)] * 4, discs=[wheel]).fixed("0rz")
    >>> round(float(natural_modes(drive, count=1)["natural_frequency"][0]), 2)
    226.8
    """
    blocks, rayleigh = _blocks(), _rayleigh_factors(damping)
    for i, beam in enumerate(elements):
        element = beam._torsion
        _add(blocks, i, element.mass_matrix(), element.stiffness_matrix(), rayleigh)
    for disc in _at_nodes(discs, elements):
        blocks["mass"].append((disc.node, np.array([[disc.polar_inertia]])))
    return _in_a_row(elements, ("rz",), blocks, bearings, sparse)


@checked
def assemble(parts: Mapping[str, Structure], *, bearings: Sequence[Bearing] = ()) -> Structure:
    """Several structures as one, such as two shafts, or a rotor and its casing.

    Parameters
    ----------
    parts : mapping of str to Structure
        The structures by their names.
    bearings : sequence of Bearing, optional
        Springs and dampers between coordinates of different parts. What is not linear there is a
        contact of `machine`.

    Returns
    -------
    Structure
        Coordinates ``name coordinate``, such as ``pinion 3rz``, in the order of the parts; sparse
        if one of the parts is. All parts turn at the same speed ``Omega`` where they depend on it.

    Raises
    ------
    ModelError
        When there is no part, one is no Structure, or a coordinate is unknown.

    Examples
    --------
    Two masses with a spring of 3 N/m between them:

    >>> import nonsmooth as ns
    >>> from nonsmooth.structures import Bearing, assemble
    >>> mass = ns.Structure([[1.0]], [[1.0]], coordinates=["x"])
    >>> spring = Bearing(["left x", "right x"], [[3.0, -3.0], [-3.0, 3.0]])
    >>> assemble({"left": mass, "right": mass}, bearings=[spring]).at_speed(0.0)[2]
    array([[ 4., -3.],
           [-3.,  4.]])
    """
    if not parts:
        raise ModelError("parts: there is none; give at least one structure by its name")
    from scipy.sparse import block_diag, coo_array

    names: list[str] = []
    held: list[Bearing] = []
    for name, part in parts.items():
        if not isinstance(part, Structure) or not isinstance(name, str) or not name.strip():
            raise ModelError(f"parts[{quote(name)}]: give names of structures, each a Structure")
        called = [f"{name} {each}" for each in part.coordinates]
        for bearing in part.bearings:
            places = places_of(bearing.coordinates, part.coordinates, "bearings")
            held.append(replace(bearing, coordinates=tuple(called[place] for place in places)))
        names += called
    sparse = any(part.sparse for part in parts.values())
    matrices = {
        key: block_diag([coo_array(getattr(part, key)) for part in parts.values()], format="csc")
        for key in MATRICES
    }
    if not sparse:
        matrices = {key: matrix.toarray() for key, matrix in matrices.items()}
    return Structure(**matrices, coordinates=tuple(names), bearings=(*held, *bearings))


def _blocks() -> Blocks:
    return {name: [] for name in MATRICES}


def _rayleigh_factors(damping: Any) -> tuple[float, float]:
    """Both factors, by which no motion gains energy."""
    factors = finite_numbers("damping", damping)
    if factors.shape != (2,):
        raise OptionError(f"damping = {quote(damping)}: give two factors, of M and of K")
    if (factors < 0.0).any():
        raise OptionError(
            f"damping = {quote(damping)}: a negative factor would feed energy into motions; give a"
            " damping that does so as that of a Structure or a Bearing"
        )
    return float(factors[0]), float(factors[1])


def _add(blocks: Blocks, first: int, mass: Any, stiffness: Any, rayleigh: Any) -> None:
    """An element, with Rayleigh's damping."""
    a, b = rayleigh
    blocks["mass"].append((first, mass))
    blocks["stiffness"].append((first, stiffness))
    blocks["damping"].append((first, a * mass + b * stiffness))


def _at_nodes(discs: Sequence[Disc], elements: Sequence[Any]) -> Sequence[Disc]:
    """Discs, each at a node that is there."""
    for disc in discs:
        if disc.node > len(elements):
            raise ModelError(f"discs: there is no node {disc.node}; the last is {len(elements)}")
    return discs


def _in_a_row(
    elements: Sequence[Any],
    directions: tuple[str, ...],
    blocks: Blocks,
    bearings: Sequence[Bearing],
    sparse: bool,
) -> Structure:
    """Elements from node to node, with the same coordinates at each of these."""
    if len(elements) == 0:
        raise ModelError("elements: there is none; give at least one Beam")
    names = [f"{node}{each}" for node in range(len(elements) + 1) for each in directions]
    matrices = {name: _assembled(each, len(names), sparse) for name, each in blocks.items() if each}
    return Structure(**matrices, coordinates=tuple(names), bearings=tuple(bearings))


def _assembled(blocks: Sequence[tuple[int, Any]], size: int, sparse: bool) -> Any:
    """Sum of blocks, each with its first row and column."""
    from scipy.sparse import coo_array

    rows, columns = zip(
        *(np.add(np.indices(block.shape), first).reshape(2, -1) for first, block in blocks),
        strict=True,
    )
    entries = np.concatenate([block.ravel() for _, block in blocks])
    where = np.concatenate(rows), np.concatenate(columns)
    matrix = coo_array((entries, where), shape=(size, size))
    return matrix.tocsc() if sparse else matrix.toarray()
