r"""The ground mole: a drifting impact oscillator with a visco-elastic frictional slider.

A mass is driven by a static and a harmonic force. In front of it, at a gap, stands a
slider: two weightless plates joined by a spring and a damper, the lower one held by dry
friction. The slider yields, and the mole progresses, where the force on it reaches the
friction limit.
"""

from __future__ import annotations

from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["moling"]


def moling(
    a: Text = 0.3,
    b: Text = 0.15,
    xi: Text = 0.05,
    omega: Text = 0.1,
    g: Text = 0.02,
    phi: Text = "pi/2",
) -> System:
    r"""Ground mole of Pavlovskaia, Wiercigroch and Grebogi (2001), dimensionless.

    With the forcing :math:`f = b + a\cos(\omega\tau + \varphi)` and the trial force
    :math:`F = 2\xi y + q`, the displacements relative to the slider's bottom are p (mass)
    and q (slider top), y is the velocity of the mass and v the progression:

    .. math::

        \text{no contact:} && p' &= y, & y' &= f, & q' &= -q/2\xi, & v' &= 0, \\
        \text{contact:} && y' &= f - F, & q' &= y, & p &= q + g, & v' &= 0, \\
        \text{progression:} && y' &= f - 1, & q' &= (1 - q)/2\xi, & p &= q + g,
        & v' &= (F - 1)/2\xi.

    ====== ========== ======= =========================================
    symbol argument   default source
    ====== ========== ======= =========================================
    a      a          0.3     chapter, Fig. 6: amplitude of the forcing
    b      b          0.15    chapter, Fig. 6(d): static force
    ξ      xi         0.05    chapter, Fig. 6: damping of the slider
    ω      omega      0.1     chapter, Fig. 6: frequency of the forcing
    g      g          0.02    chapter, section 2.1: gap
    φ      phi        pi/2    chapter, section 2.1: phase of the forcing
    ====== ========== ======= =========================================

    Parameters
    ----------
    a, b, xi, omega, g, phi : float or str
        Dimensionless parameters as in the table; forces are in units of the friction
        limit, times in units of the slider's natural period over 2 pi.

    Returns
    -------
    System
        States ``p y q v``; modes ``no_contact``, ``contact``, ``progression``; outputs
        ``x`` and ``z`` (absolute displacements of mass and slider top), ``slider_force``
        and ``acceleration``. The defaults reproduce Figs. 6(d) and 7(d).

    Raises
    ------
    ModelError
        When ``xi`` is not positive, ``g`` is negative, or ``omega`` is not positive.

    References
    ----------
    E. Pavlovskaia, M. Wiercigroch and C. Grebogi, Modeling of an impact system with a
    drift, Physical Review E 64, 056224 (2001); the chapter, Eqs. (5)-(17) and (25)-(27).

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.moling(b=0.1), periods=40)
    >>> bool(run["v"][-1] > run["v"][0])
    True
    """
    return System(
        name="moling",
        states=["p", "y", "q", "v"],
        drift=["v"],
        period="2*pi/omega",
        parameters={"a": a, "b": b, "xi": xi, "omega": omega, "g": g, "phi": phi},
        require={
            "xi > 0": "the slider needs damping, its force is 2*xi*y + q",
            "omega > 0": "the forcing needs a frequency",
            "g >= 0": "the gap cannot be negative",
        },
        definitions={"f": "b + a*cos(omega*t + phi)", "F": "2*xi*y + q", "R": "F"},
        outputs={"x": "p + v", "z": "q + v", "slider_force": "R", "acceleration": "rate(y)"},
        describe={
            "p": "displacement of the mass relative to the slider bottom",
            "y": "velocity of the mass",
            "q": "displacement of the slider top relative to its bottom",
            "v": "displacement of the slider bottom (progression)",
            "x": "displacement of the mass",
            "z": "displacement of the slider top",
            "slider_force": "force on the slider",
            "acceleration": "acceleration of the mass",
            "a": "amplitude of the forcing",
            "b": "static force",
            "xi": "damping of the slider",
            "omega": "frequency of the forcing",
            "g": "gap between mass and slider",
            "phi": "phase of the forcing",
        },
        modes={
            "no_contact": Mode(
                {"p": "y", "y": "f", "q": "-q/(2*xi)", "v": "0"},
                definitions={"R": "0"},
                exits=[Exit("q + g - p", to="contact", name="impact")],
            ),
            "contact": Mode(
                {"y": "f - F", "q": "y", "v": "0"},
                slaved={"p": "q + g"},
                exits=[
                    Exit("F", to="no_contact", name="release"),
                    Exit("1 - F", to="progression"),
                ],
            ),
            "progression": Mode(
                {"y": "f - 1", "q": "(1 - q)/(2*xi)", "v": "(F - 1)/(2*xi)"},
                slaved={"p": "q + g"},
                definitions={"R": "1"},
                exits=[Exit("F - 1", to="contact")],
            ),
        },
    )
