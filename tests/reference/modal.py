"""First crossings of several guards for any linear flow, stiff ones too: a sum of exponentials.

The pieces of `taylor.py` are 1 / norm(M) long, which a fast decay makes hopeless. Here the
eigenvalues are enclosed by balls (Arb), each guard is a sum of c exp(lambda s), and on each piece
the Taylor series has proven tails, mode by mode; a motion that has died bounds no step. What is
done with a piece is the work of `crossing.py`.

A defect has no such sum. There the matrix is changed by 1e-78 of its size, and the digits are
raised to carry the large coefficients that nearly equal eigenvalues have.
"""

import math
import random
from collections.abc import Sequence
from typing import Any, NamedTuple

import flint
from mpmath import mp, mpf

from .balls import FlintBalls
from .crossing import Crossing, _Scan, leading_derivative
from .flow import integer_parts
from .taylor import Piece

# bits, bits at which the matrix is changed (0: not at all), terms of the series
LADDER = ((320, 0, 40), (1000, 260, 80), (2600, 260, 80), (6000, 300, 100))
TURN = 1.2  # radians or lives of the fastest live motion in one piece: intervals stay tight
SMALL = 1e-34  # of the terms of a guard: what the series may leave out


class First(NamedTuple):
    """The first crossing of all guards; gap and the place of it belong to guard ``nearest``."""

    time: mpf | None
    number: int
    gaps: list[float]
    places: list[float]


class Modes:
    """Guards H exp(M s) z as sums of exponentials."""

    def __init__(self, M: Any, z: Sequence[float], H: Any, end: float) -> None:
        for self.bits, change, self.terms in LADDER:
            flint.ctx.prec = self.bits
            try:
                self._split(M, z, H, end, change)
            except (ValueError, ZeroDivisionError):
                continue
            if self._sharp():
                return
        raise ArithmeticError("no eigenvalues")

    def _split(self, M: Any, z: Any, H: Any, end: float, change: int) -> None:
        n, rng = len(z), random.Random(7)
        self.sizes = [_terms(M, z, row, end) for row in H]
        unit = flint.arb(2) ** -change if change else flint.arb(0)
        largest = float(max(max(map(abs, row)) for row in M)) or 1.0
        matrix = flint.acb_mat(
            [
                [_ball(x) + unit * (rng.uniform(-1, 1) * (float(abs(x)) or largest)) for x in row]
                for row in M
            ]
        )
        self.values = matrix.eig()
        start = flint.acb_mat([[_ball(x)] for x in z])
        guards = flint.acb_mat([[_ball(x) for x in row] for row in H])
        parts = [guards * self._part(matrix, start, j) for j in range(n)]
        self.coefficients = [[parts[j][g, 0] for j in range(n)] for g in range(len(H))]
        powers = []
        for k in range(self.terms):
            before = powers[-1] if powers else None
            powers.append(
                [before[j] * v / k for j, v in enumerate(self.values)]
                if before
                else [flint.acb(1)] * n
            )
        self.powers = flint.acb_mat(powers).transpose()
        self.speeds = [float(abs(v).mid()) * 1.001 for v in self.values]
        self.growths = [float(v.real.mid()) for v in self.values]

    def _part(self, matrix: Any, start: Any, j: int) -> Any:
        """The part of the start in motion j: Lagrange's product, which needs no vectors."""
        part = start
        for i, value in enumerate(self.values):
            if i != j:
                part = (matrix * part - part * value) * (1 / (self.values[j] - value))
        return part

    def _sharp(self) -> bool:
        """Whether the sums at the start are known well enough."""
        for size, row in zip(self.sizes, self.coefficients, strict=True):
            if not float(sum(row, flint.acb(0)).real.rad()) <= 1e-6 * SMALL * size:
                return False
        return True

    def piece(self, start: mpf, end: mpf) -> list[Piece]:
        """The pieces of all guards from ``start`` on, as long as the series allows."""
        grown = [(v * _ball(start)).exp() for v in self.values]
        now = [[c * e for c, e in zip(row, grown, strict=True)] for row in self.coefficients]
        sizes = [[_size(c) for c in row] for row in now]
        length = float(end - start)
        while True:
            tails = [self._tail(row, length, start) for row in sizes]
            if all(t <= SMALL * s for (t, _), s in zip(tails, self.sizes, strict=True)):
                break
            length *= 0.5
        norm = self.terms / length
        pieces = []
        for row, (rest, dead) in zip(now, tails, strict=True):
            kept = [flint.acb(0) if gone else c for c, gone in zip(row, dead, strict=True)]
            series = flint.acb_mat([kept]) * self.powers
            terms = [series[0, k].real for k in range(self.terms)]
            pieces.append(Piece(mpf(start), mpf(length), terms, mpf(2 * rest), mpf(norm)))
        return pieces

    def _tail(self, sizes: list[float], length: float, start: float) -> tuple[float, list[bool]]:
        """Bound of what the series leaves out, and which motions it leaves out altogether.

        exp(-a s) less k terms of its series is below (a s)^k / k!, or below one without them.
        Rates of motions left out are large: up to two derivatives, and at the start, where up
        to three powers of s may be divided out, five.
        """
        k, total, dead = self.terms, 0.0, []
        for size, speed, growth in zip(sizes, self.speeds, self.growths, strict=True):
            turn = speed * length
            rest = k * math.log(turn) - math.lgamma(k + 1) if turn > 0.0 else -1e3
            dead.append(turn > TURN and growth < 0.0)
            if size > 0.0 and dead[-1]:
                total += size * max(1.0, turn / k) ** (2 if start else 5)
            elif turn > TURN and size > 0.0:
                return math.inf, dead
            elif size > 0.0:
                total += size * math.exp(min(rest + max(growth, 0.0) * length, 600.0))
        return total, dead


