"""The first crossing of a linear guard along a linear flow, found with certainty."""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from mpmath import mp, mpf

from .balls import balls
from .flow import Rows, integer_parts
from .roots import bracketed_root
from .taylor import Balls, Piece, Polynomial, pieces

GUARD_DIGITS = 15


class Crossing(NamedTuple):
    """``time`` is None if there is no crossing. See ``first_crossing`` for ``gap``."""

    time: mpf | None
    gap: mpf


def first_crossing(
    M: Rows,
    z0: Sequence[Any],
    h: Sequence[Any],
    t_end: Any,
    *,
    digits: int = 50,
    zero_tolerance: Any = 0,
) -> Crossing:
    """The first s in (0, t_end] at which g(s) = h . exp(M s) z0 becomes negative.

    ``gap`` is how near this answer is to another one: the least |g| at the stationary points of
    g from the start to the first one behind the crossing, and at t_end if that comes first. A
    miss with a gap, or a crossing into a hump with a depth, below what doubles resolve
    (about 1e-14 times the size of the terms of g) is not a fair question to them.

    The start: time 0 if g(0) < 0, or if g(0) = 0 and its first derivative that is not zero is
    negative; a g that is zero throughout has no crossing. The zeros are exact: all numbers are
    taken as the rationals they are. States that were computed need ``zero_tolerance``, relative
    to sum(|h|) times the largest entry of the state.
    """
    with mp.workdps(digits + GUARD_DIGITS):
        matrix = [[mpf(x) for x in row] for row in M]
        state, guard, end = [mpf(x) for x in z0], [mpf(x) for x in h], mpf(t_end)
        order, leading = leading_derivative(matrix, state, guard, mpf(zero_tolerance))
        if leading == 0:
            return Crossing(None, mp.inf)
        if leading < 0:
            return Crossing(mpf(0), mp.inf)
        arith = balls(digits + GUARD_DIGITS)
        with arith.working():
            scan = _Scan(arith)
            for number, piece in enumerate(pieces(arith, matrix, state, guard, end)):
                scan.run(piece, 0 if number else order)
                if scan.done:
                    break
            else:
                scan.note(abs(arith.middle(piece.polynomial(arith)(arith.exact(piece.length)))))
        return Crossing(scan.time, scan.gap)


def leading_derivative(
    M: list[list[mpf]], z0: list[mpf], h: list[mpf], tolerance: mpf
) -> tuple[int, mpf]:
    """Order and value of the first derivative of g at 0 that is not zero; (n, 0) if none is.

    A guard whose n first derivatives vanish is zero throughout (Cayley-Hamilton).
    """
    exact_m = [[_fraction(x) for x in row] for row in M]
    state, row_h = [_fraction(x) for x in z0], [_fraction(x) for x in h]
    limit = _fraction(tolerance)
    sizes = [abs(x) for x in state]
    for order in range(len(state)):
        value = sum(a * b for a, b in zip(row_h, state, strict=True))
        size = sum(map(abs, row_h)) * max(sizes)
        if abs(value) > limit * size:
            return order, mpf(value.numerator) / value.denominator
        state = [sum(a * b for a, b in zip(row, state, strict=True)) for row in exact_m]
        sizes = [sum(abs(a) * b for a, b in zip(row, sizes, strict=True)) for row in exact_m]
    return len(state), mpf(0)


def _fraction(x: mpf) -> Fraction:
    man, exp = integer_parts(x)
    return Fraction(man) * Fraction(2) ** exp


class _Scan:
    """Goes through the pieces from left to right, splitting where signs are not certain."""

    def __init__(self, arith: Balls) -> None:
        self.arith = arith
        self.time: mpf | None = None
        self.gap = mp.inf
        self.done = False
        # Shorter stretches than this, undecided, are tangencies of higher order.
        self.shortest = mpf(10) ** -(arith.digits // 2)

    def note(self, size: mpf) -> None:
        self.gap = min(self.gap, size)

    def run(self, piece: Piece, known_zeros: int) -> None:
        """Look through one piece. g is divided by the power of s that vanishes at its start."""
        self.start, self.g = piece.start, piece.polynomial(self.arith)
        self.sign = piece.polynomial(self.arith, 0, known_zeros)
        shift = max(known_zeros - 1, 0)
        self.rate = piece.polynomial(self.arith, 1, shift)
        # The rate of that quotient, from its own coefficients.
        self.bend = _rate_of_quotient(self.arith, piece, shift)
        stretches = [(mpf(0), piece.length)]
        while stretches and not self.done:
            low, high = stretches.pop()
            if self._undecided(low, high):
                middle = (low + high) / 2
                stretches += [(middle, high), (low, middle)]

    def _undecided(self, low: mpf, high: mpf) -> bool:
        """Settle a stretch, or say that it must be split."""
        stretch = self.arith.interval(low, high)
        if self._certain(self.rate(stretch)):
            self._monotone(low, high)
        elif self._irrelevant(stretch):
            self.done = self.time is not None
        elif self._certain(self.bend(stretch)):
            for point in self._stationary(low, high):
                self._monotone(low, point)
                self._extremum(point)
                low = point
            self._monotone(low, high)
        elif high - low < self.shortest:
            self._extremum((low + high) / 2)
            self._monotone(low, high)
        else:
            return True
        return False

    def _irrelevant(self, stretch: Any) -> bool:
        """No crossing, and no extremum nearer to zero than one already seen."""
        side = self.arith.positive if self.time is None else self.arith.negative
        return side(self.sign(stretch)) and (self.arith.smallest_size(self.g(stretch)) >= self.gap)

    def _stationary(self, low: mpf, high: mpf) -> list[mpf]:
        """The one stationary point where the rate is monotone, if there is one."""
        ends = [self.rate(self.arith.exact(x)) for x in (low, high)]
        for x, rate in zip((low, high), ends, strict=True):
            if not self._certain(rate):
                return [x]
        if self.arith.positive(ends[0]) == self.arith.positive(ends[1]):
            return []
        return [bracketed_root(self._rounded(self.rate), low, high)]

    def _monotone(self, low: mpf, high: mpf) -> None:
        """g has at most one zero here: the sign at the end tells."""
        if self.done:
            return
        if self.time is None and self.arith.negative(self.sign(self.arith.exact(high))):
            f = self._rounded(self.sign)
            self.time = self.start + (bracketed_root(f, low, high) if f(low) > 0 else low)
        if self.time is not None:
            # Falling, g is farther from zero at its next extremum than here.
            self.done = self.arith.smallest_size(self.g(self.arith.exact(high))) >= self.gap

    def _extremum(self, point: mpf) -> None:
        if not self.done:
            self.note(abs(self._rounded(self.g)(point)))
            self.done = self.time is not None

    def _certain(self, x: Any) -> bool:
        return self.arith.positive(x) or self.arith.negative(x)

    def _rounded(self, polynomial: Polynomial) -> Polynomial:
        """The same polynomial in plain numbers."""
        return Polynomial([self.arith.middle(c) for c in polynomial.coefficients])


def _rate_of_quotient(arith: Balls, piece: Piece, shift: int) -> Polynomial:
    """d/ds of g'(s) / s^shift."""
    c = [x * (k + 1) for k, x in enumerate(piece.series[1:])][shift:]
    c = [x * (k + 1) for k, x in enumerate(c[1:])]
    c[0] += arith.around_zero(piece.remainder * piece.norm ** (2 + shift))
    return Polynomial(c)
