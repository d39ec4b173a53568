"""Orbits of an oscillator at a rigid wall with one impact per n periods, in closed form.

x'' + 2 zeta x' + x = F cos(omega t) left of x = sigma, v := -r v there. Between impacts the motion
is the steady one plus a damped oscillation; that it repeats after n periods is linear in the
velocity v of the impact and in cosine and sine of its phase psi (F. Peterka; S. W. Shaw and
P. J. Holmes). That these two lie on the unit circle gives v. Everything in 30 digits.
"""

from typing import NamedTuple

import mpmath as mp

mp = mp.mp.clone()
mp.dps = 30


class Orbit(NamedTuple):
    """Velocity just before the impact, state at t = 0, trace and determinant of its map."""

    speed: float
    start: dict[str, float]
    trace: mp.mpf
    determinant: mp.mpf

    @property
    def flip(self):
        """Zero where a multiplier is -1."""
        return 1 + self.trace + self.determinant


def one_impact_orbit(omega, *, zeta, sigma, r, periods=1, force=1) -> Orbit:
    """The orbit with the larger velocity."""
    omega, zeta, sigma, r, force = map(mp.mpf, (omega, zeta, sigma, r, force))
    steady = force / (1 - omega**2 + 2j * zeta * omega)
    # x = p, v = q of the steady motion at phase psi, as rows over (cos psi, sin psi)
    p = mp.matrix([[steady.real, -steady.imag]])
    q = mp.matrix([[-omega * steady.imag, -omega * steady.real]])
    span = 2 * mp.pi * periods / omega
    flow = _free(zeta, span)
    # flow (sigma - p, -r v - q) = (sigma - p, v - q)
    rest = flow - mp.eye(2)
    rows = mp.matrix([[p[0], p[1]], [q[0], q[1]]])
    by_speed = mp.matrix([-r * flow[0, 1], -r * flow[1, 1] - 1])
    alone = mp.matrix([rest[0, 0] * sigma, rest[1, 0] * sigma])
    slope = mp.lu_solve(rest * rows, by_speed)
    constant = mp.lu_solve(rest * rows, alone)
    a = slope[0] ** 2 + slope[1] ** 2
    b = slope[0] * constant[0] + slope[1] * constant[1]
    c = constant[0] ** 2 + constant[1] ** 2 - 1
    speed = (-b + mp.sqrt(b * b - a * c)) / a
    cosine, sine = slope * speed + constant
    # the jump of neighbours at the impact, from the accelerations on either side
    before = force * cosine - 2 * zeta * speed - sigma
    after = force * cosine + 2 * zeta * r * speed - sigma
    jump = mp.matrix([[-r, 0], [(after + r * before) / speed, -r]])
    tangent = flow * jump
    return Orbit(
        float(speed),
        _at_zero(omega, zeta, sigma, r, steady, speed, mp.atan2(sine, cosine)),
        tangent[0, 0] + tangent[1, 1],
        mp.det(tangent),
    )


def _free(zeta, time):
    """Matrix of the damped oscillation over a time, also where damping lets nothing oscillate."""
    rate = mp.sqrt(1 - zeta**2)
    c, s = mp.re(mp.cos(rate * time)), mp.re(mp.sin(rate * time) / rate)
    inner = mp.matrix([[c + zeta * s, s], [-s, c - zeta * s]])
    return mp.exp(-zeta * time) * inner


def _at_zero(omega, zeta, sigma, r, steady, speed, psi):
    """State at t = 0, from the impact that came before it."""
    turned = steady * mp.expj(psi)
    away = mp.matrix([sigma - turned.real, -r * speed - (1j * omega * turned).real])
    state = _free(zeta, (-psi % (2 * mp.pi)) / omega) * away
    return {
        "x": float(state[0] + steady.real),
        "v": float(state[1] + (1j * omega * steady).real),
    }
