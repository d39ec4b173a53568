"""The rotor in a preloaded snubber ring, for `smooth_run`: each contact regime is a mode.

State: x, y, vx, vy, sx, sy, mu, and the time since the ring was let go. In x and in y two springs
touch the ring (written 0), or one, on the side of + or -; with a springs, s = x - d and
d = a X/(a + mu), where X = x + sign Delta if a = 1 else x. |d| = 1 gives mu at the start of a
regime (Newton's method), and its rate afterwards.

    contact II00, III+0, IV0-, V++ ...     until n . F = 0, or |sx| or |sy| passes the preload
    free    I00, I+0 ...                   a ring beyond its preload still relaxes on one spring
    free    I                              a ring at rest in its centre
    let go  after a release, for no time: are rotor and ring parting?
    stuck   they are not, so neither contact nor flight can go on
"""

from collections.abc import Sequence
from itertools import product
from typing import Any, NamedTuple

from flint import arb
from mpmath import mp, mpf

from .nonlinear import DIGITS, SmoothExit, SmoothMode, SmoothModel
from .nonlinear_models import Case
from .power_series import cos, sin, sqrt

STATES = ["x", "y", "vx", "vy", "sx", "sy", "mu", "age"]
LIVES = 80  # of the free ring, after which it stands in its centre to 34 digits
REGIMES = {(2, 2): "II", (1, 2): "III", (2, 1): "IV", (1, 1): "V"}
SIGNS = {"0": 0, "+": 1, "-": -1}


class Side(NamedTuple):
    """Springs in touch in x or in y. ``sign`` is 0 with two, else the side of the ring."""

    letter: str
    preloaded: bool

    @property
    def sign(self) -> int:
        return SIGNS[self.letter] if self.preloaded else 0

    @property
    def count(self) -> int:
        return 1 if self.sign or not self.preloaded else 2


def rotor_case(parameters: dict[str, float], start: Sequence[float], times: Sequence[Any]) -> Case:
    """A run of the rotor from a free start (x, y, vx, vy) with the ring in its centre."""
    model = rotor_model(parameters["delta_x"] > 0, parameters["delta_y"] > 0)
    return Case(model, parameters, [*start, 0.0, 0.0, 0.0, 0.0], "I", times)


def rotor_model(preload_x: bool, preload_y: bool) -> SmoothModel:
    """Modes for a ring with or without preload in each direction."""
    modes = {"stuck": SmoothMode(lambda t, z, p: [0 * each for each in z])}
    modes["I"] = SmoothMode(free_rates(None, None), [meeting(preload_x, preload_y)])
    sides = [
        [Side(c, True) for c in "0+-"] if p else [Side("0", False)] for p in (preload_x, preload_y)
    ]
    for x, y in product(*sides):
        signs = x.letter + y.letter
        modes[regime(x, y) + signs] = contact(x, y)
        modes["I" + signs] = flight(x, y)
        opening = SmoothExit(parting(x, y), "stuck")
        onward = SmoothExit(lambda t, z, p: -1, "I" + signs)
        modes["let go " + signs] = SmoothMode(free_rates(x, y), [opening, onward])
    return SmoothModel(STATES, modes)


def regime(x: Side, y: Side) -> str:
    return REGIMES[x.count, y.count]


def plain(mode: str) -> str:
    """The chapter's regime of a mode."""
    return mode.rstrip("+-0")


# ---------------------------------------------------------------- contact


def reach(x: Side, y: Side, z: Sequence[Any], p: Any) -> tuple[Any, Any]:
    """X and Y."""
    return z[0] + x.sign * p.delta_x, z[1] + y.sign * p.delta_y


def motion(x: Side, y: Side, z: Sequence[Any], p: Any) -> tuple[Any, ...]:
    """d, mu' and s' in contact."""
    X, Y = reach(x, y, z, p)
    vx, vy, mu = z[2], z[3], z[6]
    A, B = 1 / (x.count + mu), 1 / (y.count + mu)
    dx, dy = x.count * X * A, y.count * Y * B
    rate = x.count * dx * vx * A + y.count * dy * vy * B
    rate = rate / (dx * dx * A + dy * dy * B)
    return dx, dy, rate, vx - (x.count * vx - dx * rate) * A, vy - (y.count * vy - dy * rate) * B


def loads(t: Any, z: Sequence[Any], p: Any) -> tuple[Any, Any]:
    """Accelerations of a rotor that is free."""
    size, phase = p.eta_m * p.rho * p.eta * p.eta, p.phi0 + p.eta * t
    fx = size * cos(phase) - 2 * p.nu1 * z[2] - (z[0] - p.eps_x)
    fy = size * sin(phase) - 2 * p.nu1 * z[3] - (z[1] - p.eps_y)
    return fx, fy


