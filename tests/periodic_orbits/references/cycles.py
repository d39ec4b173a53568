"""Limit cycles of systems without forcing, in closed form.

- `clock`: x'' + 2 zeta x' + x = 0 is kicked to sqrt(v^2 + 2 energy) where it passes x = 0 upwards.
- `relay`: x'' + 2 zeta x' + x = s, where s becomes 1 when x falls below -h and -1 when it rises
  above h: hysteresis feeds in 4 h per turn.
- `round_cycle`: in polar coordinates R' = R - R^3, angle' = 1: multiplier exp(-4 pi).
"""

from typing import NamedTuple

from mpmath import matrix, mp, mpf

DIGITS = 40


class Cycle(NamedTuple):
    """``start``: just behind the first event; multipliers without that of the motion itself."""

    period: mpf
    start: tuple[mpf, ...]
    multipliers: list[mpf]


def clock(*, zeta, energy) -> Cycle:
    """Behind the kick v^2 = 2 energy / (1 - d^2), with d what a turn leaves; multiplier d^2."""
    with mp.workdps(DIGITS):
        zeta, energy = mpf(zeta), mpf(energy)
        rate = mp.sqrt(1 - zeta**2)
        left = mp.exp(-2 * mp.pi * zeta / rate)
        speed = mp.sqrt(2 * energy / (1 - left**2))
        return Cycle(2 * mp.pi / rate, (mpf(0), speed), [left**2])


def relay(*, zeta, h) -> Cycle:
    """Symmetric: (-h, v) under the force 1 comes to (h, -v) after half a period.

    With z the state less its rest (1, 0), Phi z = -z - 2 rest over half a period. That the first
    row of the start is -h fixes the half period.
    """
    with mp.workdps(DIGITS):
        zeta, h = mpf(zeta), mpf(h)
        rest = matrix([1, 0])

        def behind(half: mpf) -> matrix:
            return rest - 2 * mp.lu_solve(mp.eye(2) + _free(zeta, half), rest)

        half = mp.findroot(lambda t: behind(t)[0] + h, (1.5, 2.8), solver="anderson", tol=1e-60)
        x, v = behind(half)
        # rates on both sides of the switch half a period later, at (h, -v)
        before = matrix([-v, 1 - h + 2 * zeta * v])
        after = matrix([-v, -1 - h + 2 * zeta * v])
        jump = mp.eye(2) + (after - before) * matrix([[1, 0]]) / before[0]
        values = mp.eig(jump * _free(zeta, half), left=False, right=False)
        # half a turn takes the motion along itself to -1 times itself; the other value squared
        other = max(values, key=lambda m: abs(m + 1)).real
        return Cycle(2 * half, (x, v), [other**2])


def round_cycle() -> Cycle:
    with mp.workdps(DIGITS):
        return Cycle(2 * mp.pi, (mpf(1), mpf(0)), [mp.exp(-4 * mp.pi)])


def _free(zeta: mpf, time: mpf) -> matrix:
    rate = mp.sqrt(1 - zeta**2)
    c, s = mp.cos(rate * time), mp.sin(rate * time)
    rows = [[c + zeta / rate * s, s / rate], [-s / rate, c - zeta / rate * s]]
    return mp.exp(-zeta * time) * matrix(rows)
