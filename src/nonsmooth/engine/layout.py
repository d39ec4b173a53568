"""The arrays that kernels pass around, and which row of them holds what.

`Program` is a system before parameters have values, `Tables` is the same system for one
set of values, `Segment` is the scratch of one smooth piece. Tables are few large sheets
rather than many small arrays: passing an array to a kernel costs time for each array.

Sizes: m modes, e exits at most, n states, N augmented coordinates (states, 1, powers of
time, cos and sin of each frequency). See README.md beside this file for the contract.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.jit import kernel

__all__ = [
    "DERIVATIVES",
    "MAX_AUGMENTED",
    "MAX_DEGREE",
    "Program",
    "Segment",
    "Tables",
    "allocate_segment",
    "allocate_tables",
    "augmented_size",
]

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]
Integers = npt.NDArray[np.int64]

DERIVATIVES = 6  # rows kept per guard: its value and five time derivatives
MAX_DEGREE = 24  # of the polynomial in s that multiplies exp(mu s) in a cluster
MAX_AUGMENTED = 60  # sets of coordinates are bits of one integer

# Tables.slots: number of slots, ends of the constant, real, rotation and damped ones,
# number of clusters, then first slot, size and degree of each cluster
COUNT, END_CONSTANT, END_REAL, END_ROTATION, END_DAMPED, N_CLUSTERS, CLUSTERS = range(7)
# Tables.wiring[m, 0]: number of exits, bits of slaved states;
# Tables.wiring[m, 1 + e]: target, bits of states reset, order of zero of each guard entered
N_EXITS, SLAVED = 0, 1
TARGET, RESETTING, ORDERS = 0, 1, 2
# Tables.spans: longest segment for which the closed form is accurate, unit of rounding
# margins, largest modulus of the eigenvalues, farthest look ahead where a motion grows
LONGEST, ROUNDING, FASTEST, REACH = range(4)
# Segment.modal: coordinates at the start, at the current point, at the end while samples
# are read, coefficients of clusters
START, NOW, KEPT, CHAIN = 0, 1, 2, 3
# Segment.sizes: bounds of moduli at the start and from the current point on; rounding
# margins at the start and at the current point; margins of the coefficients of clusters
SIZE_START, SIZE_NOW, NOISE_START, NOISE, CHAIN_NOISE = 0, 1, 2, 3, 4
# Segment.scan: value, rate, second rate and bound of the third one; safe step; latest root;
# rounding margin of the value over the segment
VALUE, RATE, SECOND, THIRD, SAFE, LATEST, MARGIN = range(7)


class Program(NamedTuple):
    """A system without parameter values: tape of coefficients and where they belong."""

    sizes: Integers  # n states, powers of time, frequencies, parameters, modes, exits at most
    constants: Floats  # literals of the tape
    tape: Integers  # rows: opcode, left slot, right slot, third slot
    period_slot: int  # -1 without a period
    frequency_slots: Integers
    flow: Integers  # rows: mode, state, column, slot
    relations: Integers  # rows: mode, slaved state, column, slot
    guards: Integers  # rows: mode, exit, column, slot
    resets: Integers  # rows: mode, exit, state, column, slot
    wiring: Integers  # (m, 1 + e, 2 + e) as in Tables, orders left open
    drifting: int  # bits of the states that may grow without bound


class Tables(NamedTuple):
    """A system for one set of parameter values."""

    sizes: Integers  # as in Program
    clock: Floats  # window length, 1.0 if it is a true period else 0.0
    harmonics: Floats  # (2, K): frequencies, turns in one window
    generator: Floats  # (m, N, N): z' = generator z
    affine: Floats  # (m, rows, N): guards with derivatives, relations, resets
    flow: Complexes  # (m, rows, N): everything about the modal slots of a mode
    bounds: Floats  # (m, rows, N): absolute weights for bounds and margins
    slots: Integers  # (m, 6 + 3 N)
    spans: Floats  # (m, 4)
    wiring: Integers  # (m, 1 + e, 2 + e)
    drifting: int


class Segment(NamedTuple):
    """Scratch of one smooth piece; allocated once per run."""

    z: Floats  # (N,) augmented coordinates at the start of the segment
    spare: Floats  # (N,)
    modal: Complexes  # (CHAIN + MAX_DEGREE + 1, N)
    sizes: Floats  # (CHAIN_NOISE + MAX_DEGREE + 1, N)
    order: Integers  # (e,): known order of zero of each guard at the start
    scan: Floats  # (e, 7)
    basis: Floats  # (2, N, N): directions left free by what is known to be zero, and a spare


@kernel
def guard_row(e, r):
    """Row of Tables.affine with derivative r of guard e."""
    return DERIVATIVES * e + r


@kernel
def relation_row(n_exits, i):
    """Row of Tables.affine with the relation of slaved state i."""
    return DERIVATIVES * n_exits + i


@kernel
def reset_row(n_exits, n, e, i):
    """Row of Tables.affine with the reset of state i by exit e."""
    return DERIVATIVES * n_exits + n + e * n + i


@kernel
def modal_row(i):
    """Row of Tables.flow that turns augmented coordinate i into slots; row 0 is the spectrum."""
    return 1 + i


@kernel
def state_row(big_n, i):
    """Row of Tables.flow that turns slots into state i."""
    return 1 + big_n + i


@kernel
def guard_flow_row(big_n, n, e, r):
    """Row of Tables.flow that turns slots into derivative r < 3 of guard e."""
    return 1 + big_n + n + 3 * e + r


@kernel
def nilpotent_row(big_n, n, n_exits, a):
    """Row of Tables.flow with what cluster slot a has beyond the mean eigenvalue."""
    return 1 + big_n + n + 3 * n_exits + a


@kernel
def guard_size_row(big_n, e):
    """Row of Tables.bounds with the absolute weights of guard e; modal ones come before."""
    return big_n + 2 * e


@kernel
def guard_third_row(big_n, e):
    """Row of Tables.bounds with the absolute weights of the third derivative of guard e."""
    return big_n + 2 * e + 1


def augmented_size(sizes: Integers) -> int:
    """Number of augmented coordinates N."""
    return int(sizes[0] + 1 + sizes[1] + 2 * sizes[2])


def allocate_tables(program: Program) -> Tables:
    """Empty tables for a program."""
    n, _, n_frequencies, _, m, e = (int(size) for size in program.sizes)
    big_n = augmented_size(program.sizes)
    return Tables(
        sizes=program.sizes,
        clock=np.zeros(2),
        harmonics=np.zeros((2, n_frequencies)),
        generator=np.zeros((m, big_n, big_n)),
        affine=np.zeros((m, DERIVATIVES * e + n + e * n, big_n)),
        flow=np.zeros((m, 1 + 2 * big_n + n + 3 * e, big_n), np.complex128),
        bounds=np.zeros((m, big_n + 2 * e, big_n)),
        slots=np.zeros((m, CLUSTERS + 3 * big_n), np.int64),
        spans=np.zeros((m, 4)),
        wiring=program.wiring.copy(),
        drifting=program.drifting,
    )


def allocate_segment(sizes: Integers) -> Segment:
    """Scratch for the sizes of a program."""
    e = int(sizes[5])
    big_n = augmented_size(sizes)
    return Segment(
        z=np.zeros(big_n),
        spare=np.zeros(big_n),
        modal=np.zeros((CHAIN + MAX_DEGREE + 1, big_n), np.complex128),
        sizes=np.zeros((CHAIN_NOISE + MAX_DEGREE + 1, big_n)),
        order=np.zeros(e, np.int64),
        scan=np.zeros((e, 7)),
        basis=np.zeros((2, big_n, big_n)),
    )
