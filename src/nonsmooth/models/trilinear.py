r"""The symmetric trilinear oscillator: a mass between two elastic stops."""

from __future__ import annotations

from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["trilinear"]


def trilinear(
    omega: Text = 1.5,
    zeta: Text = 0.02,
    kappa: Text = 8.0,
    delta: Text = 0.5,
    F: Text = 1.0,
) -> System:
    r"""Symmetric trilinear oscillator after Natsiavas (1989), dimensionless.

    .. math::

        x'' + 2\zeta x' + x + \kappa g(x) = F\cos(\omega\tau), \qquad
        g(x) = \begin{cases} x - \delta & x > \delta \\ 0 & |x| \le \delta \\
        x + \delta & x < -\delta \end{cases}

    Time counts in 1 over the natural frequency between the stops. A symmetric orbit is a fixed
    point of half a period followed by a reflection, and its multipliers are the squares of that
    map's; where one of those passes -1 the symmetry breaks.

    ====== ======== ======= ================================================
    symbol argument default source
    ====== ======== ======= ================================================
    ω      omega    1.5     default chosen here: frequency of the force
    ζ      zeta     0.02    default chosen here: damping ratio
    κ      kappa    8       default chosen here: stiffness ratio of the stops
    δ      delta    0.5     default chosen here: half gap between the stops
    F      F        1       default chosen here: amplitude of the force
    ====== ======== ======= ================================================

    Parameters
    ----------
    omega, zeta, kappa, delta, F : float or str
        Dimensionless parameters as in the table.

    Returns
    -------
    System
        States ``x v``; modes ``free``, ``upper`` (on the stop at δ) and ``lower`` (on the
        stop at -δ), all linear; outputs ``acceleration`` and ``stop_force``. A motion
        mirrored in x and shifted by half a period is a motion again, which is declared as its
        symmetry.

    Raises
    ------
    ModelError
        When ``omega`` is not positive, ``zeta`` or ``delta`` is negative, or ``kappa`` is
        not above -1.

    See Also
    --------
    soft_impact : one stop.
    gear_pair : nothing between the stops.

    References
    ----------
    S. Natsiavas, Periodic response and stability of oscillators with symmetric trilinear
    restoring force, Journal of Sound and Vibration 134, 315-331 (1989).

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.trilinear(), periods=100)
    >>> ns.phase_word(run, 99 * run.attrs["period"], 100 * run.attrs["period"])
    ('upper', 'free', 'lower', 'free', 'upper')
    """
    return System(
        name="trilinear",
        states=["x", "v"],
        period="2*pi/omega",
        symmetry={"x": "-x", "v": "-v"},
        parameters={"omega": omega, "zeta": zeta, "kappa": kappa, "delta": delta, "F": F},
        require={
            "omega > 0": "the force needs a frequency",
            "zeta >= 0": "negative damping would feed energy in",
            "kappa > -1": "on a stop the springs together must push back",
            "delta >= 0": "the gap between the stops cannot be negative",
        },
        definitions={"R": "0", "pull": "F*cos(omega*t) - 2*zeta*v - x"},
        outputs={"acceleration": "rate(v)", "stop_force": "R"},
        describe={
            "x": "displacement of the mass",
            "v": "velocity of the mass",
            "acceleration": "acceleration of the mass",
            "stop_force": "force of the stops on the mass, downward positive",
            "omega": "frequency of the force",
            "zeta": "damping ratio",
            "kappa": "stiffness of a stop over that of the spring",
            "delta": "half gap between the stops",
            "F": "amplitude of the force",
        },
        modes={
            "free": Mode(
                {"x": "v", "v": "pull"},
                exits=[
                    Exit("delta - x", to="upper", name="upper_impact"),
                    Exit("delta + x", to="lower", name="lower_impact"),
                ],
            ),
            "upper": Mode(
                {"x": "v", "v": "pull - R"},
                definitions={"R": "kappa*(x - delta)"},
                exits=[Exit("x - delta", to="free", name="release")],
            ),
            "lower": Mode(
                {"x": "v", "v": "pull - R"},
                definitions={"R": "kappa*(x + delta)"},
                exits=[Exit("-delta - x", to="free", name="release")],
            ),
        },
    )
