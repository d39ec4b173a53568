"""Claim on what trajectories do at a surface: they cross it or slide along it (Fig. 1)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from nonsmooth import System, simulate
from nonsmooth.chapter.judgement import Check, Evidence, Finding
from nonsmooth.models import belt_oscillator, soft_impact

__all__ = ["CHECKS"]

_STARTS = 8
_SEED = 1
_CROSSING = ("switch",)
_SLIDING = ("slide_entry", "slide_exit")
_GRAZING = ("graze",)


def _shares(
    speeds: Sequence[float] = (0.1, 0.3, 0.6, 1.0),
    frequencies: Sequence[float] = (0.6, 0.7, 0.8, 0.9, 1.0),
    periods: int = 200,
) -> Evidence:
    """Events at the surfaces of two systems, by what the trajectories do there."""
    models = {
        "dry friction": [belt_oscillator(v_b=v, F=0.5, omega=0.7) for v in speeds],
        "compliant contact": [soft_impact(omega=omega) for omega in frequencies],
    }
    rows = []
    for name, systems in models.items():
        kinds: Counter[str] = Counter()
        for system in systems:
            kinds += _kinds(system, periods)
        rows.append({"model": name, "kinds": dict(kinds)})
    return {"rows": rows, "periods": periods}


def _kinds(system: System, periods: int) -> Counter[str]:
    """Kinds of events from some starts."""
    random = np.random.default_rng(_SEED)
    found: Counter[str] = Counter()
    for x, v in random.uniform(-1.0, 1.0, (_STARTS, 2)):
        run = simulate(system, {"x": x, "v": v}, periods=periods, samples_per_period=1)
        found.update(map(str, run["event_kind"].values[1:]))
    return found


def _judge_shares(evidence: Evidence) -> Finding:
    known = (*_CROSSING, *_SLIDING, *_GRAZING)
    parts, true = [], True
    for row in evidence["rows"]:
        kinds = row["kinds"]
        total = sum(kinds.values())
        crossing, sliding, grazing = (
            sum(kinds.get(kind, 0) for kind in group) for group in (_CROSSING, _SLIDING, _GRAZING)
        )
        true = true and crossing + sliding == total and set(kinds) <= set(known)
        parts.append(
            f"{row['model']}: {total} events, {crossing / total:.1%} crossings,"
            f" {sliding / total:.1%} beginnings and ends of sliding, {grazing / total:.1%} grazing"
        )
    text = "; ".join(parts) + (
        "; a trajectory that touches a surface without crossing exists at single values of a"
        " parameter only, and none is met here"
    )
    return Finding(true, text)


CHECKS = (
    Check(
        "G2",
        "forced belt (F .5, omega .7, belt speeds .1 .3 .6 1) and soft impact (omega .6 to 1 in"
        " steps of .1), eight random starts in the unit square each, 200 periods, nothing dropped",
        _shares,
        _judge_shares,
    ),
)
