"""The snubber ring by the quartics of the chapter's Table 6, to thirty digits.

Positions are exact fractions, roots of the quartics are isolated by flint, and of the four
candidates for the regime the one is taken whose ring position is within its own bounds. Velocities
follow from the derivative of the quartic along the motion, energies by the work of Eq. (60). The
multiplier, on which the library's formulas rest, plays no part.
"""

from dataclasses import dataclass

from flint import arb, ctx, fmpq, fmpq_poly

DIGITS = 34


@dataclass
class Ring:
    """One quadrant's ring, and in the end the ring: numbers of 34 digits."""

    regime: int
    sx: arb
    sy: arb
    vx: arb
    vy: arb


def exact(value):
    return fmpq(*float(value).as_integer_ratio())


def number(value):
    return arb(exact(value)) if not isinstance(value, fmpq) else arb(value)


def wanted_root(y, shifted):
    """Root in [0, y) of (y - t)^2 (X^2 + (y + t)^2) = (y + t)^2."""
    t = fmpq_poly([0, 1])
    quartic = (y - t) ** 2 * (shifted**2 + (y + t) ** 2) - (y + t) ** 2
    roots = [root.real for root, _ in quartic.complex_roots() if root.imag == 0]
    (root,) = [root for root in roots if root >= 0 and root < arb(y)]
    return root


def radial(x, y, vx, vy):
    """Ring behind a rotor at (x, y) on equal springs, and its velocity."""
    radius = arb(x * x + y * y).sqrt()
    share, growth = 1 - 1 / radius, (arb(x) * vx + arb(y) * vy) / radius**3
    return [arb(x) * share, arb(y) * share, vx * share + x * growth, vy * share + y * growth]


def one_spring_in_x(x, y, delta, vx, vy):
    """Third row of Table 6, corrected: the quartic for y_s, then x_s."""
    shifted = x + delta
    if y == 0:  # the limit of y_s / y is mu/(2 + mu), with 1 + mu = X
        mu = arb(shifted) - 1
        return [arb(x) - 1, arb(0), vx, vy * mu / (2 + mu)]
    t, X, Y = wanted_root(y, shifted), arb(shifted), arb(y)
    # Q(t; X, y) = (y - t)^2 (X^2 + (y + t)^2) - (y + t)^2 = 0 along the motion
    by_t = -2 * (Y - t) * (X**2 + (Y + t) ** 2) + 2 * (Y - t) ** 2 * (Y + t) - 2 * (Y + t)
    by_y = 2 * (Y - t) * (X**2 + (Y + t) ** 2) + 2 * (Y - t) ** 2 * (Y + t) - 2 * (Y + t)
    by_x = 2 * (Y - t) ** 2 * X
    rate = -(by_x * vx + by_y * vy) / by_t
    ratio = 2 * t / (Y + t)
    ratio_rate = 2 * (rate * Y - t * vy) / (Y + t) ** 2
    return [X * ratio - delta, t, vx * ratio + X * ratio_rate, rate]


def candidates(x, y, delta_x, delta_y, vx, vy):
    yield 2, radial(x, y, vx, vy)
    yield 3, one_spring_in_x(x, y, delta_x, vx, vy)
    sy, sx, rate_y, rate_x = one_spring_in_x(y, x, delta_y, vy, vx)
    yield 4, [sx, sy, rate_x, rate_y]
    sx, sy, rate_x, rate_y = radial(x + delta_x, y + delta_y, vx, vy)
    yield 5, [sx - delta_x, sy - delta_y, rate_x, rate_y]


def agrees(s, delta, beyond):
    """Without preload there is one spring at a time; else one beyond it and two within."""
    return beyond if delta == 0 else (s > delta) == beyond


def ring(x, y, delta_x, delta_y, vx=0.0, vy=0.0):
    """Regime, position and velocity of the ring for one rotor position."""
    ctx.dps = DIGITS
    x, y, delta_x, delta_y, vx, vy = map(exact, (x, y, delta_x, delta_y, vx, vy))
    if x * x + y * y < 1:
        return Ring(1, *[arb(0)] * 4)
    flip_x, flip_y = (1 if value >= 0 else -1 for value in (x, y))
    fitting = []
    for regime, values in candidates(
        flip_x * x, flip_y * y, delta_x, delta_y, arb(flip_x * vx), arb(flip_y * vy)
    ):
        beyond_x, beyond_y = regime in (3, 5), regime in (4, 5)
        if agrees(values[0], delta_x, beyond_x) and agrees(values[1], delta_y, beyond_y):
            fitting.append((regime, values))
    ((regime, (sx, sy, rate_x, rate_y)),) = fitting
    return Ring(regime, flip_x * sx, flip_y * sy, flip_x * rate_x, flip_y * rate_y)


def force(state, K, nu2, delta_x, delta_y):
    """Table 4 by regime, which agrees with Eqs. (55)-(59)."""
    if state.regime == 1:
        return arb(0), arb(0)
    K, nu2 = number(K), number(nu2)
    return tuple(
        K * (s + (1 if s > 0 else -1 if s < 0 else 0) * number(delta)) + 2 * nu2 * v
        if beyond
        else 2 * K * s + 4 * nu2 * v
        for s, v, delta, beyond in (
            (state.sx, state.vx, delta_x, state.regime in (3, 5)),
            (state.sy, state.vy, delta_y, state.regime in (4, 5)),
        )
    )


def work(s, delta):
    """Work of Eq. (60) on one axis over the stiffness, piece by piece."""
    s, delta = abs(s), number(delta)
    inner = s if s < delta else delta
    outer = s - inner  # the force there runs from 2 delta to s + delta
    return inner**2 + outer * (2 * delta + s + delta) / 2


def energy(state, K, delta_x, delta_y):
    return number(K) * (work(state.sx, delta_x) + work(state.sy, delta_y))


def to_boundary(x, y, delta_x, delta_y, state):
    """How far the ring is from a boundary of its regime, and the rotor from touching."""
    distances = [abs(arb(exact(x) ** 2 + exact(y) ** 2).sqrt() - 1)]
    if state.regime > 1:
        distances += [
            abs(abs(s) - number(delta))
            for s, delta in ((state.sx, delta_x), (state.sy, delta_y))
            if delta > 0
        ]
    return min(float(d) for d in distances)
