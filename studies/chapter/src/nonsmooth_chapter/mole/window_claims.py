"""Claims on windows of periodic motion over the static force: Figs. 7 and 8(a)-(c)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth import bifurcation_diagram
from nonsmooth.models import moling
from nonsmooth_chapter.judgement import Check, Evidence, Finding, agreed, agrees
from nonsmooth_chapter.mole.static_force_sweeps import (
    AMPLITUDES,
    CHAOTIC,
    PROTOCOLS,
    Sweep,
    even_forces,
    force_sweep,
)
from nonsmooth_chapter.mole.windows import order_of_labels, stretches, widest

__all__ = ["CHECKS"]

_SWEPT = (
    "xi .05, omega .1, b from a/{columns} to a (range not printed: above b = a the force never"
    " draws the mass off the ground) in {columns} columns, restart from rest and follow up and"
    " down, 600 periods dropped, 128 kept; chaos: no period up to 64 and a largest exponent above"
    " 3 standard errors over 150 periods"
)
_COLUMNS = 200
_PROTOCOL = _SWEPT.format(columns=_COLUMNS)


def _windows(
    amplitudes: Sequence[float] = AMPLITUDES,
    columns: int = _COLUMNS,
    protocols: Sequence[str] = PROTOCOLS,
) -> Evidence:
    rows = []
    for a in amplitudes:
        for start in protocols:
            sweep = force_sweep(a, even_forces(a, columns), start)
            parts = stretches(sweep)
            rows.append(
                {
                    "a": a,
                    "start": start,
                    "step": sweep.step,
                    "stretches": parts,
                    "main": widest(parts),
                    "chaotic_share": float(np.mean(sweep.labels == CHAOTIC)),
                    "least_aperiodic": _least_share(sweep),
                    "periodic_share": float(np.mean(sweep.labels > 0)),
                }
            )
    return {"rows": rows}


def _least_share(sweep: Sweep, shortest: float = 0.25) -> list[float]:
    """Least share of aperiodic columns in any range from 0 to part of the sweep, and its end."""
    counts = np.arange(1, sweep.labels.size + 1)
    shares = np.cumsum(sweep.labels <= CHAOTIC) / counts
    long = counts >= shortest * counts[-1]
    return [float(shares[long].min()), float(sweep.b[long][shares[long].argmin()])]


def _lowest() -> Evidence:
    return _windows((0.1,))


def _highest() -> Evidence:
    return _windows((0.9,))


def _listed(rows: list[Evidence], key: str) -> str:
    return ", ".join(f"{row['start']} {row[key]:.3f}" for row in rows)


def _judge_chaos(evidence: Evidence) -> Finding:
    """Columns near a bifurcation may need longer than others to show that they are chaotic."""
    rows = [row | {"aperiodic_share": 1.0 - row["periodic_share"]} for row in evidence["rows"]]
    least = ", ".join(
        f"{row['start']} {row['least_aperiodic'][0]:.3f} (b to {row['least_aperiodic'][1]:.3g})"
        for row in rows
    )
    text = (
        f"share of aperiodic columns in 0 < b <= {rows[0]['a']:g}:"
        f" {_listed(rows, 'aperiodic_share')}; of those with a positive exponent:"
        f" {_listed(rows, 'chaotic_share')}; the range of b is not printed: in any range from 0"
        f" that ends between a/4 and a the aperiodic share is at least {least}; wide means that"
        " more than half are aperiodic in any of them, and most of these chaotic"
    )
    return Finding(
        agreed(
            row["least_aperiodic"][0] > 0.5 and row["chaotic_share"] > 0.5 * row["aperiodic_share"]
            for row in rows
        ),
        text,
    )


def _small_forces(
    amplitudes: Sequence[float] = AMPLITUDES, columns: int = _COLUMNS, fine: int = 600
) -> Evidence:
    """Windows below the main one, on a grid of their own; there a period is all that is asked."""
    found = _windows(amplitudes, columns, ("restart",))["rows"]
    rows = []
    for row in found:
        top = row["main"]["low"] - row["step"]
        forces = even_forces(top, fine)
        diagram = bifurcation_diagram(moling(a=row["a"]), "b", forces, transient=300, record=128)
        periods = diagram["period"].values[:, 0]
        edges = np.diff(np.concatenate([[0], periods > 0, [0]]).astype(int))
        widths = np.flatnonzero(edges < 0) - np.flatnonzero(edges > 0)
        rows.append(
            {
                "a": row["a"],
                "below": top,
                "windows": int(widths.size),
                "widest": float(widths.max(initial=0) * top / fine),
                "main_width": row["main"]["high"] - row["main"]["low"] + row["step"],
                "periodic_share": float(np.mean(periods > 0)),
            }
        )
    return {"columns": fine, "rows": rows}


def _judge_small_forces(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    true = [
        row["windows"] > 0
        and row["periodic_share"] < 0.5
        and row["widest"] < 0.5 * row["main_width"]
        for row in rows
    ]
    listed = "; ".join(
        f"a {row['a']:g}, b below {row['below']:.4g}: {row['windows']} windows, the widest"
        f" {row['widest']:.2g} (main one {row['main_width']:.3g}), {row['periodic_share']:.1%} of"
        f" {evidence['columns']} columns periodic"
        for row in rows
    )
    failing = [f"{row['a']:g}" for row, each in zip(rows, true, strict=True) if not each]
    return Finding(all(true), listed + (f"; not so at a = {', '.join(failing)}" * bool(failing)))


def _judge_main_window(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    starts = list(dict.fromkeys(row["start"] for row in rows))
    rising = []
    for start in starts:
        widths = [r["main"]["high"] - r["main"]["low"] for r in rows if r["start"] == start]
        rising.append(bool(np.all(np.diff(widths) > 0)))
    listed = "; ".join(
        f"a {row['a']:g} {row['start']} {row['main']['low']:.4g} to {row['main']['high']:.4g}"
        for row in rows
    )
    return Finding(agreed(rising), f"widest periodic window: {listed}")


def _judge_above(evidence: Evidence) -> Finding:
    true, listed = [], []
    for row in evidence["rows"]:
        above = [part for part in row["stretches"] if part["low"] > row["main"]["high"]]
        windows = sum(bool(part["periods"]) for part in above)
        true.append(windows >= 2 and len(above) - windows >= 2)
        listed.append(
            f"a {row['a']:g} {row['start']} {len(above) - windows} aperiodic and {windows} periodic"
        )
    failing = sorted(
        {row["a"] for row, each in zip(evidence["rows"], true, strict=True) if not each}
    )
    text = "stretches above the main window: " + "; ".join(listed)
    if failing:
        text += f"; no series at a = {', '.join(f'{a:g}' for a in failing)}"
    return Finding(all(true), text)


def _judge_most(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    a, low = rows[0]["a"], max(row["main"]["low"] for row in rows)
    text = (
        f"share of periodic columns in 0 < b <= {a:g}: {_listed(rows, 'periodic_share')}; more than"
        f" half for every range from 0 that ends above b = {2.0 * low:.3g}"
    )
    return Finding(agreed(row["periodic_share"] > 0.5 for row in rows), text)


def _judge_from(evidence: Evidence) -> Finding:
    true, listed = [], []
    for row in evidence["rows"]:
        last = row["stretches"][-1]
        from_b = last["low"] if last["periods"] else np.inf
        true.append(agrees(from_b, "0.225", about=0.02, step=row["step"]))
        listed.append(f"{row['start']} {from_b:.4g}")
    text = (
        f"every column up to b = {evidence['rows'][0]['a']:g} is periodic from b ="
        f" {', '.join(listed)}; allowed 2 % or a step of {evidence['rows'][0]['step']:.3g}"
    )
    return Finding(agreed(true), text)


def _order(first: float = 0.095, last: float = 0.19, columns: int = 96) -> Evidence:
    forces = tuple(np.linspace(first, last, columns).round(12).tolist())
    rows = []
    for start in PROTOCOLS:
        sweep = force_sweep(0.3, forces, start)
        chaos = np.flatnonzero(sweep.labels == CHAOTIC)
        rows.append(
            {
                "start": start,
                "order": order_of_labels(sweep),
                "chaos_from": float(sweep.b[chaos[0]]) if chaos.size else None,
                "stretches": stretches(sweep),
            }
        )
    return {"rows": rows}


def _judge_order(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    true = [row["order"][:4] == [4, 2, 1, CHAOTIC] for row in rows]
    listed = "; ".join(
        f"{row['start']} {' '.join(str(label) if label else 'chaos' for label in row['order'])}"
        for row in rows
    )
    return Finding(agreed(true), f"periods in order of b: {listed}; the first four decide")


CHECKS = (
    Check(
        "M13",
        "a .3, b from .095 to .19 in steps of .001, restart from rest and follow up and down, 600"
        " periods dropped, 128 kept; columns that have not settled are left out",
        _order,
        _judge_order,
    ),
    Check("M18", _PROTOCOL, _lowest, _judge_chaos),
    Check(
        "M19",
        "main window as for M20, by restart; below it 600 columns of their own from rest, 300"
        " periods dropped, 128 kept; narrow: less than half of the main window's width",
        _small_forces,
        _judge_small_forces,
    ),
    Check("M20", _PROTOCOL, _windows, _judge_main_window),
    Check("M21", _PROTOCOL + "; a series: two of each at least", _windows, _judge_above),
    Check("M22", _PROTOCOL, _highest, _judge_most),
    Check("M23", _PROTOCOL, _highest, _judge_from),
)
