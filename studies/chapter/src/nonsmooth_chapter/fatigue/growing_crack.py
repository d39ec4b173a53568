"""Motions while the crack grows: runs, their history of regimes, and alarms."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import xarray as xr

from nonsmooth import (
    ensemble,
    local_regimes,
    lyapunov_spectrum,
    measured,
    simulate,
    zero_one_test,
)
from nonsmooth.models import breathing_crack
from nonsmooth_chapter.fatigue.crack_motions import (
    D_RANGE,
    ETA,
    GROWTH,
    S_RANGE,
    TAU_END,
    XI,
    beam,
    crack_grid,
    exponent_of_beam,
    period_of,
)
from nonsmooth_chapter.judgement import Evidence

__all__ = [
    "LATE",
    "LATE_STARTS",
    "MANY",
    "NOISE",
    "RATE_OF_ALARMS",
    "SCANNED",
    "STROBES",
    "Growth",
    "alarm_rates",
    "convention_histories",
    "first_loss",
    "growing_run",
    "history",
    "label_share",
    "labelled_stretches",
    "local_exponent",
    "longest_retreat",
    "scanned_histories",
    "scatter",
    "separators",
    "strobe_labels",
    "strobed_motions",
]


# The beam whose crack grows as in Fig. 30: its strobes, and what they do at each time.

Growth = Literal["frozen", "flow"]
LATE_STARTS = ((0.0, 0.0), (1.0, 0.0), (-1.0, 1.0), (0.3, -2.0), (-0.4, 0.5), (2.0, 2.0))
_TURN = 2.0 * np.pi / ETA
_MOST_PERIOD, _WINDOW = 8, 64  # of local labels, in strobes


@lru_cache(maxsize=32)
def growing_run(
    grows: Growth = "frozen",
    start: tuple[float, float] = (0.0, 0.0),
    first: float = 0.0,
    last: float = TAU_END,
    **parameters: float,
) -> xr.Dataset:
    """Strobes of the beam while its crack grows by the law of Fig. 30.

    Parameters
    ----------
    grows : {"frozen", "flow"}, optional
        Whether the length is kept for each period, or grows within the flow.
    start : (float, float), optional
        Deflection and velocity at the beginning.
    first, last : float, optional
        Time at which the run begins, rounded down to a strobe, and ends.
    **parameters : float
        Changed parameters.

    Returns
    -------
    xarray.Dataset
        ``u``, ``v`` and ``crack`` over ``time``, one strobe per period of the forcing.

    Examples
    --------
    >>> run = growing_run(first=900_000.0, last=900_100.0)
    >>> run.sizes["time"], round(float(run["crack"][0]), 2)
    (19, 10.67)
    """
    system = breathing_crack(xi=XI, eta=ETA, growth=GROWTH, grows=grows)
    system = system.with_parameters(**parameters)
    k, end = int(first // _TURN), int(last // _TURN)
    initial = dict(zip("uv", start, strict=True))
    if grows == "frozen":
        run = simulate(
            system, initial, periods=end - k, samples_per_period=1, t_start=k * _TURN, events=False
        )
    else:
        times = _TURN * np.arange(k, end + 1)
        run = simulate(system, initial, times=times, t_start=float(times[0]), events=False)
    return run[["u", "v", "crack"]]


def strobe_labels(run: xr.Dataset) -> xr.Dataset:
    """Local labels of a run with a growing crack.

    Parameters
    ----------
    run : xarray.Dataset
        As from `growing_run`.

    Returns
    -------
    xarray.Dataset
        As from `local_regimes`, periods up to 8 in windows of 64 strobes.
    """
    return local_regimes(
        run, window=_WINDOW, most_period=_MOST_PERIOD, variables=["u", "v"], parameter="crack"
    )


def labelled_stretches(labels: xr.Dataset) -> list[Evidence]:
    """Stretches of one label in the order of time.

    Parameters
    ----------
    labels : xarray.Dataset
        As from `strobe_labels`.

    Returns
    -------
    list of dict
        ``period`` (0: none), ``from_tau``, ``to_tau``, ``from_crack``, ``to_crack`` and number of
        ``strobes``.
    """
    names = {"from_tau": "from_time", "to_tau": "to_time", "from_crack": "from_crack",
             "to_crack": "to_crack"}  # fmt: skip
    rows = []
    for k in range(labels.sizes["stretch"]):
        one = labels.isel(stretch=k)
        row: Evidence = {"period": int(one["stretch_period"])}
        row |= {name: float(one[key]) for name, key in names.items()}
        rows.append(row | {"strobes": int(one["last"] - one["first"]) + 1})
    return rows


def local_exponent(run: xr.Dataset, first: float, last: float, **parameters: float) -> Evidence:
    """Growth of small deviations along a stretch of a run, per period.

    Parameters
    ----------
    run : xarray.Dataset
        As from `growing_run`.
    first, last : float
        Times of its first and last strobe.
    **parameters : float
        Changed parameters of the run.

    Returns
    -------
    dict
        ``exponent`` per period over the stretch, of the beam whose crack grows within the flow,
        its ``error``, and whether it is ``chaotic``: above three errors, and above three over
        the periods of the stretch.
    """
    k = int(np.searchsorted(run["time"].values, first))
    start = {name: float(run[name][k]) for name in ("u", "v")}
    begin = float(run["time"][k])
    periods = max(round((last - begin) / _TURN), 1)
    system = breathing_crack(xi=XI, eta=ETA, growth=GROWTH, grows="flow")
    found = lyapunov_spectrum(
        system.with_parameters(**parameters), start, t_start=begin, transient=0.0,
        record=periods * _TURN, interval=_TURN, exponents=1,
    )  # fmt: skip
    value = _TURN * float(found["lyapunov_exponent"][0])
    error = _TURN * float(found["standard_error"][0])
    chaotic = value > 3.0 * max(error, 1.0 / periods)
    return {"exponent": value, "error": error, "chaotic": bool(chaotic)}


# What the beam does while its crack grows: labels, chaotic stretches, and the way of its point.

LATE = 820_000.0  # begin of further runs: 6.3 mm, where all starts settle to one motion
SCANNED = {
    "s": np.geomspace(*S_RANGE, 5).round(4).tolist(),
    "d": np.linspace(*D_RANGE, 5).round(4).tolist(),
}
_SETTLING = 200  # strobes left out at the beginning of each run
_SHORTEST = 20  # strobes of a stretch with an exponent of its own
MANY = 100  # strobes: a periodic stretch that counts, longer than the window of a label


@lru_cache(maxsize=64)
def history(
    grows: Growth = "frozen",
    start: tuple[float, float] = (0.0, 0.0),
    first: float = 0.0,
    **parameters: float,
) -> Evidence:
    """Stretches of one label of a run, those without a period with their exponents.

    Parameters
    ----------
    grows, start, first, **parameters
        As for `growing_run`.

    Returns
    -------
    dict
        ``grows``, ``start``, ``first`` and ``stretches``, rows as from `labelled_stretches` with
        ``exponent``, ``error`` and ``chaotic`` where there is no period.

    Examples
    --------
    >>> found = history("flow", first=935_000.0)
    >>> [row["period"] for row in found["stretches"]][:1]
    [2]
    """
    run = growing_run(grows, start, first, **parameters).isel(time=slice(_SETTLING, None))
    stretches = labelled_stretches(strobe_labels(run))
    for row in stretches:
        if row["period"]:
            continue
        row |= {"chaotic": False, "exponent": None, "error": None}
        if row["strobes"] >= _SHORTEST:
            row |= local_exponent(run, row["from_tau"], row["to_tau"], **parameters)
    return {"grows": grows, "start": list(start), "first": first, "stretches": stretches}


@lru_cache(maxsize=1)
def convention_histories() -> tuple[Evidence, ...]:
    """Runs with s = 1, d = 0: the whole of Fig. 30 from rest both ways, and others from 6.3 mm.

    Returns
    -------
    tuple of dict
        As from `history`: frozen and within the flow from rest at 5 mm, then frozen from each of
        the other starts at 6.3 mm.
    """
    whole = [history(grows) for grows in ("frozen", "flow")]
    return tuple(whole + [history("frozen", start, LATE) for start in LATE_STARTS[1:]])


@lru_cache(maxsize=1)
def scanned_histories() -> tuple[Evidence, ...]:
    """Runs from rest at 6.3 mm over s and d, with a crack that grows within the flow.

    Returns
    -------
    tuple of dict
        As from `history`, with ``s`` and ``d``, and ``retreat`` as from `longest_retreat`.
    """
    found = []
    for s in SCANNED["s"]:
        for d in SCANNED["d"]:
            row = history("flow", (0.0, 0.0), LATE, s=s, d=d)
            run = growing_run("flow", (0.0, 0.0), LATE, s=s, d=d)
            found.append(row | {"s": s, "d": d, "retreat": longest_retreat(run)})
    return tuple(found)


def first_loss(row: Evidence) -> tuple[float | None, str]:
    """Crack length at which period one first gives way to something else, and to what.

    Stretches without a period that are not chaotic and lead back to period one are jumps from
    one such motion to another, and do not count.

    Parameters
    ----------
    row : dict
        As from `history`.

    Returns
    -------
    length : float or None
        In mm; None where it never does.
    other : str
        "period 2", "chaos", or "no period".

    Examples
    --------
    >>> jump = {"period": 0, "chaotic": False, "from_crack": 7.6}
    >>> first_loss({"stretches": [{"period": 1}, jump, {"period": 1}]})
    (None, '')
    """
    stretches = row["stretches"]
    for k, each in enumerate(stretches):
        if each["period"] == 1:
            continue
        following = next((later["period"] for later in stretches[k:] if later["period"]), 0)
        if not each["period"] and not each["chaotic"] and following == 1:
            continue
        if each["period"]:
            return each["from_crack"], f"period {each['period']}"
        return each["from_crack"], "chaos" if each["chaotic"] else f"period {following}"
    return None, ""


def label_share(row: Evidence, low: float, high: float, label: Any) -> float:
    """Part of a span of time that has a label.

    Parameters
    ----------
    row : dict
        As from `history`.
    low, high : float
        Times.
    label : int or "chaos"
        Period, or chaos.

    Returns
    -------
    float

    Examples
    --------
    >>> stretch = {"period": 2, "from_tau": 0.0, "to_tau": 10.0}
    >>> label_share({"stretches": [stretch]}, 5.0, 15.0, 2)
    0.5
    """
    total = 0.0
    for each in row["stretches"]:
        same = each["period"] == label or (label == "chaos" and each.get("chaotic", False))
        if same:
            total += max(min(each["to_tau"], high) - max(each["from_tau"], low), 0.0)
    return total / (high - low)


def separators(row: Evidence, after: float) -> list[Evidence]:
    """What lies between long periodic stretches behind a crack length.

    Parameters
    ----------
    row : dict
        As from `history`.
    after : float
        Crack length [mm] from which on to look.

    Returns
    -------
    list of dict
        ``before`` and ``behind`` (periods), ``from_crack``, ``to_crack``, and whether chaos lies
        between (``chaotic``).
    """
    stretches = row["stretches"]
    long_ones = [
        k for k, each in enumerate(stretches) if each["period"] and each["strobes"] >= MANY
    ]
    rows = []
    for one, other in pairwise(long_ones):
        first, second = stretches[one], stretches[other]
        if second["from_crack"] < after:
            continue
        rows.append(
            {
                "before": first["period"],
                "behind": second["period"],
                "from_crack": first["to_crack"],
                "to_crack": second["from_crack"],
                "chaotic": any(each.get("chaotic", False) for each in stretches[one + 1 : other]),
            }
        )
    return rows


def longest_retreat(run: xr.Dataset, last: float = 10.7) -> Evidence:
    """How far the strobed point goes back on its way, while the crack is shorter than a length.

    Parameters
    ----------
    run : xarray.Dataset
        As from `growing_run`.
    last : float, optional
        Crack length [mm].

    Returns
    -------
    dict
        For ``u`` and ``v`` the largest fall against the way from the first to the last point,
        beside the range.
    """
    part = run.isel(time=slice(_SETTLING, None))
    part = part.isel(time=part["crack"].values < last)
    found: Evidence = {}
    for name in ("u", "v"):
        values = part[name].values
        values = values if values[-1] >= values[0] else -values
        back = np.maximum.accumulate(values) - values
        found[name] = float(back.max() / np.ptp(values))
    return found


# Telling chaos from strobes with noise: indicators with limits for one rate of false alarms.

NOISE = (0.0, 0.001, 0.01, 0.05)  # standard deviation beside the amplitude of u
STROBES = 300  # of a record
RATE_OF_ALARMS = 0.05  # of healthy records, for which every limit is set
_LONGEST = 8
_DRAWS = 20  # of the noise: how many of some 95 records exceed a limit is left to chance


def scatter(strobes: np.ndarray, longest: int = _LONGEST) -> float:
    """What no period explains in strobes: least root mean square about the points of a cycle.

    Parameters
    ----------
    strobes : numpy.ndarray
        One value per period of the forcing.
    longest : int, optional
        Longest period that is tried.

    Returns
    -------
    float

    Examples
    --------
    >>> scatter(np.tile([1.0, 0.0, 2.0], 20))
    0.0
    """
    least = np.inf
    for n in range(1, longest + 1):
        whole = strobes[: len(strobes) // n * n].reshape(-1, n)
        left = whole - whole.mean(axis=0)
        # each mean takes one degree of freedom
        least = min(least, float(np.sqrt(np.sum(left**2) / max(left.size - n, 1))))
    return least


@lru_cache(maxsize=2)
def strobed_motions(
    step: float = 0.05, fine: float = 0.01, transient: int = 1000
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Strobes of settled motions from rest over the crack length, and what they are.

    Parameters
    ----------
    step : float, optional
        Between lengths [mm].
    fine : float, optional
        The same from 14.2 to 15, where chaos begins.
    transient : int, optional
        Periods left out.

    Returns
    -------
    cracks, strobes, amplitudes, labels : numpy.ndarray
        Lengths; deflections at strobes; half of the range of u at 16 phases; period, 0 for chaos,
        -1 for neither.
    """
    cracks = np.unique(np.append(crack_grid(step=step), crack_grid(14.2, 15.0, fine)))
    system, values = beam(5.0), {"crack": cracks.tolist()}
    runs = ensemble(system, parameters=values, transient=transient, record=STROBES)
    points = np.stack([runs["u"].values, runs["v"].values], axis=-1)
    labels = np.array([period_of(orbit) for orbit in points])
    for lane in np.flatnonzero(labels == 0):
        there = beam(float(cracks[lane]))
        known = exponent_of_beam(there, runs.isel(lane=lane, point=-1), record=600)
        labels[lane] = 0 if known["chaotic"] else -1
    return cracks, points[:, :, 0], _amplitudes(runs, cracks), labels


