"""How close the guards of a leg come to zero between its ends: their lowest interior minimum.

A leg of an orbit begins and ends where guards vanish. In between, a guard that comes down and
turns back tells how far the orbit is from grazing, and it goes on doing so, with a negative
value, where the orbit passes through the guard. This is a smooth measure for a solver that looks
for the grazing, and no certificate: minima between two looks may be missed.
"""

from __future__ import annotations

import math

from nonsmooth.engine import layout as at
from nonsmooth.engine.arrays import copy_vector
from nonsmooth.engine.flow import advance_once, read_guard, state_at
from nonsmooth.engine.jit import entry, kernel
from nonsmooth.engine.leg_flow import enter_leg, step_of_leg
from nonsmooth.engine.linear_flow import augmented
from nonsmooth.engine.linearisation import linearise_derivatives, linearise_mode

__all__ = ["fill_minima"]

_LOOKS = 64  # in a window, and at least that many in a leg of an exact mode
_FEWEST = 32
_BEGIN = 1e-6  # part of the first step: the first look
_LOOKS_OF_STEP = 6  # in a step of a series
_MOST_STEPS = 100_000
_MOST_HALVINGS = 60
_CLOSE = 1e-15  # part of a leg


@entry
def fill_minima(tables, rates, segment, tangent, modes, states, begins, ends, minima, places):
    """Lowest interior minimum of each guard in each leg, and the time since the leg began.

    shapes: modes (L,), states (L, n) at the starts, begins, ends (L,) instants; minima, places
    (L, e), outputs, nan where a guard has no interior minimum; tangent without columns
    """
    window = tables.clock[0]
    for k in range(modes.size):
        number = math.floor(begins[k] / window)
        phase = begins[k] - number * window
        for g in range(minima.shape[1]):
            minima[k, g], places[k, g] = math.nan, math.nan
        duration = ends[k] - begins[k]
        if duration > 0.0:
            _look_along(
                tables, rates, segment, tangent, modes[k], states[k], number, phase, duration,
                minima[k], places[k],
            )  # fmt: skip


@kernel
def _look_along(tables, rates, segment, tangent, m, state, number, phase, duration, minima, places):
    if not enter_leg(tables, rates, segment, tangent, m, state, number, phase):
        return
    n, passed = tables.sizes[0], 0.0
    for _ in range(_MOST_STEPS):
        length = step_of_leg(tables, rates, segment, m, duration - passed)
        if not length > _CLOSE * duration:
            return
        if tables.kinds[m] == at.TAYLOR:
            looks = _LOOKS_OF_STEP
        else:
            looks = max(_FEWEST, int(_LOOKS * length / tables.clock[0]) + 1)
        for g in range(tables.wiring[m, 0, at.N_EXITS]):
            _look_at(
                tables, rates, segment, m, g, number, phase, length, looks, passed, duration,
                minima, places,
            )  # fmt: skip
        passed += length
        if passed >= duration * (1.0 - _CLOSE):
            return
        advance_once(tables, segment, m, length)
        state_at(tables, segment, m, segment.spare[:n])
        copy_vector(segment.spare, segment.z, n)
        phase += length
        whole = math.floor(phase / tables.clock[0])
        number, phase = number + int(whole), phase - whole * tables.clock[0]
        augmented(n, tables.sizes[1], tables.clock[0], tables.harmonics, number, phase, segment.z)


@kernel
def _look_at(
    tables, rates, segment, m, g, number, phase, length, looks, passed, duration, minima, places
):
    """Find the minima of one guard in one step by the signs of its rate."""
    low = 0.0 if passed > 0.0 else _BEGIN * length  # at the start guards may vanish by construction
    falls = _guard_at(tables, rates, segment, m, g, number, phase, low)[1] < 0.0
    for j in range(1, looks + 1):
        s = length * j / looks
        if passed + s >= duration * (1.0 - _CLOSE):
            s *= 1.0 - 1e-9  # at the end of a leg its guard vanishes by construction
        rate = _guard_at(tables, rates, segment, m, g, number, phase, s)[1]
        if falls and rate >= 0.0:
            s, value = _minimum_between(tables, rates, segment, m, g, number, phase, low, s)
            if not value >= minima[g]:
                minima[g], places[g] = value, passed + s
            rate = 1.0
        falls = rate < 0.0
        low = length * j / looks


@kernel
def _minimum_between(tables, rates, segment, m, g, number, phase, low, high):
    """Place and value where the rate of a guard rises through zero."""
    s = 0.5 * (low + high)
    value = 0.0
    for _ in range(_MOST_HALVINGS):
        value, rate, curvature = _guard_at(tables, rates, segment, m, g, number, phase, s)
        if rate < 0.0:
            low = s
        else:
            high = s
        step = -rate / curvature if curvature > 0.0 else math.nan
        new = s + step
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - s) <= 1e-14 * (abs(s) + high):
            break
        s = new
    return s, value


@kernel
def _guard_at(tables, rates, segment, m, g, number, phase, s):
    """Value, rate and second rate of a guard at a point of the step."""
    if tables.kinds[m] == at.TAYLOR:
        segment.point[0] = s
        read_guard(tables, segment, m, g, 0)
        return segment.scan[g, 0], segment.scan[g, 1], 2.0 * segment.scan[g, 2]
    n, z = tables.sizes[0], segment.mark
    advance_once(tables, segment, m, s)
    state_at(tables, segment, m, segment.spare[:n])
    copy_vector(segment.spare, z, n)
    # harmonics at the point, beside the start of the step that segment.z keeps
    augmented(n, tables.sizes[1], tables.clock[0], tables.harmonics, number, phase + s, z)
    if at.has_code(tables.code_rows, m):
        copy_vector(segment.z, segment.basis[0, 0], z.size)
        copy_vector(z, segment.z, z.size)
        linearise_mode(tables, rates, segment, m)
        linearise_derivatives(
            tables, rates.slot_rates, rates.harmonics, segment.series, segment.dual, m, segment.z
        )
        copy_vector(segment.basis[0, 0], segment.z, z.size)
    return (
        _product(tables.affine[m], at.guard_row(g, 0), z),
        _product(tables.affine[m], at.guard_row(g, 1), z),
        _product(tables.affine[m], at.guard_row(g, 2), z),
    )


@kernel
def _product(rows, row, vector):
    total = 0.0
    for i in range(vector.size):
        total += rows[row, i] * vector[i]
    return total
