"""A motion along a given word, the equations of a periodic orbit, and products of its derivatives.

Nothing is searched here. A leg goes on for as long as it is told, whether or not a guard crosses
zero on the way, and where the next leg begins is told too. What comes back is what a solver needs
to close the gaps between legs, with derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.derivatives import Columns, Rates
from nonsmooth.engine.lanes import Segment, Tangent
from nonsmooth.engine.library import engine
from nonsmooth.engine.record import Floats, Integers, Record, array_pointer, zeros
from nonsmooth.engine.tables import PATH_LENGTH, Sizes, Tables

__all__ = [
    "Closing",
    "LegResults",
    "WordLegs",
    "allocate_leg_results",
    "close_legs",
    "fill_minima",
    "multiply_graded",
    "pass_legs",
]


@dataclass(frozen=True, eq=False)
class WordLegs(Record):
    """The legs of a word: modes, exits at their ends, states at their starts, instants."""

    struct: ClassVar[str] = "WordLegs"

    modes: Integers  # (L,)
    paths: Integers  # (L, PATH_LENGTH), -1 for none
    states: Floats  # (L, n)
    begins: Floats  # (L,)
    ends: Floats  # (L,)


@dataclass(frozen=True, eq=False)
class LegResults(Record):
    """What legs come to; L legs, P parameters, e exits at most."""

    struct: ClassVar[str] = "LegResults"

    starts: Floats  # (L, n) states at the start, slaved ones on their relations
    ends: Floats  # (L, n) states just before the exits
    nexts: Floats  # (L, n) states behind them
    start_rates: Floats  # (L, n) rates of the states at the start
    end_rates: Floats  # (L, n) and at the end
    flow: Floats  # (L, n + P, n) columns of derivatives of the end by start and parameters
    jump: Floats  # (L, n + P, n) the same of the state behind the exits, by that at the end
    jump_rate: Floats  # (L, n) what the state behind the exits changes by when the leg lasts longer
    guard: Floats  # (L,) guard of the first exit at the end, nan without one
    guard_row: Floats  # (L, n + P) its derivatives by the state at the end and by parameters
    guard_rate: Floats  # (L,) its rate
    others: Floats  # (L, e) all guards of the mode at the end
    passed: Floats  # (L, PATH_LENGTH) guard of each exit, where it is passed
    passed_rate: Floats  # (L, PATH_LENGTH) its rate, where a later one is met by itself; else 0
    spare: Floats


@dataclass(frozen=True, eq=False)
class Closing(Record):
    """The equations of an orbit of L legs; unknowns are states at the starts, then instants."""

    struct: ClassVar[str] = "OrbitEquations"

    states: Floats  # (L, n)
    n_instants: int  # L where the last instant is unknown, else L - 1
    driven: bool
    begins: Floats  # (P,) what the first instant changes by with the parameters
    ends: Floats  # (P,) and the last one
    drifting: npt.NDArray[np.bool_]  # (n,) states that stay open in the last leg
    origin: Floats  # (n,) where these begin
    residual: Floats  # (S,)
    jacobian: Floats  # (S, S)
    moved: Floats  # (S, P)


@dataclass(frozen=True, eq=False)
class _GradedProduct(Record):
    struct: ClassVar[str] = "GradedProduct"

    factors: Floats
    turns: int
    frame: Floats
    start: Floats
    triangle: Floats
    spare: Floats
    exponent: float


def allocate_leg_results(sizes: Sizes, n_rates: int, count: int) -> LegResults:
    """Room for the results of some legs."""
    n = sizes.states
    made = zeros(
        LegResults.struct,
        starts=(count, n), ends=(count, n), nexts=(count, n), start_rates=(count, n),
        end_rates=(count, n), flow=(count, n + n_rates, n), jump=(count, n + n_rates, n),
        jump_rate=(count, n), guard=(count,), guard_row=(count, n + n_rates), guard_rate=(count,),
        others=(count, sizes.exits), passed=(count, PATH_LENGTH),
        passed_rate=(count, PATH_LENGTH), spare=(sizes.augmented,),
    )  # fmt: skip
    return LegResults(**made)


def pass_legs(
    tables: Tables,
    rates: Rates,
    scratch: Columns,
    segment: Segment,
    tangent: Tangent,
    legs: WordLegs,
    results: LegResults,
) -> int:
    """Pass each leg from its own start, and the exits at its end; the tangent has n + P columns.

    returns: the number of legs passed, fewer than all where one of them fails
    """
    return int(
        engine.nonsmooth_pass_legs(
            tables.as_lanes.pointer, rates.pointer, scratch.pointer, segment.pointer,
            tangent.as_lanes.pointer, legs.pointer, results.pointer,
        )
    )  # fmt: skip


def fill_minima(
    tables: Tables,
    rates: Rates,
    segment: Segment,
    tangent: Tangent,
    legs: WordLegs,
    minima: Floats,
    places: Floats,
) -> None:
    """Lowest interior minimum of each guard in each leg, and the time since the leg began.

    shapes: minima, places (L, e), outputs, nan where a guard has no interior minimum; the tangent
    is without columns
    """
    engine.nonsmooth_fill_minima(
        tables.as_lanes.pointer, rates.pointer, segment.pointer, tangent.as_lanes.pointer,
        legs.pointer, array_pointer("double", minima), array_pointer("double", places),
    )  # fmt: skip


def close_legs(results: LegResults, closing: Closing) -> None:
    """Fill the residual, its Jacobian by the unknowns, and its derivatives by parameters."""
    engine.nonsmooth_close_legs(results.pointer, closing.pointer)


def multiply_graded(
    factors: Floats, turns: int, frame: Floats, start: Floats, triangle: Floats
) -> float:
    """Turn a frame through factors, and multiply what it leaves over the last turn.

    shapes: factors (count, n, n), the first one applied first; frame (n, k) orthonormal columns at
    the start, and those at the end; start (n, k) the frame before the last turn, triangle (k, k),
    both outputs, with factors @ start = frame @ triangle * exp(exponent)
    returns: exponent, nan where the product vanishes or overflows
    """
    product = _GradedProduct(
        np.ascontiguousarray(factors), turns, frame, start, triangle, np.empty_like(frame), 0.0
    )
    engine.nonsmooth_multiply_graded(product.pointer)
    return float(product.pointer.exponent)
