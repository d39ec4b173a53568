"""Where a massless snubber ring stands that a rotor presses on: formulas for arrays of positions.

All lengths are in units of the gap. With a and b springs at work in x and y, and mu the
Lagrange multiplier of |r - s| = 1 over the stiffness of the ring, the least elastic energy is at

    a s_x + (2 - a) sgn(s_x) Delta_x = mu (x - s_x),   likewise in y with b,

so that d = r - s has the components a X/(a + mu) and b Y/(b + mu), where X is |x| + Delta_x for
one spring and |x| for two. The springs at work follow from the position before mu is known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["REGIMES", "RingPosition", "RingRate", "ring_energy", "ring_position", "ring_rate"]

Array = np.ndarray

REGIMES = ("I", "II", "III", "IV", "V")
_NEWTON = 60  # steps at most; five or six are taken


@dataclass(frozen=True)
class RingPosition:
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
class RingRate:
    """Velocity of a ring in contact."""

    vx: Array
    vy: Array


def ring_position(x: Array, y: Array, delta_x: float, delta_y: float) -> RingPosition:
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
    return RingPosition(
        touching, a, b, mu, sign_x * dx, sign_y * dy, sign_x * (p - dx), sign_y * (q - dy)
    )


def ring_rate(ring: RingPosition, vx: Array, vy: Array) -> RingRate:
    """Velocity of the ring, from the time derivatives of its equations; zero without contact."""
    weight_x, weight_y = 1.0 / (ring.springs_x + ring.mu), 1.0 / (ring.springs_y + ring.mu)
    dx, dy = ring.dx, ring.dy
    # mu' of d.s' = d.v; the terms with mu are taken together, so nothing cancels for a stiff ring
    pressing = ring.springs_x * weight_x * dx * vx + ring.springs_y * weight_y * dy * vy
    length = weight_x * dx**2 + weight_y * dy**2
    with np.errstate(invalid="ignore", divide="ignore"):
        mu_rate = np.where(ring.touching, pressing / length, 0.0)
    return RingRate(
        np.where(ring.touching, weight_x * (mu_rate * dx + ring.mu * vx), 0.0),
        np.where(ring.touching, weight_y * (mu_rate * dy + ring.mu * vy), 0.0),
    )


def ring_energy(s: Array, springs: Array, delta: float) -> Array:
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
