"""Rates of change at one instant, and how far each coordinate moves."""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import inlined, kernel

__all__ = ["fill_scale", "fill_velocity", "velocity_of"]


@kernel
def fill_velocity(n, generator, affine, wiring, m, z, velocity):
    """Rates of all augmented coordinates in a mode; slaved states follow their relation."""
    n_exits = wiring.shape[1] - 1
    slaved = wiring[m, 0, at.SLAVED]
    for i in range(z.size):
        total = 0.0
        for j in range(z.size):
            total += generator[m, i, j] * z[j]
        velocity[i] = total
    for i in range(n):
        if (slaved >> i) & 1:
            row = at.relation_row(n_exits, i)
            total = 0.0
            for j in range(z.size):
                if j >= n or not (slaved >> j) & 1:
                    total += affine[m, row, j] * velocity[j]
            velocity[i] = total


@inlined
def velocity_of(n, generator, affine, wiring, m, z, i):
    """Rate of one augmented coordinate in a mode."""
    slaved = wiring[m, 0, at.SLAVED]
    if not (i < n and (slaved >> i) & 1):
        return _rate(generator, m, z, i)
    row, total = at.relation_row(wiring.shape[1] - 1, i), 0.0
    for j in range(z.size):
        if affine[m, row, j] != 0.0 and (j >= n or not (slaved >> j) & 1):
            total += affine[m, row, j] * _rate(generator, m, z, j)
    return total


@kernel
def _rate(generator, m, z, i):
    total = 0.0
    for j in range(z.size):
        total += generator[m, i, j] * z[j]
    return total


@kernel
def fill_scale(n, generator, affine, wiring, m, z, duration, scale):
    """What counts as large for each coordinate: where it is and how far it goes in a while."""
    for i in range(z.size):
        velocity = velocity_of(n, generator, affine, wiring, m, z, i)
        scale[i] = abs(z[i]) + abs(velocity) * duration
