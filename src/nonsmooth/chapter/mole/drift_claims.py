"""Claims on the split into bounded motion and drift (section 2.3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from nonsmooth import System, simulate
from nonsmooth.chapter.judgement import Check, Evidence, Finding
from nonsmooth.chapter.mole.model_claims import STATIC_FORCES
from nonsmooth.models import drift_reconstruction, moling

__all__ = ["CHECKS"]

_UNIT = float(np.finfo(float).eps)
_PARTS, _NODES = 8, 20  # of a progression: a part is at most 14 relaxation times of the slider


def _two_drifts(
    forces: Sequence[float] = STATIC_FORCES, offset: float = 1234.5, periods: int = 100
) -> Evidence:
    differences, switches = [], []
    for b in forces:
        first = simulate(moling(b=b), periods=periods)
        second = simulate(moling(b=b), {"v": offset}, periods=periods)
        differences.append(
            max(float(np.abs(first[name] - second[name]).max()) for name in ("p", "y", "q"))
        )
        same = first.sizes["event"] == second.sizes["event"] and np.array_equal(
            first["event_time"], second["event_time"]
        )
        switches.append(bool(same))
    return {"offset": offset, "differences": differences, "same_switches": switches}


def _judge_two_drifts(evidence: Evidence) -> Finding:
    largest = max(evidence["differences"])
    text = (
        f"p, y and q of runs with v0 = 0 and v0 = {evidence['offset']:g} differ by {largest:g},"
        f" their switching times are the same in {sum(evidence['same_switches'])} of"
        f" {len(evidence['same_switches'])} sets"
    )
    return Finding(largest == 0.0 and all(evidence["same_switches"]), text)


def _separation(b: float = 0.15, periods: int = 1000) -> Evidence:
    run = simulate(moling(b=b), periods=periods)
    p, v = run["p"].values, run["v"].values
    half = len(p) // 2
    return {
        "b": b,
        "periods": periods,
        "bounds_first_half": [float(p[:half].min()), float(p[:half].max())],
        "bounds_second_half": [float(p[half:].min()), float(p[half:].max())],
        "largest_fall_of_v": float(np.max(-np.diff(v))),
        "v_end": float(v[-1]),
        "sum_error": float(np.abs(run["x"].values - p - v).max() / v[-1]),
    }


def _judge_separation(evidence: Evidence) -> Finding:
    low, high = evidence["bounds_second_half"]
    first_low, first_high = evidence["bounds_first_half"]
    slack = 1e-9 * (high - low)  # a run may near its motion from inside
    bounded = first_low - slack <= low and high <= first_high + slack
    rising = evidence["largest_fall_of_v"] <= 4.0 * _UNIT * evidence["v_end"]
    text = (
        f"at b = {evidence['b']:g} p stays between {low:.2f} and {high:.2f} while v rises to"
        f" {evidence['v_end']:.0f} in {evidence['periods']} periods; largest fall of v"
        f" {max(0.0, evidence['largest_fall_of_v']):.1g}"
    )
    return Finding(bool(bounded and rising and evidence["sum_error"] <= 2.0 * _UNIT), text)


def _idle_drift(forces: Sequence[float] = STATIC_FORCES, periods: int = 100) -> Evidence:
    changes, scale, stretches = [], 0.0, 0
    for b in forces:
        run = simulate(moling(b=b), periods=periods)
        column = list(run["state"].values).index("v")
        idle = run["event_to"].values[:-1] != 2
        change = run["state_before"].values[1:, column] - run["state_after"].values[:-1, column]
        changes.append(float(np.abs(change[idle]).max()))
        scale = max(scale, float(run["v"][-1]))
        stretches += int(idle.sum())
    return {
        "static_forces": list(forces),
        "largest_changes": changes,
        "largest_v": scale,
        "stretches": stretches,
    }


def _judge_idle(evidence: Evidence) -> Finding:
    largest = max(evidence["largest_changes"])
    text = (
        f"v changes by {largest:g} at most in {evidence['stretches']} stretches without progression"
    )
    return Finding(largest == 0.0, text)


def _printed_drift(forces: Sequence[float] = STATIC_FORCES, periods: int = 20) -> Evidence:
    """Eq. (29) as printed and corrected, against the integral of v' by quadrature."""
    rows = []
    for b in forces:
        system = moling(b=b)
        run = simulate(system, periods=periods)
        starts = np.flatnonzero(run["event_to"].values[:-1] == 2)
        for k in starts[[0, len(starts) // 2]]:
            began, ended = run["event_time"].values[[k, k + 1]]
            rows.append({"b": b, "began": float(began), **_one_progression(system, began, ended)})
    return {"rows": rows}


def _one_progression(system: System, began: float, ended: float) -> Evidence:
    times, weights = _quadrature(began, ended)
    run = simulate(system, times=times)
    integral = _integral_of_rate(run, weights)
    errors = []
    for as_printed in (True, False):
        gain = drift_reconstruction(run, as_printed=as_printed) - run["v"].values[0]
        errors.append(float(np.abs(gain.values[:: _NODES + 1] - integral).max()))
    return {
        "gain": float(integral[-1]),
        "printed_error": errors[0],
        "corrected_error": errors[1],
    }


def _quadrature(began: float, ended: float) -> tuple[np.ndarray, np.ndarray]:
    """Times of Gauss nodes in parts that grow with time, with the ends of the parts among them."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    edges = began + (ended - began) * (np.arange(_PARTS + 1) / _PARTS) ** 2
    half = 0.5 * np.diff(edges)[:, None]
    inner = edges[:-1, None] + half * (1.0 + nodes)
    times = np.column_stack([edges[:-1], inner]).ravel()
    return np.append(times, edges[-1]), half * weights


def _integral_of_rate(run: xr.Dataset, weights: np.ndarray) -> np.ndarray:
    """Integral of v' = y + (q - 1)/(2 xi), the corrected fourth line of (27), at the part ends."""
    xi = moling().parameter_values["xi"]
    rate = run["y"].values + (run["q"].values - 1.0) / (2.0 * xi)
    inner = rate[:-1].reshape(_PARTS, _NODES + 1)[:, 1:]
    return np.concatenate([[0.0], np.cumsum((inner * weights).sum(axis=1))])


def _judge_printed(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    agree = [row["printed_error"] <= 1e-10 * max(1.0, row["gain"]) for row in rows]
    worst = max(rows, key=lambda row: row["printed_error"])
    text = (
        f"as printed it departs from the integral of v' by up to {worst['printed_error']:.3g}"
        f" within a progression that gains {worst['gain']:.3g} (b = {worst['b']:g}), and agrees in"
        f" {sum(agree)} of {len(rows)}; with a minus before the exponential term by"
        f" {max(row['corrected_error'] for row in rows):.1e} at most"
    )
    return Finding(all(agree), text)


CHECKS = (
    Check("M42", "six b, from rest, 100 periods, nothing dropped", _two_drifts, _judge_two_drifts),
    Check(
        "M43", "set of Fig. 7d, from rest, 1000 periods in halves", _separation, _judge_separation
    ),
    Check("M44", "six b, from rest, 100 periods, nothing dropped", _idle_drift, _judge_idle),
    Check(
        "M45",
        "six b, from rest; first and a middle progression of 20 periods, Gauss quadrature of v'",
        _printed_drift,
        _judge_printed,
    ),
)
