"""Claims on the split into bounded motion and drift (section 2.3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from nonsmooth import System, simulate
from nonsmooth.models import drift_reconstruction, moling
from nonsmooth_chapter.judgement import Check, Evidence, Finding
from nonsmooth_chapter.mole.absolute_mole import unit_mole
from nonsmooth_chapter.mole.model_claims import STATIC_FORCES

__all__ = ["CHECKS"]

_UNIT = float(np.finfo(float).eps)
_SAME = 1e-9  # roundings of the shift grow some thousandfold where the motion is chaotic
_TWICE_XI = 0.1
_PARTS, _NODES = 8, 20  # of a progression: a part is at most 14 relaxation times of the slider


def _two_drifts(
    forces: Sequence[float] = STATIC_FORCES, offset: float = 64.0, periods: int = 10
) -> Evidence:
    """Runs in absolute displacements that begin elsewhere in the ground."""
    rows = []
    for b in forces:
        system = unit_mole(b)
        first, second = (
            simulate(system, dict.fromkeys(("X_m", "X_t", "X_b"), place), periods=periods)
            for place in (0.0, offset)
        )
        apart = [
            float(np.abs(_bounded(first)[name] - _bounded(second)[name]).max()) for name in "pyq"
        ]
        same = [*first["event_name"].values] == [*second["event_name"].values]
        rows.append({"b": b, "apart": max(apart), "same_switches": same})
    return {"offset": offset, "periods": periods, "rows": rows}


def _bounded(run: xr.Dataset) -> dict[str, np.ndarray]:
    """p = x - v, y and q = z - v of a run in absolute displacements."""
    bottom = run["X_b"].values
    return {"p": run["X_m"].values - bottom, "y": run["Y_m"].values,
            "q": run["X_t"].values - bottom}  # fmt: skip


def _judge_two_drifts(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    largest = max(rows, key=lambda row: row["apart"])
    same = sum(row["same_switches"] for row in rows)
    text = (
        "Eqs. (2)-(4) contain x - z, z - v and x' alone, so all displacements may be shifted; runs"
        f" in absolute displacements that begin {evidence['offset']:g} apart: p, y and q differ by"
        f" {largest['apart']:.1e} at most in {evidence['periods']} periods (b = {largest['b']:g}),"
        f" and the same switches follow each other in {same} of {len(rows)} sets"
    )
    return Finding(largest["apart"] <= _SAME and same == len(rows), text)


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
    """Force on the slider bottom, and its displacement, while it is not to move."""
    rows = []
    for b in forces:
        run = simulate(unit_mole(b), periods=periods, samples_per_period=200)
        mode, spring = run["mode"].values, (run["X_t"] - run["X_b"]).values
        force = np.where(mode == 1, _TWICE_XI * run["Y_m"].values + spring, 0.0)
        column = list(run["state"].values).index("X_b")
        idle = run["event_to"].values[:-1] != 2
        change = run["state_before"].values[1:, column] - run["state_after"].values[:-1, column]
        rows.append(
            {
                "b": b,
                "force": [float(force[mode == 1].min()), float(force[mode == 1].max())],
                "change": float(np.abs(change[idle]).max()),
                "stretches": int(idle.sum()),
            }
        )
    return {"rows": rows}


def _judge_idle(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    low = min(row["force"][0] for row in rows)
    high = max(row["force"][1] for row in rows)
    change = max(row["change"] for row in rows)
    text = (
        f"in {sum(row['stretches'] for row in rows)} stretches without progression, in absolute"
        f" displacements, friction holds the slider bottom: the force on it is zero in flight and"
        f" between {low:.2g} and {high:.5g} of the limit in contact; it moves by {change:g}"
    )
    return Finding(bool(change == 0.0 and low >= 0.0 and high <= 1.0), text)


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
    Check(
        "M42",
        f"six b in absolute displacements, from rest here and elsewhere in the ground, 10 periods,"
        f" nothing dropped; the same: to {_SAME:g}",
        _two_drifts,
        _judge_two_drifts,
    ),
    Check(
        "M43", "set of Fig. 7d, from rest, 1000 periods in halves", _separation, _judge_separation
    ),
    Check(
        "M44",
        "six b in absolute displacements, from rest, 100 periods, nothing dropped; true where the"
        " slider bottom keeps its place and the force on it stays within the friction limit",
        _idle_drift,
        _judge_idle,
    ),
    Check(
        "M45",
        "six b, from rest; first and a middle progression of 20 periods, Gauss quadrature of v'",
        _printed_drift,
        _judge_printed,
    ),
)
