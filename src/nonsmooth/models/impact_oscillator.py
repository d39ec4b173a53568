r"""The rigid impact oscillator: a driven mass on a spring that strikes a wall."""

from __future__ import annotations

from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["impact_oscillator"]


def impact_oscillator(
    omega: Text = 2.0,
    zeta: Text = 0.02,
    F: Text = 1.0,
    sigma: Text = 0.0,
    r: Text = 0.8,
) -> System:
    r"""Harmonically driven oscillator with a rigid wall on one side, dimensionless.

    .. math::

        x'' + 2\zeta x' + x = F\cos(\omega\tau), \quad x < \sigma; \qquad
        x'_+ = -r x'_- \quad\text{at } x = \sigma

    Time counts in 1 over the natural frequency. Impacts that accumulate leave the mass at the
    wall, :math:`x = \sigma,\; x' = 0`, for as long as :math:`F\cos\omega\tau > \sigma`.

    With :math:`T = 2\pi n/\omega`, the map of a motion with one impact in T has the determinant
    :math:`r^2 e^{-2\zeta T}`. The motion without impacts grazes at :math:`F = \sigma
    \sqrt{(1 - \omega^2)^2 + 4\zeta^2\omega^2}`.

    ====== ======== ======= =============================================
    symbol argument default source
    ====== ======== ======= =============================================
    ω      omega    2       default chosen here: frequency of the force
    ζ      zeta     0.02    default chosen here: damping ratio
    F      F        1       unit of length, where F is not varied
    sigma  sigma    0       default chosen here: position of the wall
    r      r        0.8     default chosen here: restitution
    ====== ======== ======= =============================================

    Parameters
    ----------
    omega, zeta, F, sigma, r : float or str
        Dimensionless parameters as in the table. The wall is at rest behind the spring's
        position of rest where ``sigma`` is positive; negative, it is a preload.

    Returns
    -------
    System
        States ``x v``; modes ``free`` and ``stuck``, at rest at the wall, both linear; outputs
        ``acceleration`` and ``wall_force``, which has no part from impacts. It starts at the
        spring's position of rest, or at the wall where that is nearer.

    Raises
    ------
    ModelError
        When ``omega`` is not positive, ``zeta`` is negative, or ``r`` is not between 0 and 1.

    See Also
    --------
    soft_impact : a wall that gives way.
    bouncing_ball : gravity in place of the spring, and a wall that moves.

    References
    ----------
    S. W. Shaw and P. J. Holmes, A periodically forced piecewise linear oscillator, Journal
    of Sound and Vibration 90, 129-155 (1983); F. Peterka and J. Vacik, Transition to chaotic
    motion in mechanical systems with impacts, Journal of Sound and Vibration 154, 95-115
    (1992); C. Budd and F. Dux, Chattering and related behaviour in impact oscillators,
    Philosophical Transactions of the Royal Society A 347, 365-389 (1994).

    Examples
    --------
    Slowly driven, the mass chatters to rest at the wall, and leaves it where the force
    falls to that of the spring: with the wall at 0, at a quarter of the period.

    >>> import nonsmooth as ns
    >>> slow = ns.models.impact_oscillator(omega=0.3)
    >>> run = ns.simulate(slow, periods=4)
    >>> released = run["event_phase"].values[run["event_name"].values == "release"]
    >>> round(float(released[-1]) / run.attrs["period"], 14)
    0.25
    """
    return System(
        name="impact_oscillator",
        states=["x", "v"],
        period="2*pi/omega",
        parameters={"omega": omega, "zeta": zeta, "F": F, "sigma": sigma, "r": r},
        require={
            "omega > 0": "the force needs a frequency",
            "zeta >= 0": "negative damping would feed energy in",
            "r >= 0": "the mass cannot go through the wall",
            "r <= 1": "an impact cannot feed energy in",
        },
        definitions={"pull": "F*cos(omega*t) - 2*zeta*v - x"},
        outputs={"acceleration": "rate(v)", "wall_force": "pull - rate(v)"},
        initial={"x": "min(sigma, 0)"},
        describe={
            "x": "displacement of the mass",
            "v": "velocity of the mass",
            "acceleration": "acceleration of the mass",
            "wall_force": "force of the wall on a mass that rests there",
            "omega": "frequency of the force",
            "zeta": "damping ratio",
            "F": "amplitude of the force",
            "sigma": "position of the wall",
            "r": "coefficient of restitution",
        },
        modes={
            "free": Mode(
                {"x": "v", "v": "pull"},
                exits=[Exit("sigma - x", reset={"v": "-r*v"}, sticks="stuck", name="impact")],
            ),
        },
    )
