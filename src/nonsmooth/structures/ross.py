"""Rotors of ROSS as structures: matrices of all elements but the bearings, and these as bearings.

ROSS has the shaft along z, turning from x to y, and the coordinates x, y, z, alpha, beta and theta
of each node: displacements, and rotations about x, y and z. They are called ``3x 3y 3z 3rx 3ry
3rz`` here. Supports that bearings are linked to have displacements only. ROSS is not imported: an
object of its class is all that is needed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError
from nonsmooth.structures.bearing import Bearing

__all__ = ["parts_of"]

Array = npt.NDArray[np.float64]
Tables = Literal["spline", "monotone", "ross"]

_MATRICES = {"mass": "M0", "stiffness": "K0", "damping": "C0", "gyroscopic": "G0"}
_PER_NODE = ("x", "y", "z", "rx", "ry", "rz")
_LATERAL = ("x", "y")  # the last letter of displacements and rotations alike
_UNCOUPLED = 1e-12  # of the largest entry
_AXES = "xyz"


class _Held(NamedTuple):
    """A bearing of ROSS with the rows of the matrices that it acts on."""

    element: Any
    rows: list[int]


def parts_of(rotor: Any, coordinates: str, tables: Tables) -> dict[str, Any]:
    """What `Structure` takes."""
    lacks = [name for name in (*_MATRICES.values(), "bearing_elements") if not hasattr(rotor, name)]
    if lacks:
        raise ModelError(
            f"rotor: {type(rotor).__name__} has no {lacks[0]}; give a Rotor of ROSS 2 or later"
        )
    names = _names(rotor)
    matrices = {name: np.array(getattr(rotor, each)) for name, each in _MATRICES.items()}
    held = [
        _Held(each, list(map(int, each.dof_global_index.values())))
        for each in rotor.bearing_elements
    ]
    for element, rows in held:
        matrices["mass"][np.ix_(rows, rows)] += _added_mass(element)
    kept = np.array([i for i, name in enumerate(names) if _is_kept(name, coordinates)])
    for name, matrix in matrices.items():
        _check_uncoupled(name, matrix, kept)
    bearings = [_bearing(each, names, tables, i) for i, each in enumerate(held)]
    return {
        **{name: matrix[np.ix_(kept, kept)] for name, matrix in matrices.items()},
        "coordinates": tuple(names[i] for i in kept),
        "bearings": tuple(_within(bearings, {names[i] for i in kept})),
    }


def _is_kept(name: str, coordinates: str) -> bool:
    return coordinates == "all" or name.endswith(_LATERAL)


def _names(rotor: Any) -> list[str]:
    """Names of all coordinates, node by node, those of linked supports last."""
    if rotor.number_dof != len(_PER_NODE):
        raise ModelError(
            f"rotor: {rotor.number_dof} degrees of freedom at each node; a Rotor of ROSS 2 has six"
        )
    nodes = len(rotor.nodes)
    supports, rest = divmod(rotor.ndof - len(_PER_NODE) * nodes, len(_AXES))
    if rest or supports < 0:
        raise ModelError(f"rotor: {rotor.ndof} degrees of freedom do not belong to {nodes} nodes")
    shaft = [f"{node}{each}" for node in range(nodes) for each in _PER_NODE]
    return shaft + [f"{nodes + i}{each}" for i in range(supports) for each in _AXES]


def _added_mass(element: Any) -> Array:
    """Mass that moves with a bearing, which cannot depend on the speed here."""
    speeds = [0.0] if element.frequency is None else element.frequency
    masses = np.array([element.M(speed) for speed in speeds])
    if np.abs(masses - masses[0]).max() > _UNCOUPLED * np.abs(masses).max():
        raise ModelError(
            f"rotor: the mass of the bearing {element.tag or element.n} depends on the speed; give"
            " one mass"
        )
    return masses[0]


def _check_uncoupled(name: str, matrix: Array, kept: Any) -> None:
    others = np.setdiff1d(np.arange(len(matrix)), kept)
    between = np.abs(np.concatenate([matrix[np.ix_(kept, others)].ravel(),
                                     matrix[np.ix_(others, kept)].ravel(), [0.0]]))  # fmt: skip
    if between.max() > _UNCOUPLED * np.abs(matrix).max():
        raise ModelError(
            f"rotor: its {name} couples lateral motion with axial motion or torsion; give"
            " coordinates='all'"
        )


def _bearing(held: _Held, names: list[str], tables: Tables, place: int) -> Bearing:
    element, rows = held
    coordinates = [names[row] for row in rows]
    name = str(element.tag or f"bearing {place}")
    if element.frequency is None:
        return Bearing(coordinates, element.K(0.0), element.C(0.0), name=name)
    speeds = np.asarray(element.frequency, dtype=float)
    if tables == "ross":
        laws: list[Callable[[float], Array]] = [element.K, element.C]
        return Bearing(coordinates, *laws, speeds=speeds, name=name)
    return Bearing(
        coordinates,
        _table(element, "k", len(speeds), len(rows)),
        _table(element, "c", len(speeds), len(rows)),
        speeds=speeds,
        name=name,
        interpolation=tables,
    )


def _table(element: Any, letter: str, count: int, size: int) -> Array:
    """The coefficients as they were given, in the layout of the element's matrices."""
    one = np.zeros((count, 3, 3))
    for i, j in ((0, 0), (0, 1), (1, 0), (1, 1), (2, 2)):
        one[:, i, j] = getattr(element, f"{letter}{_AXES[i]}{_AXES[j]}")
    return one if size == 3 else np.block([[one, -one], [-one, one]])


def _within(bearings: list[Bearing], kept: set[str]) -> Iterator[Bearing]:
    """Bearings with the coordinates that are kept."""
    for bearing in bearings:
        places = [i for i, name in enumerate(bearing.coordinates) if name in kept]
        if places:
            yield bearing.at(places)
