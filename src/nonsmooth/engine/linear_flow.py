"""The exact flow of a linear mode in modal coordinates.

A segment starts with `start_segment`; after that `advance` gives the modal coordinates
at any s by closed form, always from the start of the segment, so that nothing
accumulates, and `state_at` turns them into states.
"""

from __future__ import annotations

import math

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import inlined, kernel
from nonsmooth.engine.trigonometry import cos_sin

__all__ = ["advance", "advance_little", "advance_once", "augmented", "start_segment", "state_at"]

_TURN = 2.0 * math.pi


@kernel
def augmented(n, powers, window, harmonics, number, phase, z):
    """Fill 1, powers of time and harmonics of the augmented coordinates at a phase.

    shapes: harmonics (2, K), z (N,); the states in its first n entries are left alone

    Angles come from the phase within the window and the fraction of a turn that whole
    windows leave over, so they lose nothing however many periods have passed.
    """
    z[n] = 1.0
    if powers > 0:
        time = number * window + phase
        for j in range(1, powers + 1):
            z[n + j] = z[n + j - 1] * time
    for k in range(harmonics.shape[1]):
        turns = harmonics[1, k] * number
        angle = _TURN * (turns - math.floor(turns)) + harmonics[0, k] * phase
        z[n + 1 + powers + 2 * k], z[n + 2 + powers + 2 * k] = cos_sin(angle)


@kernel
def start_segment(flow, bounds, slots, unit, reach, m, z, modal, sizes, length):
    """Modal coordinates, their moduli and rounding margins at the start of a segment.

    shapes: sheets as in Tables, z (N,), modal and sizes as in Segment; length bounds the
    segment, unit scales the margins, moduli hold up to reach ahead
    """
    count = slots[m, at.COUNT]
    for j in range(count):
        re, im, noise = 0.0, 0.0, 0.0
        for i in range(z.size):
            weight = flow[m, at.modal_row(i), j]
            re += weight.real * z[i]
            im += weight.imag * z[i]
            noise += bounds[m, i, j] * abs(z[i])
        modal[at.START, j] = complex(re, im)
        modal[at.NOW, j] = complex(re, im)
        sizes[at.NOISE_START, j] = noise * unit
        sizes[at.NOISE, j] = noise * unit
        size = math.sqrt(re * re + im * im)
        growth = flow[m, 0, j].real
        if growth > 0.0:
            size *= math.exp(growth * min(reach, length))
        sizes[at.SIZE_START, j] = size
        sizes[at.SIZE_NOW, j] = size
    for c in range(slots[m, at.N_CLUSTERS]):
        _start_cluster(flow, slots, m, c, modal, sizes, length, min(reach, length))


@kernel
def _start_cluster(flow, slots, m, c, modal, sizes, length, reach):
    """Coefficients of exp(N s) w in powers of s, and bounds over the segment."""
    first = slots[m, at.CLUSTERS + 3 * c]
    end = first + slots[m, at.CLUSTERS + 3 * c + 1]
    degree = slots[m, at.CLUSTERS + 3 * c + 2]
    rest = flow.shape[1] - flow.shape[2]  # the nilpotent rows come last
    for a in range(first, end):
        modal[at.CHAIN, a] = modal[at.START, a]
        sizes[at.CHAIN_NOISE, a] = sizes[at.NOISE_START, a]
    for d in range(1, degree + 1):
        for a in range(first, end):
            total = complex(0.0, 0.0)
            noise = 0.0
            for b in range(a, end):
                total += flow[m, rest + a, b] * modal[at.CHAIN + d - 1, b]
                noise += abs(flow[m, rest + a, b]) * sizes[at.CHAIN_NOISE + d - 1, b]
            modal[at.CHAIN + d, a] = total / d
            sizes[at.CHAIN_NOISE + d, a] = noise / d
    growth = math.exp(max(0.0, flow[m, 0, first].real) * reach)
    for a in range(first, end):
        bound = 0.0
        for d in range(degree, -1, -1):
            bound = bound * length + abs(modal[at.CHAIN + d, a])
        sizes[at.SIZE_START, a] = bound * growth
        sizes[at.SIZE_NOW, a] = bound * growth


