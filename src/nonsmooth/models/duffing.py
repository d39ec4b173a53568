r"""The Duffing oscillator: a mass on a spring with a cubic term, smooth throughout."""

from __future__ import annotations

from nonsmooth.system.parts import Text
from nonsmooth.system.system import System

__all__ = ["duffing"]


def duffing(
    omega: Text = 1.2,
    delta: Text = 0.3,
    alpha: Text = -1.0,
    beta: Text = 1.0,
    gamma: Text = 0.5,
) -> System:
    r"""Duffing oscillator, double well or hardening, under a harmonic force; dimensionless.

    .. math::

        x'' + \delta x' + \alpha x + \beta x^3 = \gamma\cos(\omega\tau)

    With :math:`\alpha < 0 < \beta` there are two wells around :math:`\pm\sqrt{-\alpha/
    \beta}`; with both positive the spring hardens, and with :math:`\beta < 0 < \alpha` it
    softens up to :math:`\sqrt{-\alpha/\beta}`, beyond which the motion runs away.

    ====== ======== ======= ==========================================
    symbol argument default source
    ====== ======== ======= ==========================================
    omega  omega    1.2     default chosen here: frequency of the force
    delta  delta    0.3     default chosen here: damping
    alpha  alpha    -1      Guckenheimer and Holmes, section 2.2
    beta   beta     1       Guckenheimer and Holmes, section 2.2
    gamma  gamma    0.5     default chosen here: amplitude of the force
    ====== ======== ======= ==========================================

    Parameters
    ----------
    omega, delta, alpha, beta, gamma : float or str
        Dimensionless parameters as in the table.

    Returns
    -------
    System
        States ``x v``; one smooth mode, ``flow``, run by Taylor series; outputs
        ``acceleration`` and ``energy``, kinetic and potential. Its symmetry is declared: minus a
        motion, half a period later, is a motion.

    Raises
    ------
    ModelError
        When ``omega`` is not positive or ``delta`` is negative.

    See Also
    --------
    chua : a circuit that may have a cubic resistor.

    References
    ----------
    J. Guckenheimer and P. Holmes, Nonlinear Oscillations, Dynamical Systems, and
    Bifurcations of Vector Fields, Springer (1983), section 2.2.

    Examples
    --------
    Free and undamped it keeps its energy, here :math:`1/2 + 1/4`:

    >>> import nonsmooth as ns
    >>> spring = ns.models.duffing(delta=0, alpha=1, gamma=0)
    >>> run = ns.simulate(spring, {"x": 1.0}, t_end=50)
    >>> round(float(run["energy"][-1]), 12)
    0.75
    """
    return System(
        name="duffing",
        states=["x", "v"],
        period="2*pi/omega",
        symmetry={"x": "-x", "v": "-v"},
        parameters={"omega": omega, "delta": delta, "alpha": alpha, "beta": beta, "gamma": gamma},
        require={
            "omega > 0": "the force needs a frequency",
            "delta >= 0": "negative damping would feed energy in",
        },
        equations={"x": "v", "v": "gamma*cos(omega*t) - delta*v - alpha*x - beta*x**3"},
        outputs={
            "acceleration": "rate(v)",
            "energy": "v**2/2 + alpha*x**2/2 + beta*x**4/4",
        },
        describe={
            "x": "displacement",
            "v": "velocity",
            "acceleration": "acceleration",
            "energy": "kinetic and potential energy",
            "omega": "frequency of the force",
            "delta": "damping",
            "alpha": "linear stiffness",
            "beta": "cubic stiffness",
            "gamma": "amplitude of the force",
        },
    )
