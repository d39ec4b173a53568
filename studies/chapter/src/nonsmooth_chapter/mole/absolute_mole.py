"""The mole as the chapter first writes it: absolute displacements, SI units, Eqs. (2)-(4).

No scaling and no split into bounded motion and drift: this is the other side of the
comparisons that test both.
"""

from __future__ import annotations

from dataclasses import asdict
from math import pi
from typing import TYPE_CHECKING

from nonsmooth import Exit, Mode, System

if TYPE_CHECKING:
    from nonsmooth.models import MolingRig

__all__ = ["absolute_mole", "unit_mole"]


def absolute_mole(rig: MolingRig, *, apart: bool = False) -> System:
    """Mole with absolute displacements in m: mass, slider top and slider bottom.

    Parameters
    ----------
    rig : MolingRig
        Its data.
    apart : bool, optional
        Whether mass and slider top are integrated apart in contact too, each by its own rate;
        by default the mass is placed at the gap from the slider top.

    Returns
    -------
    System
        States ``X_m Y_m X_t X_b``; at rest all displacements are zero and the gap is open.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> rig = ns.models.MolingRig(
    ...     mass=2.0, stiffness=5e4, damping=31.6, static_force=30.0, dynamic_force=60.0,
    ...     friction_force=200.0, angular_frequency=15.8, gap=8e-5,
    ... )  # fmt: skip
    >>> run = ns.simulate(absolute_mole(rig), periods=20)
    >>> round(1e3 * float(run["X_b"][-1]))
    2457
    """
    rate = {"X_m": "Y_m"} if apart else {}
    place = {} if apart else {"X_m": "X_t + gap"}
    return System(
        name="mole in absolute displacements",
        states=["X_m", "Y_m", "X_t", "X_b"],
        parameters=asdict(rig),
        period="2*pi/angular_frequency",
        definitions={
            "load": "static_force + dynamic_force*cos(angular_frequency*t + phase)",
            "spring": "stiffness*(X_t - X_b)",
            "resistance": "damping*Y_m + spring",
        },
        modes={
            "no_contact": Mode(
                {"X_m": "Y_m", "Y_m": "load/mass", "X_t": "-spring/damping", "X_b": "0"},
                exits=[Exit("X_t + gap - X_m", to="contact", name="impact")],
            ),
            "contact": Mode(
                {**rate, "Y_m": "(load - resistance)/mass", "X_t": "Y_m", "X_b": "0"},
                slaved=place,
                exits=[
                    Exit("resistance", to="no_contact", name="release"),
                    Exit("friction_force - resistance", to="progression"),
                ],
            ),
            "progression": Mode(
                {
                    **rate,
                    "Y_m": "(load - friction_force)/mass",
                    "X_t": "Y_m",
                    "X_b": "Y_m - (friction_force - spring)/damping",
                },
                slaved=place,
                exits=[Exit("resistance - friction_force", to="contact")],
            ),
        },
    )


def unit_mole(b: float, *, apart: bool = False) -> System:
    """Mole of Fig. 7 in absolute displacements, with units in which its data are dimensionless.

    Parameters
    ----------
    b : float
        Static force.
    apart : bool, optional
        As for `absolute_mole`.

    Returns
    -------
    System

    Examples
    --------
    >>> import nonsmooth as ns
    >>> round(float(ns.simulate(unit_mole(0.15), periods=50)["X_b"][-1]))
    1554
    """
    from nonsmooth.models import MolingRig

    rig = MolingRig(
        mass=1.0, stiffness=1.0, damping=2.0 * 0.05, static_force=b, dynamic_force=0.3,
        friction_force=1.0, angular_frequency=0.1, gap=0.02, phase=0.5 * pi,
    )  # fmt: skip
    return absolute_mole(rig, apart=apart)