@inlined
def advance(flow, slots, m, modal, sizes, s):
    """Modal coordinates at s, bounds of their moduli ahead of s, rounding margins at s."""
    for j in range(slots[m, at.END_CONSTANT], slots[m, at.END_REAL]):
        rate = flow[m, 0, j].real
        decay = math.exp(rate * s)
        w = modal[at.START, j]
        modal[at.NOW, j] = complex(w.real * decay, w.imag * decay)
        sizes[at.SIZE_NOW, j] = sizes[at.SIZE_START, j] * decay
        sizes[at.NOISE, j] = sizes[at.NOISE_START, j] * decay
    for j in range(slots[m, at.END_REAL], slots[m, at.END_ROTATION]):
        cos, sin = cos_sin(flow[m, 0, j].imag * s)
        modal[at.NOW, j] = _turned(modal[at.START, j], cos, sin)
    for j in range(slots[m, at.END_ROTATION], slots[m, at.END_DAMPED]):
        rate = flow[m, 0, j].real
        decay = math.exp(rate * s)
        cos, sin = cos_sin(flow[m, 0, j].imag * s)
        modal[at.NOW, j] = _turned(modal[at.START, j], decay * cos, decay * sin)
        sizes[at.SIZE_NOW, j] = sizes[at.SIZE_START, j] * decay
        sizes[at.NOISE, j] = sizes[at.NOISE_START, j] * decay
    for c in range(slots[m, at.N_CLUSTERS]):
        _advance_cluster(flow, slots, m, c, modal, sizes, s)


@kernel
def advance_once(flow, slots, m, modal, sizes, s):
    """`advance` as a call, for the places that are rarely passed: its body is long."""
    advance(flow, slots, m, modal, sizes, s)


@kernel
def advance_little(flow, slots, m, modal, sizes, s, step):
    """Modal coordinates at s + step from those at s, for a step that turns them by little.

    Third-order Taylor factor: for |eigenvalue step| <= 1e-4 its error is below rounding.
    """
    for j in range(slots[m, at.END_CONSTANT], slots[m, at.END_DAMPED]):
        x, y = flow[m, 0, j].real * step, flow[m, 0, j].imag * step
        square_re, square_im = x * x - y * y, 2.0 * x * y
        cube_re, cube_im = square_re * x - square_im * y, square_re * y + square_im * x
        cos = 1.0 + (x + (0.5 * square_re + cube_re / 6.0))
        sin = y + (0.5 * square_im + cube_im / 6.0)
        modal[at.NOW, j] = _turned(modal[at.NOW, j], cos, sin)
    for c in range(slots[m, at.N_CLUSTERS]):
        _advance_cluster(flow, slots, m, c, modal, sizes, s + step)


@kernel
def _turned(w, cos, sin):
    return complex(w.real * cos - w.imag * sin, w.real * sin + w.imag * cos)


@kernel
def _advance_cluster(flow, slots, m, c, modal, sizes, s):
    first = slots[m, at.CLUSTERS + 3 * c]
    end = first + slots[m, at.CLUSTERS + 3 * c + 1]
    degree = slots[m, at.CLUSTERS + 3 * c + 2]
    mean = flow[m, 0, first]
    cos, sin, decay = 1.0, 0.0, 1.0
    if mean.real != 0.0 or mean.imag != 0.0:
        decay = math.exp(mean.real * s)
        cos, sin = cos_sin(mean.imag * s)
        cos, sin = decay * cos, decay * sin
    for a in range(first, end):
        re, im, noise = 0.0, 0.0, 0.0
        for d in range(degree, -1, -1):
            re = re * s + modal[at.CHAIN + d, a].real
            im = im * s + modal[at.CHAIN + d, a].imag
            noise = noise * s + sizes[at.CHAIN_NOISE + d, a]
        modal[at.NOW, a] = _turned(complex(re, im), cos, sin)
        sizes[at.SIZE_NOW, a] = sizes[at.SIZE_START, a] * decay
        sizes[at.NOISE, a] = noise * decay


@kernel
def state_at(flow, slots, m, modal, out_state):
    """States from the current modal coordinates; slaved ones follow their relation.

    shapes: out_state (n,) or longer, its first n entries are set
    """
    big_n = flow.shape[2]
    for i in range(out_state.size):
        total = 0.0
        for j in range(slots[m, at.COUNT]):
            weight = flow[m, at.state_row(big_n, i), j]
            value = modal[at.NOW, j]
            total += weight.real * value.real - weight.imag * value.imag
        out_state[i] = total
