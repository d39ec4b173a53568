r"""The soft impact oscillator: a mass on a spring that meets a second spring on one side.

The restoring force is bilinear. It is continuous, so nothing jumps when the mass meets the
second spring; as that one gets stiffer the motion approaches rigid impact.
"""

from __future__ import annotations

from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["soft_impact"]


def soft_impact(
    omega: Text = 0.85,
    zeta: Text = 0.01,
    beta: Text = 29.0,
    e: Text = 1.26,
    a: Text = 0.7,
) -> System:
    r"""Soft impact (bilinear) oscillator under harmonic excitation of its base, dimensionless.

    .. math::

        x'' + 2\zeta x' + x + \beta (x - e) H(x - e) = a\omega^2 \sin(\omega\tau)

    with the Heaviside function H; time counts in 1 over the natural frequency of the mass
    on its own spring, displacements in a reference length of the rig.

    ====== ======== ======= ===============================================
    symbol argument default source
    ====== ======== ======= ===============================================
    ω      omega    0.85    default chosen here: frequency of the excitation
    ζ      zeta     0.01    default chosen here: damping ratio
    β      beta     29      default chosen here: stiffness ratio
    e      e        1.26    default chosen here: gap
    a      a        0.7     default chosen here: amplitude of the excitation
    ====== ======== ======= ===============================================

    Parameters
    ----------
    omega, zeta, beta, e, a : float or str
        Dimensionless parameters as in the table. A negative gap is a preload; a negative
        ``beta`` is a spring that takes stiffness away, as an opening crack does.

    Returns
    -------
    System
        States ``x v``; modes ``free`` and ``contact``, both linear; outputs
        ``acceleration`` and ``stop_force``, the force of the second spring.

    Raises
    ------
    ModelError
        When ``omega`` is not positive, ``zeta`` is negative, or ``beta`` is not above -1.

    See Also
    --------
    trilinear : the same with a second spring on either side.

    References
    ----------
    S. W. Shaw and P. J. Holmes, A periodically forced piecewise linear oscillator, Journal
    of Sound and Vibration 90, 129-155 (1983); J. Ing, E. Pavlovskaia, M. Wiercigroch and
    S. Banerjee, Experimental study of impact oscillator with one-sided elastic constraint,
    Philosophical Transactions of the Royal Society A 366, 679-704 (2008).

    Examples
    --------
    Free and undamped with no gap, the mass spends half a period on either stiffness: the
    period is :math:`\pi + \pi/\sqrt{1 + \beta}`.

    >>> import nonsmooth as ns
    >>> bilinear = ns.models.soft_impact(zeta=0, beta=8, e=0, a=0)
    >>> run = ns.simulate(bilinear, {"v": 1.0}, t_end=10)
    >>> period = run["event_time"][3] - run["event_time"][1]
    >>> round(float(period) / 3.141592653589793, 12)
    1.333333333333
    """
    return System(
        name="soft_impact",
        states=["x", "v"],
        period="2*pi/omega",
        parameters={"omega": omega, "zeta": zeta, "beta": beta, "e": e, "a": a},
        require={
            "omega > 0": "the excitation needs a frequency",
            "zeta >= 0": "negative damping would feed energy in",
            "beta > -1": "in contact the two springs together must push back",
        },
        definitions={"R": "beta*(x - e)", "pull": "a*omega**2*sin(omega*t) - 2*zeta*v - x"},
        outputs={"acceleration": "rate(v)", "stop_force": "R"},
        describe={
            "x": "displacement of the mass",
            "v": "velocity of the mass",
            "acceleration": "acceleration of the mass",
            "stop_force": "force of the second spring",
            "omega": "frequency of the excitation",
            "zeta": "damping ratio",
            "beta": "stiffness of the second spring over that of the first",
            "e": "gap to the second spring",
            "a": "amplitude of the excitation",
        },
        modes={
            "free": Mode(
                {"x": "v", "v": "pull"},
                definitions={"R": "0"},
                exits=[Exit("e - x", to="contact", name="impact")],
            ),
            "contact": Mode(
                {"x": "v", "v": "pull - R"},
                exits=[Exit("x - e", to="free", name="release")],
            ),
        },
    )
