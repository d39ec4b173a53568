r"""`natural_modes`: eigenvalues of a structure, with what engineers read from them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.arguments import checked
from nonsmooth.errors import ResultWarning
from nonsmooth.leading_entry import leading_entry
from nonsmooth.real_numbers import whole_number
from nonsmooth.structures.eigenpairs import nearest_to_zero
from nonsmooth.structures.following import FollowedModes
from nonsmooth.structures.pencil import Pencil, computing_form
from nonsmooth.structures.stability import growth_of
from nonsmooth.structures.structure import Structure
from nonsmooth.structures.whirl import directions_of, whirl_of
from nonsmooth.version import __version__

__all__ = [
    "eigenvalue_variables",
    "followed_variables",
    "natural_modes",
    "normalised",
    "warn_if_unstable",
    "whirl_variables",
]

Array = npt.NDArray[Any]

_LOOKED_AT = 8  # modes of a large structure at first: unstable whirl of bearings is slow
_ROUNDING = 1e-6  # of a damping ratio, as the modes of fine meshes have it


@checked
def natural_modes(
    structure: Structure, speed: float = 0.0, *, count: int | None = None
) -> xr.Dataset:
    r"""Natural modes of a structure that stands still, or whose shaft turns.

    Solutions :math:`q = \mathrm{Re}\,\phi\, e^{\lambda t}` of
    :math:`(\lambda^2 M + \lambda (C + \Omega G + C_b) + K + K_b) \phi = 0`.

    Parameters
    ----------
    structure : Structure
        The structure.
    speed : float, optional
        Speed of the shaft in rad/s.
    count : int, optional
        How many modes, the slowest ones; all by default.

    Returns
    -------
    xarray.Dataset
        Over ``mode``, from 1, by growing natural frequency: the complex ``eigenvalue``;
        ``natural_frequency``, its modulus; ``damped_frequency``, its imaginary part, both in
        rad/s; ``frequency``, the latter in Hz; ``damping_ratio`` and ``log_decrement``. Over
        ``mode`` and ``coordinate`` the complex ``shape``, whose largest entry is 1. Where nodes
        have x and y, also ``whirl``, from -1 to 1, and ``direction``: ``forward``, ``backward``,
        or ``straight``.

    Raises
    ------
    ModelError
        When a coordinate has no inertia, or modes cannot be computed in this number.

    See Also
    --------
    campbell : modes over the speed.
    nonsmooth.plot.mode_shapes : a picture.

    Notes
    -----
    A pair of conjugate eigenvalues is one mode; a real eigenvalue, of an overdamped motion, is one
    by itself, and its logarithmic decrement is not a number. A motion without a restoring force has
    the eigenvalue zero.

    All modes come from a dense decomposition, whose time grows with the cube of the size. A few of
    a large structure come from Arnoldi's method around zero, with one sparse factorisation; a
    second run makes sure that no eigenvalue was passed over.

    ``whirl`` is the sum over all nodes of the squared forward amplitudes, less that of the backward
    ones, over the sum of both. Within one mode some nodes may whirl forward and others backward.
    Where no node is displaced, rotations about x and y take their place.

    References
    ----------
    M. I. Friswell, J. E. T. Penny, S. D. Garvey and A. W. Lees, Dynamics of Rotating Machines,
    Cambridge University Press 2010, Chapters 5 and 6.

    Examples
    --------
    Two equal masses between three equal springs:

    >>> import nonsmooth as ns
    >>> chain = ns.Structure([[1, 0], [0, 1]], [[2, -1], [-1, 2]])
    >>> ns.structures.natural_modes(chain)["natural_frequency"].values
    array([1.        , 1.73205081])
    """
    if count is not None:
        count = whole_number("count", count)
    found = nearest_to_zero(Pencil(computing_form(structure), float(speed)), count)
    shapes = normalised(found.vectors)
    variables = eigenvalue_variables("mode", found.values)
    variables["shape"] = ("coordinate", "mode"), shapes, {"long_name": "mode shape", "units": "1"}
    coordinates: dict[str, Any] = {
        "mode": ("mode", np.arange(1, len(found.values) + 1), {"long_name": "mode"}),
        "coordinate": ("coordinate", list(structure.coordinates), {"long_name": "coordinate"}),
    }
    whirl = whirl_of(shapes, structure.coordinates, float(speed))
    if whirl is not None:
        variables |= whirl_variables("mode", whirl)
    attrs = {"speed": float(speed), "speed_units": "rad/s", "nonsmooth_version": __version__}
    return xr.Dataset(variables, coordinates, attrs)


def _unstable_mode(structure: Structure, speed: float) -> tuple[str | None, str]:
    """Words for the mode that grows most, or None; and words where it is not told of all."""
    pencil = Pencil(computing_form(structure), speed)
    found = growth_of(pencil, _ROUNDING, _LOOKED_AT)
    if not found.grows:
        return None, found.untold
    modes = natural_modes(structure, speed, count=found.modes)
    worst = modes.isel(mode=int(np.argmin(modes["damping_ratio"].values)))
    whirl = f", {worst['direction'].item()}" if "direction" in worst else ""
    rate, frequency = worst["eigenvalue"].item().real, worst["damped_frequency"].item()
    return (
        f"the mode of {frequency:.4g} rad/s{whirl}, grows as exp({rate:.3g} t) at a speed of"
        f" {speed:.6g} rad/s"
    ), ""


def warn_if_unstable(structure: Structure, axis: Array) -> None:
    """Tell of an instability at the ends of some speeds, and where it begins on the way up."""
    at = len(axis) - 1
    words, untold = _unstable_mode(structure, float(axis[at]))
    if words is None:
        words, more = _unstable_mode(structure, float(axis[0]))
        untold = untold or more
    else:
        stable = -1
        while at - stable > 1:
            middle = (at + stable) // 2
            found, _ = _unstable_mode(structure, float(axis[middle]))
            at, stable, words = (at, middle, words) if found is None else (middle, stable, found)
    if words is not None:
        words += "; motions leave this response, which is that of a settled one"
    elif untold:
        words = f"{untold}; motions may leave this response"
    if words is not None:
        warnings.warn(f"structure: {words}", ResultWarning, stacklevel=4)


def normalised(vectors: Array) -> Array:
    """Shapes whose largest entry is one."""
    columns = np.arange(vectors.shape[1])
    return vectors / vectors[leading_entry(vectors), columns]


def eigenvalue_variables(dims: Any, values: Array) -> dict[str, Any]:
    """An eigenvalue, and what is read from it."""
    size = np.abs(values)
    with np.errstate(invalid="ignore", divide="ignore"):
        decay = 0.0 - values.real  # zero without a sign where there is none
        ratio = np.where(size > 0.0, decay / size, 0.0)
        decrement = np.where(values.imag > 0.0, 2.0 * np.pi * decay / values.imag, np.nan)
    missing = np.isnan(size)
    ratio = np.where(missing, np.nan, ratio)
    speeds = {"units": "rad/s"}
    return {
        "eigenvalue": (dims, values, {"long_name": "eigenvalue", **speeds}),
        "natural_frequency": (dims, size, {"long_name": "natural frequency", **speeds}),
        "damped_frequency": (
            dims,
            values.imag,
            {"long_name": "frequency of the damped motion", **speeds},
        ),
        "frequency": (
            dims,
            values.imag / (2.0 * np.pi),
            {"long_name": "frequency of the damped motion", "units": "Hz"},
        ),
        "damping_ratio": (dims, ratio, {"long_name": "damping ratio", "units": "1"}),
        "log_decrement": (dims, decrement, {"long_name": "logarithmic decrement", "units": "1"}),
    }


def followed_variables(
    followed: FollowedModes, coordinates: Sequence[str], axis: str, speeds: Array
) -> dict[str, Any]:
    """What is read from modes over a value or a speed, with the speed of the shaft at each."""
    dims = (axis, "mode")
    variables = eigenvalue_variables(dims, followed.values)
    words = f"modal assurance criterion with the {axis} before"
    variables["mac"] = dims, followed.likeness, {"long_name": words, "units": "1"}
    whirl = [
        whirl_of(vectors, coordinates, float(speed))
        for speed, vectors in zip(speeds, followed.vectors, strict=True)
    ]
    if whirl[0] is not None:
        variables |= whirl_variables(dims, np.array(whirl))
    return variables


def whirl_variables(dims: Any, whirl: Array) -> dict[str, Any]:
    """Sense of whirl as a number and as a word."""
    return {
        "whirl": (dims, whirl, {"long_name": "forward less backward whirl", "units": "1"}),
        "direction": (dims, directions_of(whirl), {"long_name": "sense of whirl"}),
    }
