"""Claim on the simplest progressive system, a mass on a dry-friction slider: Fig. 2(a)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth import bifurcation_diagram
from nonsmooth.models import percussive_drilling
from nonsmooth_chapter.judgement import Check, Evidence, Finding
from nonsmooth_chapter.mole.static_force_sweeps import PROTOCOLS

__all__ = ["CHECKS"]

_AMPLITUDES = tuple(round(0.1 * k, 1) for k in range(1, 21))


def _best_regimes(
    amplitudes: Sequence[float] = _AMPLITUDES,
    columns: int = 100,
    protocols: Sequence[str] = PROTOCOLS,
) -> Evidence:
    """Regime where the progression is largest, for every amplitude."""
    # between the values at which the force just touches zero or the friction limit
    b = (np.arange(columns) + 0.5) / columns
    rows = []
    for a in amplitudes:
        for start in protocols:
            diagram = bifurcation_diagram(
                percussive_drilling(a=a, omega=1.0), "b", b, start=start, transient=300, record=100
            )
            gain, period = (diagram[n].values[:, 0] for n in ("v_per_period", "period"))
            words = diagram["word"].values[:, 0]
            # a motion that never leaves the slider has the period of the force
            impacts = np.array(["flight" in word for word in words]) | (period != 1)
            for reading, allowed in (("all b", b < 1.0), ("with impacts", impacts)):
                best = int(np.where(allowed, gain, -np.inf).argmax())
                rows.append(
                    {
                        "a": a,
                        "start": start,
                        "reading": reading,
                        "b": float(b[best]),
                        "per_period": float(gain[best]),
                        "period": int(period[best]),
                        "word": str(words[best]),
                        "period_one_share": float(np.mean(period[allowed] == 1)),
                    }
                )
    return {"rows": rows}


def _judge_best_regimes(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    ones = [row["period"] == 1 for row in rows]
    listed = ", ".join(
        f"a {row['a']:g}: {row['per_period']:.4g} at b {row['b']:.3g}"
        for row in rows
        if row["reading"] == "with impacts" and row["start"] == "restart"
    )
    best = max(rows, key=lambda row: row["per_period"])
    failing = [
        f"a {row['a']:g} {row['start']} {row['reading']} (period {row['period'] or 'none'})"
        for row, each in zip(rows, ones, strict=True)
        if not each
    ]
    text = (
        f"best progression per period times omega^2 with impacts: {listed}; period one at"
        f" {sum(ones)} of {len(rows)} maxima (each a and protocol, with impacts and of all); over"
        f" the plane {best['per_period']:.4g} at a = {best['a']:g}, b = {best['b']:.3g}, period"
        f" {best['period'] or 'none'}"
    )
    if failing:
        text += "; not so for " + ", ".join(failing)
    return Finding(all(ones), text)


CHECKS = (
    Check(
        "M01",
        "a from .1 to 2 in steps of .1, b from .005 to .995 in steps of .01 (omega is a scale),"
        " restart from rest and follow up and down, 300 periods dropped, 100 kept",
        _best_regimes,
        _judge_best_regimes,
    ),
)
