"""The three modes of the ground mole in closed form, and their guards as Rolle chains.

Time s counts from the start of the mode, theta = theta0 + omega s, f = b + a cos(theta),
F = 2 xi y + q and k = 1/(2 xi). Each guard is positive inside its mode.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from mpmath import mp, mpf

from .roots import Function, first_crossing, harmonic_zeros


class State(NamedTuple):
    p: mpf
    y: mpf
    q: mpf
    v: mpf


@dataclass(frozen=True)
class Mole:
    """Parameters, each the exact value of the double that was given."""

    a: mpf
    b: mpf
    xi: mpf
    omega: mpf
    g: mpf
    phi: mpf

    @cached_property
    def k(self) -> mpf:
        return 1 / (2 * self.xi)

    @cached_property
    def period(self) -> mpf:
        return 2 * mp.pi / self.omega

    def gap(self, state: State) -> mpf:
        """The gap still open, positive in flight."""
        return state.q + self.g - state.p

    def force(self, state: State) -> mpf:
        return 2 * self.xi * state.y + state.q

    def load(self, theta: mpf) -> mpf:
        return self.b + self.a * mp.cos(theta)

    def load_rate(self, theta: mpf) -> mpf:
        return -self.a * self.omega * mp.sin(theta)

    def force_rate(self, state: State, theta: mpf) -> mpf:
        """dF/dt in contact; at F = 1 it is the same in progression."""
        return 2 * self.xi * (self.load(theta) - self.force(state)) + state.y


@dataclass(frozen=True)
class Guard:
    """One exit of a mode.

    ``levels(low, high)`` is the chain on a stretch no longer than ``longest_piece``. The level
    after its last one is harmonic[0] + harmonic[1] cos(theta) + harmonic[2] sin(theta).
    """

    to: str
    levels: Callable[[mpf, mpf], list[Function]]
    harmonic: tuple[mpf, mpf, mpf]
    omega: mpf
    theta0: mpf
    longest_piece: mpf = mp.inf

    def first_crossing(self, end: mpf, known_zeros: int) -> tuple[mpf | None, mpf]:
        """The first s in (0, end] at which the guard falls below zero, and the nearest miss."""
        low, gap = mpf(0), mp.inf
        while low < end:
            high = min(low + self.longest_piece, end)
            zeros = harmonic_zeros(*self.harmonic, self.omega, self.theta0, low, high)
            found, miss = first_crossing(self.levels(low, high), zeros, low, high, known_zeros)
            gap = min(gap, miss)
            if found is not None:
                return found, gap
            low, known_zeros = high, 0
        return None, gap


class FreeMass:
    """The mass under f less a constant resistance, and the integral x of its velocity y."""

    def __init__(self, mole: Mole, y0: mpf, theta0: mpf, resistance: int) -> None:
        self.omega, self.theta0, self.a = mole.omega, theta0, mole.a
        self.mean = mole.b - resistance
        self.speed = mole.a / mole.omega
        self.cos0, self.sin0 = mp.cos_sin(theta0)
        self.y0 = y0

    def __call__(self, s: mpf) -> tuple[mpf, mpf, mpf]:
        """Displacement since the start, velocity, acceleration."""
        cos, sin = mp.cos_sin(self.theta0 + self.omega * s)
        x = (self.y0 - self.speed * self.sin0 + self.mean * s / 2) * s
        x -= self.speed / self.omega * (cos - self.cos0)
        return (
            x,
            self.y0 + self.mean * s + self.speed * (sin - self.sin0),
            self.mean + self.a * cos,
        )


class NoContact:
    """p' = y, y' = f, q' = -k q, v' = 0."""

    def __init__(self, mole: Mole, start: State, theta0: mpf) -> None:
        self.mole, self.start, self.theta0 = mole, start, theta0
        self.mass = FreeMass(mole, start.y, theta0, resistance=0)

    def at(self, s: mpf) -> State:
        x, y, _ = self.mass(s)
        return State(self.start.p + x, y, self.start.q * mp.exp(-self.mole.k * s), self.start.v)

    def guards(self) -> list[Guard]:
        """The gap. G' + k G is free of the exponential; two derivatives leave a harmonic."""
        m, k = self.mole, self.mole.k

        def gap(s: mpf) -> mpf:
            return m.gap(self.at(s))

        def without_exponential(s: mpf) -> mpf:
            x, y, _ = self.mass(s)
            return k * (m.g - self.start.p - x) - y

        def its_rate(s: mpf) -> mpf:
            _, y, f = self.mass(s)
            return -k * y - f

        levels = [gap, without_exponential, its_rate]
        harmonic = (-k * m.b, -k * m.a, m.a * m.omega)
        return [Guard("contact", lambda low, high: levels, harmonic, m.omega, self.theta0)]

    def rate(self, to: str, state: State, theta: mpf) -> mpf:
        """The rate of the guard towards ``to``."""
        return -self.mole.k * self.mole.force(state)


