"""Ball and interval arithmetic behind one set of names: python-flint, or mpmath without it.

Only sums, products and signs are needed. With flint, every number carries a proven error bound.
Without it, intervals are mpmath's, and the states at the nodes of the time grid are rounded
values with many guard digits, widened by a margin: right up to that margin being enough.
"""

from collections.abc import Iterator
from typing import Any

from mpmath import iv, mp, mpf

from .flow import integer_parts

try:
    import flint
except ImportError:  # the fallback below then serves
    flint = None


class FlintBalls:
    """Balls of the Arb library."""

    def __init__(self, digits: int) -> None:
        self.digits = digits

    def working(self) -> Any:
        """The context in which every other method must be called."""
        return flint.ctx.workprec(int(self.digits * 3.33) + 8)

    def exact(self, x: mpf) -> Any:
        return flint.arb(integer_parts(x))

    def interval(self, low: mpf, high: mpf) -> Any:
        return self.exact(low).union(self.exact(high))

    def around_zero(self, radius: mpf) -> Any:
        return self.interval(-radius, radius)

    def positive(self, x: Any) -> bool:
        return x > 0

    def negative(self, x: Any) -> bool:
        return x < 0

    def middle(self, x: Any) -> mpf:
        man, exp = x.mid().man_exp()
        return mp.ldexp(mpf(int(man)), int(exp))

    def smallest_size(self, x: Any) -> mpf:
        return self.middle(x.abs_lower())

    def nodes(self, M: list[list[mpf]], z0: list[mpf], step: mpf) -> Iterator[list[Any]]:
        """exp(M n step) z0 for n = 0, 1, ...

        Each node has its own matrix exponential: going from node to node would multiply the
        radii by exp(norm(M) step) every time.
        """
        n = len(z0)
        matrix = flint.arb_mat(n, n, [self.exact(x) for row in M for x in row])
        start = flint.arb_mat(n, 1, [self.exact(x) for x in z0])
        matrix *= self.exact(step)
        count = 0
        while True:
            state = (matrix * count).exp() * start
            yield [state[i, 0] for i in range(n)]
            count += 1


class IntervalBalls:
    """Intervals of mpmath: about five times slower."""

    GUARD_DIGITS = 40

    def __init__(self, digits: int) -> None:
        self.digits = digits

    def working(self) -> Any:
        return _IntervalDigits(self.digits)

    def exact(self, x: mpf) -> Any:
        return iv.mpf([x, x])

    def interval(self, low: mpf, high: mpf) -> Any:
        return iv.mpf([low, high])

    def around_zero(self, radius: mpf) -> Any:
        return iv.mpf([-radius, radius])

    def positive(self, x: Any) -> bool:
        return mpf(x.a) > 0

    def negative(self, x: Any) -> bool:
        return mpf(x.b) < 0

    def middle(self, x: Any) -> mpf:
        return mpf(x.mid)

    def smallest_size(self, x: Any) -> mpf:
        low, high = mpf(x.a), mpf(x.b)
        return mpf(0) if low <= 0 <= high else min(abs(low), abs(high))

    def nodes(self, M: list[list[mpf]], z0: list[mpf], step: mpf) -> Iterator[list[Any]]:
        """exp(M n step) z0 for n = 0, 1, ..., one rounded product after the other."""
        with mp.workdps(self.digits + self.GUARD_DIGITS):
            factor = mp.expm(mp.matrix(M) * step, method="taylor")
            state = mp.matrix(z0)
        while True:
            margin = self.around_zero(mpf(10) ** -self.digits * mp.mnorm(state, mp.inf))
            yield [self.exact(x) + margin for x in state]
            with mp.workdps(self.digits + self.GUARD_DIGITS):
                state = factor * state


class _IntervalDigits:
    """mpmath's interval context has no ``workdps`` of its own."""

    def __init__(self, digits: int) -> None:
        self.digits = digits

    def __enter__(self) -> None:
        self.before, iv.dps = iv.dps, self.digits

    def __exit__(self, *_: object) -> None:
        iv.dps = self.before


def balls(digits: int) -> FlintBalls | IntervalBalls:
    """The better arithmetic of those installed."""
    return FlintBalls(digits) if flint is not None else IntervalBalls(digits)
