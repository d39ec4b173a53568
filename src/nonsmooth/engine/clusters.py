"""Clusters: slots whose eigenvalues are too close to be told apart.

Together they move as exp(mu s) times a polynomial in s: rigid-body chains, critical
damping, resonance. The coefficients of the polynomial are made once per segment.
"""

from __future__ import annotations

import math

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.trigonometry import cos_sin

__all__ = ["advance_cluster", "start_cluster"]


@kernel
def start_cluster(spectrum, nilpotent, slots, m, c, origin, now, chain, chain_noise, length, reach):
    """Coefficients of exp(N s) w in powers of s, and bounds over the segment.

    shapes: as in Tables and Segment; length bounds the segment, moduli of growing clusters
    hold up to reach ahead
    """
    first = slots[m, at.CLUSTERS + 3 * c]
    end = first + slots[m, at.CLUSTERS + 3 * c + 1]
    degree = slots[m, at.CLUSTERS + 3 * c + 2]
    for a in range(first, end):
        chain[0, a] = complex(origin[a, at.RE], origin[a, at.IM])
        chain_noise[0, a] = origin[a, at.NOISE]
    for d in range(1, degree + 1):
        for a in range(first, end):
            total = complex(0.0, 0.0)
            noise = 0.0
            for b in range(first, end):
                total += nilpotent[m, a, b] * chain[d - 1, b]
                noise += abs(nilpotent[m, a, b]) * chain_noise[d - 1, b]
            chain[d, a] = total / d
            chain_noise[d, a] = noise / d
    growth = math.exp(max(0.0, spectrum[m, first].real) * reach)
    for a in range(first, end):
        bound = 0.0
        for d in range(degree, -1, -1):
            bound = bound * length + abs(chain[d, a])
        origin[a, at.SIZE] = bound * growth
        now[a, at.SIZE] = bound * growth


@kernel
def advance_cluster(spectrum, slots, m, c, origin, now, chain, chain_noise, s):
    """Slots of a cluster at s, with bounds of their moduli and rounding margins."""
    first = slots[m, at.CLUSTERS + 3 * c]
    end = first + slots[m, at.CLUSTERS + 3 * c + 1]
    degree = slots[m, at.CLUSTERS + 3 * c + 2]
    mean = spectrum[m, first]
    cos, sin, decay = 1.0, 0.0, 1.0
    if mean.real != 0.0 or mean.imag != 0.0:
        decay = math.exp(mean.real * s)
        cos, sin = cos_sin(mean.imag * s)
        cos, sin = decay * cos, decay * sin
    for a in range(first, end):
        re, im, noise = 0.0, 0.0, 0.0
        for d in range(degree, -1, -1):
            re = re * s + chain[d, a].real
            im = im * s + chain[d, a].imag
            noise = noise * s + chain_noise[d, a]
        now[a, at.RE] = re * cos - im * sin
        now[a, at.IM] = re * sin + im * cos
        now[a, at.SIZE] = origin[a, at.SIZE] * decay
        now[a, at.NOISE] = noise * decay
