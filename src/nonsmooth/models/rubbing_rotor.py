r"""A Jeffcott rotor that rubs on an elastic ring with dry friction."""

from __future__ import annotations

from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["rubbing_rotor"]


def rubbing_rotor(
    omega: Text = 0.9,
    zeta: Text = 0.06,
    kappa: Text = 20.0,
    rho: Text = 0.7,
    f: Text = 0.1,
    radius: Text = 60.0,
) -> System:
    r"""Jeffcott rotor that rubs on an elastic ring with Coulomb friction; dimensionless.

    The rotor of `clearance_rotor`, pushed back by the ring with :math:`N = \kappa (|z| - 1)`
    where it touches, and by friction f N at right angles to that, against the slip of the
    shaft's surface on the ring. With the displacement :math:`z = x + iy` of the centre of the
    shaft in units of the clearance and time in 1 over its natural frequency,

    .. math::

        z'' + 2\zeta z' + z + \kappa (1 - 1/|z|)(1 + i f \,\mathrm{sgn}\, u)\, z
        = \rho\omega^2 e^{i\omega\tau}, \quad u = \omega R_s + (x y' - y x')/|z|.

    The slip u is the velocity of the point of the shaft that touches: its own rotation, and the
    motion of the centre along the ring. It is known at every angle of contact, so friction has
    the right direction everywhere and changes it where a backward whirl outruns the rotation.

    ====== ======== ======= ================================================
    symbol argument default source
    ====== ======== ======= ================================================
    omega  omega    0.9     default chosen here: speed of the rotor
    zeta   zeta     0.06    default chosen here: damping ratio
    kappa  kappa    20      default chosen here: stiffness of the ring
    rho    rho      0.7     default chosen here: eccentricity
    f      f        0.1     default chosen here: coefficient of friction
    R_s    radius   60      default chosen here: radius of the shaft
    ====== ======== ======= ================================================

    Parameters
    ----------
    omega, zeta, kappa, rho, f, radius : float or str
        Dimensionless parameters as in the table; the stiffness of the ring is in units of
        that of the shaft, eccentricity and radius in units of the clearance.

    Returns
    -------
    System
        States ``x y vx vy``; modes ``free`` and ``rub``. The cells of the latter are called
        ``forward_slip``, as the rotation has it, ``backward_slip``, where the contact
        point of a backward whirl is faster, and ``rolling``. Outputs ``radius_of_whirl``, ``slip``,
        ``normal_force``, ``friction`` (on the rotor, positive in the sense of rotation) and
        ``whirl`` (angular velocity of the centre). Its symmetry is declared: minus a motion, half
        a period later, is a motion.

    Raises
    ------
    ModelError
        When ``omega`` or ``radius`` is not positive, or ``zeta``, ``kappa`` or ``f`` is
        negative.

    See Also
    --------
    clearance_rotor : the same without friction.
    massive_ring_rotor : friction on a ring that moves.

    Notes
    -----
    In a synchronous rub of radius R, with :math:`s = 1 + \kappa - \omega^2`,

    .. math::

        (sR - \kappa)^2 + (2\zeta\omega R + f\kappa(R - 1))^2 = \rho^2\omega^4.

    Friction drives a backward whirl. Without unbalance it whirls in a circle, faster than the
    natural frequency, where friction gives as much as damping takes: with
    :math:`p = \kappa (1 - 1/R)`,

    .. math::

        f p = 2\zeta\sqrt{1 + p}, \quad \text{frequency} -\sqrt{1 + p},

    which needs :math:`f > 2\zeta\sqrt{1 + \kappa}/\kappa`. The circle is unstable: beyond it the
    whirl grows (dry whip) until the shaft rolls on the ring, u = 0. There friction takes the value
    that keeps it rolling, until that would exceed f N. Without unbalance the whip settles on the
    circle

    .. math::

        (1 + \kappa) R^2 - \kappa R = (\omega R_s)^2, \quad \text{frequency} -\omega R_s/R, \quad
        \text{friction} -2\zeta\omega R_s.

    References
    ----------
    H. F. Black, Interaction of a whirling rotor with a vibrating stator across a clearance
    annulus, Journal of Mechanical Engineering Science 10, 1-12 (1968); J. Jiang, H. Ulbrich,
    The physical reason and the analytical condition for the onset of dry whip in
    rotor-to-stator contact systems, Journal of Vibration and Acoustics 127, 594-603 (2005);
    J. Jiang, The analytical solution and the existence condition of dry friction backward whirl
    in rotor-to-stator contact systems, the same 129, 260 (2007).

    Examples
    --------
    A synchronous rub at high speed, and what friction does to its radius:

    >>> import nonsmooth as ns
    >>> rub = ns.models.rubbing_rotor(omega=1.5, zeta=0.1, f=0.05)
    >>> run = ns.simulate(rub, {"x": 1.0, "vy": 1.5}, periods=100)
    >>> round(float(run["radius_of_whirl"][-1]), 8)
    1.14649039

    Friction acts against the slip, here still forward in a backward whirl:

    >>> whip = ns.models.rubbing_rotor(rho=0, f=0.2, radius=10)
    >>> run = ns.simulate(whip, {"x": 1.1, "vy": -5.0}, t_end=1)
    >>> [round(float(run[name][0]), 12) for name in ("slip", "normal_force", "friction")]
    [4.0, 2.0, -0.4]

    Later it rolls:

    >>> run = ns.simulate(whip, {"x": 1.1, "vy": -5.0}, t_end=150)
    >>> ns.phase_word(run)
    ('forward_slip', 'rolling')
    >>> [round(float(run[name][-1]), 6) for name in ("radius_of_whirl", "friction")]
    [2.497065, -1.079495]
    """
    return System(
        name="rubbing_rotor",
        states=["x", "y", "vx", "vy"],
        period="2*pi/omega",
        symmetry={"x": "-x", "y": "-y", "vx": "-vx", "vy": "-vy"},
        parameters={
            "omega": omega,
            "zeta": zeta,
            "kappa": kappa,
            "rho": rho,
            "f": f,
            "radius": radius,
        },
        require={
            "omega > 0": "the rotor must turn",
            "zeta >= 0": "negative damping would feed energy in",
            "kappa >= 0": "the ring cannot pull",
            "f >= 0": "friction acts against the slip",
            "radius > 0": "the shaft touches with its surface",
        },
        definitions={
            "r": "sqrt(x**2 + y**2)",
            "u": "omega*radius + (x*vy - y*vx)/r",
            "push": "kappa*(1 - 1/r)",
            "drag": "f*sign(u)*push",
            "N": "kappa*(r - 1)",
            "T": "-f*sign(u)*N",
        },
        outputs={
            "radius_of_whirl": "r",
            "slip": "u",
            "normal_force": "N",
            "friction": "T",
            "whirl": "(x*vy - y*vx)/r**2",
        },
        describe=_LABELS,
        modes=_modes(),
    )


