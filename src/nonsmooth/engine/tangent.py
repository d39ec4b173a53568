"""Columns of derivatives along a run: by the initial state, and by parameters.

Within a segment the columns follow the linearised flow. At an event they are taken to the
surface of the guard that fires, through the resets and relations passed there, and back to
the time of the event with the rates of the mode that holds then: the saltation matrix
(P. Mueller, Calculation of Lyapunov exponents for dynamic systems with discontinuities, 1995).
Where nothing is carried, there are no columns, and all of this costs one comparison.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.engine import layout as at
from nonsmooth.engine.column_series import carry_by_series
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.layout import Floats, Integers, augmented_size, n_blocks
from nonsmooth.engine.variation import advance_columns, augmented_columns
from nonsmooth.engine.velocity import fill_velocity

__all__ = [
    "Tangent",
    "allocate_columns",
    "allocate_tangent",
    "carry",
    "complete_columns",
    "end_saltation",
    "push_columns",
    "relate_columns",
    "start_columns",
    "start_saltation",
]


class Tangent(NamedTuple):
    """Columns of derivatives and their scratch; C columns, none where nothing is carried."""

    columns: Floats  # (C, N) at the anchor: by each initial state, then by each parameter
    now: Floats  # (C, N) at the current point
    shifts: Floats  # (C,) of the time of the present event
    velocity: Floats  # (N,) rates of all coordinates
    dual: Floats  # (R, blocks of C, ORDER + 1, LANES) series of the columns of a Taylor step
    ready: Integers  # (1,): whether dual belongs to the present step
    piece: Floats  # (C, N) at the start of a piece of a step
    series: Floats  # (R, SERIES_ROW) of a piece
    samples: Floats  # (s, C, n)


def allocate_tangent(sizes: Integers, n_parameters: int, n_samples: int) -> Tangent:
    """Room for the columns of all states and some parameters; with -1, for no column at all."""
    count = 0 if n_parameters < 0 else int(sizes[0]) + n_parameters
    return allocate_columns(sizes, count, n_samples)


def allocate_columns(sizes: Integers, count: int, n_samples: int) -> Tangent:
    """Room for any number of columns."""
    n, big_n = int(sizes[0]), augmented_size(sizes)
    registers = int(sizes[6]) if count else 0
    return Tangent(
        columns=np.zeros((count, big_n)),
        now=np.zeros((count, big_n)),
        shifts=np.zeros(count),
        velocity=np.zeros(big_n if count else 0),
        dual=np.zeros((registers, n_blocks(count), at.ORDER + 1, at.LANES)),
        ready=np.zeros(1, np.int64),
        piece=np.zeros((count, big_n)),
        series=np.zeros((registers, at.SERIES_ROW)),
        samples=np.full((n_samples if count else 0, count, n), np.nan),
    )


@kernel
def start_columns(n, tangent):
    """Columns at the initial state: the identity, and zero for parameters."""
    columns = tangent.columns
    for c in range(columns.shape[0]):
        for i in range(columns.shape[1]):
            columns[c, i] = 1.0 if i == c and c < n else 0.0


@kernel
def complete_columns(tables, rates, tangent, number, phase, z):
    """Entries of time and harmonics in the columns at the anchor."""
    time = number * tables.clock[0] + phase
    augmented_columns(tables.sizes[0], tables.sizes[1], time, rates.harmonics, z, tangent.columns)
    tangent.ready[0] = 0


@kernel
def carry(tables, rates, scratch, segment, tangent, m, s):
    """Columns after s of the present segment, into tangent.now."""
    if tables.kinds[m] == at.EXACT:
        advance_columns(tables, rates, scratch, m, segment.z, s, tangent.columns, tangent.now)
    else:
        carry_by_series(tables, rates, segment, tangent, m, s)


@kernel
def start_saltation(tables, rates, segment, tangent, m, e):
    """Columns, in tangent.columns, taken to the surface where exit e of mode m fires."""
    n, z, velocity, columns = tables.sizes[0], segment.z, tangent.velocity, tangent.columns
    fill_velocity(n, tables.generator, tables.affine, tables.wiring, m, z, velocity)
    row = at.guard_row(e, 0)
    rate = _product(tables.affine, m, row, velocity)
    for c in range(columns.shape[0]):
        change = _product(tables.affine, m, row, columns[c])
        if c >= n:
            change += _product(rates.affine[c - n], m, row, z)
        tangent.shifts[c] = change / rate
        for i in range(z.size):
            columns[c, i] -= velocity[i] * tangent.shifts[c]


@kernel
def push_columns(tables, rates, segment, tangent, m, e):
    """Carry the columns through the reset of an exit; segment.z is still that before it."""
    n, z, spare = tables.sizes[0], segment.z, tangent.velocity
    bits = tables.wiring[m, 1 + e, at.RESETTING]
    n_exits = tables.wiring.shape[1] - 1
    for c in range(tangent.columns.shape[0]):
        column = tangent.columns[c]
        for i in range(n):
            spare[i] = column[i]
            if (bits >> i) & 1:
                row = at.reset_row(n_exits, n, e, i)
                spare[i] = _product(tables.affine, m, row, column)
                if c >= n:
                    spare[i] += _product(rates.affine[c - n], m, row, z)
        for i in range(n):
            column[i] = spare[i]


@kernel
def relate_columns(tables, rates, segment, tangent, m):
    """Put the slaved entries of the columns on the relations of a mode, at segment.z."""
    n, slaved = tables.sizes[0], tables.wiring[m, 0, at.SLAVED]
    n_exits = tables.wiring.shape[1] - 1
    for c in range(tangent.columns.shape[0]):
        column = tangent.columns[c]
        for i in range(n):
            if (slaved >> i) & 1:
                row = at.relation_row(n_exits, i)
                column[i] = _product(tables.affine, m, row, column)
                if c >= n:
                    column[i] += _product(rates.affine[c - n], m, row, segment.z)


@kernel
def end_saltation(tables, segment, tangent, m):
    """Columns brought back to the time of the event with the rates of the mode that holds."""
    n, velocity, columns = tables.sizes[0], tangent.velocity, tangent.columns
    fill_velocity(n, tables.generator, tables.affine, tables.wiring, m, segment.z, velocity)
    for c in range(columns.shape[0]):
        for i in range(velocity.size):
            columns[c, i] += velocity[i] * tangent.shifts[c]


@kernel
def _product(rows, m, row, vector):
    total = 0.0
    for i in range(vector.size):
        total += rows[m, row, i] * vector[i]
    return total
