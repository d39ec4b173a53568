"""What section 3.6 prints for the beam with a breathing crack, and what is assumed beside it.

The chapter gives neither the scale s of its stiffnesses nor the constant force d. The convention
is s = 1 and d = 0. What depends on them is looked at over `S_RANGE` and `D_RANGE` as well: s from
0.1 to 2, which holds what the data of Figs. 24 and 25 give (0.43 and 0.11), and |d| up to the
amplitude eta^2 of the inertial force, beyond which the crack would hardly breathe.
"""

from __future__ import annotations

import numpy as np

from nonsmooth import System
from nonsmooth.models import breathing_crack

__all__ = [
    "CRACK_BOX",
    "D_RANGE",
    "ETA",
    "GROWTH",
    "K_CLOSED",
    "K_FACTOR",
    "NOTCH",
    "RATE",
    "S_RANGE",
    "TAU_END",
    "WIDTH",
    "XI",
    "beam",
    "crack_at",
    "grid_of_missing_data",
    "tau_at",
    "turn",
]

XI, ETA = 0.014, 1.1475
K_CLOSED, K_FACTOR = 14.327, 4.245e-3  # k_s closed, and open over (20 - a)^3, of Fig. 29
WIDTH = 20.0  # of the specimen [mm]
NOTCH = 5.0  # [mm]
GROWTH = "5 + 1e-3*exp(t/54734 - 7.8)"  # of the caption of Fig. 30 [mm]
RATE = 54734.0  # time in which the growth is multiplied by e
TAU_END = 940_000.0
S_RANGE, D_RANGE = (0.1, 2.0), (-(ETA**2), ETA**2)
CRACK_BOX = {"u": (-3.0, 3.0), "v": (-3.0, 3.0)}  # from which starts are drawn


def beam(crack: float, **parameters: float) -> System:
    """Beam with the data of Figs. 29 and 30.

    Parameters
    ----------
    crack : float
        Length of the crack [mm].
    **parameters : float
        Changed parameters.

    Returns
    -------
    System

    Examples
    --------
    >>> beam(12.09, s=0.5).parameter_values["s"]
    0.5
    """
    return breathing_crack(xi=XI, eta=ETA, crack=crack).with_parameters(**parameters)


def turn(system: System) -> float:
    """Period of the forcing.

    Parameters
    ----------
    system : System
        The beam.

    Returns
    -------
    float
    """
    return 2.0 * np.pi / system.parameter_values["eta"]


def crack_at(tau: float) -> float:
    """Length of the growing crack of Fig. 30 at a time.

    Parameters
    ----------
    tau : float
        Dimensionless time.

    Returns
    -------
    float
        In mm.

    Examples
    --------
    >>> round(crack_at(900_514.0), 3)
    10.724
    """
    return NOTCH + 1e-3 * float(np.exp(tau / RATE - 7.8))


def tau_at(crack: float) -> float:
    """Time at which the growing crack of Fig. 30 has a length.

    Parameters
    ----------
    crack : float
        Length [mm], above 5.

    Returns
    -------
    float

    Examples
    --------
    >>> round(tau_at(12.0))
    911522
    """
    return RATE * (7.8 + float(np.log(1e3 * (crack - NOTCH))))


def grid_of_missing_data(columns: int = 20, rows: int = 21) -> dict[str, list[float]]:
    """Values of s and d over the stated range.

    Parameters
    ----------
    columns, rows : int, optional
        Number of values of s and of d.

    Returns
    -------
    dict of str to list of float
        ``s`` and ``d``.

    Examples
    --------
    >>> [len(values) for values in grid_of_missing_data().values()]
    [20, 21]
    """
    return {
        "s": np.linspace(*S_RANGE, columns).tolist(),
        "d": np.linspace(*D_RANGE, rows).tolist(),
    }
