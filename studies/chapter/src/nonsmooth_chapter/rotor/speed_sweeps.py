"""The rotor over its speed: sweeps, branches of orbits, and where they bifurcate."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import groupby, pairwise

import numpy as np
import xarray as xr

from nonsmooth import System, bifurcation_diagram, continue_orbit, ensemble
from nonsmooth_chapter.exponents import largest_exponent
from nonsmooth_chapter.judgement import Evidence
from nonsmooth_chapter.results import processors
from nonsmooth_chapter.rotor.motions import follow_orbit, orbit_near, set_a

__all__ = [
    "CHAOTIC",
    "PROTOCOLS",
    "REGULAR",
    "UNKNOWN",
    "Sweep",
    "branch_end",
    "branches_at_strobes",
    "branches_of_set_a",
    "even_values",
    "last_strobe",
    "orbit_at",
    "speed_sweeps",
    "stretches",
    "sweep_of_set_a",
    "transition",
    "with_exponents",
]


# The rotor over its speed: what each column of a diagram settles to, by three protocols.
#
# Section 4.3 begins every column at zero and raises eta; section 4.4 begins where the column before
# has ended. Both are computed, the second one with rising and with falling speed.

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
    >>> from nonsmooth_chapter.rotor.motions import set_a
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
        system, "eta", list(etas), start=start, transient=transient, record=record
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
    >>> from nonsmooth_chapter.rotor.motions import set_a
    >>> (sweep,) = speed_sweeps(set_a(0.0), (2.0, 2.5), ("restart",), transient=200)
    >>> with_exponents(set_a(0.0), sweep).labels
    array([1, 0])
    """
    labels, exponents = sweep.labels.copy(), sweep.exponents.copy()

    def exponent(column: int) -> tuple[float, bool]:
        there = system.with_parameters(eta=float(sweep.eta[column]))
        start = sweep.data.isel(parameter=column, point=-1)
        value, chaotic = np.nan, False
        for span, clearly in _SPANS:
            value, error = largest_exponent(there, start, transient=10, record=span)
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
    >>> from nonsmooth_chapter.rotor.motions import set_a
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


# Branches of orbits of set A over eta, stable or not: the lines of Fig. 36.

_SPAN = (2.0, 5.0)
_SETTLED = 1500  # periods from zero
# Period, an eta at which zero leads to such an orbit, the range over which it is followed, and
# steps either way; period two from where period one flips, period three only around its stable
# parts, which lie on closed curves near eta = 2.2.
_STARTS = {
    0.0: ((1, 2.05, _SPAN, 60), (2, 3.05, _SPAN, 120), (3, 2.18, (2.0, 2.5), 30),
          (3, 4.5, (3.5, 5.0), 90)),
    0.1: ((1, 2.05, _SPAN, 60), (2, 3.05, _SPAN, 120), (3, 2.3, (2.0, 2.5), 50),
          (3, 4.7, (3.5, 5.0), 90)),
}  # fmt: skip
_STEP = 0.02
_BEHIND = 1e-6  # of eta, where the doubled orbit is told from the single one
_SHOWN = ("flip", "fold", "torus")
_CRITICAL = 1e-6  # of a multiplier from the unit circle; at a graze a branch may turn with others


@lru_cache(maxsize=4)
def branches_of_set_a(delta: float, longest: int = 3) -> dict[int, list[xr.Dataset]]:
    """Branches of the orbits of period one, two and three that set A settles to.

    Parameters
    ----------
    delta : float
        Preload along both axes, 0 or 0.1.
    longest : int, optional
        Longest period that is followed.

    Returns
    -------
    dict of int to list of xarray.Dataset
        By period, as from `continue_orbit`.

    Examples
    --------
    >>> branches = branches_of_set_a(0.1, longest=1)
    >>> kinds = branches[1][0]["special_kind"].values
    >>> [str(kind) for kind in kinds]
    ['bound', 'flip', 'bound']
    """
    found: dict[int, list[xr.Dataset]] = {}
    for period, eta, (low, high), steps in _STARTS[delta]:
        if period > longest:
            continue
        if period == 2:
            flips = found[1][0]["special_kind"].values == "flip"
            low = float(found[1][0]["special_value"].values[flips][0]) + _BEHIND
        system = set_a(delta, eta)
        branch = continue_orbit(
            system, "eta", (low, high), initial=last_strobe(system, _SETTLED), period=period,
            steps=steps, step=_STEP, largest_step=_STEP,
        )  # fmt: skip
        found.setdefault(period, []).append(branch)
    return found


