r"""A mass on a moving belt: stick-slip, as of a bowed string or a squealing brake.

The belt drags the mass along until the spring pulls it off. It keeps moving since friction at
rest is larger than in motion: by a jump, or by a law that falls with the speed of slip.
"""

from __future__ import annotations

from typing import Literal

from nonsmooth.system.model.evaluated import parameter_values
from nonsmooth.system.parts import Text
from nonsmooth.system.surfaces import Surface
from nonsmooth.system.system import System

__all__ = ["belt_oscillator"]

_LAWS = ("coulomb", "falling")
_LABELS = {
    "x": "displacement",
    "v": "velocity",
    "friction": "friction force on the mass",
    "slip_velocity": "velocity relative to the belt",
    "acceleration": "acceleration",
    "v_b": "velocity of the belt",
    "F_s": "static friction",
    "F_k": "kinetic friction",
    "delta": "fall of friction with the speed of slip",
    "zeta": "damping ratio",
    "F": "amplitude of the force",
    "omega": "frequency of the force",
}


def belt_oscillator(
    v_b: Text = 0.3,
    F_s: Text = 0.6,
    F_k: Text = 0.4,
    delta: Text = 3.0,
    zeta: Text = 0.0,
    F: Text = 0.0,
    omega: Text = 0.7,
    law: Literal["coulomb", "falling"] = "coulomb",
) -> System:
    r"""Stick-slip oscillator on a moving belt, dimensionless.

    .. math::

        x'' + 2\zeta x' + x = R + F\cos(\omega\tau), \qquad
        v_r = x' - v_b,

    where friction in slip is :math:`R = -F_k\operatorname{sign}v_r`, or by the falling law of
    Leine et al. (1998)

    .. math::

        R = -\frac{F_s}{1 + \delta |v_r|}\operatorname{sign} v_r .

    In stick :math:`v_r = 0`, and R is what keeps it so, :math:`|R| \le F_s` with both laws.
    Time counts in 1 over the natural frequency, displacements in what a unit of force
    stretches the spring by.

    ====== ======== ======= ===================================================
    symbol argument default source
    ====== ======== ======= ===================================================
    v_b    v_b      0.3     default chosen here: velocity of the belt
    F_s    F_s      0.6     default chosen here: static friction
    F_k    F_k      0.4     default chosen here: kinetic friction
    δ      delta    3       Leine et al. (recalled, not verified): falling law
    ζ      zeta     0       default chosen here: damping ratio
    F      F        0       default chosen here: nothing drives it but the belt
    ω      omega    0.7     default chosen here: frequency of the force
    ====== ======== ======= ===================================================

    Parameters
    ----------
    v_b, F_s, zeta : float or str
        Dimensionless parameters as in the table; the belt moves forward or stands still.
    F_k, delta : float or str
        Kinetic friction of the Coulomb law, at most ``F_s``; fall of the falling law. The
        system has the one that its law needs.
    F, omega : float or str
        Amplitude and frequency of a harmonic force. With ``F = 0`` the system has neither,
        and no period; to vary ``F`` through zero, make the system with another value first.
    law : {"coulomb", "falling"}, optional
        Friction in slip: constant, or falling with the speed of slip.

    Returns
    -------
    System
        States ``x v``; cells ``lag`` (slower than the belt), ``lead`` and ``stick``, all
        linear with the Coulomb law; outputs ``friction``, the force on the mass,
        ``slip_velocity`` and ``acceleration``.

    Raises
    ------
    ModelError
        When ``law`` is another word, ``F_k`` is not positive or above ``F_s``, ``omega`` or
        ``F_s`` is not positive, or ``v_b``, ``delta`` or ``zeta`` is negative.

    See Also
    --------
    friction_oscillator : on a table that stands still.
    brake_mode_coupling : two degrees of freedom, unstable at constant friction.

    Notes
    -----
    Undamped and not driven, the Coulomb law has the stick-slip motion of period

    .. math::

        T = \frac{2D}{v_b} + 2\pi - 2\arctan\frac{D}{v_b}, \qquad D = F_s - F_k .

    References
    ----------
    R. I. Leine, D. H. van Campen, A. de Kraker and L. van den Steen, Stick-slip vibrations
    induced by alternate friction models, Nonlinear Dynamics 16, 41-54 (1998).

    Examples
    --------
    >>> import math
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.belt_oscillator(), t_end=60)
    >>> stops = run["event_time"].values[run["event_kind"] == "slide_entry"]
    >>> round(float(stops[-1] - stops[-2]), 10)
    6.4405134334
    >>> round(2 * 0.2 / 0.3 + 2 * math.pi - 2 * math.atan(0.2 / 0.3), 10)
    6.4405134334
    """
    # all of them, as the system has only those that play a part
    values = parameter_values({"F_k": F_k, "delta": delta, "F": F, "omega": omega})
    driven = values["F"] != 0.0
    coulomb = law == "coulomb"
    parameters: dict[str, Text] = {"v_b": v_b, "F_s": F_s}
    require = {
        "v_b >= 0": "x counts along the belt",
        "F_s > 0": "friction acts against the slip",
        "zeta >= 0": "negative damping would feed energy in",
    }
    if coulomb:
        parameters["F_k"] = F_k
        require["F_k > 0"] = "friction acts against the slip"
        require["F_s >= F_k"] = "friction holds at least as much as it drags"
    else:
        parameters["delta"] = delta
        require["delta >= 0"] = "friction falls with the speed of slip"
    parameters["zeta"] = zeta
    if driven:
        parameters |= {"F": F, "omega": omega}
        require["omega > 0"] = "the force needs a frequency"
    known = {"x", "v", "friction", "slip_velocity", "acceleration", *parameters}
    return System(
        name="belt_oscillator",
        states=["x", "v"],
        period="2*pi/omega" if driven else None,
        parameters=parameters,
        require=require,
        definitions={
            "R": "-F_k*sign(slip)" if coulomb else "-F_s*sign(slip)/(1 + delta*abs(slip))",
            "pull": ("F*cos(omega*t) " if driven else "") + "- 2*zeta*v - x",
        },
        outputs={"friction": "R", "slip_velocity": "v - v_b", "acceleration": "rate(v)"},
        describe={name: text for name, text in _LABELS.items() if name in known},
        surfaces={
            "slip": Surface(
                "v - v_b",
                below="lag",
                on="stick",
                above="lead",
                hold="F_s/F_k" if coulomb else None,
            )
        },
        equations={"x": "v", "v": "pull + R"},
    )
