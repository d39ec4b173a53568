"""Claims on the frequency of the mole's excitation (section 2.4)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import xarray as xr

from nonsmooth import System, bifurcation_diagram, simulate
from nonsmooth.models import moling
from nonsmooth_chapter.judgement import Check, Evidence, Finding
from nonsmooth_chapter.mole.model_claims import STATIC_FORCES
from nonsmooth_chapter.mole.orbit_branches import best_stable, four_phase_branch
from nonsmooth_chapter.mole.static_force_sweeps import PROTOCOLS

__all__ = ["CHECKS", "distinct_attractors"]

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


CHECKS = (
    Check(
        "M55",
        "a .3, b .1, xi .1 at the frequencies of Fig. 12 and at eleven lower ones from .1 on; the"
        " six b of Fig. 7 with xi .05 at .1 beside it; 135 starts on a grid half as wide again as"
        " the flights of the motion from rest, q = max(0, p - g), 3000 periods dropped (600 below"
        " omega .5), 128 kept; true with one attractor at .1 and several at each of Fig. 12",
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
