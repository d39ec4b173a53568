"""Claims on branches of orbits of the mole, and on its best force and frequency."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise, product

import numpy as np
import xarray as xr

from nonsmooth import System, bifurcation_diagram, continue_orbit, regime, simulate
from nonsmooth.models import moling
from nonsmooth_chapter.judgement import Evidence, Finding, agreed
from nonsmooth_chapter.mole.model_claims import STATIC_FORCES
from nonsmooth_chapter.mole.orbits import (
    best_stable,
    first_sheet,
    four_phase_branch,
    observed,
)
from nonsmooth_chapter.mole.sweeps import PROTOCOLS, even_forces

__all__ = ["distinct_attractors"]


# Claims on Fig. 10: progression along branches of period-one orbits.
#
# The chapter prints neither the amplitudes nor the static forces of the curves, so each claim is
# judged for every one of those stated here.

_BY_B = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
_CLOSE = 0.1  # of b: how near the end of the branch "close" is
# A curve has one value for each parameter: it is the sheet between folds on which the branch began.
_READINGS: dict[str, Callable[[xr.Dataset], np.ndarray]] = {
    "stable": observed,
    "every motion": lambda branch: np.asarray(branch["admissible"].values, bool),
}


def _slopes(
    parameter: str, between: tuple[float, float], curve: str, values: Sequence[float]
) -> Evidence:
    """Part of the range of a parameter on which progression rises along each branch."""
    rows = []
    for value in values:
        branch = first_sheet(four_phase_branch(parameter, between, **{curve: value}))
        x, y = branch[parameter].values, branch["v_per_period"].values
        for reading, chosen in _READINGS.items():
            inside = chosen(branch)
            both = inside[1:] & inside[:-1] & (np.diff(x) != 0.0)
            lengths = np.abs(np.diff(x)[both])
            slopes = np.diff(y)[both] / np.diff(x)[both]
            rows.append(
                {
                    "value": value,
                    "reading": reading,
                    "steps": int(both.sum()),
                    "rising": float(lengths[slopes > 0.0].sum() / lengths.sum())
                    if slopes.size
                    else None,
                    "slopes": [float(slopes.min()), float(slopes.max())] if slopes.size else None,
                    "from": float(x[inside].min()) if inside.any() else None,
                    "to": float(x[inside].max()) if inside.any() else None,
                }
            )
    return {"over": parameter, "curve": curve, "rows": rows}


def _judge_slopes(evidence: Evidence, rising: bool) -> Finding:
    rows = [row for row in evidence["rows"] if row["steps"]]
    true = [row["rising"] == float(rising) for row in rows]
    over, curve = evidence["over"], evidence["curve"]
    values = sorted({row["value"] for row in rows})
    listed = "; ".join(
        f"{curve} {row['value']:g} {row['reading']} {over} {row['from']:.4g} to"
        f" {row['to']:.4g}: {row['slopes'][0]:.3g} to {row['slopes'][1]:.3g} per unit of"
        f" {over}, rising on {row['rising']:.1%} of it"
        for row in rows
    )
    found = agreed(true)
    return Finding(found, listed, for_all=_each(found, curve, values))


def _each(found: bool | None, name: str, values: Sequence[float]) -> str:
    """Range of the missing data for which a finding was shown, value by value."""
    if found is None:
        return ""
    return f"{name} = {', '.join(f'{value:g}' for value in values)}, each with its own branch"


def _order(
    parameter: str, between: tuple[float, float], curve: str, values: Sequence[float]
) -> Evidence:
    """Least gain from one curve to the next at the same parameter, where both are there."""
    grid = np.linspace(*between, 400)
    rows = []
    for reading, chosen in _READINGS.items():
        heights = {v: _upper(parameter, between, curve, v, grid, chosen) for v in values}
        for low, high in pairwise(values):
            gain = heights[high] - heights[low]
            common = np.isfinite(gain)
            rows.append(
                {
                    "reading": reading,
                    "low": low,
                    "high": high,
                    "common": int(common.sum()),
                    "least_gain": float(gain[common].min()) if common.any() else None,
                    "range": [float(grid[common].min()), float(grid[common].max())]
                    if common.any()
                    else None,
                }
            )
    return {"over": parameter, "curve": curve, "values": list(values), "rows": rows}


def _upper(
    parameter: str, between: tuple[float, float], curve: str, value: float, grid: np.ndarray,
    chosen: Callable[[xr.Dataset], np.ndarray],
) -> np.ndarray:  # fmt: skip
    """Progression of the chosen orbits of a sheet at each value of a grid, nan without one."""
    branch = first_sheet(four_phase_branch(parameter, between, **{curve: value}))
    x, y, inside = branch[parameter].values, branch["v_per_period"].values, chosen(branch)
    best = np.full(grid.size, np.nan)
    for k in np.flatnonzero(inside[1:] & inside[:-1]):
        (low, first), (high, second) = sorted([(x[k], y[k]), (x[k + 1], y[k + 1])])
        here = (grid >= low) & (grid <= high)
        if high > low and here.any():
            best[here] = np.fmax(best[here], np.interp(grid[here], [low, high], [first, second]))
    return best


def _judge_order(evidence: Evidence) -> Finding:
    rows = [row for row in evidence["rows"] if row["common"]]
    true = [row["least_gain"] > 0.0 for row in rows]
    curve = evidence["curve"]
    listed = "; ".join(
        f"{curve} {row['high']:g} above {row['low']:g} ({row['reading']},"
        f" {evidence['over']} {row['range'][0]:.3g} to {row['range'][1]:.3g}) by"
        f" {row['least_gain']:.3g} at least"
        for row in rows
    )
    found = agreed(true)
    return Finding(found, listed, for_all=_each(found, curve, evidence["values"]))


def _maxima(amplitudes: Sequence[float] = _BY_B) -> Evidence:
    """Maximum of progression over b inside the stable part of each branch, and where that ends."""
    rows = []
    for a in amplitudes:
        branch = four_phase_branch("b", (0.02, a), a=a)
        b, gain, solid = branch["b"].values, branch["v_per_period"].values, observed(branch)
        k = best_stable(branch)
        inner = (gain[1:-1] > gain[:-2]) & (gain[1:-1] > gain[2:]) & solid[1:-1]
        end = k
        while end + 1 < b.size and solid[end + 1]:
            end += 1
        while end - 1 >= 0 and solid[end - 1] and b[end - 1] > b[end]:
            end -= 1
        near = branch["special_kind"].values[np.abs(branch["special_point"].values - end) <= 1]
        rows.append(
            {
                "a": a,
                "at": float(b[k]),
                "per_period": float(gain[k]),
                "inner_maxima": [float(each) for each in b[1:-1][inner]],
                "end": float(b[end]),
                "ends_in": str(near[0]) if near.size else "guard",
                "at_end": float(gain[end]),
            }
        )
    return {"rows": rows}


def _judge_maxima(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    true = [bool(row["inner_maxima"]) for row in rows]
    listed = "; ".join(
        f"a {row['a']:g}: {row['per_period']:.4g} at b = {row['at']:.4f}" + _inner(row)
        for row in rows
    )
    found = agreed(true)
    return Finding(found, f"largest along the stable part, b up to a: {listed}",
                   for_all=_each(found, "a", [row["a"] for row in rows]))  # fmt: skip


def _inner(row: Evidence) -> str:
    if not row["inner_maxima"]:
        return " (at the end, no maximum inside)"
    if min(abs(each - row["at"]) for each in row["inner_maxima"]) > 1e-9:
        return f" (at the end; a maximum inside at {row['inner_maxima'][0]:.4f})"
    return ""


def _judge_breakdown(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    true = [
        row["ends_in"] != "bound" and abs(row["end"] - row["at"]) <= _CLOSE * row["end"]
        for row in rows
    ]
    listed = "; ".join(
        f"a {row['a']:g}: best at b = {row['at']:.4f}, "
        + (
            "stable up to b = a"
            if row["ends_in"] == "bound"
            else f"ends at {row['end']:.4f} ({row['ends_in']}), {1.0 - row['at'] / row['end']:.1%}"
            " further"
        )
        for row in rows
    )
    found = agreed(true)
    return Finding(found, f"{listed}; close: within {_CLOSE:.0%} of b",
                   for_all=_each(found, "a", [row["a"] for row in rows]))  # fmt: skip


def _dashed(amplitudes: Sequence[float] = _BY_B, per_part: int = 4) -> Evidence:
    """Regimes from rest and from the construction, at some places of the dashed parts.

    A curve of the figure has one value for each b, so the sheets behind folds are left out.
    """
    rows = []
    for a in amplitudes:
        branch = first_sheet(four_phase_branch("b", (0.02, a), a=a))
        b, solid = branch["b"].values, observed(branch)
        top = float(b[solid].max())
        for part, inside in {
            "below the stable part": ~solid & (b < b[solid].min()),
            "beside it": ~solid & (b >= b[solid].min()) & (b <= top),
            "above it": ~solid & (b > top),
        }.items():
            places = np.flatnonzero(inside)
            if not places.size:
                continue
            chosen = places[np.linspace(0, places.size - 1, per_part + 2).astype(int)[1:-1]]
            periods = [_periods_at(branch.isel(point=int(k)), a) for k in np.unique(chosen)]
            rows.append(
                {
                    "a": a,
                    "part": part,
                    "places": len(periods),
                    "admissible": int(branch["admissible"].values[np.unique(chosen)].sum()),
                    "periodic_from_rest": sum(bool(rest) for rest, _ in periods),
                    "periodic_from_orbit": sum(bool(orbit) for _, orbit in periods),
                }
            )
    return {"rows": rows}


def _periods_at(orbit: xr.Dataset, a: float) -> tuple[int, int]:
    system = moling(a=a, b=float(orbit["b"]), xi=0.01)
    start = {name: float(orbit["leg_states"][0].sel(state=name)) for name in "py"}
    start["q"] = max(0.0, start["p"] - system.parameter_values["g"])
    return int(regime(system)["period"]), int(regime(system, start)["period"])


def _judge_dashed(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    readings = {
        "from rest": [row["periodic_from_rest"] == 0 for row in rows],
        "from the construction": [row["periodic_from_orbit"] == 0 for row in rows],
    }
    listed = "; ".join(
        f"a {row['a']:g} {row['part']}: {row['places'] - row['periodic_from_rest']} of"
        f" {row['places']} not periodic from rest"
        f" ({row['places'] - row['periodic_from_orbit']} from the construction;"
        f" {row['admissible']} constructions are motions)"
        for row in rows
    )
    by_amplitude = [
        all(each for each, row in zip(true, rows, strict=True) if row["a"] == a)
        for true in readings.values()
        for a in dict.fromkeys(row["a"] for row in rows)
    ]
    found = agreed(by_amplitude)
    return Finding(found, listed,
                   for_all=_each(found, "a", sorted({row["a"] for row in rows})))  # fmt: skip


# Claims on the frequency of the mole's excitation (section 2.4).

_HIGH = (1.4, 1.45, 1.56, 1.58, 1.6, 1.7)  # the frequencies of Fig. 12
_OMEGAS = (0.1, 0.15, 0.2, 0.3, 0.45, 0.65, 0.85, 1.0, 1.1, 1.2, 1.3, *_HIGH)
_LOW, _DAMPED = 0.1, 0.1  # omega and xi that are compared with Fig. 12
_LOOKED_AT, _WIDER = 100, 1.5  # periods from rest, of which the second half tells of flights
_APART = 1e-4  # between points of two orbits; settled strobes agree to 1e-6 of their size


def _starts(system: System, positions: int = 15, velocities: int = 9) -> list[dict[str, float]]:
    """Initial states on a grid half as wide again as the flights of the motion from rest.

    Each has the least q that is admissible.
    """
    run = simulate(system, periods=_LOOKED_AT)
    late = slice(run.sizes["time"] // 2, None)
    deepest, fastest = (float(np.abs(run[name].values[late]).max()) for name in "py")
    grid = product(
        np.linspace(-_WIDER * deepest, 1.0, positions),
        np.linspace(-_WIDER * fastest, _WIDER * fastest, velocities),
    )
    gap = system.parameter_values["g"]
    return [{"p": p, "y": y, "q": max(0.0, p - gap)} for p, y in grid]


def distinct_attractors(diagram: xr.Dataset) -> list[Evidence]:
    """Attractors that the lanes of a diagram of one column lead to.

    Periodic motions are one where their points are the same sets; those without a period count as
    one together, so there may be more.

    Parameters
    ----------
    diagram : xarray.Dataset
        Result of `bifurcation_diagram` for one value and several initial states of the mole.

    Returns
    -------
    list of dict
        ``period`` (0: none found) and number of ``starts`` of each, the most frequent first.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> starts = [{"p": -1.0}, {"p": -2.0}]
    >>> distinct_attractors(ns.bifurcation_diagram(ns.models.moling(), "b", [0.15], initial=starts))
    [{'period': 1, 'starts': 2}]
    """
    periods = diagram["period"].values[0]
    points = np.stack([diagram[name].values[0] for name in "pyq"], axis=-1)
    found: list[tuple[int, np.ndarray, int]] = []
    for period, lane in zip(periods.astype(int).tolist(), points, strict=True):
        orbit = lane[: max(period, 1)]
        for i, (known, other, count) in enumerate(found):
            if known == period and (period == 0 or _same_set(orbit, other)):
                found[i] = (known, other, count + 1)
                break
        else:
            found.append((period, orbit, 1))
    found.sort(key=lambda each: -each[2])
    return [{"period": period, "starts": count} for period, _, count in found]


def _same_set(first: np.ndarray, second: np.ndarray) -> bool:
    distances = np.abs(first[:, None] - second).max(axis=2)
    return bool(distances.min(axis=1).max() < _APART)


def _coexistence(
    omegas: Sequence[float] = _OMEGAS,
    forces: Sequence[float] = STATIC_FORCES,
    transient: int = 3000,
    low_transient: int = 600,
) -> Evidence:
    """Attractors over the frequency for the set of Fig. 12, and for those of Fig. 7 beside it."""
    cases = [(0.1, 0.1, omega) for omega in omegas] + [(0.05, b, _LOW) for b in forces]
    rows = []
    for xi, b, omega in cases:
        system = moling(b=b, xi=xi, omega=omega)
        starts = _starts(system)
        diagram = bifurcation_diagram(
            system, "b", [b], initial=starts, record=128,
            transient=transient if omega > 0.5 else low_transient,
        )  # fmt: skip
        found = distinct_attractors(diagram)
        rows.append(
            {"xi": xi, "b": b, "omega": omega, "starts": len(starts),
             "deepest": starts[0]["p"], "attractors": found}
        )  # fmt: skip
    return {"rows": rows}


def _judge_coexistence(evidence: Evidence) -> Finding:
    """The set of Fig. 12 with another frequency decides: like is compared with like."""
    same = [row for row in evidence["rows"] if row["xi"] == _DAMPED]
    several = [len(row["attractors"]) > 1 for row in same]
    high = [each for each, row in zip(several, same, strict=True) if row["omega"] in _HIGH]
    low = [each for each, row in zip(several, same, strict=True) if row["omega"] == _LOW]
    text = (
        "attractors over omega, xi .1, b .1: "
        + "; ".join(f"{row['omega']:g}: {_listed(row)}" for row in same)
        + "; beside it at omega .1 with xi .05: "
        + "; ".join(
            f"b {row['b']:g}: {_listed(row)}" for row in evidence["rows"] if row["xi"] != _DAMPED
        )
        + f" (in brackets how many of {same[0]['starts']} starts reach each)"
    )
    return Finding(all(high) and not any(low), text)


def _listed(row: Evidence) -> str:
    return " + ".join(
        f"{'period ' + str(each['period']) if each['period'] else 'aperiodic'} ({each['starts']})"
        for each in row["attractors"]
    )


def _frequencies(
    amplitudes: Sequence[float] = (0.3, 0.5, 0.7, 0.9),
    columns: int = 41,
    protocols: Sequence[str] = PROTOCOLS,
    b: float = 0.15,
    damping: Sequence[float] = (0.01, 0.05),
) -> Evidence:
    omegas = np.geomspace(0.02, 2.0, columns)
    rows = []
    for xi, a, start in product(damping, amplitudes, protocols):
        diagram = bifurcation_diagram(
            moling(a=a, b=b, xi=xi), "omega", omegas, start=start, transient=300, record=100
        )
        by_period, by_time = (diagram[name].values[:, 0] for name in ("v_per_period", "v_per_time"))
        best, quickest = int(by_period.argmax()), int(by_time.argmax())
        rows.append(
            {
                "xi": xi,
                "a": a,
                "start": start,
                "omega_per_period": float(omegas[best]),
                "per_period": float(by_period[best]),
                "omega_per_time": float(omegas[quickest]),
                "per_time": float(by_time[quickest]),
                "at_natural": float(by_time[int(np.abs(omegas - 1.0).argmin())]),
                "falls_throughout": bool(np.all(np.diff(by_period) <= 0.0)),
            }
        )
    branches = [_best_on_branch(a, b) for a in amplitudes]
    return {
        "b": b,
        "range": [float(omegas[0]), float(omegas[-1])],
        "rows": rows,
        "branches": [each for each in branches if each],
    }


def _best_on_branch(a: float, b: float) -> Evidence:
    """Best stable period-one orbit of four phases over the frequency, by both measures."""
    branch = four_phase_branch("omega", (0.03, 0.5), a=a, b=b)
    by_period, by_time = (best_stable(branch, name) for name in ("v_per_period", "v_per_time"))
    if by_period < 0:
        return {}
    return {
        "a": a,
        "omega_per_period": float(branch["omega"][by_period]),
        "omega_per_time": float(branch["omega"][by_time]),
    }


def _judge_frequencies(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    largest = max(max(row["omega_per_period"], row["omega_per_time"]) for row in rows)
    orbits = evidence["branches"]
    true = [max(row["omega_per_period"], row["omega_per_time"]) <= 0.1 for row in [*rows, *orbits]]
    told = ", ".join(
        f"a {row['a']:g} {row['omega_per_period']:.3g} and {row['omega_per_time']:.3g}"
        for row in orbits
    )
    listed = "; ".join(
        f"xi {row['xi']:g}, a {row['a']:g} {row['per_period']:.4g} per period at omega"
        f" {row['omega_per_period']:.3g}, {row['per_time']:.3g} per unit time at"
        f" {row['omega_per_time']:.3g} ({row['at_natural']:.2g} near 1)"
        for row in rows
        if row["start"] == "restart"
    )
    text = (
        f"best over omega from {evidence['range'][0]:g} to {evidence['range'][1]:g}, restart:"
        f" {listed}; by any protocol and measure at omega = {largest:.3g} at most; monotone per"
        f" period in {sum(row['falls_throughout'] for row in rows)} of {len(rows)}; the best stable"
        f" orbits of four phases at xi .01, by period and by time, at omega = {told or 'none'}"
    )
    return Finding(all(true), text)


# Claim on the ratio of dynamic to static force at the best progression (section 2.4).

_RATIO, _ALLOWED = 2.0, 0.1  # "about", for a ratio of forces: within a tenth of it
_AMPLITUDES = (0.1, 0.2, 0.3, 0.5, 0.7, 0.9)
_LOWEST, _STEPS = 0.1, 150


def _ratios(
    amplitudes: Sequence[float] = _AMPLITUDES,
    damping: Sequence[float] = (0.01, 0.05, 0.1),
    columns: int = 60,
) -> Evidence:
    """Best stable orbit for each amplitude: on the branch of period one, and of any period."""
    rows = []
    for xi, a in product(damping, amplitudes):
        diagram = bifurcation_diagram(
            moling(a=a, xi=xi), "b", even_forces(min(a, 0.95), columns), transient=300, record=100
        )
        periods, gains = (diagram[name].values[:, 0] for name in ("period", "v_per_period"))
        swept = np.where(periods > 0, gains, -np.inf)
        k = int(swept.argmax())
        begin = float(diagram["parameter"][int(np.where(periods == 1, gains, -np.inf).argmax())])
        branch = _branch(a, begin, xi)
        solid = observed(branch)
        gain = np.where(solid, branch["v_per_period"].values, -np.inf)
        best = int(gain.argmax())
        rows.append(
            {
                "xi": xi,
                "a": a,
                "b": float(branch["b"][best]),
                "per_period": float(gain[best]),
                "ratio": a / float(branch["b"][best]),
                "swept_b": float(diagram["parameter"][k]),
                "swept": float(swept[k]),
                "swept_ratio": a / float(diagram["parameter"][k]),
                "swept_period": int(periods[k]),
            }
        )
    return {"rows": rows}


def _branch(a: float, b: float, xi: float) -> xr.Dataset:
    """Period-one orbits over the static force, through changes of their word."""
    between = (min(_LOWEST * a, b), max(min(a, 0.95), b))
    return continue_orbit(moling(a=a, b=b, xi=xi), "b", between, steps=_STEPS, transient=300)


def _about(ratio: float) -> bool:
    return abs(ratio - _RATIO) <= _ALLOWED * _RATIO


def _judge_ratios(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    text, true = [], []
    for key, gain, name in (
        ("ratio", "per_period", "on the branch of period one"),
        ("swept_ratio", "swept", "periodic from rest"),
    ):
        near = [_about(row[key]) for row in rows]
        best = max(rows, key=lambda row: row[gain])
        true.append(all(near) and _about(best[key]))
        listed = ", ".join(f"xi {row['xi']:g} a {row['a']:g} {row[key]:.2f}" for row in rows)
        text.append(
            f"{name}: {listed}; within a tenth of {_RATIO:g} in {sum(near)} of {len(rows)}; over"
            f" the plane {best[key]:.2f} at a = {best['a']:g}, xi = {best['xi']:g}"
        )
    return Finding(agreed(true), "a/b at the best progression, " + "; ".join(text))
