"""The exact flow of a linear mode in modal slots.

A segment starts with `start_segment`; after that `advance` gives the slots at any s by
closed form, always from the start of the segment, so that nothing accumulates, and
`state_at` turns them into states. Where only the next look at a guard is wanted,
`climb` turns the slots by factors computed beforehand.
"""

from __future__ import annotations

import math

from nonsmooth.engine import layout as at
from nonsmooth.engine.clusters import advance_cluster, start_cluster
from nonsmooth.engine.jit import inlined, kernel
from nonsmooth.engine.trigonometry import cos_sin

__all__ = [
    "advance",
    "advance_little",
    "augmented",
    "climb",
    "start_segment",
    "state_at",
]

_TURN = 2.0 * math.pi
_NOTHING = 1e-290  # a motion that has faded so far loses its digits, and is gone


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


@inlined
def start_segment(tables, segment, m, length):
    """Slots, bounds of their moduli and rounding margins at the start of a segment.

    shapes: segment.z holds the augmented coordinates; length bounds the segment
    """
    entry, spectrum, slots = tables.entry, tables.spectrum, tables.slots
    origin, now, z = segment.origin, segment.now, segment.z
    unit = tables.spans[m, at.ROUNDING]
    reach = min(tables.spans[m, at.REACH], length)
    for j in range(slots[m, at.COUNT]):
        re, im, noise = 0.0, 0.0, 0.0
        for i in range(tables.reads[m, j], z.size):
            re += entry[m, j, i, at.WEIGHT_RE] * z[i]
            im += entry[m, j, i, at.WEIGHT_IM] * z[i]
            noise += entry[m, j, i, at.WEIGHT_SIZE] * abs(z[i])
        size = math.sqrt(re * re + im * im)
        if size < _NOTHING:
            re, im, size, noise = 0.0, 0.0, 0.0, 0.0
        growth = spectrum[m, j].real
        if growth > 0.0:
            size *= math.exp(growth * reach)
        origin[j, at.RE], origin[j, at.IM] = re, im
        origin[j, at.SIZE], origin[j, at.NOISE] = size, noise * unit
        now[j, at.RE], now[j, at.IM] = re, im
        now[j, at.SIZE], now[j, at.NOISE] = size, noise * unit
    for c in range(slots[m, at.N_CLUSTERS]):
        start_cluster(
            spectrum, tables.nilpotent, slots, m, c, origin, now, segment.chain,
            segment.chain_noise, length, reach,
        )  # fmt: skip


@inlined
def advance(tables, segment, m, s):
    """Slots at s by closed form, bounds of their moduli ahead of s, margins at s."""
    spectrum, slots, origin, now = tables.spectrum, tables.slots, segment.origin, segment.now
    for j in range(slots[m, at.END_CONSTANT], slots[m, at.END_REAL]):
        decay = math.exp(spectrum[m, j].real * s)
        for k in range(4):
            now[j, k] = origin[j, k] * decay
    for j in range(slots[m, at.END_REAL], slots[m, at.END_ROTATION]):
        cos, sin = cos_sin(spectrum[m, j].imag * s)
        _turn(origin, now, j, cos, sin)
    for j in range(slots[m, at.END_ROTATION], slots[m, at.END_DAMPED]):
        decay = math.exp(spectrum[m, j].real * s)
        cos, sin = cos_sin(spectrum[m, j].imag * s)
        _turn(origin, now, j, decay * cos, decay * sin)
        now[j, at.SIZE] = origin[j, at.SIZE] * decay
        now[j, at.NOISE] = origin[j, at.NOISE] * decay
    _advance_clusters(tables, segment, m, s)


@inlined
def climb(tables, segment, m, rung, s):
    """Slots at s, one step of the ladder after the current point.

    The factors of a step were computed in the set-up, so this costs no transcendental
    function; its rounding adds up, and after some tens of steps `advance` has to be called.
    """
    slots, ladder, now = tables.slots, tables.ladder, segment.now
    for j in range(slots[m, at.END_CONSTANT], slots[m, at.END_DAMPED]):
        _turn(now, now, j, ladder[m, rung, j, at.RE], ladder[m, rung, j, at.IM])
        now[j, at.SIZE] *= ladder[m, rung, j, at.SIZE]
        now[j, at.NOISE] *= ladder[m, rung, j, at.SIZE]
    _advance_clusters(tables, segment, m, s)


@inlined
def advance_little(tables, segment, m, s, step):
    """Slots at s + step from those at s, for a step that turns them by little.

    Third-order Taylor factor: for |eigenvalue step| <= 1e-4 its error is below rounding.
    """
    spectrum, slots, now = tables.spectrum, tables.slots, segment.now
    for j in range(slots[m, at.END_CONSTANT], slots[m, at.END_DAMPED]):
        x, y = spectrum[m, j].real * step, spectrum[m, j].imag * step
        square_re, square_im = x * x - y * y, 2.0 * x * y
        cube_re, cube_im = square_re * x - square_im * y, square_re * y + square_im * x
        cos = 1.0 + (x + (0.5 * square_re + cube_re / 6.0))
        sin = y + (0.5 * square_im + cube_im / 6.0)
        _turn(now, now, j, cos, sin)
    _advance_clusters(tables, segment, m, s + step)


@inlined
def _advance_clusters(tables, segment, m, s):
    for c in range(tables.slots[m, at.N_CLUSTERS]):
        advance_cluster(
            tables.spectrum, tables.slots, m, c, segment.origin, segment.now, segment.chain,
            segment.chain_noise, s,
        )  # fmt: skip


@inlined
def _turn(source, target, j, cos, sin):
    re, im = source[j, at.RE], source[j, at.IM]
    target[j, at.RE] = re * cos - im * sin
    target[j, at.IM] = re * sin + im * cos


@inlined
def state_at(tables, segment, m, out_state):
    """States from the current slots; slaved ones follow their relation.

    shapes: out_state (n,)
    """
    states, now = tables.states, segment.now
    for i in range(out_state.size):
        total = 0.0
        for j in range(tables.slots[m, at.COUNT]):
            weight = states[m, i, j]
            total += weight.real * now[j, at.RE] - weight.imag * now[j, at.IM]
        out_state[i] = total
