r"""A Jeffcott rotor that whirls inside an elastic ring with clearance."""

from __future__ import annotations

from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["clearance_rotor"]


def clearance_rotor(
    omega: Text = 0.9,
    zeta: Text = 0.06,
    kappa: Text = 20.0,
    rho: Text = 0.7,
) -> System:
    r"""Jeffcott rotor with clearance, without preload and friction; dimensionless.

    With the displacement :math:`z = x + iy` of the shaft's centre in units of the clearance
    and time in 1 over the natural frequency of the shaft,

    .. math::

        z'' + 2\zeta z' + z + \kappa (1 - 1/|z|) z H(|z| - 1) = \rho\omega^2 e^{i\omega\tau}.

    A synchronous rub is a circle :math:`z = R e^{i(\omega\tau - \theta)}`; with
    :math:`s = 1 + \kappa - \omega^2` its radius is a root, above 1, of

    .. math::

        (s^2 + 4\zeta^2\omega^2) R^2 - 2\kappa s R + \kappa^2 - \rho^2\omega^4 = 0.

    ====== ======== ======= ==========================================
    symbol argument default source
    ====== ======== ======= ==========================================
    omega  omega    0.9     default chosen here: speed of the rotor
    zeta   zeta     0.06    default chosen here: damping ratio
    kappa  kappa    20      default chosen here: stiffness of the ring
    rho    rho      0.7     default chosen here: eccentricity
    ====== ======== ======= ==========================================

    Parameters
    ----------
    omega, zeta, kappa, rho : float or str
        Dimensionless parameters as in the table; the stiffness of the ring is in units of
        that of the shaft, the eccentricity of the mass in units of the clearance.

    Returns
    -------
    System
        States ``x u y v`` (displacements, each with its velocity); modes ``free``, whose
        guard is the polynomial 1 - x² - y², in closed form, and ``rub`` by Taylor series; outputs
        ``radius`` and ``ring_force``. Its symmetry is declared: minus a motion, half a period
        later, is a motion.

    Raises
    ------
    ModelError
        When ``omega`` is not positive, or ``zeta`` or ``kappa`` is negative.

    See Also
    --------
    soft_impact : one direction only.

    References
    ----------
    D. C. Johnson, Synchronous whirl of a vertical shaft having clearance in one bearing,
    Journal of Mechanical Engineering Science 4, 85-93 (1962); H. F. Black, Interaction of a
    whirling rotor with a vibrating stator across a clearance annulus, Journal of Mechanical
    Engineering Science 10, 1-12 (1968).

    Examples
    --------
    Far below contact the rotor whirls at the radius of the linear one:

    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.clearance_rotor(omega=0.2, zeta=0.5), periods=20)
    >>> round(float(run["radius"][-1]), 6), round(0.7 * 0.04 / abs(1 - 0.04 + 0.2j), 6)
    (0.028554, 0.028554)
    """
    pull_x = "rho*omega**2*cos(omega*t) - 2*zeta*u - x"
    pull_y = "rho*omega**2*sin(omega*t) - 2*zeta*v - y"
    return System(
        name="clearance_rotor",
        states=["x", "u", "y", "v"],
        period="2*pi/omega",
        symmetry={"x": "-x", "u": "-u", "y": "-y", "v": "-v"},
        parameters={"omega": omega, "zeta": zeta, "kappa": kappa, "rho": rho},
        require={
            "omega > 0": "the rotor must turn",
            "zeta >= 0": "negative damping would feed energy in",
            "kappa >= 0": "the ring cannot pull",
        },
        definitions={"r": "sqrt(x**2 + y**2)", "push": "kappa*(1 - 1/r)", "R": "kappa*(r - 1)"},
        outputs={"radius": "r", "ring_force": "R"},
        describe={
            "x": "displacement in x",
            "u": "velocity in x",
            "y": "displacement in y",
            "v": "velocity in y",
            "radius": "radius of the whirl",
            "ring_force": "force between shaft and ring",
            "omega": "speed of the rotor",
            "zeta": "damping ratio",
            "kappa": "stiffness of the ring over that of the shaft",
            "rho": "eccentricity over the clearance",
        },
        modes={
            "free": Mode(
                {"x": "u", "u": pull_x, "y": "v", "v": pull_y},
                definitions={"R": "0"},
                exits=[Exit("1 - x**2 - y**2", to="rub", name="contact")],
            ),
            "rub": Mode(
                {"x": "u", "u": f"{pull_x} - push*x", "y": "v", "v": f"{pull_y} - push*y"},
                exits=[Exit("x**2 + y**2 - 1", to="free", name="release")],
            ),
        },
    )
