"""The mole over its static force: what each column of a diagram settles to, by three protocols.

The chapter prints neither the range of the static force nor how its columns begin. Here b runs
evenly up to a: above b = a the force never draws the mass off the
ground. Columns begin at rest, or where the next lower or higher one has ended.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import xarray as xr

from nonsmooth import bifurcation_diagram, lyapunov_spectrum
from nonsmooth.models import moling

__all__ = [
    "AMPLITUDES",
    "CHAOTIC",
    "PROTOCOLS",
    "UNSETTLED",
    "Sweep",
    "even_forces",
    "first_fifty",
    "force_sweep",
    "settled_labels",
]

AMPLITUDES = (0.1, 0.3, 0.9)
PROTOCOLS = ("restart", "follow up", "follow down")
CHAOTIC, UNSETTLED = 0, -1
_SPAN = 150  # periods over which an exponent is taken


@dataclass(frozen=True)
class Sweep:
    """Columns of a diagram of the mole over b, in order of b.

    Parameters
    ----------
    b : numpy.ndarray
        Static forces.
    labels : numpy.ndarray
        Period of each motion, or `CHAOTIC` or `UNSETTLED`.
    per_period : numpy.ndarray
        Settled progression per period.
    exponents : numpy.ndarray
        Largest exponent per period of those without a period, nan elsewhere.

    Examples
    --------
    >>> import numpy as np
    >>> Sweep(np.array([0.1, 0.2]), np.array([1, 0]), np.zeros(2), np.zeros(2)).step
    0.1
    """

    b: np.ndarray
    labels: np.ndarray
    per_period: np.ndarray
    exponents: np.ndarray

    @property
    def step(self) -> float:
        """Distance of neighbouring columns."""
        return float(self.b[1] - self.b[0])


def even_forces(limit: float, columns: int) -> tuple[float, ...]:
    """Static forces from limit/columns to limit.

    Parameters
    ----------
    limit : float
        The largest.
    columns : int
        How many.

    Returns
    -------
    tuple of float

    Examples
    --------
    >>> even_forces(0.4, 4)
    (0.1, 0.2, 0.3, 0.4)
    """
    return tuple(round(limit * (k + 1) / columns, 12) for k in range(columns))


@lru_cache(maxsize=64)
def force_sweep(
    a: float,
    forces: tuple[float, ...],
    start: str = "restart",
    *,
    transient: int = 600,
    record: int = 128,
    xi: float = 0.05,
    omega: float = 0.1,
) -> Sweep:
    """Labels and progression of the mole for many static forces.

    Parameters
    ----------
    a : float
        Amplitude of the force.
    forces : tuple of float
        Static forces, rising.
    start : str, optional
        Protocol, as for `bifurcation_diagram`.
    transient, record : int, optional
        Periods left out and looked at.
    xi, omega : float, optional
        Damping ratio and frequency.

    Returns
    -------
    Sweep

    Examples
    --------
    >>> force_sweep(0.3, (0.1, 0.15), transient=200, record=20).labels
    array([2, 1])
    """
    diagram = bifurcation_diagram(
        moling(a=a, xi=xi, omega=omega), "b", forces, start=start, transient=transient,
        record=record,
    )  # fmt: skip
    labels, exponents = settled_labels(diagram, a=a, xi=xi, omega=omega)
    return Sweep(np.array(forces), labels, diagram["v_per_period"].values[:, 0], exponents)


def settled_labels(
    diagram: xr.Dataset, *, a: float, xi: float, omega: float
) -> tuple[np.ndarray, np.ndarray]:
    """Label of each column, with the largest exponent per period of those without a period.

    A motion without a period is chaotic when its exponent is above three standard errors and
    above one over the periods averaged; otherwise it has not settled, as near a bifurcation.

    Parameters
    ----------
    diagram : xarray.Dataset
        Diagram over b, one lane.
    a, xi, omega : float
        Other parameters of the mole.

    Returns
    -------
    labels, exponents : numpy.ndarray

    Examples
    --------
    >>> import nonsmooth as ns
    >>> diagram = ns.bifurcation_diagram(ns.models.moling(), "b", [0.05, 0.15])
    >>> settled_labels(diagram, a=0.3, xi=0.05, omega=0.1)[0]
    array([0, 1])
    """
    labels = diagram["period"].isel(lane=0).values.astype(int)
    exponents = np.full(labels.size, np.nan)
    turn = 2.0 * np.pi / omega
    for i in np.flatnonzero(labels == 0):
        found = lyapunov_spectrum(
            moling(a=a, b=float(diagram["parameter"][i]), xi=xi, omega=omega),
            diagram.isel(parameter=i, lane=0, point=-1),
            transient=10,
            record=_SPAN,
            exponents=1,
        )
        exponents[i] = turn * float(found["lyapunov_exponent"][0])
        error = turn * float(found["standard_error"][0])
        labels[i] = CHAOTIC if exponents[i] > max(3.0 * error, 1.0 / _SPAN) else UNSETTLED
    return labels, exponents


@lru_cache(maxsize=16)
def first_fifty(a: float, forces: tuple[float, ...]) -> np.ndarray:
    """Progression in the first 50 periods from rest, xi = 0.05 and omega = 0.1.

    Parameters
    ----------
    a : float
        Amplitude of the force.
    forces : tuple of float
        Static forces.

    Returns
    -------
    numpy.ndarray

    Examples
    --------
    >>> first_fifty(0.3, (0.1, 0.15)).round()
    array([ 697., 1554.])
    """
    diagram = bifurcation_diagram(moling(a=a), "b", forces, transient=0, record=50)
    return 50.0 * diagram["v_per_period"].values[:, 0]
