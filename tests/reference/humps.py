"""Guards in closed form with a hump that just reaches zero or just misses it.

    g(t) = c + d t + sum of exp(a t) (p cos(w t) + q sin(w t)),  two damped parts and one with a = 0

g is below zero until shortly before its hump at ``top``. There it is lifted so that its two
roots lie ``gap`` apart, or lowered by as much so that it has none. Its first root is enclosed by
ball arithmetic from the doubles that stand in the case, so it is that of the guard as given and
not of the one that was meant.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from flint import arb, ctx

T_END = 10.0
CLEARANCE = 1e-3  # g is below minus this up to HEADWAY before the hump
HEADWAY = 0.4
SHARPEST = 1e-14
GOLDEN = (5**0.5 - 1) / 2


class Part(NamedTuple):
    """exp(a t) (p cos(w t) + q sin(w t))."""

    a: float
    w: float
    p: float
    q: float


class Hump(NamedTuple):
    """``gap`` is negative where there are no roots; ``bend`` is -g'' at the top."""

    c: float
    d: float
    parts: tuple[Part, ...]
    top: float
    gap: float
    bend: float

    @property
    def size(self) -> float:
        """What the terms of g add up to."""
        swing = sum(np.hypot(part.p, part.q) for part in self.parts)
        return abs(self.c) + abs(self.d) * T_END + float(swing)


def derivatives(c, d, parts, t):
    """g, g' and g'' in double precision; t may be an array."""
    g, rate, second = c + d * t, d + 0 * t, 0 * t
    for a, w, p, q in parts:
        u = np.exp(a * t) * (p * np.cos(w * t) + q * np.sin(w * t))
        v = np.exp(a * t) * (q * np.cos(w * t) - p * np.sin(w * t))
        g, rate, second = g + u, rate + a * u + w * v, second + (a * a - w * w) * u + 2 * a * w * v
    return g, rate, second


def draw_humps(seed: int, count: int, gaps: tuple[float, float]) -> Iterator[Hump]:
    """Cases with gaps between the two powers of ten, half of them without roots."""
    rng = np.random.default_rng(seed)
    drawn = 0
    while drawn < count:
        damping, speed = [-rng.uniform(0, 1), -(10 ** rng.uniform(-3, 0.5)), 0.0], rng.uniform
        waves = [speed(0.3, 8), speed(0.3, 8), speed(0.3, 3)]
        size = rng.normal(size=(3, 2))
        parts = tuple(Part(a, w, *pq) for a, w, pq in zip(damping, waves, size, strict=True))
        top, tilt = rng.uniform(0.5, T_END - 0.5), 0.2 * rng.normal()
        tilt -= derivatives(0.0, tilt, parts, top)[1]
        height, _, second = derivatives(0.0, tilt, parts, top)
        # spread evenly over the decades, whatever is rejected
        sign, share = rng.choice([-1.0, 1.0]), drawn * GOLDEN % 1.0
        gap = gaps[0] * (gaps[1] / gaps[0]) ** share
        lift = sign * abs(second) * gap**2 / 8 - height
        before = np.linspace(0.0, max(top - HEADWAY, 0.0), 200)
        if second < -0.05 and (derivatives(lift, tilt, parts, before)[0] < -CLEARANCE).all():
            drawn += 1
            parts = tuple(Part(*map(float, part)) for part in parts)
            yield Hump(float(lift), float(tilt), parts, top, float(sign * gap), float(-second))


def first_root(case: Hump) -> tuple[float, float]:
    """First time at which g rises above zero, and its rate there; infinite if it does not."""
    before, ctx.prec = ctx.prec, 160
    try:
        return _search(case)
    finally:
        ctx.prec = before


def _enclose(case: Hump, t: arb) -> tuple[arb, arb]:
    g, rate = arb(case.c) + arb(case.d) * t, arb(case.d)
    for a, w, p, q in case.parts:
        (sin, cos), e = (w * t).sin_cos(), (a * t).exp()
        u, v = e * (p * cos + q * sin), e * (q * cos - p * sin)
        g, rate = g + u, rate + a * u + w * v
    return g, rate


def _search(case: Hump) -> tuple[float, float]:
    stack = [(0.0, T_END)]
    while stack:
        low, high = stack.pop()
        middle, half = (low + high) / 2, (high - low) / 2
        value, rate = _enclose(case, arb(middle, half))
        # the mean value form is the sharper one on short stretches
        if value < 0 or _enclose(case, arb(middle))[0] + rate * arb(0, half) < 0:
            continue
        rises, falls = rate > 0, rate < 0
        if rises and _enclose(case, arb(high))[0] > 0:
            return _bisect(case, low, high)
        if rises and _enclose(case, arb(high))[0] < 0:
            continue
        if falls and _enclose(case, arb(low))[0] < 0:
            continue
        if half < SHARPEST:
            raise ArithmeticError(f"a tangency at {middle} that 160 bits do not decide")
        stack += [(middle, high), (low, middle)]
    return np.inf, 0.0


def _bisect(case: Hump, low: float, high: float) -> tuple[float, float]:
    while low < (low + high) / 2 < high:
        middle = (low + high) / 2
        low, high = (middle, high) if _enclose(case, arb(middle))[0] < 0 else (low, middle)
    return high, float(_enclose(case, arb(high))[1].mid())
