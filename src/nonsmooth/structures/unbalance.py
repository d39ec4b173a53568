r"""`unbalance_response`: how a shaft whirls at its own speed under unbalances."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.arguments import checked
from nonsmooth.errors import ModelError, OptionError, quote
from nonsmooth.real_numbers import finite_real
from nonsmooth.structures.coordinates import NodePlane, node_plane, place_of, planes
from nonsmooth.structures.critical_speeds import speed_axis, speeds_of
from nonsmooth.structures.modes import warn_if_unstable
from nonsmooth.structures.pencil import Pencil, computing_form
from nonsmooth.structures.structure import Structure
from nonsmooth.structures.whirl import whirl_parts
from nonsmooth.version import __version__

__all__ = ["unbalance_response"]

Array = npt.NDArray[Any]


@checked
def unbalance_response(structure: Structure, speeds: Sequence[float], unbalance: Any) -> xr.Dataset:
    r"""Response of a shaft to unbalances, over its speed.

    An unbalance of moment u and phase :math:`\varphi` pulls its node with
    :math:`u\,\Omega^2 \cos(\Omega t + \varphi)` in x and with the sine in y. The answer is
    :math:`q = \mathrm{Re}\,\hat q\, e^{i \Omega t}`.

    Parameters
    ----------
    structure : Structure
        The structure, with the bearings that hold it.
    speeds : sequence of float
        Speeds of the shaft in rad/s, increasing.
    unbalance : tuple or list of tuple
        Each ``(node, moment)`` or ``(node, moment, phase)``: the node as it stands in the names of
        coordinates, such as ``3``, or the pair of its coordinates in x and y, such as
        ``("q4", "q5")``; mass times eccentricity in kg m; angle in rad.

    Returns
    -------
    xarray.Dataset
        Over ``speed`` and ``coordinate``: ``displacement``, the complex :math:`\hat q`, its
        ``amplitude`` and its ``phase`` in rad, from -pi to pi; a negative phase lags. Where nodes
        have x and y, over ``speed`` and ``node``: ``forward`` and ``backward``, the complex
        amplitudes of the two circles that make up the orbit, and its half axes ``major_axis`` and
        ``minor_axis``, the latter negative in backward whirl.

    Raises
    ------
    OptionError
        When a node does not exist, or speeds do not increase or lie outside the table of a bearing.
    ModelError
        When the response is infinite, at an undamped critical speed.

    Warns
    -----
    ResultWarning
        When the structure is unstable at the last or at the first speed: a motion then grows away
        from this response. Or when it has too many modes to tell, and negative damping.

    See Also
    --------
    campbell : the critical speeds.
    frequency_response : under forces of any frequency, at one speed.
    nonsmooth.plot.unbalance_response : a picture.

    Notes
    -----
    With :math:`x + i y = f e^{i \Omega t} + \bar b\, e^{-i \Omega t}`, f is ``forward`` and b is
    ``backward``; the half axes are :math:`|f| + |b|` and :math:`|f| - |b|`. There is one
    factorisation for each speed.

    Examples
    --------
    A disc in equal bearings, at twice its critical speed: it is farther out than its centre of
    mass, and opposite to it.

    >>> import nonsmooth as ns
    >>> disc = ns.Structure([[2, 0], [0, 2]], [[800, 0], [0, 800]], coordinates=["1x", "1y"])
    >>> found = ns.structures.unbalance_response(disc, [40.0], (1, 2e-3))
    >>> found["forward"].values[0].real * 1e3
    array([-1.33333333])
    """
    axis = speeds_of(speeds, structure)
    names = structure.coordinates
    force = np.zeros(structure.size, dtype=complex)
    for plane, moment, phase in _unbalances(unbalance, names):
        force[plane.x] += moment * np.exp(1j * phase)
        force[plane.y] += -1j * moment * np.exp(1j * phase)
    found = np.empty((len(axis), structure.size), dtype=complex)
    light = computing_form(structure)
    for row, speed in zip(found, axis, strict=True):
        try:
            row[:] = Pencil(light, speed).solver(1j * speed)(speed**2 * force)
        except np.linalg.LinAlgError:
            raise ModelError(
                f"at {speed:g} rad/s the response is infinite; give damping, or other speeds"
            ) from None
    warn_if_unstable(structure, axis)
    over: Any = ("speed", "coordinate")
    variables: dict[str, Any] = {
        "displacement": (over, found, {"long_name": "complex displacement", "units": "m"}),
        "amplitude": (over, np.abs(found), {"long_name": "amplitude", "units": "m"}),
        "phase": (over, np.angle(found), {"long_name": "phase", "units": "rad"}),
    }
    coordinates: dict[str, Any] = {
        "speed": speed_axis(axis),
        "coordinate": ("coordinate", list(names), {"long_name": "coordinate"}),
    }
    known = planes(names)
    if known:
        variables |= _orbits(found, known)
        nodes = [each.node or "0" for each in known]
        coordinates["node"] = "node", nodes, {"long_name": "node"}
    return xr.Dataset(variables, coordinates, {"nonsmooth_version": __version__})


def _orbits(found: Array, known: list[NodePlane]) -> dict[str, Any]:
    """Circles and half axes of the orbit of each node."""
    forward, backward = (part.T for part in whirl_parts(found.T, known))
    over = ("speed", "node")
    long, short = np.abs(forward) + np.abs(backward), np.abs(forward) - np.abs(backward)
    columns = {
        "forward": (forward, "forward circle"),
        "backward": (backward, "backward circle"),
        "major_axis": (long, "half of the major axis of the orbit"),
        "minor_axis": (short, "half of the minor axis of the orbit"),
    }
    return {
        name: (over, values, {"long_name": text, "units": "m"})
        for name, (values, text) in columns.items()
    }


def _unbalances(given: Any, names: tuple[str, ...]) -> list[tuple[NodePlane, float, float]]:
    """NodePlane, moment and phase of each."""
    words = "(node, moment) or (node, moment, phase)"
    if not isinstance(given, list | tuple) or not given:
        raise OptionError(f"unbalance = {quote(given)}: give {words}, or a list of these")
    single = isinstance(given, tuple) and not isinstance(given[-1], list | tuple)
    found = []
    for each in [given] if single else given:
        if not isinstance(each, list | tuple) or len(each) not in (2, 3):
            raise OptionError(f"unbalance = {quote(each)}: give {words}")
        node, moment, phase = (*each, 0.0)[:3]
        if isinstance(node, list | tuple):
            if len(node) != 2:
                raise OptionError(f"unbalance: {quote(node)}: give the coordinates of x and of y")
            x, y = (place_of(one, names, "unbalance") for one in node)
            plane = NodePlane("", x, y)
        else:
            plane = node_plane(node, names, "unbalance")
        size = finite_real("unbalance: moment", moment)
        found.append((plane, size, finite_real("unbalance: phase", phase)))
    return found
