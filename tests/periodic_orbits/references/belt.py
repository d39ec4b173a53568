"""A mass on a belt: orbits with stick, and where they begin to slide in another way.

    x'' + 2 zeta x' + x = F cos(omega t) - mu u,    u = sign(x' - v_b), between -1 and 1 in stick

Legs are closed forms; instants of events and the parameter follow from equations at which each
kind of sliding bifurcation is defined (di Bernardo et al., 2008): the field beside the surface is
tangent to it, that is u = 1 or -1, where the orbit comes onto it, leaves it, or in between.
"""

from typing import NamedTuple

from mpmath import mp, mpf

DIGITS = 40


class Belt(NamedTuple):
    """Parameters; ``v_b`` may be an unknown."""

    v_b: mpf
    mu: mpf
    omega: mpf
    zeta: mpf
    F: mpf = mpf(1)

    @property
    def period(self) -> mpf:
        return 2 * mp.pi / self.omega

    def steady(self, t, force):
        """State of the forced response about a constant force."""
        z = self.F / (1 - self.omega**2 + 2j * self.zeta * self.omega)
        turning = z * mp.exp(1j * self.omega * t)
        return mp.re(turning) + force, mp.re(1j * self.omega * turning)

    def slip(self, start, begin, end, sign):
        """State at ``end`` of a slip with sign of the relative speed, from a state at ``begin``."""
        at, there = self.steady(begin, -sign * self.mu), self.steady(end, -sign * self.mu)
        x, v = start[0] - at[0], start[1] - at[1]
        rate, s = mp.sqrt(1 - self.zeta**2), end - begin
        decay, c, d = mp.exp(-self.zeta * s), mp.cos(rate * s), mp.sin(rate * s) / rate
        x, v = (
            decay * (x * (c + self.zeta * d) + v * d),
            decay * (v * (c - self.zeta * d) - x * d),
        )
        return x + there[0], v + there[1]

    def control(self, x, t):
        """The share u of the friction force that stick needs."""
        force = self.F * mp.cos(self.omega * t) - x - 2 * self.zeta * self.v_b
        return force / self.mu

    def control_rate(self, t):
        return (-self.F * self.omega * mp.sin(self.omega * t) - self.v_b) / self.mu


def grazing(belt: Belt) -> mpf:
    """The belt's speed that the mass reaches without ever sticking."""
    with mp.workdps(DIGITS):
        z = belt.F / (1 - belt.omega**2 + 2j * belt.zeta * belt.omega)
        return abs(belt.omega * z)


def solved(equations, guess):
    """Root of equations at many digits."""
    with mp.workdps(DIGITS):
        root = mp.findroot(lambda *u: equations(*u), [mpf(g) for g in guess], tol=mpf(10) ** -60)
        return [root[i] for i in range(len(guess))]


def stick_and_lag(belt: Belt, entry, x, leave):
    """What closes an orbit that sticks from ``entry`` at x to ``leave``, and then lags."""
    there = x + belt.v_b * (leave - entry)
    end = belt.slip((there, belt.v_b), leave, entry + belt.period, -1)
    return [belt.control(there, leave) + 1, end[0] - x, end[1] - belt.v_b]


def switching(belt: Belt, guess):
    """(entry, x, leave, v_b): the orbit comes onto the belt where u = 1."""

    def equations(entry, x, leave, v_b):
        there = belt._replace(v_b=v_b)
        return [*stick_and_lag(there, entry, x, leave), there.control(x, entry) - 1]

    return solved(equations, guess)


def adding(belt: Belt, guess):
    """(entry, x, leave, v_b, touch): while it sticks, u comes up to 1 and turns back."""

    def equations(entry, x, leave, v_b, touch):
        there = belt._replace(v_b=v_b)
        at_touch = x + v_b * (touch - entry)
        return [
            *stick_and_lag(there, entry, x, leave),
            there.control(at_touch, touch) - 1,
            there.control_rate(touch),
        ]

    return solved(equations, guess)


def crossing(belt: Belt, guess):
    """(up, x, down, v_b): it leads for a while, and crosses back where u = -1."""

    def equations(up, x, down, v_b):
        there = belt._replace(v_b=v_b)
        top = there.slip((x, v_b), up, down, 1)
        end = there.slip(top, down, up + there.period, -1)
        return [top[1] - v_b, end[0] - x, end[1] - v_b, there.control(top[0], down) + 1]

    return solved(equations, guess)


def multiplier(belt: Belt, entry, x, leave) -> mpf:
    """Of the orbit that sticks and lags: what a turn makes of a shift of x in stick."""
    with mp.workdps(DIGITS):

        def turned(shift):
            """x where u = -1 of the orbit that is shifted, and back in stick after a turn."""
            base = x + shift - belt.v_b * entry
            off = mp.findroot(lambda t: belt.control(base + belt.v_b * t, t) + 1, leave)
            start = (base + belt.v_b * off, belt.v_b)
            on = mp.findroot(
                lambda t: belt.slip(start, off, t, -1)[1] - belt.v_b, entry + belt.period
            )
            return belt.slip(start, off, on, -1)[0] - belt.v_b * (on - belt.period)

        return mp.diff(turned, 0)


def stops(omega, zeta, guess):
    """(turn, x, mu): a mass on ground that never sticks, and would where it turns at x > 0.

    x'' + 2 zeta x' + x = cos(omega t) - mu sign(x'), antisymmetric half a period later.
    """
    with mp.workdps(DIGITS):

        def equations(turn, x, mu):
            ground = Belt(mpf(0), mu, mpf(omega), mpf(zeta))
            end = ground.slip((x, mpf(0)), turn, turn + ground.period / 2, -1)
            return [end[0] + x, end[1], ground.control(x, turn) + 1]

        return solved(equations, guess)
