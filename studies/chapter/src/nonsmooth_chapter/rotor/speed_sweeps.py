"""The rotor over its speed: what each column of a diagram settles to, by three protocols.

Section 4.3 begins every column at zero and raises eta; section 4.4 begins where the column before
has ended. Both are computed, the second one with rising and with falling speed.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import groupby

import numpy as np
import xarray as xr

from nonsmooth import System, bifurcation_diagram, ensemble, lyapunov_spectrum
from nonsmooth_chapter.files import processors

__all__ = [
    "CHAOTIC",
    "PROTOCOLS",
    "REGULAR",
    "UNKNOWN",
    "Sweep",
    "even_values",
    "last_strobe",
    "speed_sweeps",
    "stretches",
    "with_exponents",
]

PROTOCOLS = ("restart", "follow up", "follow down")
# labels of columns whose strobes do not repeat: chaos, an exponent of zero (quasi-periodic, or
# still settling), and not looked at yet
CHAOTIC, REGULAR, UNKNOWN = 0, -1, -2
# Periods over which an exponent is taken, and standard errors above which it tells of chaos. What
# is far above after a short time needs no longer one.
_SPANS = ((100, 6.0), (400, 3.0))


@dataclass(frozen=True, eq=False)
class Sweep:
    """Columns of a diagram of the rotor over eta, in order of eta.

    Parameters
    ----------
    start : str
        Protocol.
    eta : numpy.ndarray
        Ratios of frequencies.
    labels : numpy.ndarray
        Period of each motion, or `CHAOTIC`, `REGULAR` or `UNKNOWN`.
    data : xarray.Dataset
        The diagram, one lane.
    exponents : numpy.ndarray
        Largest exponent per period of columns without a period, nan elsewhere.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> Sweep("restart", np.array([2.0, 2.5]), np.ones(2, int), xr.Dataset(), np.ones(2)).step
    0.5
    """

    start: str
    eta: np.ndarray
    labels: np.ndarray
    data: xr.Dataset
    exponents: np.ndarray

    @property
    def step(self) -> float:
        """Distance of neighbouring columns."""
        return float(self.eta[1] - self.eta[0])

    def share(self, label: int) -> float:
        """Part of the columns with a label."""
        return float(np.mean(self.labels == label))


def speed_sweeps(
    system: System,
    etas: tuple[float, ...],
    starts: tuple[str, ...] = PROTOCOLS,
    *,
    transient: int = 300,
    record: int = 150,
) -> tuple[Sweep, ...]:
    """Diagrams of the rotor over eta by several protocols, at once.

    Parameters
    ----------
    system : System
        The rotor.
    etas : tuple of float
        Ratios of frequencies, rising.
    starts : tuple of str, optional
        Protocols, as for `bifurcation_diagram`; columns that restart begin at zero.
    transient, record : int, optional
        Periods left out and looked at.

    Returns
    -------
    tuple of Sweep
        One for each protocol.

    Examples
    --------
    >>> from nonsmooth_chapter.rotor.data import set_a
    >>> speed_sweeps(set_a(0.0), (2.0, 2.05), ("restart",), transient=200)[0].labels
    array([1, 1])
    """

    def sweep(start: str) -> Sweep:
        return _sweep(system, etas, start, transient, record)

    # a followed diagram is one chain: chains run side by side
    with ThreadPoolExecutor(processors()) as pool:
        return tuple(pool.map(sweep, starts))


@lru_cache(maxsize=32)  # a figure and the claims beside it share what they have in common
def _sweep(
    system: System, etas: tuple[float, ...], start: str, transient: int, record: int
) -> Sweep:
    """Diagram by one protocol."""
    found = bifurcation_diagram(
        system, "eta", etas, start=start, transient=transient, record=record
    ).isel(lane=0)
    periods = found["period"].values.astype(int)
    labels = np.where(periods > 0, periods, UNKNOWN)
    return Sweep(start, np.array(etas), labels, found, np.full(len(etas), np.nan))


@lru_cache(maxsize=32)
def with_exponents(system: System, sweep: Sweep) -> Sweep:
    """Sweep with labels for the columns whose strobes do not repeat.

    A motion is chaotic when its largest exponent over 100 periods is above six standard errors and
    above six over these periods, or that over 400 periods above three.

    Parameters
    ----------
    system : System
        The rotor.
    sweep : Sweep
        As from `speed_sweeps`.

    Returns
    -------
    Sweep

    Examples
    --------
    >>> from nonsmooth_chapter.rotor.data import set_a
    >>> (sweep,) = speed_sweeps(set_a(0.0), (2.0, 2.5), ("restart",), transient=200)
    >>> with_exponents(set_a(0.0), sweep).labels
    array([1, 0])
    """
    labels, exponents = sweep.labels.copy(), sweep.exponents.copy()

    def exponent(column: int) -> tuple[float, bool]:
        there = system.with_parameters(eta=float(sweep.eta[column]))
        start, turn = sweep.data.isel(parameter=column, point=-1), float(there.period_value or 0.0)
        value, chaotic = np.nan, False
        for span, clearly in _SPANS:
            found = lyapunov_spectrum(there, start, transient=10, record=span, exponents=1)
            value = turn * float(found["lyapunov_exponent"][0])
            error = turn * float(found["standard_error"][0])
            chaotic = value > clearly * max(error, 1.0 / span)
            if chaotic:
                break
        return value, chaotic

    columns = np.flatnonzero(sweep.labels == UNKNOWN)
    with ThreadPoolExecutor(processors()) as pool:
        for column, (value, chaotic) in zip(columns, pool.map(exponent, columns), strict=True):
            exponents[column] = value
            labels[column] = CHAOTIC if chaotic else REGULAR
    return replace(sweep, labels=labels, exponents=exponents)


def even_values(first: float, last: float, columns: int) -> tuple[float, ...]:
    """Values with even distances, both ends among them.

    Parameters
    ----------
    first, last : float
        Ends.
    columns : int
        Steps between them; there is one value more.

    Returns
    -------
    tuple of float

    Examples
    --------
    >>> even_values(2.0, 3.0, 4)
    (2.0, 2.25, 2.5, 2.75, 3.0)
    """
    return tuple(np.linspace(first, last, columns + 1).round(12).tolist())


def last_strobe(
    system: System, transient: int, start: dict[str, float] | None = None
) -> dict[str, float]:
    """State at the last strobe of a run.

    Parameters
    ----------
    system : System
        The rotor.
    transient : int
        Periods of the run.
    start : mapping of str to float, optional
        Initial state; zero without it.

    Returns
    -------
    dict of str to float

    Examples
    --------
    >>> from nonsmooth_chapter.rotor.data import set_a
    >>> list(last_strobe(set_a(0.1), 10))
    ['x', 'y', 'vx', 'vy', 'sx', 'sy', 'mu']
    """
    found = ensemble(system, start, transient=transient, record=1).isel(lane=0, point=0)
    return {name: float(found[name]) for name in system.states}


def stretches(sweep: Sweep) -> list[tuple[int, float, float]]:
    """Neighbouring columns with one label: the label, first and last eta.

    Parameters
    ----------
    sweep : Sweep
        Columns with labels.

    Returns
    -------
    list of (int, float, float)

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> labels = np.array([1, 1, 3])
    >>> stretches(Sweep("restart", np.array([2.0, 2.1, 2.2]), labels, xr.Dataset(), np.ones(3)))
    [(1, 2.0, 2.1), (3, 2.2, 2.2)]
    """
    groups = groupby(range(sweep.labels.size), lambda i: int(sweep.labels[i]))
    parts = [(label, list(part)) for label, part in groups]
    return [(label, float(sweep.eta[i[0]]), float(sweep.eta[i[-1]])) for label, i in parts]
