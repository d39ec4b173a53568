"""Coefficients of bearings as texts of the speed: polynomials in pieces, exact for tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError
from nonsmooth.structures.bearing import Bearing, through_table

__all__ = ["SpeedPiece", "coefficient_pieces", "piecewise_definitions", "varies"]

Floats = npt.NDArray[np.float64]
_ACCURACY = 1e-10  # of polynomials through a function, relative to the largest coefficient
_DEGREE = 12
_NEGLIGIBLE = 1e-13  # coefficients that rounding alone has left
_NARROWEST = 2e-3  # of the range of speeds: a piece that is halved no more
_LONG = 2000  # characters of a half that has a definition of its own: texts have a greatest length


class SpeedPiece(NamedTuple):
    """A polynomial in (speed - centre)/scale from one speed to another.

    ``coefficients`` (p, 2, k, k): highest power first, stiffness and damping of the bearing.
    """

    begin: float
    end: float
    centre: float
    scale: float
    coefficients: Floats


def coefficient_pieces(
    bearing: Bearing, speed_range: tuple[float, float] | None
) -> list[SpeedPiece]:
    """Coefficients of a bearing as polynomials; one piece where they are constant."""
    if bearing.constant:
        values = np.array(bearing.at_speed(0.0))
        return [SpeedPiece(-np.inf, np.inf, 0.0, 1.0, values[np.newaxis])]

    def both(speed: float) -> Floats:
        return np.array(bearing.at_speed(speed))

    if callable(bearing.stiffness) or callable(bearing.damping):
        begin, end = _range(bearing, speed_range)
        rows = [] if bearing.speeds is None else bearing.speeds.tolist()
        law = _Law(both, rows, _NARROWEST * (end - begin))
        return list(law.pieces(begin, end, np.abs(both(0.5 * (begin + end)))))
    # the polynomials of the bearing itself, for it makes them in the same way
    assert bearing.speeds is not None
    table = np.array([both(speed) for speed in bearing.speeds.tolist()])
    spline = through_table(bearing.speeds, table, bearing.interpolation)
    knots = spline.x.tolist()
    return [
        SpeedPiece(begin, end, begin, 1.0, spline.c[:, i])
        for i, (begin, end) in enumerate(pairwise(knots))
    ]


def _range(bearing: Bearing, given: tuple[float, float] | None) -> tuple[float, float]:
    limits = bearing.speed_range or given
    if limits is None:
        called = bearing.name or ", ".join(map(str, bearing.coordinates))
        raise ModelError(
            f"speed_range: the bearing at {called} is a function of the speed; give the lowest and"
            " highest speed that the machine will have, and polynomials between them stand for it"
        )
    return limits


class _Law(NamedTuple):
    """A function of the speed, and where its derivatives may jump."""

    function: Callable[[float], Floats]
    rows: Sequence[float]
    """Speeds of the table that the function goes along, if there is one."""
    narrowest: float

    def pieces(self, begin: float, end: float, size: Floats) -> Sequence[SpeedPiece]:
        """Polynomials through the function, parted until they are right between their points."""
        from numpy.polynomial import chebyshev

        centre, scale = 0.5 * (begin + end), 0.5 * (end - begin)
        at = chebyshev.chebpts1(_DEGREE + 1)
        values = np.array([self.function(centre + scale * s) for s in at.tolist()])
        found = chebyshev.chebfit(at, values.reshape(len(at), -1), _DEGREE)
        between = np.cos(np.arange(_DEGREE + 2) * np.pi / (_DEGREE + 1))
        right = np.array([self.function(centre + scale * s) for s in between.tolist()])
        fault = np.abs(chebyshev.chebval(between, found).T.reshape(right.shape) - right)
        size = np.maximum(size, np.abs(right).max(axis=0))
        if (fault.max(axis=0) <= _ACCURACY * size).all():
            powers = np.zeros_like(found)
            for i, (column, most) in enumerate(zip(found.T, size.ravel(), strict=True)):
                each = chebyshev.cheb2poly(chebyshev.chebtrim(column, _NEGLIGIBLE * most))
                powers[: len(each), i] = each
            coefficients = powers[::-1].reshape(-1, *right.shape[1:])
            return [SpeedPiece(begin, end, centre, scale, coefficients)]
        inside = [row for row in self.rows if begin < row < end]
        if end - begin < self.narrowest and not inside:
            raise ModelError(
                f"bearings: a coefficient is no smooth function of the speed: near {centre:g} rad/s"
                " no polynomial comes close to it; give a table with speeds="
            )
        # the bends of a spline are at rows of its table
        middle = min(inside, key=lambda row: abs(row - centre), default=centre)
        return [*self.pieces(begin, middle, size), *self.pieces(middle, end, size)]


def piecewise_definitions(
    name: str, along: str, pieces: Sequence[SpeedPiece], at: tuple[int, int, int]
) -> dict[str, str]:
    """One coefficient as a function of a parameter ``along``.

    It is the definition ``name``, the last one; parts of a long text have definitions of their own
    before it.
    """
    made: dict[str, str] = {}

    def text(some: Sequence[SpeedPiece]) -> str:
        if len(some) == 1:
            return _polynomial(along, some[0], at)
        middle = len(some) // 2  # halves, so that the text is nested no deeper than it must be
        limit = some[middle].begin
        return f"where({along} < {limit!r}, {short(some[:middle])}, {short(some[middle:])})"

    def short(some: Sequence[SpeedPiece]) -> str:
        found = text(some)
        if len(found) <= _LONG:
            return found
        called = f"{name}_part{len(made) + 1}"
        made[called] = found
        return called

    whole = text(pieces)
    return {**made, name: whole}


def _polynomial(name: str, piece: SpeedPiece, at: tuple[int, int, int]) -> str:
    """Text of one coefficient in one piece, by Horner's rule."""
    values = [float(each) for each in piece.coefficients[(slice(None), *at)]]
    while len(values) > 1 and values[0] == 0.0:
        del values[0]
    along = f"({name} - {piece.centre!r})" if piece.centre else name
    if piece.scale != 1.0:
        along = f"({along}/{piece.scale!r})"
    text = repr(values[0])
    for value in values[1:]:
        text = f"({value!r} + {along}*{text})"
    return text


def varies(pieces: Sequence[SpeedPiece], at: tuple[int, int, int]) -> bool:
    """Whether a coefficient depends on the speed."""
    first = pieces[0].coefficients[(-1, *at)]
    return any(
        piece.coefficients[(slice(None, -1), *at)].any() or piece.coefficients[(-1, *at)] != first
        for piece in pieces
    )
