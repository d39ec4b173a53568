"""`static_contact`: where a rotor that does not turn rests on its snubber ring."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.models.rigs.data import one_number
from nonsmooth.models.snubber_ring import check_preload, check_ring, snubber_ring

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["static_contact"]


def static_contact(
    *,
    K: float = 30.0,
    eps_x: float = 0.9,
    eps_y: float = 0.0,
    delta_x: float = 0.1,
    delta_y: float = 0.1,
) -> xr.Dataset:
    r"""Equilibrium of the rotor at rest: at its eccentricity, or against the ring beyond the gap.

    Parameters
    ----------
    K : float, optional
        Stiffness of one spring of the ring over that of the rotor.
    eps_x, eps_y : float, optional
        Eccentricity in units of the gap: where the rotor would be without a ring.
    delta_x, delta_y : float, optional
        Preload of the springs in x and y, zero or positive.

    Returns
    -------
    xarray.Dataset
        ``x`` and ``y`` of the rotor, ``contact``, which tells whether it rests on the ring, and
        the variables of `snubber_ring` there.

    Raises
    ------
    ModelError
        For a negative preload, or ``K`` that is not positive.
    OptionError
        For an eccentricity that is not finite.

    See Also
    --------
    snubber_ring : the ring at given positions of the rotor.

    Notes
    -----
    The energy of rotor and ring is convex and so is the ring's inside, hence there is one
    equilibrium. With the force f of the contact, along the unit normal n,

    .. math::

        \varepsilon = s + (1 + f) n, \qquad
        K [a s_x + (2 - a) \mathrm{sgn}(s_x) \Delta_x] = f n_x,

    in y likewise, and f is the root of :math:`|n(f)| = 1` between 0 and
    :math:`|\varepsilon| - 1`, found by Brent's method.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> rest = ns.models.static_contact(eps_x=1.5, eps_y=0.2)
    >>> bool(rest["contact"]), round(float(rest["x"]), 6), round(float(rest["force"]), 6)
    (True, 0.999568, 0.50486)
    >>> bool(ns.models.static_contact(eps_x=0.9)["contact"])
    False
    """
    K, _ = check_ring(K)
    delta_x, delta_y = check_preload(delta_x, delta_y)
    eps_x, eps_y = one_number("eps_x", eps_x), one_number("eps_y", eps_y)
    distance = math.hypot(eps_x, eps_y)
    x, y = float(eps_x), float(eps_y)
    if distance > 1.0:
        force = _force(K, (abs(x), abs(y)), (delta_x, delta_y))
        x -= force * math.copysign(_normal(force, K, abs(x), delta_x), x)
        y -= force * math.copysign(_normal(force, K, abs(y), delta_y), y)
    data = snubber_ring(x, y, K=K, delta_x=delta_x, delta_y=delta_y).reset_coords()
    data["contact"] = ((), np.bool_(distance >= 1.0), {"long_name": "whether rotor touches ring"})
    data.attrs |= {"eps_x": float(eps_x), "eps_y": float(eps_y)}
    return data


def _force(K: float, eps: tuple[float, float], delta: tuple[float, float]) -> float:
    from scipy.optimize import brentq

    def excess(force: float) -> float:
        parts = (_normal(force, K, e, d) for e, d in zip(eps, delta, strict=True))
        return math.hypot(*parts) - 1.0

    # each part of the normal is at most eps/(1 + f), so that at this force it is no longer than 1
    most = math.hypot(*eps) - 1.0
    if excess(most) >= 0.0:  # by rounding
        return most
    return float(brentq(excess, 0.0, most, xtol=1e-16 * most, rtol=1e-15))


def _normal(force: float, K: float, eps: float, delta: float) -> float:
    """Component of r - s along an axis at a force: of two springs, or less of one beyond Delta."""
    across, spread = K * eps, K * (1.0 + force)
    return min(2.0 * across / (2.0 * spread + force), (across + K * delta) / (spread + force))
