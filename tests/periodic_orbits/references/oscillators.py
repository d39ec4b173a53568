"""Courses of forced oscillators on springs in pieces: soft impact, trilinear, friction."""

from functools import partial
from itertools import pairwise

from mpmath import matrix, mp, mpf

from .turn import Course, Leg, State


def oscillation(
    stiffness, zeta, push, drive, omega, state: State, time: mpf, duration: mpf
) -> State:
    """x'' + 2 zeta x' + stiffness x = push + Re(drive exp(i omega t)), in closed form."""
    rest = push / stiffness
    steady = drive / (stiffness - omega**2 + 2j * zeta * omega)
    old, new = (steady * mp.expj(omega * t) for t in (time, time + duration))
    x, v = state[0] - rest - old.real, state[1] - (1j * omega * old).real
    rate = mp.sqrt(stiffness - zeta**2)
    decay, c, s = mp.exp(-zeta * duration), mp.cos(rate * duration), mp.sin(rate * duration)
    return (
        decay * (x * c + (v + zeta * x) / rate * s) + rest + new.real,
        decay * (v * c - (zeta * v + stiffness * x) / rate * s) + (1j * omega * new).real,
    )


def identity(state: State) -> State:
    return tuple(state)


class SoftImpact:
    """x'' + 2 zeta x' + x + beta (x - e) H(x - e) = a omega^2 sin(omega t)."""

    def __init__(self, *, omega="0.85", zeta="0.01", beta="29", e="1.26", a="0.7") -> None:
        self.omega, self.zeta, self.beta, self.e, self.a = map(mpf, (omega, zeta, beta, e, a))
        self.period = 2 * mp.pi / self.omega

    def course(self, word: str, periods: int = 1) -> Course:
        """The course of a word of ``free`` and ``contact``, from phase 0."""
        modes = word.split()
        legs = [Leg(mode, self._flow(mode), self._gap) for mode in modes[:-1]]
        legs.append(Leg(modes[-1], self._flow(modes[-1])))
        return Course(legs, identity, identity, periods * self.period)

    def _flow(self, mode: str):
        drive = -1j * self.a * self.omega**2
        if mode == "free":
            return partial(oscillation, mpf(1), self.zeta, mpf(0), drive, self.omega)
        stiffness, push = 1 + self.beta, self.beta * self.e
        return partial(oscillation, stiffness, self.zeta, push, drive, self.omega)

    def _gap(self, state: State, time: mpf) -> mpf:
        return state[0] - self.e


def soft_grazing_amplitude(*, omega, zeta, e) -> mpf:
    """The amplitude a at which the motion on the first spring touches the second."""
    omega, zeta, e = map(mpf, (omega, zeta, e))
    return e * mp.sqrt((1 - omega**2) ** 2 + 4 * zeta**2 * omega**2) / omega**2


def soft_grazing_frequencies(*, zeta, e, a) -> list[mpf]:
    """The frequencies at which it does, ascending: a quadratic in omega^2."""
    zeta, e, a = map(mpf, (zeta, e, a))
    # e^2 ((1 - u)^2 + 4 zeta^2 u) = a^2 u^2
    square, middle = 1 - (a / e) ** 2, 1 - 2 * zeta**2
    spread = mp.sqrt(middle**2 - square)
    return sorted(
        mp.sqrt(u) for u in ((middle - spread) / square, (middle + spread) / square) if u > 0
    )


class Trilinear:
    """x'' + 2 zeta x' + x + kappa (x -+ delta beyond either stop) = F cos(omega t)."""

    def __init__(self, *, omega="1.5", zeta="0.02", kappa="8", delta="0.5", F="1") -> None:
        self.omega, self.zeta, self.kappa = map(mpf, (omega, zeta, kappa))
        self.delta, self.force = mpf(delta), mpf(F)
        self.period = 2 * mp.pi / self.omega

    def course(self, word: str, *, half: bool = False) -> Course:
        """A turn of one period; with ``half``, of half a period and mirrored at its end."""
        modes = word.split()
        legs = [
            Leg(mode, self._flow(mode), partial(self._gap, mode, to))
            for mode, to in pairwise(modes)
        ]
        legs.append(Leg(modes[-1], self._flow(modes[-1])))
        if half:
            return Course(legs, identity, lambda z: (-z[0], -z[1]), self.period / 2)
        return Course(legs, identity, identity, self.period)

    def _flow(self, mode: str):
        side = {"free": 0, "upper": 1, "lower": -1}[mode]
        stiffness = 1 + self.kappa * abs(side)
        push = side * self.kappa * self.delta
        return partial(oscillation, stiffness, self.zeta, push, mp.mpc(self.force), self.omega)

    def _gap(self, mode: str, to: str, state: State, time: mpf) -> mpf:
        return state[0] + (self.delta if "lower" in (mode, to) else -self.delta)


class DenHartog:
    """x'' + x + q sign(x') = cos(beta t), in the motion that never stops (1931).

    It turns at amplitude X = sqrt(V^2 - q^2 U^2), V = 1 / (1 - beta^2), U = sin(pi/beta) / (beta
    (1 + cos(pi/beta))), twice in a period, mirrored after half of one.
    """

    def __init__(self, *, beta, q) -> None:
        self.beta, self.q = mpf(beta), mpf(q)
        self.period = 2 * mp.pi / self.beta
        angle = mp.pi / self.beta
        self.v = 1 / (1 - self.beta**2)
        self.u = mp.sin(angle) / (self.beta * (1 + mp.cos(angle)))
        self.amplitude = mp.sqrt(self.v**2 - (self.q * self.u) ** 2)

    def turning_phase(self) -> mpf:
        """beta t at which the upper turning point is reached.

        The swing down is x = q + V cos(beta t) + free part; that it ends at -X after half a
        period leaves X = V cos(phase) and q U = -V sin(phase).
        """
        return mp.atan2(-self.q * self.u / self.v, self.amplitude / self.v)

    def swing(self, since: mpf, top: int = 1) -> State:
        """Motion at a time since a turning point: the upper one (top = 1) or the lower (-1)."""
        t = self.turning_phase() / self.beta + (0 if top == 1 else self.period / 2)
        flow = partial(oscillation, mpf(1), mpf(0), top * self.q, mp.mpc(1), self.beta)
        return flow((top * self.amplitude, mpf(0)), t, since)

    def course(self) -> Course:
        """From phase 0, which lies behind the upper turning point or before it."""
        down, up = (
            Leg(name, partial(oscillation, mpf(1), mpf(0), side * self.q, mp.mpc(1), self.beta))
            for name, side in (("down", 1), ("up", -1))
        )
        first, then = (down, up) if self.turning_phase() <= 0 else (up, down)
        legs = [leg._replace(guard=lambda z, t: z[1]) for leg in (first, then)] + [first]
        return Course(legs, identity, identity, self.period)

    def start(self) -> State:
        """State at phase 0."""
        phase = self.turning_phase()
        if phase <= 0:
            return self.swing(-phase / self.beta)
        return self.swing(self.period / 2 - phase / self.beta, -1)

    def multipliers(self) -> list[mp.mpc]:
        """Of half a period with the mirror, squared: the jump at a turn is diag(1, a+/a-)."""
        phase = self.turning_phase()
        pull = mp.cos(phase) - self.amplitude
        jump = matrix([[1, 0], [0, (pull + self.q) / (pull - self.q)]])
        c, s = mp.cos(mp.pi / self.beta), mp.sin(mp.pi / self.beta)
        half = -jump * matrix([[c, s], [-s, c]])
        return sorted((m**2 for m in mp.eig(half)[0]), key=lambda m: -abs(m))
