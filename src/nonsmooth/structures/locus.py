r"""`root_locus`: the eigenvalues of a structure while one of its values changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth.arguments import checked
from nonsmooth.errors import NonsmoothError, OptionError, quote
from nonsmooth.real_numbers import finite_numbers, whole_number
from nonsmooth.structures.critical_speeds import speeds_of
from nonsmooth.structures.following import follow
from nonsmooth.structures.modes import followed_variables
from nonsmooth.structures.pencil import Pencil, computing_form
from nonsmooth.structures.stability import decay_of, decaying
from nonsmooth.structures.structure import Structure
from nonsmooth.version import __version__

__all__ = ["root_locus"]


@checked
def root_locus(
    structure: Structure | Callable[..., Any],
    values: Sequence[float],
    *,
    count: int = 8,
    speed: float = 0.0,
    name: str = "value",
    units: str = "",
) -> xr.Dataset:
    r"""Eigenvalues of a structure over one of its values, or over the speed.

    Parameters
    ----------
    structure : Structure or callable
        A function that returns the `Structure` for each value, such as that of a damping; or one
        structure, whose values are speeds.
    values : sequence of float
        The values, increasing or decreasing, two or more.
    count : int, optional
        How many modes, the slowest ones at the first value that oscillate. Real eigenvalues, and
        modes that become of these, are followed beside them where they are not farther from zero.
    speed : float, optional
        Speed of the shaft in rad/s, where ``structure`` is a function.
    name, units : str, optional
        What the value is, for labels.

    Returns
    -------
    xarray.Dataset
        Over ``value`` and ``mode``: the complex ``eigenvalue``, what is read from it, and the sense
        of whirl, as in `natural_modes`; ``mac``, the modal assurance criterion of a shape with that
        at the value before. ``stable`` over ``value``: whether all motions of the structure decay,
        also those that are not among these modes, rigid ones aside.

    Raises
    ------
    OptionError
        When values are too few, or the function returns something else.

    Warns
    -----
    ResultWarning
        When there are too many eigenvalues to tell whether all motions decay.

    See Also
    --------
    campbell : frequencies over the speed, with critical speeds.
    nonsmooth.plot.root_locus : a picture.

    Notes
    -----
    Modes are followed as in `campbell`. Where a mode becomes overdamped, its pair of eigenvalues
    becomes two real ones: it goes on with one of them, and a mode begins with the other. Where two
    real ones meet and oscillate, one goes on and the other ends. A mode that is not there at a
    value has no numbers.

    Of a large structure as many eigenvalues are computed as it takes until the damping tells that
    no others grow. An eigenvalue zero is on the border of stability; that of a rigid motion, which
    no force restores at any value, says nothing.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> def damped(c):
    ...     return ns.Structure([[1.0]], [[1.0]], damping=[[c]])
    >>> locus = ns.structures.root_locus(damped, [-0.2, 0.2], name="damping")
    >>> locus["stable"].values
    array([False,  True])
    """
    count = whole_number("count", count)
    if isinstance(structure, Structure):
        fixed = computing_form(structure)
        axis = speeds_of(values, fixed, least=2, name="values")
        name, units, coordinates = "speed of the shaft", "rad/s", fixed.coordinates

        def pencil_at(value: float) -> Pencil:
            return Pencil(fixed, value)
    else:
        axis = finite_numbers("values", values)
        steps = np.diff(axis) if axis.ndim == 1 else np.zeros(0)
        if not steps.size or not ((steps > 0.0).all() or (steps < 0.0).all()):
            raise OptionError("values: give two or more, increasing or decreasing")
        make, coordinates = structure, _made(structure, float(axis[0])).coordinates
        size = len(coordinates)

        def pencil_at(value: float) -> Pencil:
            made = _made(make, value)
            if made.size != size:
                raise OptionError(
                    f"structure({value:g}) has {made.size} coordinates, and that of the first"
                    f" value {size}; modes are followed where there are as many at all values"
                )
            return Pencil(computing_form(made), float(speed))

    followed = follow(pencil_at, axis, count, overdamped=True).rows(axis)
    speeds = axis if isinstance(structure, Structure) else np.full(axis.shape, float(speed))
    variables = followed_variables(followed, coordinates, "value", speeds)
    decays = [
        decay_of(pencil_at(float(value)), near)
        for value, near in zip(axis, followed.near, strict=True)
    ]
    variables["stable"] = "value", decaying(decays), {"long_name": "whether all motions decay"}
    numbers = np.arange(1, followed.values.shape[1] + 1)
    return xr.Dataset(
        variables,
        {
            "value": ("value", axis, {"long_name": name, "units": units}),
            "mode": ("mode", numbers, {"long_name": "mode"}),
        },
        {"nonsmooth_version": __version__},
    )


def _made(make: Callable[[float], Any], value: float) -> Structure:
    """What a function of the user's makes, or an error that says where it fails."""
    try:
        made = make(value)
    except NonsmoothError:
        raise
    except Exception as error:
        raise OptionError(
            f"structure: the function fails at {value:g} with {type(error).__name__}: {error};"
            " it takes one value, and returns a Structure for each"
        ) from error
    if not isinstance(made, Structure):
        raise OptionError(
            f"structure({value:g}) is {quote(made)}; the function returns a Structure"
        )
    return made
