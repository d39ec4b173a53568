"""Synchronous rub of a rotor with clearance: z = R exp(i (omega t - theta)).

z'' + 2 zeta z' + z + kappa (1 - 1/|z|) z = rho omega^2 exp(i omega t). The radius is a root above 1
of a quadratic; seen from the turning shaft the motion next to it has constant coefficients, so the
multipliers are exp(lambda period) with the roots of a quartic.
"""

from typing import NamedTuple

from mpmath import matrix, mp, mpf

DIGITS = 40


class Rub(NamedTuple):
    radius: mpf
    start: dict[str, float]
    multipliers: list[mp.mpc]


def rubs(*, omega, zeta, kappa, rho) -> list[Rub]:
    """All synchronous rubs, the largest radius first."""
    with mp.workdps(DIGITS):
        omega, zeta, kappa, rho = map(mpf, (omega, zeta, kappa, rho))
        s = 1 + kappa - omega**2
        square = s**2 + (2 * zeta * omega) ** 2
        spread = (kappa * s) ** 2 - square * (kappa**2 - rho**2 * omega**4)
        if spread < 0:
            return []
        radii = [(kappa * s + sign * mp.sqrt(spread)) / square for sign in (1, -1)]
        return [_rub(radius, omega, zeta, kappa, rho) for radius in radii if radius > 1]


def _rub(radius, omega, zeta, kappa, rho) -> Rub:
    push = kappa * (1 - 1 / radius)
    z = rho * omega**2 / (1 - omega**2 + 2j * zeta * omega + push)
    # z = (R + d) exp(i (omega t - theta)): d'' + (2 zeta + 2 i omega) d' + (1 - omega^2 + 2 i zeta
    # omega) d + kappa (d - i Im(d) / R) = 0, with d = d1 + i d2
    along = 1 - omega**2 + kappa
    across = along - kappa / radius
    rates = matrix(
        [
            [0, 0, 1, 0],
            [0, 0, 0, 1],
            [-along, 2 * zeta * omega, -2 * zeta, 2 * omega],
            [-2 * zeta * omega, -across, -2 * omega, -2 * zeta],
        ]
    )
    values = mp.eig(rates, left=False, right=False)
    period = 2 * mp.pi / omega
    start = {"x": z.real, "u": (1j * omega * z).real, "y": z.imag, "v": (1j * omega * z).imag}
    return Rub(
        abs(z),
        {name: float(value) for name, value in start.items()},
        sorted((mp.exp(value * period) for value in values), key=lambda m: -abs(m)),
    )
