r"""`frequency_response` and `static_deflection`: a structure under forces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.arguments import checked
from nonsmooth.errors import ModelError, OptionError, quote
from nonsmooth.real_numbers import finite_numbers, finite_real
from nonsmooth.structures.coordinates import in_direction, place_of, places_of
from nonsmooth.structures.modes import warn_if_unstable
from nonsmooth.structures.pencil import Pencil, computing_form, regular_solver
from nonsmooth.structures.structure import Structure
from nonsmooth.version import __version__

__all__ = ["frequency_response", "static_deflection"]

Array = npt.NDArray[Any]

_KINDS = {
    "receptance": (0, "receptance, displacement over force", "m/N"),
    "mobility": (1, "mobility, velocity over force", "m/(N s)"),
    "accelerance": (2, "accelerance, acceleration over force", "1/kg"),
}


@checked
def frequency_response(
    structure: Structure,
    frequencies: Sequence[float],
    *,
    inputs: Any = None,
    outputs: Any = None,
    speed: float | Literal["synchronous"] = 0.0,
    kind: Literal["receptance", "mobility", "accelerance"] = "receptance",
) -> xr.Dataset:
    r"""Frequency response of a structure: amplitudes at some coordinates under forces at others.

    .. math:: H(\omega) = (i\omega)^s\,
        (K + K_b + i\omega (C + \Omega G + C_b) - \omega^2 M)^{-1}

    with s = 0, 1 or 2 for displacements, velocities or accelerations.

    Parameters
    ----------
    structure : Structure
        The structure.
    frequencies : sequence of float
        Frequencies of the forces in rad/s.
    inputs, outputs : str, int or list of these, optional
        Coordinates at which forces act, and those at which the answer is wanted; all by default.
    speed : float or "synchronous", optional
        Speed of the shaft in rad/s; at rest by default. With "synchronous" the shaft turns at each
        frequency, as under forces that its own rotation makes.
    kind : {"receptance", "mobility", "accelerance"}, optional
        What is over the force: displacement, velocity or acceleration.

    Returns
    -------
    xarray.Dataset
        Over ``frequency``, ``output`` and ``input``: the complex ``response`` with its
        ``amplitude`` and its ``phase`` in rad. Of an angle read rad for m, of a moment N m for N.

    Raises
    ------
    OptionError
        When a coordinate does not exist.
    ModelError
        When the response is infinite, at a natural frequency without damping.

    Warns
    -----
    ResultWarning
        When the structure is unstable at a speed: a motion then grows away from its response. Or
        when it has too many modes to tell, and negative damping.

    See Also
    --------
    unbalance_response : forces that turn with the shaft.
    nonsmooth.plot.frequency_response : a picture.

    Notes
    -----
    There is one factorisation for each frequency; no modes are left out. Coefficients of bearings
    are those at the speed of the shaft.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> mass = ns.Structure([[1.0]], [[4.0]], damping=[[0.1]])
    >>> found = ns.structures.frequency_response(mass, [0.0, 2.0])
    >>> found["amplitude"].values.ravel()
    array([0.25, 5.  ])
    """
    axis = finite_numbers("frequencies", frequencies)
    if axis.ndim != 1 or not axis.size:
        raise OptionError("frequencies: give a list of one or more")
    names = structure.coordinates
    driven = places_of(inputs, names, "inputs")
    seen = places_of(outputs, names, "outputs")
    light, synchronous = computing_form(structure), speed == "synchronous"
    pencil = None if synchronous else Pencil(light, float(speed))
    force = np.zeros((structure.size, len(driven)), dtype=complex)
    force[driven, np.arange(len(driven))] = 1.0
    power, text, units = _KINDS[kind]
    found = np.empty((len(axis), len(seen), len(driven)), dtype=complex)
    for page, frequency in zip(found, axis, strict=True):
        try:
            solve = (pencil or Pencil(light, float(frequency))).solver(1j * frequency)
            page[:] = (1j * frequency) ** power * solve(force)[seen]
        except np.linalg.LinAlgError:
            raise ModelError(
                f"at {frequency:g} rad/s the response is infinite; give damping, or other"
                " frequencies"
            ) from None
    warn_if_unstable(structure, np.unique(axis) if synchronous else np.array([float(speed)]))
    over: Any = ("frequency", "output", "input")
    return xr.Dataset(
        {
            "response": (over, found, {"long_name": text, "units": units}),
            "amplitude": (over, np.abs(found), {"long_name": text, "units": units}),
            "phase": (over, np.angle(found), {"long_name": "phase", "units": "rad"}),
        },
        {
            "frequency": ("frequency", axis, {"long_name": "frequency", "units": "rad/s"}),
            "output": ("output", [names[i] for i in seen], {"long_name": "coordinate"}),
            "input": ("input", [names[i] for i in driven], {"long_name": "force at"}),
        },
        {
            "kind": kind,
            "speed": speed if synchronous else float(speed),
            "nonsmooth_version": __version__,
        },
    )


@checked
def static_deflection(
    structure: Structure,
    load: Any = None,
    *,
    gravity: Mapping[str, float] | None = None,
    speed: float = 0.0,
) -> xr.Dataset:
    r"""Static deflection of a structure under constant forces.

    Parameters
    ----------
    structure : Structure
        The structure, with the bearings that hold it.
    load : mapping or array_like, optional
        Force in N, or moment in N m, at each coordinate: a mapping of names to numbers, or a number
        for each.
    gravity : mapping of str to float, optional
        Acceleration in m/s^2 for each direction, such as ``{"y": -9.81}``: it acts on all
        coordinates whose names end so, and gives the weight.
    speed : float, optional
        Speed of the shaft in rad/s, for bearings that depend on it.

    Returns
    -------
    xarray.Dataset
        Over ``coordinate``: ``displacement`` in m, or rad of an angle, and ``force``, the whole
        load; ``reaction``, the force of the bearings on the structure, which with the load is in
        balance where ``stiffness`` itself holds nothing.

    Raises
    ------
    OptionError
        When there is no load, or a name is unknown.
    ModelError
        When the structure can move without a force: hold it by bearings.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> frame = ns.Structure([[1, 0], [0, 1]], [[2, -1], [-1, 1]], coordinates=["1y", "2y"])
    >>> ns.structures.static_deflection(frame, {"2y": 3.0})["displacement"].values
    array([3., 6.])
    """
    force = _force(load, gravity, structure)
    _, _, stiffness = structure.at_speed(float(speed))
    cure = "the structure can move without a force; hold it by bearings"
    moved = regular_solver(Pencil(computing_form(structure), float(speed)).K, "stiffness", cure)(
        force
    )
    reaction = structure.stiffness @ moved - stiffness @ moved
    words = {"displacement": (moved, "static deflection", "m"), "force": (force, "load", "N"),
             "reaction": (reaction, "force of the bearings", "N")}  # fmt: skip
    return xr.Dataset(
        {
            name: ("coordinate", values, {"long_name": text, "units": units})
            for name, (values, text, units) in words.items()
        },
        {"coordinate": ("coordinate", list(structure.coordinates), {"long_name": "coordinate"})},
        {"speed": float(speed), "nonsmooth_version": __version__},
    )


def _force(load: Any, gravity: Mapping[str, float] | None, structure: Structure) -> Array:
    """The whole load, a number for each coordinate."""
    names = structure.coordinates
    if load is None and not gravity:
        raise OptionError("load: there is none; give load=, or gravity= such as {'y': -9.81}")
    force = np.zeros(structure.size)
    if isinstance(load, Mapping):
        for name, value in load.items():
            force[place_of(name, names, "load")] += finite_real(f"load[{quote(name)}]", value)
    elif load is not None:
        force = finite_numbers("load", load)
        if force.shape != (structure.size,):
            raise OptionError(
                f"load = {quote(load)}: give a number for each of the {structure.size} coordinates,"
                " or a mapping of names to numbers"
            )
    for direction, value in (gravity or {}).items():
        places = in_direction(direction, names) if direction in ("x", "y", "z") else []
        if not places:
            raise OptionError(
                f"gravity: no coordinate has the direction {quote(direction)}; give x, y or z, with"
                " which names such as '3y' end"
            )
        along = np.zeros(structure.size)
        along[places] = finite_real(f"gravity[{direction!r}]", value)
        force = force + structure.mass @ along
    return force
