"""Motions of the beam with a breathing crack: data, attractors, onset of chaos."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth import System, attractors, bifurcation_diagram, ensemble
from nonsmooth.models import breathing_crack
from nonsmooth_chapter.exponents import largest_exponent
from nonsmooth_chapter.judgement import Evidence

__all__ = [
    "BOX_STARTS",
    "CRACK_BOX",
    "DROPPED",
    "D_RANGE",
    "ETA",
    "GROWTH",
    "K_CLOSED",
    "K_FACTOR",
    "NOTCH",
    "RATE",
    "SCAN_STARTS",
    "S_RANGE",
    "TAU_END",
    "WIDTH",
    "XI",
    "beam",
    "crack_at",
    "crack_grid",
    "exponent_of_beam",
    "followed_periods",
    "grid_of_missing_data",
    "motions",
    "motions_from",
    "onset_along_growth",
    "onset_from_starts",
    "period_of",
    "scan_of_missing_data",
    "settling",
    "tau_at",
    "turn",
]


# What section 3.6 prints for the beam with a breathing crack, and what is assumed beside it.
#
# The chapter gives neither the scale s of its stiffnesses nor the constant force d. The convention
# is s = 1 and d = 0. What depends on them is looked at over `S_RANGE` and `D_RANGE` as well: s from
# 0.1 to 2, which holds what the data of Figs. 24 and 25 give (0.43 and 0.11), and |d| up to the
# amplitude eta^2 of the inertial force, beyond which the crack would hardly breathe.

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


# Motions of the beam with a crack of one length: which coexist, and how long they take to settle.
#
# A start counts as settled when its strobes stay on the attractor it ends on. Where that takes long
# the motion before looks like an attractor of its own; these times are kept beside the regimes.

BOX_STARTS = 64  # drawn from the box, seed 0
DROPPED = 3000  # periods
SCAN_STARTS = {"u": [0.0, 1.0], "v": [0.0, 0.0]}
_LONGEST = 32
_REPEATS = 1e-6
_SPAN = 1000  # periods over which an exponent is taken
_INTERVAL = 5  # periods between notes of the growth
_NEAR = 0.01  # of the size of an attractor: within it a motion has settled


def period_of(points: np.ndarray, longest: int = _LONGEST) -> int:
    """Period of a sequence of strobes, in periods of the forcing.

    Parameters
    ----------
    points : numpy.ndarray
        Strobes, one row each, at least twice the longest period.
    longest : int, optional
        Longest period to look for.

    Returns
    -------
    int
        0 where they do not repeat.

    Examples
    --------
    >>> period_of(np.tile([[0.0, 1.0], [0.5, 0.0]], (40, 1)))
    2
    """
    for n in range(1, longest + 1):
        if np.abs(points[n:] - points[:-n]).max() <= _REPEATS:
            return n
    return 0


def exponent_of_beam(system: System, start: Any, *, record: int = _SPAN) -> Evidence:
    """Largest exponent per period with its error, and whether it means chaos.

    Parameters
    ----------
    system : System
        The beam.
    start : mapping or dataset
        Settled state at a strobe.
    record : int, optional
        Periods averaged.

    Returns
    -------
    dict
        ``exponent``, ``error`` and ``chaotic``: above three errors, and above three over the
        periods averaged.

    Examples
    --------
    >>> exponent_of_beam(beam(14.5), {"u": 0.0}, record=300)["chaotic"]
    True
    """
    value, error = largest_exponent(system, start, transient=20, record=record, interval=_INTERVAL)
    chaotic = value > 3.0 * max(error, 1.0 / record)
    return {"exponent": value, "error": error, "chaotic": bool(chaotic)}


@lru_cache(maxsize=256)
def motions(system: System, samples: int = BOX_STARTS) -> tuple[Evidence, ...]:
    """Attractors that starts in the box lead to.

    Parameters
    ----------
    system : System
        The beam.
    samples : int, optional
        Starts.

    Returns
    -------
    tuple of dict
        The most frequent first: ``kind``, ``period`` (0: none), ``share`` of the starts, ``word``,
        ``multiplier`` (modulus of the largest) or ``exponent`` and ``error`` per period, ``point``
        (u, v at a strobe).

    Examples
    --------
    >>> [(row["kind"], row["period"]) for row in motions(beam(5.0))]
    [('periodic', 1)]
    """
    found = attractors(system, CRACK_BOX, samples=samples)
    rows = []
    for k in found["attractor"].values:
        one = found.sel(attractor=k)
        row: Evidence = {
            "kind": str(one["kind"].values),
            "period": int(one["period"]),
            "share": float(one["fraction"]),
            "word": str(one["word"].values),
            "point": [float(one["points"].sel(point=0, state=name)) for name in ("u", "v")],
        }
        if row["period"]:
            sizes = np.hypot(one["multiplier_real"], one["multiplier_imag"])
            row["multiplier"] = float(sizes.max())
        else:
            row["exponent"] = float(one["exponent"])
            row["error"] = float(one["exponent_error"])
        rows.append(row)
    return tuple(sorted(rows, key=lambda row: -row["share"]))


def motions_from(
    system: System, starts: dict[str, list[float]], transient: int = DROPPED
) -> list[Evidence]:
    """What certain starts settle to.

    Parameters
    ----------
    system : System
        The beam.
    starts : dict of str to list of float
        ``u`` and ``v``.
    transient : int, optional
        Periods left out.

    Returns
    -------
    list of dict
        For each start ``u``, ``v``, ``period`` and, without a period, the exponent.

    Examples
    --------
    >>> [row["period"] for row in motions_from(beam(5.0), {"u": [0.0], "v": [0.0]})]
    [1]
    """
    runs = ensemble(system, starts, transient=transient, record=4 * _LONGEST)
    rows = []
    for lane in range(runs.sizes["lane"]):
        run = runs.isel(lane=lane)
        row: Evidence = {name: float(starts[name][lane]) for name in ("u", "v")}
        row["period"] = period_of(np.stack([run["u"].values, run["v"].values], axis=1))
        if not row["period"]:
            row |= exponent_of_beam(system, {name: float(run[name][-1]) for name in ("u", "v")})
        rows.append(row)
    return rows


def settling(
    system: System, starts: int = BOX_STARTS, longest: int = DROPPED, seed: int = 0
) -> Evidence:
    """Periods until motions from the box have come to what they end on.

    Parameters
    ----------
    system : System
        The beam.
    starts : int, optional
        Starts drawn from the box; the first is at rest.
    longest : int, optional
        Periods of each run.
    seed : int, optional
        Of the starts.

    Returns
    -------
    dict
        ``median`` and ``longest`` number of periods until the strobes of those that end on a cycle
        stay within 1 % of its size (at least 0.01), that of the start at ``rest``, and
        ``aperiodic``, how many end on no cycle.

    Examples
    --------
    >>> settling(beam(5.0), starts=4, longest=400)["aperiodic"]
    0
    """
    random = np.random.default_rng(seed)
    drawn = {name: random.uniform(*limits, starts).tolist() for name, limits in CRACK_BOX.items()}
    for values in drawn.values():
        values[0] = 0.0
    runs = ensemble(system, drawn, transient=0, record=longest)
    points = np.stack([runs["u"].values, runs["v"].values], axis=-1)
    times, aperiodic = [], 0
    for orbit in points:
        time = _settled_after(orbit)
        aperiodic += time is None
        times.append(time)
    known = [time for time in times if time is not None]
    return {
        "median": float(np.median(known)) if known else None,
        "longest": max(known, default=None),
        "rest": times[0],
        "aperiodic": aperiodic,
    }


def _settled_after(orbit: np.ndarray) -> int | None:
    """Index from which strobes stay near the cycle of the last ones."""
    period = period_of(orbit[-4 * _LONGEST :])
    if not period:
        return None
    cycle = orbit[-period:]
    # the cycle in step with the strobes, from the end backwards
    steps = np.arange(len(orbit)) - len(orbit)
    off = np.abs(orbit - cycle[steps % period]).max(axis=1)
    far = np.flatnonzero(off > max(_NEAR * float(np.ptp(cycle, axis=0).max()), _NEAR))
    return int(far[-1]) + 1 if far.size else 0


@lru_cache(maxsize=16)
def scan_of_missing_data(crack: float, transient: int = 2000) -> Evidence:
    """Regimes at one crack length over s and d, from rest and from (1, 0).

    Parameters
    ----------
    crack : float
        Length of the crack [mm].
    transient : int, optional
        Periods left out.

    Returns
    -------
    dict
        ``cases``, and ``shares`` of periods, of ``chaotic`` motions and of those that are neither;
        ``labels`` one for each case: a period, 0 for chaos, -1 for neither.

    Examples
    --------
    >>> scan_of_missing_data(5.0, transient=300)["shares"]
    {'1': 1.0}
    """
    grid = grid_of_missing_data()
    system = beam(crack)
    runs = ensemble(system, SCAN_STARTS, parameters=grid, transient=transient, record=2 * _LONGEST)
    points = np.stack([runs["u"].values, runs["v"].values], axis=-1)
    labels = np.array([period_of(orbit) for orbit in points])
    for lane in np.flatnonzero(labels == 0):
        labels[lane] = 0 if _chaotic(system, runs.isel(lane=lane, point=-1)) else -1
    names = {0: "chaotic", -1: "neither"}
    kinds, counts = np.unique(labels, return_counts=True)
    shares = {
        names.get(int(kind), str(kind)): float(count / labels.size)
        for kind, count in zip(kinds, counts, strict=True)
    }
    return {"cases": int(labels.size), "shares": shares, "labels": labels.tolist()}


def _chaotic(system: System, end: xr.Dataset) -> bool:
    there = system.with_parameters(s=float(end["s"]), d=float(end["d"]))
    start = {name: float(end[name]) for name in ("u", "v")}
    return bool(exponent_of_beam(there, start, record=400)["chaotic"])


# At which crack length the strange attractor is born: followed as the crack grows, or from starts.
#
# Followed, the motion is what a monitor would see; from many starts another attractor may be
# chaotic earlier. Both are first crack lengths on a grid.

STEP = 0.02  # mm
_FIRST, _LAST = 5.0, 19.8
_STARTS = {
    "u": [0.0, 1.0, -1.0, 0.3, -0.4, 2.0],
    "v": [0.0, 0.0, 1.0, -2.0, 0.5, 2.0],
}
_TRANSIENT, _RECORD = 400, 128


def crack_grid(first: float = _FIRST, last: float = _LAST, step: float = STEP) -> np.ndarray:
    """Crack lengths of a sweep.

    Parameters
    ----------
    first, last, step : float, optional
        In mm.

    Returns
    -------
    numpy.ndarray

    Examples
    --------
    >>> crack_grid(5.0, 5.1, 0.05).tolist()
    [5.0, 5.05, 5.1]
    """
    return np.round(np.arange(first, last + 0.5 * step, step), 6)


@lru_cache(maxsize=64)
def followed_periods(step: float = STEP, **parameters: float) -> Any:
    """Diagram over the crack length, followed up from rest at 5 mm.

    Parameters
    ----------
    step : float, optional
        Between columns [mm].
    **parameters : float
        Changed parameters of the beam.

    Returns
    -------
    xarray.Dataset
        As from `bifurcation_diagram`, one lane.
    """
    return bifurcation_diagram(
        beam(_FIRST, **parameters), "crack", crack_grid(step=step), start="follow up",
        transient=_TRANSIENT, record=_RECORD,
    ).isel(lane=0)  # fmt: skip


@lru_cache(maxsize=64)
def onset_along_growth(step: float = STEP, **parameters: float) -> Evidence:
    """First crack length at which the followed motion is chaotic.

    Parameters
    ----------
    step : float, optional
        Between columns [mm].
    **parameters : float
        Changed parameters of the beam.

    Returns
    -------
    dict
        ``crack`` (None without chaos up to 19.8 mm), ``exponent`` and ``error`` per period there,
        and ``other_than_one``, the first length at which the period is not one.

    Examples
    --------
    >>> 14.0 < onset_along_growth(0.1)["crack"] < 15.0
    True
    """
    found = followed_periods(step, **parameters)
    cracks, periods = found["parameter"].values, found["period"].values
    row: Evidence = {"crack": None, "exponent": None, "error": None}
    other = np.flatnonzero(periods != 1)
    row["other_than_one"] = float(cracks[other[0]]) if other.size else None
    for column in np.flatnonzero(periods == 0):
        there = beam(float(cracks[column]), **parameters)
        tried = exponent_of_beam(there, found.isel(parameter=column, point=-1), record=600)
        if tried["chaotic"]:
            return row | {
                "crack": float(cracks[column]),
                "exponent": tried["exponent"],
                "error": tried["error"],
            }
    return row


@lru_cache(maxsize=32)
def onset_from_starts(step: float = 0.05, **parameters: float) -> Evidence:
    """First crack length at which any of six starts leads to chaos.

    Parameters
    ----------
    step : float, optional
        Between lengths [mm].
    **parameters : float
        Changed parameters of the beam.

    Returns
    -------
    dict
        ``crack`` (None without chaos), ``exponent`` and ``error`` per period there, ``last``, the
        last length with a chaotic motion, and ``share`` of lengths in between that have one.
    """
    cracks = crack_grid(step=step)
    system = beam(_FIRST, **parameters)
    runs = ensemble(
        system, _STARTS, parameters={"crack": cracks.tolist()}, transient=1000, record=_RECORD
    )
    points = np.stack([runs["u"].values, runs["v"].values], axis=-1)
    found: dict[float, Evidence] = {}
    for lane in range(runs.sizes["lane"]):
        crack = float(runs["crack"][lane])
        if crack in found or period_of(points[lane]):
            continue
        there = beam(crack, **parameters)
        tried = exponent_of_beam(there, runs.isel(lane=lane, point=-1), record=600)
        if tried["chaotic"]:
            found[crack] = tried
    if not found:
        return {"crack": None, "exponent": None, "error": None, "last": None, "share": 0.0}
    first, last = min(found), max(found)
    between = int(np.sum((cracks >= first - 1e-9) & (cracks <= last + 1e-9)))
    return {
        "crack": first, "exponent": found[first]["exponent"], "error": found[first]["error"],
        "last": last, "share": len(found) / between,
    }  # fmt: skip
