"""Claim on what trajectories do at a surface: they cross it or slide along it (Fig. 1)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
import xarray as xr
from scipy.integrate import solve_ivp

from nonsmooth import System, simulate
from nonsmooth.models import belt_oscillator, soft_impact
from nonsmooth_chapter.judgement import Check, Evidence, Finding

__all__ = ["CHECKS"]

_STARTS = 8
_SEED = 1
_CROSSING = ("switch",)
_SLIDING = ("slide_entry", "slide_exit")
_GRAZING = ("graze",)
_SAMPLES = 200  # per period
_TOUCHES = 1e-6  # of the range of the guard: parabolas through samples are right to some 1e-7


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
        touches = 0
        for system in systems:
            found, touched = _kinds(system, periods)
            kinds, touches = kinds + found, touches + touched
        rows.append({"model": name, "kinds": dict(kinds), "touches": touches})
    return {"rows": rows, "periods": periods, "control": _touches(*_touching_run())}


def _kinds(system: System, periods: int) -> tuple[Counter[str], int]:
    """Kinds of events from some starts, and touches without an event."""
    random = np.random.default_rng(_SEED)
    found: Counter[str] = Counter()
    touches = 0
    for x, v in random.uniform(-1.0, 1.0, (_STARTS, 2)):
        run = simulate(system, {"x": x, "v": v}, periods=periods, samples_per_period=_SAMPLES)
        found.update(map(str, run["event_kind"].values[1:]))
        touches += _touches(system, run)
    return found, touches


def _touches(system: System, run: xr.Dataset) -> int:
    """Places where a run comes to a surface and turns back, by parabolas through its samples.

    The surface of the compliant contact is x = e, that of the friction v = v_b.
    """
    values = system.parameter_values
    gap = run["x"].values - values["e"] if "e" in values else run["v"].values - values["v_b"]
    before, here, behind = gap[:-2], gap[1:-1], gap[2:]
    curved = before - 2.0 * here + behind
    turns = (here - before) * (behind - here) < 0.0
    turns &= np.abs(behind - before) < 2.0 * np.abs(curved)
    curved = np.where(turns, curved, 1.0)
    peak = here - (behind - before) ** 2 / (8.0 * curved)
    back = np.sign(before) == np.sign(behind)
    scale = float(np.ptp(gap))
    return int(np.sum(turns & back & (np.abs(peak) < _TOUCHES * scale)))


def _touching_run(omega: float = 0.8, at: float = 0.6) -> tuple[System, xr.Dataset]:
    """A run of the compliant contact that was made to touch: the count must see it.

    The free motion through x = e, v = 0 with a force that pulls back, followed backwards by a
    general integrator to the time zero.
    """
    system = soft_impact(omega=omega)
    p = system.parameter_values
    period = 2.0 * np.pi / omega

    def rates(t: float, s: np.ndarray) -> list[float]:
        pull = p["a"] * omega**2 * np.sin(omega * t) - 2.0 * p["zeta"] * s[1] - s[0]
        return [s[1], pull]

    back = solve_ivp(
        rates, (at * period, 0.0), [p["e"], 0.0], method="DOP853", rtol=1e-13, atol=1e-13
    )
    start = {"x": float(back.y[0, -1]), "v": float(back.y[1, -1])}
    return system, simulate(system, start, periods=1, samples_per_period=_SAMPLES)


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
        true = true and row["touches"] == 0
        parts.append(
            f"{row['model']}: {total} events, {crossing / total:.1%} crossings,"
            f" {sliding / total:.1%} beginnings and ends of sliding, {grazing / total:.1%} grazing,"
            f" {row['touches']} touches without an event"
        )
    text = "; ".join(parts) + (
        f"; a run that was made to touch the surface is counted as {evidence['control']} touch, and"
        " such starts fill no volume"
    )
    # a count that does not see the touch it was given tells nothing
    return Finding(true if evidence["control"] == 1 else None, text)


CHECKS = (
    Check(
        "G2",
        "forced belt (F .5, omega .7, belt speeds .1 .3 .6 1) and soft impact (omega .6 to 1 in"
        " steps of .1), eight random starts in the unit square each, 200 periods, nothing dropped;"
        f" a touch: a run turns back within {_TOUCHES:g} of its range from the surface",
        _shares,
        _judge_shares,
    ),
)
