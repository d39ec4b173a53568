"""`snubber_boundaries`: where one regime of contact with the ring ends and another begins."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.models.rigs.data import one_number
from nonsmooth.models.snubber_ring import check_preload, regime_flags
from nonsmooth.real_numbers import finite_real

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["snubber_boundaries"]

_SIGNS = (1, -1)
_FEWEST = 3  # points of a curve
_MOST = 10**6
_NUMBERS = {"I": 1, "II": 2, "III": 3, "IV": 4, "V": 5}


class _Curve(NamedTuple):
    """Positions of the rotor, the equation, the regimes on either side, the side of the ring."""

    x: np.ndarray
    y: np.ndarray
    equation: int
    inner: str
    outer: str
    side_x: int
    side_y: int


def snubber_boundaries(
    *, delta_x: float = 0.1, delta_y: float = 0.1, extent: float = 2.0, points: int = 201
) -> xr.Dataset:
    r"""Boundaries between the regimes I to V over the positions of the rotor, Eqs. (62)-(66).

    Lengths are in units of the gap. In the first quadrant all four regimes of contact meet at the
    corner :math:`r_c = \Delta(1 + 1/|\Delta|)`; each equation holds on one side of it only, and
    only that piece is given, with its mirror images in the other quadrants.

    Parameters
    ----------
    delta_x, delta_y : float, optional
        Preload of the springs in x and y, zero or positive.
    extent : float, optional
        How far (65) and (66) are followed, in the displacement of the ring.
    points : int, optional
        Points of each curve.

    Returns
    -------
    xarray.Dataset
        ``x`` and ``y`` over ``curve`` and ``point``; for each curve its ``equation``, the regimes
        ``inner`` and ``outer`` of it, where inner is the one nearer to the centre or, for (65) and
        (66), the one in which one pair of springs is within its preload; ``side_x`` and ``side_y``
        tell to which sides the ring is displaced, 0 for both.

    Raises
    ------
    ModelError
        For a negative preload.
    OptionError
        For an extent within the corner, or too few points.

    See Also
    --------
    snubber_ring : regime of given positions.

    Notes
    -----
    The curves are written by the displacement t of the ring along them. On (63) the ring is at
    :math:`s = (\Delta_x, t)`, :math:`|t| \le \Delta_y`, and the rotor at
    :math:`s + s/|s|`; on (65) it is at :math:`s = (t, \Delta_y)`, :math:`t \ge \Delta_x`, and the
    rotor at :math:`s + n`, :math:`n` along :math:`(t + \Delta_x, 2\Delta_y)`. Without preload in
    a direction the curves that belong to it do not exist.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> curves = ns.models.snubber_boundaries(delta_x=0.1, delta_y=0.05)
    >>> [int((curves["equation"] == number).sum()) for number in range(62, 67)]
    [1, 2, 2, 4, 4]
    >>> ns.models.snubber_boundaries(delta_x=0.0, delta_y=0.0).sizes["curve"]
    1
    """
    import xarray as xr

    delta_x, delta_y = check_preload(delta_x, delta_y)
    corner = 1.0 + math.hypot(delta_x, delta_y)
    extent = one_number("extent", extent)
    if not extent >= corner:
        raise OptionError(
            f"extent = {extent:g} must not be below {corner:g}, where the corner is for delta_x ="
            f" {delta_x:g} and delta_y = {delta_y:g}"
        )
    given = finite_real("points", points)
    if given != int(given) or not _FEWEST <= given <= _MOST:
        raise OptionError(f"points = {given:g} must be a whole number from {_FEWEST} to {_MOST}")
    curves = list(_curves(delta_x, delta_y, extent, int(points)))
    flags = regime_flags()
    return xr.Dataset(
        {
            "x": (("curve", "point"), np.array([c.x for c in curves]), _length("x")),
            "y": (("curve", "point"), np.array([c.y for c in curves]), _length("y")),
            **{
                name: (
                    "curve",
                    np.array([_NUMBERS[getattr(c, name)] for c in curves], np.int8),
                    flags | {"long_name": f"regime on the {name} side"},
                )
                for name in ("inner", "outer")
            },
        },
        {
            "equation": ("curve", [c.equation for c in curves], {"long_name": "equation"}),
            "side_x": ("curve", [c.side_x for c in curves], {"long_name": "sign of sx, or 0"}),
            "side_y": ("curve", [c.side_y for c in curves], {"long_name": "sign of sy, or 0"}),
        },
        {"delta_x": delta_x, "delta_y": delta_y, "extent": float(extent)},
    )


def _curves(delta_x: float, delta_y: float, extent: float, points: int) -> Iterator[_Curve]:
    angle = np.linspace(0.0, 2.0 * math.pi, points)
    yield _Curve(np.cos(angle), np.sin(angle), 62, "I", _first(delta_x, delta_y), 0, 0)
    if delta_x > 0.0 and delta_y > 0.0:
        for sign in _SIGNS:
            x, y = _two_springs(delta_x, np.linspace(-delta_y, delta_y, points))
            yield _Curve(sign * x, y, 63, "II", "III", sign, 0)
        for sign in _SIGNS:
            y, x = _two_springs(delta_y, np.linspace(-delta_x, delta_x, points))
            yield _Curve(x, sign * y, 64, "II", "IV", 0, sign)
    if delta_y > 0.0:
        x, y = _one_spring(_spread(delta_x, extent, points), delta_x, delta_y)
        for side_x in _SIGNS:
            for side_y in _SIGNS:
                yield _Curve(side_x * x, side_y * y, 65, "III", "V", side_x, side_y)
    if delta_x > 0.0:
        y, x = _one_spring(_spread(delta_y, extent, points), delta_y, delta_x)
        for side_x in _SIGNS:
            for side_y in _SIGNS:
                yield _Curve(side_x * x, side_y * y, 66, "IV", "V", side_x, side_y)


def _first(delta_x: float, delta_y: float) -> str:
    """Regime in which a contact begins."""
    if delta_x > 0.0:
        return "II" if delta_y > 0.0 else "IV"
    return "III" if delta_y > 0.0 else "V"


def _two_springs(delta: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotor for the ring at (delta, t), all springs at work."""
    growth = 1.0 + 1.0 / np.hypot(delta, t)
    return delta * growth, t * growth


def _one_spring(t: np.ndarray, along: float, across: float) -> tuple[np.ndarray, np.ndarray]:
    """Rotor for the ring at (t, across), one spring along t and two, just still, across."""
    normal = np.hypot(t + along, 2.0 * across)
    return t + (t + along) / normal, across + 2.0 * across / normal


def _spread(first: float, last: float, points: int) -> np.ndarray:
    """Displacements closer together near the corner, where the curves bend."""
    return first + (last - first) * np.linspace(0.0, 1.0, points) ** 2


def _length(axis: str) -> dict[str, str]:
    return {"long_name": f"position of the rotor in {axis}", "units": "dimensionless"}
