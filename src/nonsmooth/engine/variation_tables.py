"""The arrays from which columns of derivatives are carried along, and their scratch.

`Rates` is to the derivatives by some parameters what `Tables` is to the system: made once
for a set of parameter values. `Columns` is the scratch of a run.

Sizes as in `layout`, and P chosen parameters. *Full slots* are the slots of a mode and
after them the conjugates that `Tables` leaves out; together they are as many as the
coordinates that are not slaved.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.layout import DERIVATIVES, Program, augmented_size

__all__ = [
    "Columns",
    "Rates",
    "allocate_columns",
    "allocate_rates",
    "no_columns",
    "no_rates",
]

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]
Integers = npt.NDArray[np.int64]

# Rates.bundles[f, m]: number of bundles, then first member and size of each, then from 1 + N the
# members, full slots, and from 1 + 2 N the slot of which a full slot is the conjugate
N_BUNDLES, BUNDLES = 0, 1
FRAMES = 6  # at most; further ones would tell apart no more than a few motions better


class Rates(NamedTuple):
    """Derivatives by the chosen parameters, and the modal form in which they are carried.

    A bundle is a group of full slots with close eigenvalues: across bundles all couplings
    that a parameter makes are turned into a motion of the frame, within them they stay. What
    is close depends on the time; so there are some frames (F at most), for ever shorter ones.
    """

    chosen: Integers  # (P,) numbers of the parameters
    slot_rates: Floats  # (number of slots of the tape, P)
    harmonics: Floats  # (P, K): of the frequencies
    generator: Floats  # (P, m, N, N): of Tables.generator
    affine: Floats  # (P, m, rows, N): of guards (not of their derivatives), relations, resets
    longest: Floats  # (F, m): time up to which a frame serves, zero where there is none
    frame: Floats  # (F, P, m, N, N): what u - frame z leaves coupled only within bundles
    lift: Complexes  # (F, P, m, n, N): slots to the part of u that is frame z
    couplings: Complexes  # (F, P, m, N, N): of full slots of one bundle
    rest: Complexes  # (F, m, N, N): full slots, what bundles have beyond their mean eigenvalue
    means: Complexes  # (F, m, N): mean eigenvalue of each bundle
    spreads: Floats  # (F, m, N): largest distance from it
    bundles: Integers  # (F, m, 1 + 3 N)
    growth: Floats  # (m, 2): bound of growth, whose inverse is a short time; spread of units


class Columns(NamedTuple):
    """Scratch for carrying columns along; allocated once per run."""

    factors: Complexes  # (N,) of simple slots over the segment
    turns: Complexes  # (N, N) the same of clusters
    start: Complexes  # (N,) slots of the motion at the start
    end: Complexes  # (N,) and at the end of the segment
    column: Floats  # (N,) a column less frame z
    slots: Complexes  # (N,) its slots at the start
    moved: Complexes  # (N,) and at the end
    forced: Complexes  # (P, N) slots that parameters add, from zero at the start
    sums: Complexes  # (1 + P, N) members of a bundle: motion, then derivatives
    terms: Complexes  # (1 + P, N) the present term of their Taylor series
    spare: Complexes  # (N,)
    added: Floats  # (1 + P, N) over a short time: motion, then what parameters add
    series: Floats  # (1 + P, N) the present term of their Taylor series


def allocate_rates(program: Program, chosen: Integers) -> Rates:
    """Empty derivatives for a program and the numbers of some of its parameters."""
    n, _, n_frequencies, n_parameters, m, e, *_ = (int(size) for size in program.sizes)
    n_slots = n_parameters + program.constants.size + program.tape.shape[0]
    return _rates(chosen, n, n_frequencies, m, e, augmented_size(program.sizes), n_slots)


def no_rates() -> Rates:
    """Derivatives by no parameter, for a run that carries no columns."""
    return _rates(np.zeros(0, np.int64), 0, 0, 0, 0, 0, 0)


def _rates(
    chosen: Integers, n: int, n_frequencies: int, m: int, e: int, big_n: int, n_slots: int
) -> Rates:
    p = len(chosen)
    return Rates(
        chosen=np.asarray(chosen, np.int64),
        slot_rates=np.zeros((n_slots, p)),
        harmonics=np.zeros((p, n_frequencies)),
        generator=np.zeros((p, m, big_n, big_n)),
        affine=np.zeros((p, m, DERIVATIVES * e + n + e * n, big_n)),
        longest=np.zeros((FRAMES, m)),
        frame=np.zeros((FRAMES, p, m, big_n, big_n)),
        lift=np.zeros((FRAMES, p, m, n, big_n), np.complex128),
        couplings=np.zeros((FRAMES, p, m, big_n, big_n), np.complex128),
        rest=np.zeros((FRAMES, m, big_n, big_n), np.complex128),
        means=np.zeros((FRAMES, m, big_n), np.complex128),
        spreads=np.zeros((FRAMES, m, big_n)),
        bundles=np.zeros((FRAMES, m, 1 + 3 * big_n), np.int64),
        growth=np.zeros((m, 2)),
    )


def allocate_columns(program: Program, chosen: Integers) -> Columns:
    """Scratch for the columns of the states and of the chosen parameters."""
    return _columns(len(chosen), augmented_size(program.sizes))


def no_columns() -> Columns:
    """Scratch of a run that carries no columns."""
    return _columns(0, 0)


def _columns(p: int, big_n: int) -> Columns:
    return Columns(
        factors=np.zeros(big_n, np.complex128),
        turns=np.zeros((big_n, big_n), np.complex128),
        start=np.zeros(big_n, np.complex128),
        end=np.zeros(big_n, np.complex128),
        column=np.zeros(big_n),
        slots=np.zeros(big_n, np.complex128),
        moved=np.zeros(big_n, np.complex128),
        forced=np.zeros((p, big_n), np.complex128),
        sums=np.zeros((1 + p, big_n), np.complex128),
        terms=np.zeros((1 + p, big_n), np.complex128),
        spare=np.zeros(big_n, np.complex128),
        added=np.zeros((1 + p, big_n)),
        series=np.zeros((1 + p, big_n)),
    )
