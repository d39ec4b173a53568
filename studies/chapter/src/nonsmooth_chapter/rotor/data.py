"""Data that section 4 prints: two dimensionless sets, and the rig in SI units."""

from __future__ import annotations

from typing import Any

from nonsmooth import System
from nonsmooth.models import RotorRig, rotor

__all__ = [
    "DELTA_40",
    "DELTA_41",
    "EPS_40",
    "EPS_41",
    "rig",
    "set_a",
    "set_b",
]

_SET_B: dict[str, Any] = {"nu1": 0.06, "eta_m": 0.00289, "eps_x": 0.4, "eps_y": 0.5}


# Eccentricity and preload of Fig. 40, and of Figs. 41 and 42 [mm].
EPS_40, DELTA_40 = (0.5, 0.0), 0.1
EPS_41, DELTA_41 = (0.45, 0.05), 0.04


def set_a(delta: float, eta: float = 2.442) -> System:
    """Rotor with the data of Figs. 36, 37 and 38(c), (d).

    Parameters
    ----------
    delta : float
        Preload along both axes.
    eta : float, optional
        Ratio of frequencies.

    Returns
    -------
    System

    Examples
    --------
    >>> set_a(0.1).parameter_values["eps_x"]
    0.9
    """
    return rotor(eta=eta, delta_x=delta, delta_y=delta)


def set_b(delta: float, eta: float = 2.5) -> System:
    """Rotor with the data of Fig. 38(a), (b).

    Parameters
    ----------
    delta : float
        Preload along both axes.
    eta : float, optional
        Ratio of frequencies.

    Returns
    -------
    System

    Examples
    --------
    >>> set_b(0.05).parameter_values["nu1"]
    0.06
    """
    return rotor(eta=eta, delta_x=delta, delta_y=delta, **_SET_B)


def rig(
    eps: tuple[float, float] = EPS_41, delta: float = DELTA_41, speed: float = 13.1
) -> RotorRig:
    """Rig of section 4.4 in SI units.

    Parameters
    ----------
    eps : (float, float), optional
        Eccentricity [mm].
    delta : float, optional
        Preload along both axes [mm].
    speed : float, optional
        Speed of the shaft [Hz].

    Returns
    -------
    RotorRig

    Examples
    --------
    >>> round(rig().natural_frequency, 2)
    14.36
    """
    return RotorRig(
        mass=9.7, unbalance_mass=0.028, unbalance_radius=35.0, rotor_stiffness=79e3,
        ring_stiffness=2354e3, rotor_damping=105.0, ring_damping=3.5, gap=0.5, speed=speed,
        eccentricity_x=eps[0], eccentricity_y=eps[1], preload_x=delta, preload_y=delta,
    )  # fmt: skip
