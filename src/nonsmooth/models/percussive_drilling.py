r"""Percussive drilling against dry friction: the simplest system with impacts and progression.

A bit under a static and a harmonic force drives a slider that has neither mass nor elasticity.
It is the limit of the mole for a ground of which only the friction is felt.
"""

from __future__ import annotations

from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["percussive_drilling"]


def percussive_drilling(a: Text = 0.3, b: Text = 0.15, omega: Text = 0.1) -> System:
    r"""Percussive drilling with a dry-friction slider, dimensionless.

    With the force :math:`f = b + a\cos\omega\tau` and the displacement :math:`x = p + v`, where
    v is that of the slider,

    .. math::

        x'' = f                     &\quad\text{in flight, } p < 0 \\
        x'' = f - 1,\; v' = x'      &\quad\text{in progression, } p = 0,\; x' > 0 \\
        x' = v' = 0                 &\quad\text{in stick, } p = 0,\; 0 \le f \le 1

    The slider resists with the friction limit, the unit of force, and only pushes: the bit leaves
    it where the force falls below zero. It has no mass, so the bit keeps its velocity when it
    comes back and goes on in progression. Stick is Filippov's motion on the surface x' = 0,
    where the slider's force is f; it is written as a mode so that its ends have names.

    ====== ======== ======= ===============================================
    symbol argument default source
    ====== ======== ======= ===============================================
    a      a        0.3     as the mole of Fig. 7 of the chapter
    b      b        0.15    as the mole of Fig. 7(d) of the chapter
    ω      omega    0.1     as the mole of Fig. 7 of the chapter
    ====== ======== ======= ===============================================

    Parameters
    ----------
    a, b : float or str
        Amplitude of the harmonic force and static force, over the friction limit. With b from
        one on the bit accelerates for ever.
    omega : float or str
        Frequency. It only sets the scales: velocities go with 1/ω, displacements with 1/ω².

    Returns
    -------
    System
        States ``p y v``: bit relative to the slider, velocity of the bit, and progression of
        the slider, the drift; modes ``flight``, ``progression`` and ``stick``, all linear;
        outputs ``x``, ``slider_force`` and ``acceleration``.

    Raises
    ------
    ModelError
        When ``omega`` is not positive.

    See Also
    --------
    moling : the same in a visco-elastic ground.

    References
    ----------
    A. M. Krivtsov and M. Wiercigroch, Dry friction model of percussive drilling, Meccanica 34,
    425-434 (1999); the chapter, Fig. 2(a).

    Examples
    --------
    The progression per period times ω² is the same at every frequency.

    >>> import nonsmooth as ns
    >>> for omega in (0.1, 2.0):
    ...     run = ns.simulate(ns.models.percussive_drilling(omega=omega), periods=20)
    ...     gain = float(ns.models.progression(run, periods=5)["per_period"])
    ...     print(run.attrs["phase_word"], round(gain * omega**2, 9))
    flight progression stick flight 0.259164738
    flight progression stick flight 0.259164738
    """
    return System(
        name="percussive_drilling",
        states=["p", "y", "v"],
        drift=["v"],
        period="2*pi/omega",
        parameters={"a": a, "b": b, "omega": omega},
        require={"omega > 0": "the force needs a frequency"},
        definitions={"f": "b + a*cos(omega*t)", "R": "0"},
        outputs={"x": "p + v", "slider_force": "R", "acceleration": "rate(y)"},
        describe={
            "p": "displacement of the bit relative to the slider",
            "y": "velocity of the bit",
            "v": "displacement of the slider (progression)",
            "x": "displacement of the bit",
            "slider_force": "force of the slider",
            "acceleration": "acceleration of the bit",
            "a": "amplitude of the force over the friction limit",
            "b": "static force over the friction limit",
            "omega": "frequency of the force",
        },
        modes={
            "flight": Mode(
                {"p": "y", "y": "f", "v": "0"},
                exits=[Exit("-p", to="progression", name="impact")],
            ),
            "progression": Mode(
                {"y": "f - 1", "v": "y"},
                slaved={"p": "0"},
                definitions={"R": "1"},
                exits=[Exit("y", to="stick", name="stop")],
            ),
            "stick": Mode(
                {"v": "0"},
                slaved={"p": "0", "y": "0"},
                definitions={"R": "f"},
                exits=[
                    Exit("f", to="flight", name="lift_off"),
                    Exit("1 - f", to="progression", name="slip"),
                ],
            ),
        },
    )