def contact(x: Side, y: Side) -> SmoothMode:
    """Contact in one regime."""

    def rates(t: Any, z: Sequence[Any], p: Any) -> list[Any]:
        dx, dy, rate, sx, sy = motion(x, y, z, p)
        fx, fy = loads(t, z, p)
        fx = fx - p.K * z[6] * dx - 2 * p.nu2 * x.count * sx
        fy = fy - p.K * z[6] * dy - 2 * p.nu2 * y.count * sy
        return [z[2], z[3], fx, fy, sx, sy, rate, 0 * z[7]]

    def pressure(t: Any, z: Sequence[Any], p: Any) -> Any:
        dx, dy, _, sx, sy = motion(x, y, z, p)
        return p.K * z[6] + 2 * p.nu2 * (x.count * dx * sx + y.count * dy * sy)

    exits = []
    if x.preloaded:
        exits += passages(x, 4, "delta_x", lambda other: (other, y))
    if y.preloaded:
        exits += passages(y, 5, "delta_y", lambda other: (x, other))
    signs = x.letter + y.letter
    exits.append(SmoothExit(pressure, "let go " + signs, lambda t, z, p: [*z[:6], arb(0), arb(0)]))
    return SmoothMode(rates, exits)


def passages(own: Side, number: int, preload: str, sides: Any) -> list[SmoothExit]:
    """Exits where this coordinate of the ring passes its preload."""

    def to(letter: str) -> tuple[str, Any]:
        x, y = sides(Side(letter, True))
        return regime(x, y) + x.letter + y.letter, placed(x, y)

    def guard(sign: int, inside: int) -> Any:
        return lambda t, z, p: inside * (getattr(p, preload) - sign * z[number])

    if own.sign:
        return [SmoothExit(guard(own.sign, -1), *to("0"))]
    return [SmoothExit(guard(1, 1), *to("+")), SmoothExit(guard(-1, 1), *to("-"))]


def placed(x: Side, y: Side) -> Any:
    """A reset: the ring in equilibrium in this regime."""

    def reset(t: Any, z: Sequence[Any], p: Any) -> list[Any]:
        X, Y = reach(x, y, z, p)
        a, b = x.count, y.count
        mu = multiplier(X, Y, a, b)
        return [*z[:4], z[0] - a * X / (a + mu), z[1] - b * Y / (b + mu), mu, arb(0)]

    return reset


def multiplier(X: Any, Y: Any, a: int, b: int) -> Any:
    """The root of (a X/(a + mu))^2 + (b Y/(b + mu))^2 = 1."""
    radius = sqrt(X * X + Y * Y)
    if a == b:
        return a * (radius - 1)
    mu = (radius - 1).mid()
    for _ in range(100):
        P, Q = (a * X / (a + mu)) ** 2, (b * Y / (b + mu)) ** 2
        change = ((P + Q - 1) / (2 * P / (a + mu) + 2 * Q / (b + mu))).mid()
        mu = (mu + change).mid()
        if abs(mpf(float(change))) < mpf(10) ** (5 - DIGITS):
            return mu
    raise RuntimeError("Newton's method for the ring does not end")


# ---------------------------------------------------------------- free


def free_rates(x: Side | None, y: Side | None) -> Any:
    """Rates without contact; None for a ring at rest."""

    def rates(t: Any, z: Sequence[Any], p: Any) -> list[Any]:
        fx, fy = loads(t, z, p)
        still = 0 * z[4]
        if x is None or y is None:
            return [z[2], z[3], fx, fy, still, still, still, still]
        return [z[2], z[3], fx, fy, *relaxing(x, y, z, p), still, still + 1]

    return rates


def meeting(preload_x: bool, preload_y: bool) -> SmoothExit:
    """The rotor meets the ring, which jumps to in equilibrium."""

    def gap(t: Any, z: Sequence[Any], p: Any) -> Any:
        return (1 - (z[0] - z[4]) ** 2 - (z[1] - z[5]) ** 2) / 2

    first = Side("0", preload_x), Side("0", preload_y)
    return SmoothExit(gap, regime(*first) + "00", placed(*first))


def relaxing(x: Side, y: Side, z: Sequence[Any], p: Any) -> tuple[Any, Any]:
    """Rates of the free ring: one spring pulls towards minus its preload."""
    rate = p.K / (2 * p.nu2)
    return -rate * (z[4] + x.sign * p.delta_x), -rate * (z[5] + y.sign * p.delta_y)


def flight(x: Side, y: Side) -> SmoothMode:
    """No contact. A ring beyond its preload meets the second spring on its way back."""

    exits = [meeting(x.preloaded, y.preloaded)]
    if not x.sign and not y.sign:
        exits.append(SmoothExit(settled, "I", lambda t, z, p: [*z[:4], *[arb(0)] * 4]))
    if x.sign:
        exits.append(SmoothExit(lambda t, z, p: x.sign * z[4] - p.delta_x, "I0" + y.letter))
    if y.sign:
        exits.append(SmoothExit(lambda t, z, p: y.sign * z[5] - p.delta_y, "I" + x.letter + "0"))
    return SmoothMode(free_rates(x, y), exits)


def settled(t: Any, z: Sequence[Any], p: Any) -> Any:
    return LIVES - z[7] * p.K / (2 * p.nu2)


def parting(x: Side, y: Side) -> Any:
    """Half the rate at which the square of the distance falls."""

    def guard(t: Any, z: Sequence[Any], p: Any) -> Any:
        ux, uy = relaxing(x, y, z, p)
        return -(z[0] - z[4]) * (z[2] - ux) - (z[1] - z[5]) * (z[3] - uy)

    return guard


def period(parameters: dict[str, float]) -> mpf:
    with mp.workdps(DIGITS):
        return 2 * mp.pi / mpf(parameters["eta"])
