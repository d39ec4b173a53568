"""Derivatives by parameters: what they need beside the tables of a system."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from nonsmooth.engine.library import constant, engine, ffi
from nonsmooth.engine.record import Complexes, Floats, Integers, Record, array_pointer, zeros
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import DERIVATIVES, Program, Sizes, Tables

__all__ = [
    "Columns",
    "Rates",
    "allocate_rates",
    "allocate_scratch",
    "no_rates",
    "no_scratch",
    "set_up_rates",
]

_FRAMES = constant("FRAMES")
_NOTHING = Sizes(0, 0, 0, 0, 0, 0, 0, 0, 0)


@dataclass(frozen=True, eq=False)
class Rates(Record):
    """Derivatives by the chosen parameters, and the modal form in which they are carried."""

    struct: ClassVar[str] = "Rates"

    chosen: Integers
    slot_rates: Floats
    harmonics: Floats
    generator: Floats
    affine: Floats
    longest: Floats
    frame: Floats
    lift: Complexes
    couplings: Complexes
    rest: Complexes
    means: Complexes
    spreads: Floats
    bundles: Integers
    growth: Floats


@dataclass(frozen=True, eq=False)
class Columns(Record):
    """Scratch for carrying columns along; allocated once per run."""

    struct: ClassVar[str] = "Columns"

    factors: Complexes
    turns: Complexes
    start: Complexes
    end: Complexes
    column: Floats
    slots: Complexes
    moved: Complexes
    forced: Complexes
    sums: Complexes
    terms: Complexes
    spare: Complexes
    added: Floats
    series: Floats


def allocate_rates(program: Program, chosen: Integers) -> Rates:
    """Empty derivatives for a program and the numbers of some of its parameters."""
    return _rates(program.sizes, program.n_slots, chosen)


def no_rates() -> Rates:
    """Derivatives by no parameter, for columns by initial states or none at all."""
    return _rates(_NOTHING, 0, np.zeros(0, np.int64), big_n=0)


def _rates(sizes: Sizes, n_slots: int, chosen: Integers, big_n: int | None = None) -> Rates:
    p, n, m, e = len(chosen), sizes.states, sizes.modes, sizes.exits
    big_n = sizes.augmented if big_n is None else big_n
    made = zeros(
        Rates.struct,
        slot_rates=(n_slots, p), harmonics=(p, sizes.frequencies), generator=(p, m, big_n, big_n),
        affine=(p, m, DERIVATIVES * e + n + e * n, big_n), longest=(_FRAMES, m),
        frame=(_FRAMES, p, m, big_n, big_n), lift=(_FRAMES, p, m, n, big_n),
        couplings=(_FRAMES, p, m, big_n, big_n), rest=(_FRAMES, m, big_n, big_n),
        means=(_FRAMES, m, big_n), spreads=(_FRAMES, m, big_n),
        bundles=(_FRAMES, m, 1 + 3 * big_n), growth=(m, 2),
    )  # fmt: skip
    return Rates(chosen=np.asarray(chosen, np.int64), **made)


def allocate_scratch(program: Program, chosen: Integers) -> Columns:
    """Scratch for the columns of the states and of the chosen parameters."""
    return _scratch(len(chosen), program.sizes.augmented)


def no_scratch() -> Columns:
    """Scratch of a run that carries no columns."""
    return _scratch(0, 0)


def _scratch(p: int, big_n: int) -> Columns:
    made = zeros(
        Columns.struct,
        factors=(big_n,), turns=(big_n, big_n), start=(big_n,), end=(big_n,), column=(big_n,),
        slots=(big_n,), moved=(big_n,), forced=(p, big_n), sums=(1 + p, big_n),
        terms=(1 + p, big_n), spare=(big_n,), added=(1 + p, big_n), series=(1 + p, big_n),
    )  # fmt: skip
    return Columns(**made)


def set_up_rates(
    program: Program, parameters: Floats, tables: Tables, rates: Rates
) -> tuple[Status, int]:
    """Fill the derivatives for the parameter values for which the tables were set up.

    returns: COMPLETED, or NOT_FINITE with the place in ``rates.chosen`` of the parameter by which a
    coefficient has no finite derivative
    """
    place = ffi.new("int64_t *")
    given = array_pointer("double", np.ascontiguousarray(parameters))
    status = engine.nonsmooth_set_up_rates(
        program.pointer, given, tables.as_lanes.pointer, rates.pointer, place
    )
    return Status(status), place[0]
