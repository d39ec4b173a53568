"""Claims on the frequency of the mole's excitation (section 2.4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np
import xarray as xr

from nonsmooth import bifurcation_diagram
from nonsmooth.chapter.judgement import Check, Evidence, Finding
from nonsmooth.chapter.mole.model_claims import STATIC_FORCES
from nonsmooth.chapter.mole.orbit_branches import best_stable, four_phase_branch
from nonsmooth.chapter.mole.static_force_sweeps import PROTOCOLS
from nonsmooth.chapter.mole.windows import agreed
from nonsmooth.models import moling

__all__ = ["CHECKS", "distinct_attractors"]

_HIGH = (1.4, 1.45, 1.56, 1.58, 1.6, 1.7)  # the frequencies of Fig. 12
_LOW = 0.1
_APART = 1e-4  # between points of two orbits; settled strobes agree to 1e-6 of their size


def _starts(positions: int = 15, velocities: int = 9, g: float = 0.02) -> list[Mapping[str, float]]:
    """Initial states on a grid, with the least q that is admissible."""
    grid = product(np.linspace(-4.0, 1.0, positions), np.linspace(-2.0, 2.0, velocities))
    return [{"p": p, "y": y, "q": max(0.0, p - g)} for p, y in grid]


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
    high: Sequence[float] = _HIGH,
    forces: Sequence[float] = STATIC_FORCES,
    transient: int = 3000,
    low_transient: int = 300,
) -> Evidence:
    starts = _starts()
    cases = [(0.1, 0.1, _LOW, low_transient)]
    cases += [(0.05, b, _LOW, low_transient) for b in forces]
    cases += [(0.1, 0.1, omega, transient) for omega in high]
    rows = []
    for xi, b, omega, dropped in cases:
        diagram = bifurcation_diagram(
            moling(b=b, xi=xi, omega=omega), "b", [b], initial=starts, transient=dropped,
            record=128,
        )  # fmt: skip
        found = distinct_attractors(diagram)
        rows.append({"xi": xi, "b": b, "omega": omega, "attractors": found})
    return {"starts": len(starts), "rows": rows}


def _judge_coexistence(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    several = [row for row in rows if row["omega"] != _LOW]
    at_high = all(len(row["attractors"]) > 1 for row in several)
    low = [row for row in rows if row["omega"] == _LOW]
    same_set = all(len(row["attractors"]) == 1 for row in low if row["xi"] == 0.1)
    whole_set = all(len(row["attractors"]) == 1 for row in low)
    listed = "; ".join(
        f"xi {row['xi']:g}, b {row['b']:g}, omega {row['omega']:g}: "
        + " + ".join(
            f"{'period ' + str(each['period']) if each['period'] else 'aperiodic'}"
            f" ({each['starts']})"
            for each in row["attractors"]
        )
        for row in rows
    )
    text = f"attractors from {evidence['starts']} starts (how many reach each): {listed}"
    if at_high and same_set and not whole_set:
        text += "; several at each of the higher frequencies, but one set of omega 0.1 has two"
    return Finding(agreed([at_high and same_set, at_high and whole_set]), text)


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


CHECKS = (
    Check(
        "M55",
        "a .3; b .1, xi .1 at the frequencies of Fig. 12 and at .1; the six b of Fig. 7 with xi .05"
        " at .1; 135 starts on a grid of p from -4 to 1 and y from -2 to 2, q = max(0, p - g), 3000"
        " periods dropped (300 at .1), 128 kept",
        _coexistence,
        _judge_coexistence,
    ),
    Check(
        "M57",
        "b .15, xi .01 (Fig. 10) and .05, a above b: .3 .5 .7 .9; 41 values of omega from .02 to 2,"
        " even in the logarithm; restart from rest and follow up and down, 300 periods dropped, 100"
        " kept; also branches of Fig. 10(a); low: a tenth of the natural frequency at most",
        _frequencies,
        _judge_frequencies,
    ),
)