def branches_at_strobes(system: System, branches: Sequence[xr.Dataset]) -> xr.Dataset:
    """One branch for plots with all strobes of some branches of one period.

    Parameters
    ----------
    system : System
        The rotor.
    branches : sequence of xarray.Dataset
        As from `continue_orbit`.

    Returns
    -------
    xarray.Dataset
        ``x`` and ``stable`` over ``point``, strobe after strobe with a gap (nan) between them;
        flips, folds and tori as special points.

    Examples
    --------
    >>> from nonsmooth import continue_orbit
    >>> system = set_a(0.1, eta=2.05)
    >>> branch = continue_orbit(system, "eta", (2.0, 2.1), transient=300)
    >>> branches_at_strobes(system, [branch]).sizes["point"] == branch.sizes["point"] + 1
    True
    """
    parts: dict[str, list[np.ndarray]] = {name: [] for name in ("eta", "x", "stable")}
    marks: dict[str, list[np.ndarray]] = {name: [] for name in ("kind", "value", "point")}
    done = 0
    for branch in branches:
        period, eta = int(branch.attrs["period"]), branch["eta"].values
        strobes = ensemble(
            system, {name: branch[name].values.tolist() for name in system.states},
            parameters={"eta": eta.tolist()}, combine="pairs", record=period,
        )["x"].transpose("lane", "point").values  # fmt: skip
        shown = _shown(branch)
        number = np.arange(eta.size)
        for x in strobes.T:
            there = np.isfinite(x)  # a start where two events coincide may be refused
            x = np.interp(number, number[there], x[there])
            for name, values in (("eta", eta), ("x", x), ("stable", branch["stable"].values)):
                parts[name] += [values, np.array([0.0 if name == "stable" else np.nan])]
            marks["kind"].append(branch["special_kind"].values[shown])
            marks["value"].append(branch["special_value"].values[shown])
            marks["point"].append(done + branch["special_point"].values[shown])
            done += eta.size + 1
    variables = {name: ("point", np.concatenate(each)) for name, each in parts.items()}
    variables |= {f"special_{k}": ("special", np.concatenate(v)) for k, v in marks.items()}
    variables["stable"] = ("point", variables["stable"][1].astype(bool))
    return xr.Dataset(variables, attrs={"parameter": "eta"})


def _shown(branch: xr.Dataset) -> np.ndarray:
    kind, value = branch["special_kind"].values, branch["special_multiplier"].values
    return np.isin(kind, _SHOWN) & (np.abs(np.abs(value) - 1.0) < _CRITICAL)


# Where the motions of set A change over eta: by restart, by following, and on the orbits.

_COLUMNS, _FOLLOWED = 600, 300  # from 2 to 5
_ZOOM, _LONG = 20, 3000  # columns between two, and periods left out in them
_AGAIN = 0.2  # of eta, within which another stretch of the same period is told
_BETWEEN = 4  # columns at most that have not settled where one period becomes another


@lru_cache(maxsize=8)
def sweep_of_set_a(delta: float, start: str) -> Sweep:
    """Diagram of set A over eta from 2 to 5 by one protocol.

    Parameters
    ----------
    delta : float
        Preload along both axes.
    start : str
        Protocol; 600 columns that restart, or 300 that follow.

    Returns
    -------
    Sweep
    """
    if start == "restart":
        return speed_sweeps(set_a(delta), even_values(2.0, 5.0, _COLUMNS), (start,))[0]
    both = ("follow up", "follow down")
    found = speed_sweeps(set_a(delta), even_values(2.0, 5.0, _FOLLOWED), both)
    return found[both.index(start)]


