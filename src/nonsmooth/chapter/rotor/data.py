"""Data that section 4 prints: two dimensionless sets, and the rig in SI units."""

from __future__ import annotations

import math
from typing import NamedTuple

from nonsmooth import System
from nonsmooth.models import rotor

__all__ = [
    "DELTA_40",
    "DELTA_41",
    "EPS_40",
    "EPS_41",
    "RIG",
    "Rig",
    "natural_frequency",
    "rig",
    "rig_data",
    "set_a",
    "set_b",
]

_SET_B = {"nu1": 0.06, "eta_m": 0.00289, "eps_x": 0.4, "eps_y": 0.5}


class Rig(NamedTuple):
    """The rig of section 4.4 in SI units.

    Parameters
    ----------
    M, m : float
        Mass of the rotor, and out of balance [kg].
    k_r, k_s : float
        Stiffness of the rotor's rods, and of one spring of the ring [N/m].
    c_r, c_s : float
        Damping of the rotor, and of one support of the ring [kg/s].
    rho, gamma : float
        Radius of the mass out of balance, and gap [m].

    Examples
    --------
    >>> Rig().M
    9.7
    """

    M: float = 9.7
    m: float = 0.028
    k_r: float = 79e3
    k_s: float = 2354e3
    c_r: float = 105.0
    c_s: float = 3.5
    rho: float = 35e-3
    gamma: float = 0.5e-3


RIG = Rig()
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


def rig_data(data: Rig = RIG) -> dict[str, float]:
    """Dimensionless parameters of the rig.

    Parameters
    ----------
    data : Rig, optional
        The rig.

    Returns
    -------
    dict of str to float
        ``nu1``, ``nu2``, ``K``, ``eta_m``, ``rho``.

    Examples
    --------
    >>> round(rig_data()["nu1"], 4)
    0.06
    """
    critical = 2.0 * math.sqrt(data.k_r * data.M)
    return {
        "nu1": data.c_r / critical,
        "nu2": data.c_s / critical,
        "K": data.k_s / data.k_r,
        "eta_m": data.m / data.M,
        "rho": data.rho / data.gamma,
    }


def natural_frequency(data: Rig = RIG) -> float:
    """Natural frequency of the rotor on its rods, in Hz.

    Parameters
    ----------
    data : Rig, optional
        The rig.

    Returns
    -------
    float

    Examples
    --------
    >>> round(natural_frequency(), 2)
    14.36
    """
    return math.sqrt(data.k_r / data.M) / (2.0 * math.pi)


def rig(
    eps: tuple[float, float] = EPS_41, delta: float = DELTA_41, frequency: float = 13.1
) -> System:
    """Rotor with the data of the rig.

    Parameters
    ----------
    eps : (float, float), optional
        Eccentricity [mm].
    delta : float, optional
        Preload along both axes [mm].
    frequency : float, optional
        Speed of the shaft [Hz].

    Returns
    -------
    System

    Examples
    --------
    >>> round(rig(frequency=14.36).parameter_values["eta"], 2)
    1.0
    """
    gap = 1e3 * RIG.gamma
    return rotor(
        eta=frequency / natural_frequency(),
        eps_x=eps[0] / gap,
        eps_y=eps[1] / gap,
        delta_x=delta / gap,
        delta_y=delta / gap,
        **rig_data(),
    )
