r"""`shaft`: a structure made of beams, discs and bearings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import ModelError
from nonsmooth.real_numbers import finite_numbers
from nonsmooth.structures.beam import Beam, Disc
from nonsmooth.structures.bearing import Bearing
from nonsmooth.structures.structure import Structure

__all__ = ["shaft"]

_PER_NODE = ("x", "y", "rx", "ry")


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
        Factors a and b of Rayleigh's damping :math:`a M + b K` of the elements. It acts in the
        axes that stand still. Damping inside a turning shaft, which may make it unstable, is
        something else.
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
    if len(elements) == 0:
        raise ModelError("elements: there is none; give at least one Beam")
    per = len(_PER_NODE)
    size = per * (len(elements) + 1)
    names = [f"{node}{each}" for node in range(len(elements) + 1) for each in _PER_NODE]
    a, b = finite_numbers("damping", damping)
    blocks: dict[str, list[tuple[int, Any]]] = {"mass": [], "stiffness": [], "gyroscopic": []}
    blocks["damping"] = []
    for i, beam in enumerate(elements):
        mass, stiffness = beam.mass_matrix(), beam.stiffness_matrix()
        blocks["mass"].append((per * i, mass))
        blocks["stiffness"].append((per * i, stiffness))
        blocks["damping"].append((per * i, a * mass + b * stiffness))
        blocks["gyroscopic"].append((per * i, beam.gyroscopic_matrix()))
    for disc in discs:
        if disc.node > len(elements):
            raise ModelError(f"discs: there is no node {disc.node}; the last is {len(elements)}")
        blocks["mass"].append((per * disc.node, disc.mass_matrix()))
        blocks["gyroscopic"].append((per * disc.node, disc.gyroscopic_matrix()))
    matrices = {name: _assembled(each, size, sparse) for name, each in blocks.items()}
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
