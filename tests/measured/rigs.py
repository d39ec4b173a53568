"""Motions known in closed form, as a recorder would have seen them."""

from __future__ import annotations

import numpy as np

AMPLITUDES = {1: 0.8, 2: 0.25, 3: 0.1}  # mm, by harmonic
PHASES = {1: 0.3, 2: 1.1, 3: -0.7}
SPEED = 2 * np.pi * 15.0  # rad/s


def derivative(t, order: int):
    """Displacement in mm, or one of its derivatives."""
    return sum(
        a * (j * SPEED) ** order * np.cos(j * SPEED * t + PHASES[j] + order * np.pi / 2)
        for j, a in AMPLITUDES.items()
    )


def largest(order: int) -> float:
    """Bound of a derivative."""
    return sum(a * (j * SPEED) ** order for j, a in AMPLITUDES.items())


def jittering_marks(count: int, seed: int = 3) -> np.ndarray:
    """Times of revolutions whose lengths scatter by half a per cent."""
    lengths = 2 * np.pi / SPEED * (1 + 0.005 * np.random.default_rng(seed).standard_normal(count))
    return 0.05 + np.cumsum(lengths)


def pulses(times, marks, rise: float, width: float = 6e-3, high: float = 5.0):
    """Pulses whose edges rise linearly within ``rise`` and pass the middle at the marks."""
    since = times[:, None] - marks[None, :]
    up = np.clip(since / rise + 0.5, 0, 1)
    down = np.clip((since - width) / rise + 0.5, 0, 1)
    return high * (up - down).sum(axis=1)