class Contact:
    """p' = q' = y, y' = f - F: a damped oscillator in q with damping ratio xi, any xi > 0."""

    def __init__(self, mole: Mole, start: State, theta0: mpf) -> None:
        self.mole, self.start, self.theta0 = mole, start, theta0
        a, xi, w = mole.a, mole.xi, mole.omega
        self.spread = 1 - xi**2  # square of the natural frequency
        d = (1 - w**2) ** 2 + (2 * xi * w) ** 2
        self.in_phase, self.out_of_phase = a * (1 - w**2) / d, 2 * xi * w * a / d
        forced = self._forced(*mp.cos_sin(theta0))
        self.q0, self.y0 = start.q - forced[0], start.y - forced[1]

    def _forced(self, cos: mpf, sin: mpf) -> tuple[mpf, mpf]:
        q = self.mole.b + self.in_phase * cos + self.out_of_phase * sin
        return q, self.mole.omega * (self.out_of_phase * cos - self.in_phase * sin)

    def _natural(self, s: mpf) -> tuple[mpf, mpf]:
        """q and y of the free oscillation: even and odd solutions times exp(-xi s)."""
        if self.spread > 0:
            w = mp.sqrt(self.spread)
            even, odd = mp.cos_sin(w * s)
            odd /= w
        elif self.spread < 0:
            w = mp.sqrt(-self.spread)
            even, odd = mp.cosh(w * s), mp.sinh(w * s) / w
        else:
            even, odd = mpf(1), s
        xi, decay = self.mole.xi, mp.exp(-self.mole.xi * s)
        q = decay * (self.q0 * even + (self.y0 + xi * self.q0) * odd)
        return q, decay * (self.y0 * even - (self.q0 + xi * self.y0) * odd)

    def _oscillator(self, s: mpf) -> tuple[mpf, mpf, mpf]:
        """q, y, f."""
        cos, sin = mp.cos_sin(self.theta0 + self.mole.omega * s)
        q, y = (sum(parts) for parts in zip(self._forced(cos, sin), self._natural(s), strict=True))
        return q, y, self.mole.b + self.mole.a * cos

    def at(self, s: mpf) -> State:
        q, y, _ = self._oscillator(s)
        return State(q + self.mole.g, y, q, self.start.v)

    def guards(self) -> list[Guard]:
        return [self._guard("no_contact", 1, 0), self._guard("progression", -1, 1)]

    def _guard(self, to: str, sign: int, threshold: int) -> Guard:
        """sign (F - threshold), its Wronskian with a positive free solution u, a harmonic.

        With L x = x'' + 2 xi x' + x and L u = 0, f/u is monotone where W = u f' - u' f keeps its
        sign, and W exp(2 xi s) is monotone where L f does. L F = 2 xi f' + f is harmonic. For
        xi < 1, u = exp(-xi s) cos(w (s - middle)) is positive on less than half a natural period
        only, hence the pieces. Positive factors are left out.
        """
        m, xi = self.mole, self.mole.xi
        w = mp.sqrt(abs(self.spread))

        def force(s: mpf) -> mpf:
            q, y, _ = self._oscillator(s)
            return sign * (2 * xi * y + q - threshold)

        def wronskian(s: mpf, middle: mpf) -> mpf:
            q, y, f = self._oscillator(s)
            f0 = sign * (2 * xi * y + q - threshold)
            f1 = sign * (2 * xi * (f - 2 * xi * y - q) + y)
            if self.spread <= 0:
                return f1 + (xi - w) * f0
            cos, sin = mp.cos_sin(w * (s - middle))
            return cos * f1 + (xi * cos + w * sin) * f0

        def levels(low: mpf, high: mpf) -> list[Function]:
            middle = (low + high) / 2
            return [force, lambda s: wronskian(s, middle)]

        harmonic = (sign * (m.b - threshold), sign * m.a, -sign * 2 * xi * m.a * m.omega)
        longest = mpf("0.9") * mp.pi / w if self.spread > 0 else mp.inf
        return Guard(to, levels, harmonic, m.omega, self.theta0, longest)

    def rate(self, to: str, state: State, theta: mpf) -> mpf:
        rate = self.mole.force_rate(state, theta)
        return rate if to == "no_contact" else -rate


class Progression:
    """y' = f - 1, p' = q' = k (1 - q), v' = y - q'."""

    def __init__(self, mole: Mole, start: State, theta0: mpf) -> None:
        self.mole, self.start, self.theta0 = mole, start, theta0
        self.mass = FreeMass(mole, start.y, theta0, resistance=1)

    def at(self, s: mpf) -> State:
        x, y, _ = self.mass(s)
        q = 1 + (self.start.q - 1) * mp.exp(-self.mole.k * s)
        return State(q + self.mole.g, y, q, self.start.v + x - (q - self.start.q))

    def guards(self) -> list[Guard]:
        """F - 1. (d/ds + k) removes the exponential; one derivative leaves a harmonic."""
        m, xi = self.mole, self.mole.xi

        def force(s: mpf) -> mpf:
            return m.force(self.at(s)) - 1

        def without_exponential(s: mpf) -> mpf:
            _, y, f = self.mass(s)
            return 2 * xi * f + y

        levels = [force, without_exponential]
        harmonic = (m.b - 1, m.a, -2 * xi * m.a * m.omega)
        return [Guard("contact", lambda low, high: levels, harmonic, m.omega, self.theta0)]

    def rate(self, to: str, state: State, theta: mpf) -> mpf:
        return self.mole.force_rate(state, theta)


MODES = {"no_contact": NoContact, "contact": Contact, "progression": Progression}