def transition(delta: float, before: int, after: int | None, near: str, start: str) -> Evidence:
    """Where one period becomes another as eta rises, nearest to a printed value.

    Parameters
    ----------
    delta : float
        Preload along both axes.
    before : int
        Period below.
    after : int or None
        Period above, any other motion without it.
    near : str
        The printed value.
    start : str
        Protocol.

    Returns
    -------
    dict
        ``last`` eta with the period below, ``first`` with the motion above, ``becomes`` (its
        period, 0 for none); for columns that restart after a zoom in with longer transients.
        Both are None where there is no such change. ``others``: stretches of the period above,
        up to where that orbit could be meant, with ``from``, ``last`` and ``becomes``.
    """
    sweep = sweep_of_set_a(delta, start)
    place = _nearest(sweep, before, after, float(near))
    if place is None:
        return {"start": start, "last": None, "first": None, "becomes": None, "others": []}
    low, high = place
    others = [
        each for each in _ends_of(sweep, before)
        if sweep.eta[high] < each["last"] <= sweep.eta[high] + _AGAIN
    ]  # fmt: skip
    if start == "restart":
        inner = even_values(float(sweep.eta[low]), float(sweep.eta[high]), _ZOOM)
        (zoom,) = speed_sweeps(set_a(delta), inner, (start,), transient=_LONG)
        closer = _nearest(zoom, before, after, float(near))
        if closer is not None:
            sweep, (low, high) = zoom, closer
    return {
        "start": start,
        "last": float(sweep.eta[low]),
        "first": float(sweep.eta[high]),
        "becomes": max(int(sweep.labels[high]), 0),
        "others": others,
    }


def _ends_of(sweep: Sweep, period: int) -> list[Evidence]:
    """Stretches of a period, and what the column behind each shows (0: no period)."""
    parts = stretches(sweep)
    return [
        {"from": first, "last": last, "becomes": max(behind[0], 0)}
        for (label, first, last), behind in pairwise(parts)
        if label == period
    ]


def _nearest(sweep: Sweep, before: int, after: int | None, near: float) -> tuple[int, int] | None:
    """Last column with one period and first one with the other."""
    labels, found = sweep.labels, []
    for low in np.flatnonzero(labels[:-1] == before).tolist():
        for high in range(low + 1, min(low + 2 + _BETWEEN, labels.size)):
            if labels[high] == before:
                break
            if after is None or labels[high] == after:
                found.append((low, high))
                break
            if labels[high] > 0:
                break
    middle = [abs(0.5 * (sweep.eta[a] + sweep.eta[b]) - near) for a, b in found]
    return found[int(np.argmin(middle))] if found else None


@lru_cache(maxsize=16)
def orbit_at(delta: float, period: int, eta: float) -> xr.Dataset | None:
    """Orbit of set A that the start at zero leads to.

    Parameters
    ----------
    delta : float
        Preload along both axes.
    period : int
        Its period.
    eta : float
        Ratio of frequencies.

    Returns
    -------
    xarray.Dataset or None
        As from `orbit_near`.
    """
    system = set_a(delta, eta)
    return orbit_near(system, last_strobe(system, 1500), period)


def branch_end(delta: float, period: int, begin: float, to: float) -> Evidence:
    """Where an orbit of set A stops being stable, followed from where zero leads to it.

    Parameters
    ----------
    delta : float
        Preload along both axes.
    period : int
        Its period.
    begin, to : float
        First and last eta.

    Returns
    -------
    dict
        As from `follow_orbit`.

    Examples
    --------
    >>> branch_end(0.0, 1, 2.05, 2.1)["kind"]
    'none'
    """
    orbit = orbit_at(delta, period, begin)
    if orbit is None:
        return {"eta": begin, "kind": "no orbit", "multiplier": [0.0, 0.0], "changes": []}
    return follow_orbit(set_a(delta, begin), orbit, to)
