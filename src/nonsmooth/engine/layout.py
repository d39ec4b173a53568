"""The arrays that kernels pass around, and which row of them holds what.

`Program` is a system before parameters have values, `Tables` is the same system for one
set of values, `Segment` is the scratch of one smooth piece.

Sizes: m modes, e exits at most, n states, N augmented coordinates (states, 1, powers of
time, cos and sin of each frequency, four of each signal).
See README.md beside this file for the contract.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.jit import allocating, inlined, kernel

__all__ = [
    "CHAIN",
    "DERIVATIVES",
    "MAX_AUGMENTED",
    "MAX_DEGREE",
    "Program",
    "Segment",
    "Tables",
    "allocate_segment",
    "allocate_stack",
    "allocate_tables",
    "augmented_size",
    "counted_tables_at",
    "explicit",
    "factor_row",
    "first_of_signals",
    "has_code",
    "n_blocks",
    "part_of_stack",
    "slots_of",
    "stack_of_one",
    "tables_at",
    "vanishing",
]

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]
Integers = npt.NDArray[np.int64]

DERIVATIVES = 6  # rows kept per guard: its value and five time derivatives
TERMS = 6  # of the Taylor polynomial of a guard; the next one is bounded
MAX_DEGREE = 32  # of the polynomial in s that multiplies exp(mu s) in a cluster
MAX_AUGMENTED = 60  # sets of coordinates are bits of one integer
WINDOWS = 2  # that a segment may last
ORDER = 20  # of Taylor series of the motion; near the best for double precision
# A row of Segment.series: coefficients; what a recurrence multiplies by in place of dividing;
# from LAG on those with 0 < j < k once more, settled when order k is computed; from MIRROR on
# the same backwards, and behind them zeros for ever
RECIPROCAL, LAG, MIRROR, SERIES_ROW = 21, 24, 48, 96
LANES = 8  # directions of derivatives side by side, as many as a vector register holds
RUNGS = 8  # of the ladder of steps for which rotations are computed beforehand

CHAIN = 4  # coordinates of a signal: value, rate, second and third derivative

# Program.kinds: how the flow of a mode is solved
EXACT, TAYLOR = 0, 1
# Tables.clock: length of a window, 1.0 if it is a true period else 0.0, longest time that a
# segment may last, time over which eigenvalues have to be told apart
WINDOW, IS_PERIOD, LASTS, HORIZON = range(4)
# Tables.knots: time at which a piece begins and its coefficients in powers of the time since
# then; Tables.signals: row of the first knot of a signal and number of its knots
TIME = 0
FIRST, KNOTS = 0, 1
# Tables.slots: number of slots, ends of the constant, fading, other real, rotation and damped
# ones, number of clusters, then first slot, size and degree of each cluster
COUNT, END_CONSTANT, END_FADING, END_REAL, END_ROTATION, END_DAMPED, N_CLUSTERS = range(7)
CLUSTERS = 7
# Tables.wiring[m, 0]: number of exits that are searched for, bits of slaved states, of those solved
# for by equations, kind of the cell, number of all exits; Tables.wiring[m, 1 + e]: target, bits of
# states reset, the exit that leads onto the surface of this one (-1: none, e: it does so itself),
# what a start does from which both sides lead away, order of zero of each guard entered. Exits
# from N_EXITS on are passed on behalf of others, never by themselves
N_EXITS, SLAVED, IMPLICIT, KIND, N_WAYS = 0, 1, 2, 3, 4
TARGET, RESETTING, ONTO, CHOICE, ORDERS = 0, 1, 2, 3, 4
FREE, SLIDES, RESTING = 0, 1, 2  # kinds: off all surfaces, on one by Filippov, on one by a reaction
NO_CHOICE, STAY, CROSS = 0, 1, 2
# Tables.spans: longest segment for which the closed form is accurate, unit of rounding
# margins, largest modulus of the eigenvalues, farthest look ahead where a motion grows,
# longest step of the ladder
LONGEST, ROUNDING, FASTEST, REACH, RUNG = range(5)
SPANS = 5
# Tables.entry[m, slot, i]: weight of augmented coordinate i in a slot and its modulus
WEIGHT_RE, WEIGHT_IM, WEIGHT_SIZE = range(3)
# Tables.series[m, e, slot]: what a slot adds to the Taylor coefficients of a guard, by its
# real part and by its imaginary part, to the bound of the next one, and to the margin
BY_RE, BY_IM, BY_SIZE, BY_NOISE = 0, TERMS, 2 * TERMS, 2 * TERMS + 1
SERIES = 2 * TERMS + 2
# Segment.origin and Segment.now: real and imaginary part of a slot, bound of its modulus
# from there on, rounding margin; Tables.ladder: factors of the first three
RE, IM, SIZE, NOISE = range(4)
# Segment.doubt: size of a register over a step, and what rounding leaves of it in units
EXTENT, UNITS = 0, 1
# Segment.factors: Taylor coefficients of what lasts and of what fades, bounds of the coefficients
# of both from here on with that of the next one, rounding margin
LASTS_IN, FADES_IN, LASTING, FADED, DOUBT = 0, TERMS, 2 * TERMS, 3 * TERMS + 1, 4 * TERMS + 2
FACTOR = 4 * TERMS + 3
# Segment.scan: Taylor coefficients of a guard, bound of the next one, rounding margin of the
# value, safe step, latest root, what fading motions may take off and their whole size, where
# they are left out of the polynomial, and up to where a tangency is passed already
BOUND, MARGIN, SAFE, LATEST, TAKEN_OFF, FADING, PASSED = range(TERMS, TERMS + 7)
SCAN = TERMS + 7


class Program(NamedTuple):
    """A system without parameter values: tape of coefficients and where they belong."""

    # n states, powers of time, frequencies, parameters, modes, exits at most, registers, signals,
    # factors of guards at most
    sizes: Integers
    constants: Floats  # literals of the tape
    tape: Integers  # rows: opcode, left slot, right slot, third slot
    period_slot: int  # -1 without a period
    frequency_slots: Integers
    flow: Integers  # rows: mode, state, column, slot
    relations: Integers  # rows: mode, slaved state, column, slot
    guards: Integers  # rows: mode, exit, column, slot
    resets: Integers  # rows: mode, exit, state, column, slot
    factors: Integers  # rows: mode, factor, column, slot
    products: Integers  # (p, 2) factors
    product_rows: Integers  # (m, e, 2): first product of a guard and the one after its last
    wiring: Integers  # (m, 1 + e, ORDERS + e) as in Tables, orders left open
    drifting: int  # bits of the states that may grow without bound
    kinds: Integers  # (m,): EXACT or TAYLOR flow
    families: Integers  # (m,): cells of one declared mode have the same number
    code: Integers  # (r, 5) instructions on series, of all Taylor modes (taylor_opcodes)
    terms: Integers  # (t, 2) of their sums: register, slot
    code_rows: Integers  # (m, 3): first row, end of flow, relations and guards, end of resets
    # (m, n + e + e * n + n) registers of rates or relations, guards, resets, and of what vanishes
    # by the relations that are solved for
    outlets: Integers
    rest_slots: Integers  # (n,) slots of the rest state, -1 for zero
    signals: Integers  # as in Tables, likewise the next one
    knots: Floats
    spacing: Floats  # (2,): shortest and longest time between knots, inf without signals


class Tables(NamedTuple):
    """A system for one set of parameter values."""

    sizes: Integers  # as in Program
    clock: Floats  # (4,)
    harmonics: Floats  # (2, K): frequencies, turns in one window
    generator: Floats  # (m, N, N): z' = generator z
    affine: Floats  # (m, rows, N): guards with derivatives, relations, resets, factors
    spectrum: Complexes  # (m, N): eigenvalue of each slot
    nilpotent: Complexes  # (m, N, N): what clusters have beyond their mean eigenvalue
    entry: Floats  # (m, N, N, 3): augmented coordinates to slots
    reads: Integers  # (m, N): first augmented coordinate with a weight in a slot
    states: Complexes  # (m, n, N): slots to states
    series: Floats  # (m, e + factors, N, SERIES): slots to Taylor coefficients of guards
    products: Integers  # as in Program, likewise the next one
    product_rows: Integers
    ladder: Floats  # (m, RUNGS, N, 3): factors of the slots for a step of each rung
    slots: Integers  # (m, CLUSTERS + 3 N)
    spans: Floats  # (m, SPANS)
    wiring: Integers  # (m, 1 + e, ORDERS + e)
    drifting: int
    kinds: Integers  # (m,)
    families: Integers  # (m,)
    # of Taylor modes, whose generator, affine rows and spans are those of the last point or step
    values: Floats  # (slots of the parameter tape,)
    weights: Floats  # (t,): values of the slots of the terms
    code: Integers  # as in Program, likewise the next three
    terms: Integers
    code_rows: Integers
    outlets: Integers
    rest_slots: Integers  # as in Program
    # of measured input
    signals: Integers  # (S, 2)
    knots: Floats  # (knots of all signals, 5)


class Segment(NamedTuple):
    """Scratch of one smooth piece; allocated once per run."""

    z: Floats  # (N,) augmented coordinates at the start of the segment
    spare: Floats  # (N,)
    origin: Floats  # (N, 4) slots at the start of the segment
    now: Floats  # (N, 4) slots at the current point
    kept: Floats  # (N, 4) slots at the end of the segment while samples are read
    chain: Complexes  # (MAX_DEGREE + 1, N) coefficients of clusters in powers of s
    chain_noise: Floats  # (MAX_DEGREE + 1, N) their rounding margins
    order: Integers  # (e,): known order of zero of each guard at the start
    to_knot: Floats  # (1,): time to the next knot of a signal, inf without signals
    left_out: Integers  # (1,): bits of the states that a start leaves to their equations
    extent: Floats  # (N,) size of each coordinate at an event
    mark: Floats  # (N,) states from which exits are passed at one instant
    visited: Integers  # (M,): spell in which a mode is entered at one instant without a jump, or 0
    newton: Floats  # (3, N): last point and step of Newton's method, and what counts as large
    factors: Floats  # (factors + 1, FACTOR): of the products of a guard, and its linear part
    scan: Floats  # (e, SCAN)
    scale: Floats  # (N,) how far each coordinate moves
    basis: Floats  # (2, N, N): directions left free by what is known to be zero, and a spare
    # of Taylor modes
    point: Floats  # (1,) current point of the step
    series: Floats  # (R, SERIES_ROW) coefficients of all registers at the start of the step
    doubt: Floats  # (R, 2)
    dual: Floats  # (R, blocks of N and more, TERMS, LANES) derivatives at an instant


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
def factor_row(n_exits, n, f):
    """Row of Tables.affine with factor f of products in guards."""
    return DERIVATIVES * n_exits + n + n_exits * n + f


@kernel
def vanishing(n_exits, n, i):
    """Place among the outlets of what vanishes by the relation that state i is solved for by."""
    return n + n_exits + n_exits * n + i


@kernel
def explicit(wiring, m):
    """Bits of the slaved states of a mode that are given by expressions."""
    return wiring[m, 0, SLAVED] & ~wiring[m, 0, IMPLICIT]


@kernel
def has_code(code_rows, m):
    """Whether rows of a mode hold at an instant only: a Taylor mode, or one with curved exits."""
    return code_rows[m, 2] > code_rows[m, 0]


@kernel
def first_of_signals(sizes):
    """First augmented coordinate of the signals."""
    return sizes[0] + 1 + sizes[1] + 2 * sizes[2]


def augmented_size(sizes: Integers) -> int:
    """Number of augmented coordinates N."""
    return int(sizes[0] + 1 + sizes[1] + 2 * sizes[2] + CHAIN * sizes[7])


@kernel
def n_blocks(n_directions):
    """Number of blocks of lanes that hold some directions."""
    return (n_directions + LANES - 1) // LANES


def allocate_tables(program: Program) -> Tables:
    """Empty tables for a program."""
    n, n_frequencies, m, e, factors = (int(program.sizes[i]) for i in (0, 2, 4, 5, 8))
    big_n = augmented_size(program.sizes)
    return Tables(
        sizes=program.sizes,
        clock=np.zeros(4),
        harmonics=np.zeros((2, n_frequencies)),
        generator=np.zeros((m, big_n, big_n)),
        affine=np.zeros((m, DERIVATIVES * e + n + e * n + factors, big_n)),
        spectrum=np.zeros((m, big_n), np.complex128),
        nilpotent=np.zeros((m, big_n, big_n), np.complex128),
        entry=np.zeros((m, big_n, big_n, 3)),
        reads=np.zeros((m, big_n), np.int64),
        states=np.zeros((m, n, big_n), np.complex128),
        series=np.zeros((m, e + factors, big_n, SERIES)),
        products=program.products,
        product_rows=program.product_rows,
        ladder=np.zeros((m, RUNGS, big_n, 3)),
        slots=np.zeros((m, CLUSTERS + 3 * big_n), np.int64),
        spans=np.zeros((m, SPANS)),
        wiring=program.wiring.copy(),
        drifting=program.drifting,
        kinds=program.kinds,
        families=program.families,
        values=np.zeros(slots_of(program)),
        weights=np.zeros(len(program.terms)),
        code=program.code,
        terms=program.terms,
        code_rows=program.code_rows,
        outlets=program.outlets,
        rest_slots=program.rest_slots,
        signals=program.signals,
        knots=program.knots,
    )


# fields of Tables that are those of the program, whatever the parameter values
_SHARED = (
    "sizes", "products", "product_rows", "drifting", "kinds", "families", "code", "terms",
    "code_rows", "outlets", "rest_slots", "signals", "knots",
)  # fmt: skip


def allocate_stack(program: Program, count: int) -> Tables:
    """Empty tables for several sets of parameter values, one after the other in each array."""
    one = allocate_tables(program)
    own: dict[str, Any] = {
        name: np.repeat(each[None], count, axis=0)
        for name, each in one._asdict().items()
        if name not in _SHARED
    }
    return one._replace(**own)


def stack_of_one(tables: Tables) -> Tables:
    """The same tables as a stack."""
    return part_of_stack(tables, None)


def part_of_stack(stack: Tables, which: slice | int | None) -> Tables:
    """Some of the tables of a stack as a stack, or one of them by itself."""
    own: dict[str, Any] = {
        name: each[which] for name, each in stack._asdict().items() if name not in _SHARED
    }
    return stack._replace(**own)


def _tables_at(stack, k):
    """Tables number k of a stack."""
    return Tables(
        stack.sizes, stack.clock[k], stack.harmonics[k], stack.generator[k], stack.affine[k],
        stack.spectrum[k], stack.nilpotent[k], stack.entry[k], stack.reads[k], stack.states[k],
        stack.series[k], stack.products, stack.product_rows, stack.ladder[k], stack.slots[k],
        stack.spans[k], stack.wiring[k], stack.drifting, stack.kinds, stack.families,
        stack.values[k], stack.weights[k], stack.code, stack.terms, stack.code_rows,
        stack.outlets, stack.rest_slots, stack.signals, stack.knots,
    )  # fmt: skip


tables_at = inlined(_tables_at)
# the same for functions with numba's memory manager, which counts who holds an array
counted_tables_at = allocating(_tables_at)


def slots_of(program: Program) -> int:
    """Number of slots of the parameter tape."""
    return int(program.sizes[3]) + program.constants.size + program.tape.shape[0]


def allocate_segment(sizes: Integers, n_rates: int = 0) -> Segment:
    """Scratch for the sizes of a program, and derivatives by some parameters."""
    e = int(sizes[5])
    big_n = augmented_size(sizes)
    return Segment(
        z=np.zeros(big_n),
        spare=np.zeros(big_n),
        origin=np.zeros((big_n, 4)),
        now=np.zeros((big_n, 4)),
        kept=np.zeros((big_n, 4)),
        chain=np.zeros((MAX_DEGREE + 1, big_n), np.complex128),
        chain_noise=np.zeros((MAX_DEGREE + 1, big_n)),
        order=np.zeros(e, np.int64),
        to_knot=np.full(1, np.inf),
        left_out=np.zeros(1, np.int64),
        extent=np.zeros(big_n),
        mark=np.zeros(big_n),
        visited=np.zeros(int(sizes[4]), np.int64),
        newton=np.zeros((3, big_n)),
        factors=np.zeros((int(sizes[8]) + 1, FACTOR)),
        scan=np.zeros((e, SCAN)),
        scale=np.zeros(big_n),
        basis=np.zeros((2, big_n, big_n)),
        point=np.zeros(1),
        series=np.zeros((int(sizes[6]), SERIES_ROW)),
        doubt=np.zeros((int(sizes[6]), 2)),
        dual=np.zeros((int(sizes[6]), n_blocks(big_n + n_rates), TERMS, LANES)),
    )
