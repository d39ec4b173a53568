"""First crossings of closed forms, none missed, by chains of monotone functions (Rolle).

A guard f comes with a chain of levels f = f_0, f_1, ..., f_n such that between two neighbouring
zeros of f_{k+1} some positive multiple of f_k is monotone, and such that the zeros of f_n are
known in closed form. A monotone function has at most one zero, and the signs at the two ends
tell whether it has it. So the zeros of f_{n-1} follow from those of f_n, and so on up to f:
no step width, no sampling, no bound to be guessed.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

from mpmath import mp, mpf

Function = Callable[[mpf], mpf]

# Values below this are rounding at 50 digits: what they decide is not known.
TINY = mpf(10) ** -35


class Undecidable(Exception):
    """Two different courses of events agree to within the rounding of the reference."""


def bracketed_root(f: Function, low: mpf, high: mpf) -> mpf:
    """The zero between two points at which f has opposite signs: secants, bisection as guard."""
    x, fx, far = high, f(high), low
    previous, f_previous = low, f(low)
    last_step = before_last = high - low
    while fx != 0:
        tolerance = 1000 * mp.eps * (1 + abs(x))
        if abs(far - x) <= 2 * tolerance:
            break
        slope = (fx - f_previous) / (x - previous)
        step = -fx / slope if slope else far - x
        # As Brent does: a secant step must stay inside and keep shrinking.
        if not 0 < step / (far - x) < 1 or 2 * abs(step) > abs(before_last):
            step = (far - x) / 2
        # A shortest step jumps over the zero once x is there, which closes the bracket.
        if abs(step) < tolerance:
            step = tolerance * mp.sign(far - x)
        last_step, before_last = step, last_step
        new = x + step
        f_new = f(new)
        if f_new * fx < 0:
            far = x
        previous, f_previous, x, fx = x, fx, new, f_new
    return x


def sign_changes(f: Function, points: Sequence[mpf], zero_at_start: bool) -> list[mpf]:
    """All zeros of f, of which a positive multiple is monotone between neighbouring points."""
    values = [f(point) for point in points]
    if zero_at_start:
        values[0] = mpf(0)  # exactly, so the first interval holds no other zero
    return [
        bracketed_root(f, low, high)
        for (low, high), (f_low, f_high) in zip(pairwise(points), pairwise(values), strict=True)
        if f_low * f_high < 0
    ]


def first_crossing(
    levels: Sequence[Function], last_zeros: list[mpf], low: mpf, high: mpf, known_zeros: int
) -> tuple[mpf | None, mpf]:
    """Where f = levels[0] first falls below zero in (low, high], and its nearest miss before that.

    ``levels`` are f_0 ... f_{n-1}, ``last_zeros`` the zeros of f_n between low and high, and
    ``known_zeros`` the number of leading Taylor coefficients of f at ``low`` that vanish exactly.
    The nearest miss is the least |f| at the extrema of that multiple of f which is monotone
    between them; next to a tangency it is the depth of the miss or of the crossing.
    """
    inner = last_zeros
    for k in range(len(levels) - 1, 0, -1):
        inner = sign_changes(levels[k], [low, *inner, high], known_zeros > k)
    f = levels[0]
    gap = mp.inf
    if known_zeros == 0 and f(low) < TINY:
        raise Undecidable(f"the guard is {mp.nstr(f(low), 5)} where it should be positive")
    before = low
    for point in [*inner, high]:
        value = f(point)
        if point is not high:
            gap = min(gap, abs(value))
            if gap < TINY:
                raise Undecidable(f"the guard grazes zero to within {mp.nstr(gap, 5)}")
        if value < 0:
            if known_zeros and before is low:
                raise Undecidable("the guard falls at once from a zero it should rise from")
            return bracketed_root(f, before, point), gap
        before = point
    return None, gap


def harmonic_zeros(
    constant: mpf, cosine: mpf, sine: mpf, omega: mpf, theta0: mpf, low: mpf, high: mpf
) -> list[mpf]:
    """The s in (low, high) with constant + cosine cos(theta) + sine sin(theta) = 0.

    theta is theta0 + omega s. None where the expression is constant or keeps its sign.
    """
    radius = mp.hypot(cosine, sine)
    if radius == 0 or abs(constant) >= radius:
        return []
    middle, half_width = mp.atan2(sine, cosine), mp.acos(-constant / radius)
    turn = 2 * mp.pi
    found = []
    for angle in (middle - half_width, middle + half_width):
        first = mp.ceil((theta0 + omega * low - angle) / turn)
        s = (angle + turn * first - theta0) / omega
        while s < high:
            if s > low:
                found.append(s)
            s += turn / omega
    return sorted(found)