_LABELS = {
    "x": "displacement in x",
    "y": "displacement in y",
    "vx": "velocity in x",
    "vy": "velocity in y",
    "radius_of_whirl": "radius of the whirl",
    "slip": "slip of the shaft on the ring",
    "normal_force": "normal force on the shaft",
    "friction": "friction on the shaft",
    "whirl": "angular velocity of the whirl",
    "omega": "speed of the rotor",
    "zeta": "damping ratio",
    "kappa": "stiffness of the ring over that of the shaft",
    "rho": "eccentricity over the clearance",
    "f": "coefficient of friction",
    "radius": "radius of the shaft over the clearance",
}


def _modes() -> dict[str, Mode]:
    pull_x = "rho*omega**2*cos(omega*t) - 2*zeta*vx - x"
    pull_y = "rho*omega**2*sin(omega*t) - 2*zeta*vy - y"
    return {
        "free": Mode(
            {"x": "vx", "y": "vy", "vx": pull_x, "vy": pull_y},
            definitions={"N": "0", "T": "0"},
            exits=[Exit("1 - x**2 - y**2", to="rub", name="contact")],
        ),
        "rub": Mode(
            {
                "x": "vx",
                "y": "vy",
                "vx": f"{pull_x} - push*x + drag*y",
                "vy": f"{pull_y} - push*y - drag*x",
            },
            exits=[Exit("x**2 + y**2 - 1", to="free", name="release")],
            # the surface is -u
            cells={"-": "forward_slip", "0": "rolling", "+": "backward_slip"},
        ),
    }
