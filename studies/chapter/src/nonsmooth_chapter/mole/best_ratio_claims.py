"""Claim on the ratio of dynamic to static force at the best progression (section 2.4)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import xarray as xr

from nonsmooth import bifurcation_diagram, continue_orbit
from nonsmooth.models import moling
from nonsmooth_chapter.judgement import Check, Evidence, Finding, agreed
from nonsmooth_chapter.mole.orbit_branches import observed
from nonsmooth_chapter.mole.static_force_sweeps import even_forces

__all__ = ["CHECKS"]

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


CHECKS = (
    Check(
        "M56",
        "omega .1, xi .01, .05 and .1, six amplitudes, b from a/10 to a (at most .95): best"
        " periodic column of 60 from rest, and best stable orbit on the branch through the best"
        " column of period one; about 2: within a tenth, for every amplitude and over the plane",
        _ratios,
        _judge_ratios,
    ),
)
