"""The guard g(s) = h . exp(M s) z0 as a row of Taylor polynomials with proven remainders."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from mpmath import mp, mpf

from .balls import FlintBalls, IntervalBalls

Balls = FlintBalls | IntervalBalls
Matrix = list[list[mpf]]


class Polynomial(NamedTuple):
    """Coefficients as balls; the remainder is part of the first."""

    coefficients: list[Any]

    def __call__(self, x: Any) -> Any:
        value = self.coefficients[-1]
        for c in reversed(self.coefficients[:-1]):
            value = value * x + c
        return value


class Piece(NamedTuple):
    """g on [start, start + length], as a series in s - start.

    What the series leaves out of its derivative of order d, divided by (s - start)^r, is below
    ``remainder`` norm^(d + r), for d up to 2.
    """

    start: mpf
    length: mpf
    series: list[Any]
    remainder: mpf
    norm: mpf

    def polynomial(self, arith: Balls, derivative: int = 0, shift: int = 0) -> Polynomial:
        """That derivative divided by (s - start)^shift; the coefficients dropped are zero."""
        c = self.series
        for _ in range(derivative):
            c = [x * (k + 1) for k, x in enumerate(c[1:])]
        bound = self.remainder * self.norm ** (derivative + shift)
        return Polynomial([c[shift] + arith.around_zero(bound), *c[shift + 1 :]])


def pieces(arith: Balls, M: Matrix, z0: list[mpf], h: list[mpf], t_end: mpf) -> Iterator[Piece]:
    """The pieces that cover [0, t_end], from left to right, each 1 / norm(M) long."""
    M, z0, h = balanced(M, z0, h)
    norm = max(mp.mnorm(mp.matrix(M), mp.inf), 1 / t_end)
    step = 1 / norm
    terms = n_terms(arith.digits)
    zero = arith.exact(mpf(0))
    rows = [[(j, arith.exact(x)) for j, x in enumerate(row) if x] for row in M]
    guard = [(j, arith.exact(x)) for j, x in enumerate(h) if x]
    for index, state in enumerate(arith.nodes(M, z0, step)):
        start = index * step
        if start >= t_end:
            return
        # Twice the middles: more than the radii can add.
        size = 2 * sum(map(abs, h)) * max(abs(arith.middle(x)) for x in state)
        series = []
        for k in range(terms):
            series.append(sum((x * state[j] for j, x in guard), zero))
            part = arith.exact(mpf(1)) / (k + 1)
            state = [sum((x * state[j] for j, x in row), zero) * part for row in rows]
        # Terms from k = n on: norm^k step^k / k! each, k (k - 1) times that in the derivatives.
        remainder = 3 * size / mp.factorial(terms - 2)
        yield Piece(start, min(step, t_end - start), series, remainder, norm)


def n_terms(digits: int) -> int:
    """Terms after which the remainder is below the precision."""
    k = 10
    while mp.factorial(k - 2) < mpf(10) ** (digits + 4):
        k += 1
    return k


def balanced(M: Matrix, z0: list[mpf], h: list[mpf]) -> tuple[Matrix, list[mpf], list[mpf]]:
    """The same guard in coordinates scaled by powers of two, exactly, to make norm(M) small."""
    n = len(z0)
    M, z0, h = [row[:] for row in M], z0[:], h[:]
    for _ in range(8):
        for i in range(n):
            others = [j for j in range(n) if j != i]
            row, column = sum(abs(M[i][j]) for j in others), sum(abs(M[j][i]) for j in others)
            if not row or not column:
                continue
            scale = mpf(2) ** int(mp.nint(mp.log(row / column, 2) / 2))
            for j in others:
                M[i][j] /= scale
                M[j][i] *= scale
            z0[i] /= scale
            h[i] *= scale
    return M, z0, h