def _ball(x: Any) -> Any:
    """A double or mpf as the number that it is."""
    return flint.arb(integer_parts(mpf(x)))


def _terms(M: Any, z: Any, row: Any, end: float) -> float:
    """Size of the terms of a guard at the start; if all are zero, that of the next derivative."""
    state, factor = [abs(x) for x in z], 1.0
    for k in range(1, 6):
        size = factor * sum(abs(h) * x for h, x in zip(row, state, strict=True))
        if size > 0.0:
            return float(size)
        state = [sum(abs(a) * x for a, x in zip(m, state, strict=True)) for m in M]
        factor *= end / k
    return 1e-300


def _size(c: Any) -> float:
    upper = c.abs_upper()
    return float(upper.mid()) if upper > 1e-290 else 0.0


class _PlacedScan(_Scan):
    """Also says where the nearest miss is."""

    place = 0.0
    flat = mpf(0)

    def _undecided(self, low: mpf, high: mpf) -> bool:
        """Where all motions have died the guard is flat, and its rate has no certain sign.

        A guard that is flat at zero is a miss by nothing.
        """
        if self.start > 0:
            value = self.g(self.arith.interval(low, high))
            if self.arith.middle(value.abs_upper()) < self.flat:
                self._extremum(low)
                return False
            if self._certain(value) and self.arith.middle(value.rad()) < self.flat:
                self._extremum(low)
                self._monotone(low, high)
                return False
        return super()._undecided(low, high)

    def _extremum(self, point: mpf) -> None:
        before = self.gap
        super()._extremum(point)
        if self.gap < before:
            self.place = float(self.start + point)


def first_of(
    M: Any, z: Any, H: Any, t_end: Any, cap: float = 1e-2, zero_tolerance: Any = 0
) -> First:
    """The first of all guards that crosses in (0, t_end].

    Numbers are doubles or mpf, taken as they are. Misses farther than ``cap`` of the terms of a
    guard at the start are not looked at: gaps are inf there. A guard that starts at zero or
    below and must fall has time 0.
    """
    precision = flint.ctx.prec
    try:
        with mp.workdps(80):
            return _first_of(M, z, H, t_end, cap, mpf(zero_tolerance))
    finally:
        flint.ctx.prec = precision


def _first_of(M: Any, z: Any, H: Any, t_end: Any, cap: float, zero: mpf) -> First:
    modes, arith = Modes(M, z, H, t_end), FlintBalls(65)
    exact = [[mpf(x) for x in row] for row in M], [mpf(x) for x in z]
    orders, scans = [], []
    for row, size in zip(H, modes.sizes, strict=True):
        order, leading = leading_derivative(*exact, [mpf(x) for x in row], zero)
        if leading < 0:
            return First(mpf(0), len(scans), [math.inf] * len(H), [0.0] * len(H))
        orders.append(order)
        scan = _PlacedScan(arith)
        scan.gap, scan.done, scan.flat = mpf(cap * size), leading == 0, mpf(1e-28 * size)
        scans.append(scan)
    start, first, pieces = mpf(0), None, []
    while start < t_end and not all(s.done for s in scans):
        if first is not None and all(s.done for s in scans if s.time is not None):
            break
        pieces = modes.piece(start, t_end)
        for number, (scan, piece) in enumerate(zip(scans, pieces, strict=True)):
            if not scan.done and (first is None or scan.time is not None):
                scan.run(piece, 0 if start else orders[number])
        crossed = [(s.time, i) for i, s in enumerate(scans) if s.time is not None]
        first = min(crossed) if crossed else None
        start = pieces[0].start + pieces[0].length
    if first is None:
        _note_ends(scans, pieces, arith, t_end)
    gaps = [float(s.gap) if s.place else math.inf for s in scans]
    time, number = first or (None, -1)
    return First(time, number, gaps, [s.place for s in scans])


def _note_ends(
    scans: list[_PlacedScan], pieces: list[Piece], arith: FlintBalls, t_end: float
) -> None:
    for scan, piece in zip(scans, pieces, strict=False):
        size = abs(arith.middle(piece.polynomial(arith)(arith.exact(piece.length))))
        if size < scan.gap and not scan.done:
            scan.gap, scan.place = size, t_end


def first_crossing(
    M: Any, z0: Any, h: Any, t_end: Any, *, digits: int = 30, zero_tolerance: Any = 0
) -> Crossing:
    """`crossing.first_crossing` for stiff flows: 30 digits, gaps up to 1e-2 of the terms."""
    if digits > 50:
        raise ValueError("at most 50 digits")
    found = first_of(M, z0, [h], t_end, zero_tolerance=zero_tolerance)
    return Crossing(found.time, mpf(found.gaps[0]))
