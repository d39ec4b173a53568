"""Claim on the work that the semi-analytical prediction saves (section 2.2)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from time import perf_counter
from typing import Any

import numpy as np

from nonsmooth import find_orbit, simulate
from nonsmooth.chapter.judgement import Check, Evidence, Finding
from nonsmooth.chapter.mole.adaptive_mole import adaptive_mole_run
from nonsmooth.chapter.mole.windows import agreed
from nonsmooth.models import four_phase_orbit, moling, progression_start

__all__ = ["CHECKS"]

Values = Mapping[str, float]

_STABLE: Sequence[Values] = (
    {"a": 0.35, "b": 0.15, "xi": 0.01, "omega": 0.1},
    {"a": 0.5, "b": 0.3, "xi": 0.01, "omega": 0.1},
    {"a": 0.9, "b": 0.4, "xi": 0.01, "omega": 0.1},
)
_FAR_LESS = 10.0  # times


def _costs(sets: Sequence[Values] = _STABLE, periods: int = 30) -> Evidence:
    """Progression by three routes, and the time that each takes; a neighbour gives the guess."""
    rows = []
    for values in sets:
        system = moling(**values)
        near = find_orbit(system, parameters={"b": 0.99 * values["b"]})
        start = progression_start(near)
        # each lambda is called at once, before the loop goes on: B023 does not apply
        orbit, newton = _timed(lambda: find_orbit(system, near))  # noqa: B023
        found, simplex = _timed(lambda: four_phase_orbit(system, start))  # noqa: B023
        turns = 2.0 * np.pi / values["omega"] * np.arange(periods + 1)
        run, engine = _timed(lambda: simulate(system, times=turns))  # noqa: B023
        general, stepping = _timed(
            lambda: adaptive_mole_run(system.parameter_values, turns, tolerance=1e-9)  # noqa: B023
        )
        drift = float(orbit["v_per_period"])
        others = {
            "minimum": float(found["v_per_period"][0]),
            "events": float(np.diff(run["v"].values)[-1]),
            "steps": float(np.diff(general.states[:, 3])[-1]),
        }
        rows.append(
            {
                "set": dict(values),
                "per_period": drift,
                "differences": {name: abs(each / drift - 1.0) for name, each in others.items()},
                "evaluations": int(found.attrs["evaluations"]),
                "integrator_steps": general.n_steps,
                "seconds": {
                    "newton": newton, "minimum": simplex, "events": engine, "steps": stepping,
                },
            }
        )  # fmt: skip
    return {"periods": periods, "rows": rows}


def _timed(call: Callable[[], Any], repeats: int = 2) -> tuple[Any, float]:
    """Result, and the shortest time of some calls."""
    times = []
    for _ in range(repeats):
        began = perf_counter()
        result = call()
        times.append(perf_counter() - began)
    return result, min(times)


def _judge_costs(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    same = all(max(row["differences"].values()) < 1e-6 for row in rows)
    ratios = {
        (ours, theirs): min(row["seconds"][theirs] / row["seconds"][ours] for row in rows)
        for ours in ("minimum", "newton")
        for theirs in ("steps", "events")
    }
    true = [same and ratio >= _FAR_LESS for ratio in ratios.values()]
    worst = max(max(row["differences"].values()) for row in rows)
    evaluations = max(row["evaluations"] for row in rows)
    names = {
        "minimum": "minimum of F", "newton": "Newton's method",
        "steps": "an adaptive integrator", "events": "events on exact flows",
    }  # fmt: skip
    told = "; ".join(
        f"{names[ours]} takes {1.0 / ratio:.2g} of the time of {names[theirs]}"
        for (ours, theirs), ratio in ratios.items()
    )
    text = (
        f"progression by all routes agrees to {worst:.1e}; at worst {told}; {evaluations}"
        f" evaluations of F at most; far less: a tenth"
    )
    return Finding(False if not same else agreed(true), text)


CHECKS = (
    Check(
        "M34",
        "three sets inside the windows of Fig. 10, guesses from orbits at 0.99 b; simulation from"
        " rest, 30 periods, the last one taken; agreement to 1e-6; both constructions against an"
        " adaptive integrator (DOP853, 1e-9) and against this library's events",
        _costs,
        _judge_costs,
    ),
)  # fmt: skip
