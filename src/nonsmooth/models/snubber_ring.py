"""`snubber_ring`: position, force, energy and regime of the preloaded ring for rotor positions.

All lengths are in units of the gap. With a and b springs at work in x and y, and mu the
Lagrange multiplier of |r - s| = 1 over the stiffness of the ring, the least elastic energy is at

    a s_x + (2 - a) sgn(s_x) Delta_x = mu (x - s_x),   likewise in y with b,

so that d = r - s has the components a X/(a + mu) and b Y/(b + mu), where X is |x| + Delta_x for
one spring and |x| for two. The springs at work follow from the position before mu is known.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.errors import ModelError, OptionError
from nonsmooth.real_numbers import check_size, finite_numbers, finite_real

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["check_preload", "check_ring", "regime_flags", "snubber_ring"]

Array = np.ndarray

_LABELS = {
    "x": "position of the rotor in x",
    "y": "position of the rotor in y",
    "sx": "displacement of the ring in x",
    "sy": "displacement of the ring in y",
    "mu": "multiplier of the contact over the stiffness of the ring",
    "ring_vx": "velocity of the ring in x",
    "ring_vy": "velocity of the ring in y",
    "force_x": "force of the rotor on the ring in x",
    "force_y": "force of the rotor on the ring in y",
    "force": "force of the rotor on the ring",
    "normal_force": "component of the force along the normal",
    "contact_angle": "direction from ring to rotor",
    "energy": "elastic energy of the ring",
}
_REGIMES = ("I", "II", "III", "IV", "V")
_NEWTON = 60  # steps at most; five or six are taken


def snubber_ring(
    x: ArrayLike,
    y: ArrayLike,
    vx: ArrayLike | None = None,
    vy: ArrayLike | None = None,
    *,
    K: float = 30.0,
    nu2: float = 0.002,
    delta_x: float = 0.1,
    delta_y: float = 0.1,
) -> xr.Dataset:
    r"""Preloaded snubber ring for given positions of the rotor, by least elastic energy.

    Lengths are in units of the gap :math:`\gamma`, forces of :math:`k_r\gamma`, energies of
    :math:`k_r\gamma^2`, times of one over the natural frequency of the rotor; the origin is the
    centre of the ring at rest. A rotor at least the gap away from it is taken to be in contact.

    Parameters
    ----------
    x, y : array_like or xarray.DataArray
        Positions of the rotor, of shapes that can be broadcast; a DataArray keeps its dimensions.
    vx, vy : array_like or xarray.DataArray, optional
        Velocities of the rotor; with them the force has its dissipative part.
    K : float, optional
        Stiffness of one spring of the ring over that of the rotor.
    nu2 : float, optional
        Damping ratio of one damper of the ring; without velocities it plays no part.
    delta_x, delta_y : float, optional
        Preload of the springs in x and y, zero or positive. With none there is one spring at a
        time in that direction, so with none at all the only regimes are I and V.

    Returns
    -------
    xarray.Dataset
        ``sx`` and ``sy``, ``mu``, ``regime`` (1 to 5 with the names I to V as CF flags),
        ``force_x`` and ``force_y``, the restraining force of Eq. (59), ``force``, its magnitude,
        ``normal_force``, ``contact_angle``, the direction of r - s, ``energy``; with velocities
        ``ring_vx`` and ``ring_vy``; the positions as coordinates. Where there is no contact the
        ring is at its centre and all of these but the angle are zero. A negative
        ``normal_force`` tells that the rotor leaves the ring.

    Raises
    ------
    ModelError
        For a negative preload, ``K`` that is not positive, or a negative ``nu2``.
    OptionError
        For arguments that are not finite real numbers, or positions and velocities that do not
        fit together.

    See Also
    --------
    snubber_boundaries : where one regime ends and another begins.
    static_contact : where a rotor that does not turn rests.

    Notes
    -----
    In regimes II and V the multiplier has a closed form. The quartics of the chapter's Table 6,
    for III and IV, become one equation in the multiplier, monotone and convex, so that there is
    one root. A point on a boundary counts to the regime with more springs.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ring = ns.models.snubber_ring([0.5, 1.05, 1.5], [0.0, 0.0, 0.2])
    >>> ring["regime"].values
    array([1, 2, 3], dtype=int8)
    >>> [round(float(value), 6) for value in ring["force"]]
    [0.0, 3.0, 18.569826]
    """
    import xarray as xr

    K, nu2 = check_ring(K, nu2)
    delta_x, delta_y = check_preload(delta_x, delta_y)
    if (vx is None) != (vy is None):
        raise OptionError("one velocity only: give vx and vy, or neither")
    given = {"x": x, "y": y} if vx is None or vy is None else {"x": x, "y": y, "vx": vx, "vy": vy}
    dims, coords, arrays = _broadcast(given)
    ring = _ring_position(arrays["x"], arrays["y"], delta_x, delta_y)
    variables = _statics(ring, K, delta_x, delta_y)
    if vx is not None:
        rate = _ring_rate(ring, arrays["vx"], arrays["vy"])
        variables |= {"ring_vx": rate.vx, "ring_vy": rate.vy}
        variables["force_x"] = variables["force_x"] + 2.0 * nu2 * ring.springs_x * rate.vx
        variables["force_y"] = variables["force_y"] + 2.0 * nu2 * ring.springs_y * rate.vy
    variables["force"] = np.hypot(variables["force_x"], variables["force_y"])
    variables["normal_force"] = variables["force_x"] * ring.dx + variables["force_y"] * ring.dy
    data = xr.Dataset(
        {name: (dims, values, _attributes(name)) for name, values in variables.items()},
        coords,
        {"K": K, "delta_x": delta_x, "delta_y": delta_y} | ({} if vx is None else {"nu2": nu2}),
    )
    data["regime"] = (dims, ring.regime, regime_flags())
    return data.assign_coords({n: (dims, arrays[n], _attributes(n)) for n in ("x", "y")})


def _statics(
    ring: _RingPosition, K: float, delta_x: float, delta_y: float
) -> dict[str, np.ndarray]:
    energy_x = _ring_energy(ring.sx, ring.springs_x, delta_x)
    energy_y = _ring_energy(ring.sy, ring.springs_y, delta_y)
    return {
        "sx": ring.sx,
        "sy": ring.sy,
        "mu": ring.mu,
        "force_x": K * ring.mu * ring.dx,
        "force_y": K * ring.mu * ring.dy,
        "energy": np.where(ring.touching, K * (energy_x + energy_y), 0.0),
        "contact_angle": np.arctan2(ring.dy, ring.dx),
    }


def regime_flags() -> dict[str, Any]:
    """Attributes of a variable that holds regimes as numbers."""
    return {
        "long_name": "regime of contact",
        "flag_values": np.arange(1, 1 + len(_REGIMES), dtype=np.int8),
        "flag_meanings": " ".join(_REGIMES),
    }


def check_ring(K: float, nu2: float = 0.0) -> tuple[float, float]:
    """Stiffness and damping as numbers; those that no ring has are refused."""
    stiffness, damping = _number("K", K), _number("nu2", nu2)
    if stiffness <= 0.0:
        raise ModelError(f"K = {stiffness:g} must be positive: the ring stands on springs")
    if damping < 0.0:
        raise ModelError(f"nu2 = {damping:g} must not be negative: a damper takes energy out")
    return stiffness, damping


def check_preload(delta_x: float, delta_y: float) -> tuple[float, float]:
    """Preloads as numbers; those that the formulas do not cover are refused."""
    x, y = _number("delta_x", delta_x), _number("delta_y", delta_y)
    for name, value in (("delta_x", x), ("delta_y", y)):
        if value < 0.0:
            raise ModelError(
                f"{name} = {value:g} must not be negative: a preload presses the springs on the"
                " ring; with 0 they just touch it"
            )
    return x, y


def _number(name: str, value: Any) -> float:
    number = finite_real(name, value, ModelError)
    check_size(name, number, ModelError)
    return number


def _attributes(name: str) -> dict[str, str]:
    return {
        "long_name": _LABELS[name],
        "units": "rad" if name == "contact_angle" else "dimensionless",
    }


def _broadcast(
    given: dict[str, Any],
) -> tuple[tuple[Any, ...], dict[Any, Any], dict[str, np.ndarray]]:
    """Dimensions, their coordinates, and the arrays in one shape, checked."""
    import xarray as xr

    labelled = any(isinstance(values, xr.DataArray) for values in given.values())
    if labelled:
        try:
            together = xr.broadcast(*map(_labelled, given.values()))
        except ValueError as error:
            raise OptionError(f"{_names(given)} do not fit together: {error}") from None
        coords = {n: c for n, c in together[0].coords.items() if n not in ("x", "y")}
        dims: tuple[Any, ...] = together[0].dims
        if clash := {"x", "y"} & set(dims):
            raise OptionError(
                f"dimensions {sorted(clash)} would have the names of the positions; rename them"
            )
        found = [_finite(n, v.values) for n, v in zip(given, together, strict=True)]
        return dims, coords, dict(zip(given, found, strict=True))
    arrays = [_finite(name, values) for name, values in given.items()]
    try:
        same = np.broadcast_arrays(*arrays)
    except ValueError:
        shapes = ", ".join(f"{n} {v.shape}" for n, v in zip(given, arrays, strict=True))
        raise OptionError(f"shapes cannot be broadcast: {shapes}") from None
    count = same[0].ndim
    dims = ("point",) if count == 1 else tuple(f"axis_{i}" for i in range(count))
    return dims, {}, dict(zip(given, same, strict=True))


def _labelled(values: Any) -> xr.DataArray:
    import xarray as xr

    if isinstance(values, xr.DataArray):
        return values
    if np.ndim(values):
        raise OptionError("an array beside a DataArray has no dimensions; make all DataArrays")
    return xr.DataArray(values)


def _names(given: dict[str, Any]) -> str:
    return ", ".join(given)


def _finite(name: str, values: Any) -> np.ndarray:
    array = finite_numbers(name, values)
    check_size(name, max(float(np.abs(array).max(initial=0.0)), 1.0))
    return array


@dataclass(frozen=True)
class _RingPosition:
    """Ring below rotor positions: springs at work, multiplier, normal d = r - s, position s."""

    touching: Array
    springs_x: Array
    springs_y: Array
    mu: Array
    dx: Array
    dy: Array
    sx: Array
    sy: Array

    @property
    def regime(self) -> Array:
        """Regimes I to V as 1 to 5."""
        pushed_x, pushed_y = self.springs_x == 1, self.springs_y == 1
        number = 2 + pushed_x.astype(np.int8) + 2 * pushed_y.astype(np.int8)
        return np.where(self.touching, number, 1).astype(np.int8)


@dataclass(frozen=True)
class _RingRate:
    """Velocity of a ring in contact."""

    vx: Array
    vy: Array


def _ring_position(x: Array, y: Array, delta_x: float, delta_y: float) -> _RingPosition:
    """Ring of least elastic energy at |r - s| = 1; at its centre where the rotor is inside."""
    p, q = np.abs(x), np.abs(y)
    touching = np.hypot(p, q) >= 1.0
    a = _springs(p, q, delta_x, delta_y)
    b = _springs(q, p, delta_y, delta_x)
    shifted_x, shifted_y = np.where(a == 1, p + delta_x, p), np.where(b == 1, q + delta_y, q)
    mu = _multiplier(a, b, shifted_x, shifted_y)
    mu = np.where(touching, np.maximum(mu, 0.0), 0.0)
    dx = np.where(touching, a * shifted_x / (a + mu), p)
    dy = np.where(touching, b * shifted_y / (b + mu), q)
    sign_x, sign_y = np.sign(x), np.sign(y)
    return _RingPosition(
        touching, a, b, mu, sign_x * dx, sign_y * dy, sign_x * (p - dx), sign_y * (q - dy)
    )


def _ring_rate(ring: _RingPosition, vx: Array, vy: Array) -> _RingRate:
    """Velocity of the ring, from the time derivatives of its equations; zero without contact."""
    weight_x, weight_y = 1.0 / (ring.springs_x + ring.mu), 1.0 / (ring.springs_y + ring.mu)
    dx, dy = ring.dx, ring.dy
    # mu' of d.s' = d.v; the terms with mu are taken together, so nothing cancels for a stiff ring
    pressing = ring.springs_x * weight_x * dx * vx + ring.springs_y * weight_y * dy * vy
    length = weight_x * dx**2 + weight_y * dy**2
    with np.errstate(invalid="ignore", divide="ignore"):
        mu_rate = np.where(ring.touching, pressing / length, 0.0)
    return _RingRate(
        np.where(ring.touching, weight_x * (mu_rate * dx + ring.mu * vx), 0.0),
        np.where(ring.touching, weight_y * (mu_rate * dy + ring.mu * vy), 0.0),
    )


def _ring_energy(s: Array, springs: Array, delta: float) -> Array:
    """Elastic energy of one axis over the stiffness of one spring: Table 5, corrected."""
    return np.where(springs == 2, s**2, 0.5 * s**2 + delta * np.abs(s) - 0.5 * delta**2)


def _springs(p: Array, q: Array, delta: float, other: float) -> Array:
    """Springs at work along p: one where the ring goes beyond the preload of that axis.

    At the multiplier that puts the ring exactly there the normal is (p - delta)(1, slope), with
    the smaller of the slopes that one or two springs along q give. Is it longer than the gap, then
    the multiplier must grow on. Its length is one on the curves (63), (64) and (65), (66).
    """
    if delta == 0.0:
        return np.ones(p.shape, np.int8)  # a spring without preload leaves the ring at once
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):  # no slope: p is zero
        slope = np.minimum(q / p, (q + other) / (p + delta))
        beyond = (p > delta) & ((p - delta) * np.hypot(1.0, slope) > 1.0)
    return np.where(beyond, 1, 2).astype(np.int8)


def _multiplier(a: Array, b: Array, shifted_x: Array, shifted_y: Array) -> Array:
    """Closed forms for equal numbers of springs; else Newton's method from below.

    The square of the normal falls with mu and is convex; at the closed form for one spring each
    it is not below one, so the steps go up to the root and cannot pass it.
    """
    length = np.hypot(shifted_x, shifted_y)
    mu = np.where((a == 2) & (b == 2), 2.0 * (length - 1.0), length - 1.0)
    mixed = (a != b) & (length > 1.0)
    if not mixed.any():
        return mu
    a, b, value = a[mixed], b[mixed], mu[mixed]
    across, along = a * shifted_x[mixed], b * shifted_y[mixed]
    for _ in range(_NEWTON):
        square_x, square_y = (across / (a + value)) ** 2, (along / (b + value)) ** 2
        slope = 2.0 * (square_x / (a + value) + square_y / (b + value))
        step = (square_x + square_y - 1.0) / slope
        value = value + step
        if np.all(np.abs(step) <= 1e-15 * (1.0 + value)):
            break
    mu[mixed] = value
    return mu