def _amplitudes(runs: xr.Dataset, cracks: np.ndarray) -> np.ndarray:
    """Half of the range of u over 8 periods behind the strobes."""
    last = runs.isel(point=-1)
    turn = float(beam(5.0).period_value or 0.0)
    behind = ensemble(
        beam(5.0), {name: last[name].values.tolist() for name in ("u", "v")},
        parameters={"crack": cracks.tolist()}, combine="pairs",
        times=np.linspace(0.0, 8.0 * turn, 129),
    )  # fmt: skip
    found: np.ndarray = np.ptp(behind["u"].values, axis=1) / 2.0
    return found


@lru_cache(maxsize=2)
def alarm_rates(seed: int = 0) -> tuple[Evidence, ...]:
    """How often alarms at one stated rate are false, and how much chaos they miss.

    Parameters
    ----------
    seed : int, optional
        Of the noise.

    Returns
    -------
    tuple of dict
        For each level ``noise``; the numbers of ``healthy`` and ``chaotic`` records that are
        judged; for each of the indicators ``amplitude``, ``scatter`` and ``zero_one`` the shares of
        ``false`` alarms among the former and ``missed`` ones among the latter, and the interval
        that was stated for the rate of false ones, ``low`` to ``high``.

    Notes
    -----
    Healthy are all lengths before the first chaotic one. Every other one sets the limits, by
    `nonsmooth.measured.alarm`; the rest is judged. The amplitude is what a monitor without any
    theory of chaos would watch. Strobes of a motion of period one hold nothing but noise, so their
    scatter cannot tell that a crack grows until the period is lost. Numbers are means over 20 draws
    of the noise, each with limits of its own; of the 0-1 test, which takes long, they are of one.
    """
    cracks, strobes, amplitudes, labels = strobed_motions()
    judged = (cracks < cracks[labels == 0].min()) | (labels == 0)
    chaotic = labels[judged] == 0
    strobes, amplitudes = strobes[judged], amplitudes[judged]
    random = np.random.default_rng(seed)
    rows = []
    for level in NOISE:
        found: dict[str, list[Evidence]] = {"amplitude": [], "scatter": [], "zero_one": []}
        for draw in range(_DRAWS):
            noise = level * amplitudes * random.standard_normal((STROBES + 1, amplitudes.size))
            seen, felt = strobes + noise[:-1].T, amplitudes + noise[-1]
            about = np.array([scatter(row) for row in seen]) / amplitudes
            found["amplitude"].append(_errors(felt, chaotic))
            found["scatter"].append(_errors(about, chaotic))
            if draw == 0:
                known = np.array([float(zero_one_test(row)["K"]) for row in seen])
                found["zero_one"].append(_errors(known, chaotic))
        row: Evidence = {"noise": level, "chaotic": int(chaotic.sum())}
        row["healthy"] = int((~chaotic).sum()) // 2
        for name, errors in found.items():
            row[name] = {key: float(np.mean([one[key] for one in errors])) for key in errors[0]}
        rows.append(row)
    return tuple(rows)


def _errors(values: np.ndarray, chaotic: np.ndarray) -> Evidence:
    """False and missed alarms by one indicator; each length is a record of one window."""
    healthy = values[~chaotic]
    known = [_window(healthy[[k]]) for k in range(0, healthy.size, 2)]
    unseen, late = healthy[1::2], values[chaotic]
    found = measured.alarm(known, _window(np.append(unseen, late)), rate=RATE_OF_ALARMS)
    alarmed = found["alarmed"].values
    return {
        "false": float(alarmed[: unseen.size].mean()),
        "missed": float(1.0 - alarmed[unseen.size :].mean()),
        "low": float(found["rate_low"]),
        "high": float(found["rate_high"]),
    }


def _window(values: np.ndarray) -> xr.Dataset:
    return xr.Dataset({"indicator": ("window", values)})
