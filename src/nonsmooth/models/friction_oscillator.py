r"""The oscillator with Coulomb friction: a mass on a spring that rubs on a fixed table.

At rest friction takes whatever value balances the other forces, up to its limit: the mass stays
stuck until they exceed it. That is Filippov's motion on the surface x' = 0.
"""

from __future__ import annotations

from nonsmooth.system.model.evaluated import parameter_values
from nonsmooth.system.parts import Mode, Text
from nonsmooth.system.surfaces import Surface
from nonsmooth.system.system import System

__all__ = ["friction_oscillator"]

_LABELS = {
    "x": "displacement",
    "v": "velocity",
    "friction": "friction force on the mass",
    "acceleration": "acceleration",
    "omega": "frequency of the force",
    "zeta": "damping ratio",
    "f": "friction limit",
    "a": "amplitude of the force",
    "k": "growth of the normal force with the displacement",
}
_UNLOADED = {"++": "forth", "-+": "back", "0+": "stick", "+-": "lifted", "--": "lifted"}


def friction_oscillator(
    omega: Text = 0.7,
    zeta: Text = 0.0,
    f: Text = 0.3,
    a: Text = 1.0,
    k: Text = 0.0,
) -> System:
    r"""Oscillator with Coulomb friction after Den Hartog (1931) and Feeny (1992), dimensionless.

    .. math::

        x'' + 2\zeta x' + x + f\,n(x)\operatorname{sign}(x') = a\cos(\omega\tau), \qquad
        n(x) = \max(1 + kx,\, 0)

    Time counts in 1 over the natural frequency, displacements in what a unit of force
    stretches the spring by. In stick :math:`x' = 0` and friction is what balances the other
    forces, :math:`|a\cos\omega\tau - x| \le f\,n(x)`.

    ====== ======== ======= ==============================================
    symbol argument default source
    ====== ======== ======= ==============================================
    ω      omega    0.7     default chosen here: frequency of the force
    ζ      zeta     0       Den Hartog: friction alone takes energy out
    f      f        0.3     default chosen here: friction over the force
    a      a        1       Den Hartog: the force is the unit of force
    k      k        0       Den Hartog: constant normal force
    ====== ======== ======= ==============================================

    Parameters
    ----------
    omega, zeta, f, a : float or str
        Dimensionless parameters as in the table. With ``a = 0`` the motion decays.
    k : float or str, optional
        Growth of the normal force with the displacement, as in Feeny's oscillator, which is
        chaotic at ω = 1.25, ζ = 0.015, f = 1, a = 1.9, k = 1.5 (recalled from Feeny and
        Moon, not verified against the paper). With ``k = 0`` the system has no such
        parameter; to vary ``k`` through zero, make the system with another value first.

    Returns
    -------
    System
        States ``x v``; cells ``forth`` (v > 0), ``back`` and ``stick``, with ``k`` also
        ``lifted``, all linear; outputs ``friction``, the force on the mass, and
        ``acceleration``. Without ``k`` its symmetry is declared: minus a motion, half a period
        later, is a motion.

    Raises
    ------
    ModelError
        When ``omega`` is not positive, or ``zeta`` or ``f`` is negative.

    See Also
    --------
    belt_oscillator : the table moves, and may hold more than it drags.

    Notes
    -----
    Without force and damping the turning points lose 2f each, and the mass stops for good at
    the first one with :math:`|x| \le f`. Under the force and undamped, Den Hartog's motion
    without stops has the amplitude

    .. math::

        X = \sqrt{V^2 - (f/a)^2 U^2}\,a, \qquad V = \frac{1}{1 - \omega^2}, \qquad
        U = \frac{\sin(\pi/\omega)}{\omega (1 + \cos(\pi/\omega))},

    while friction cannot hold the mass at its turning points, :math:`X\omega^2 > f`, and it
    moves one way all through each half period.

    References
    ----------
    J. P. Den Hartog, Forced vibrations with combined Coulomb and viscous friction,
    Transactions of the ASME 53, 107-115 (1931); B. Feeny, A nonsmooth Coulomb friction
    oscillator, Physica D 59, 25-38 (1992); B. Feeny and F. C. Moon, Chaos in a forced
    dry-friction oscillator: experiments and numerical modelling, Journal of Sound and
    Vibration 170, 303-323 (1994).

    Examples
    --------
    A free decay from 1.05 with f = 0.1 stops at the fifth turning point, where friction
    balances the spring:

    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.friction_oscillator(f=0.1, a=0), {"x": 1.05}, t_end=50)
    >>> [round(float(x), 12) for x in run["state_after"][:, 0]]
    [1.05, -0.85, 0.65, -0.45, 0.25, -0.05]
    >>> float(run["v"][-1]), round(float(run["friction"][-1]), 12)
    (0.0, -0.05)
    """
    loaded = parameter_values({"k": k})["k"] != 0.0
    parameters = {"omega": omega, "zeta": zeta, "f": f, "a": a}
    slip = Surface("v", below="back", on="stick", above="forth")
    return System(
        name="friction_oscillator",
        states=["x", "v"],
        period="2*pi/omega",
        symmetry={} if loaded else {"x": "-x", "v": "-v"},
        parameters=parameters | ({"k": k} if loaded else {}),
        require={
            "omega > 0": "the force needs a frequency",
            "zeta >= 0": "negative damping would feed energy in",
            "f >= 0": "friction acts against the motion",
        },
        definitions={"n": "max(1 + k*x, 0)" if loaded else "1", "drag": "f*n*sign(slip)"},
        outputs={"friction": "-drag", "acceleration": "rate(v)"},
        describe={name: text for name, text in _LABELS.items() if loaded or name != "k"},
        surfaces={"slip": slip},
        modes={
            "flow": Mode(
                {"x": "v", "v": "a*cos(omega*t) - 2*zeta*v - x - drag"},
                cells=_UNLOADED if loaded else None,
            )
        },
    )
