"""The mole as the chapter first writes it: absolute displacements, SI units, Eqs. (2)-(4).

No scaling and no split into bounded motion and drift: this is the other side of the
comparisons that test both.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from nonsmooth import Exit, Mode, System

if TYPE_CHECKING:
    from nonsmooth.models import MolingRig

__all__ = ["absolute_mole"]


def absolute_mole(rig: MolingRig) -> System:
    """Mole with absolute displacements in m: mass, slider top and slider bottom.

    Parameters
    ----------
    rig : MolingRig
        Its data.

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
                {"Y_m": "(load - resistance)/mass", "X_t": "Y_m", "X_b": "0"},
                slaved={"X_m": "X_t + gap"},
                exits=[
                    Exit("resistance", to="no_contact", name="release"),
                    Exit("friction_force - resistance", to="progression"),
                ],
            ),
            "progression": Mode(
                {
                    "Y_m": "(load - friction_force)/mass",
                    "X_t": "Y_m",
                    "X_b": "Y_m - (friction_force - spring)/damping",
                },
                slaved={"X_m": "X_t + gap"},
                exits=[Exit("resistance - friction_force", to="contact")],
            ),
        },
    )
