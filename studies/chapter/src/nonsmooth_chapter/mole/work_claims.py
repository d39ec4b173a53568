"""Claim on the work that the semi-analytical prediction saves (section 2.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from nonsmooth import find_orbit
from nonsmooth.models import four_phase_orbit, moling, progression_start
from nonsmooth_chapter.judgement import Check, Evidence, Finding
from nonsmooth_chapter.mole.adaptive_mole import adaptive_mole_run

__all__ = ["CHECKS"]

Values = Mapping[str, float]

_STABLE: Sequence[Values] = (
    {"a": 0.35, "b": 0.15, "xi": 0.01, "omega": 0.1},
    {"a": 0.5, "b": 0.3, "xi": 0.01, "omega": 0.1},
    {"a": 0.9, "b": 0.4, "xi": 0.01, "omega": 0.1},
)
_FAR_LESS = 10.0  # times
_AGREES = 1e-6


def _costs(sets: Sequence[Values] = _STABLE, periods: int = 30) -> Evidence:
    """Progression by three routes, and what two of them evaluate; a neighbour gives the guess."""
    rows = []
    for values in sets:
        system = moling(**values)
        near = find_orbit(system, parameters={"b": 0.99 * values["b"]})
        orbit = find_orbit(system, near)
        found = four_phase_orbit(system, progression_start(near))
        turns = 2.0 * np.pi / values["omega"] * np.arange(periods + 1)
        run = adaptive_mole_run(system.parameter_values, turns, tolerance=1e-9, longest_step=4.0)
        drift = float(orbit["v_per_period"])
        others = {
            "minimum": float(found["v_per_period"][0]),
            "steps": float(np.diff(run.states[:, 3])[-1]),
        }
        rows.append(
            {
                "set": dict(values),
                "per_period": drift,
                "differences": {name: abs(each / drift - 1.0) for name, each in others.items()},
                "evaluations": int(found.attrs["evaluations"]),
                "steps": run.n_steps,
                "rates": run.n_evaluations,
            }
        )
    return {"periods": periods, "rows": rows}


def _judge_costs(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    worst = max(max(row["differences"].values()) for row in rows)
    ratio = min(row["steps"] / row["evaluations"] for row in rows)
    listed = "; ".join(
        f"a {row['set']['a']:g}, b {row['set']['b']:g}: {row['evaluations']} evaluations of F,"
        f" {row['steps']} steps with {row['rates']} evaluations of the rates"
        for row in rows
    )
    text = (
        f"progression by the minimum of F and by {evidence['periods']} simulated periods agrees to"
        f" {worst:.1e}; {listed}; {ratio:.0f} steps for each evaluation of F at least (far less:"
        f" {_FAR_LESS:g}). An evaluation of F passes one period in closed form; to miss no end of"
        " a phase, this program looks at some 2000 values of its formulas, a choice of its own"
    )
    return Finding(worst < _AGREES and ratio >= _FAR_LESS, text)


CHECKS = (
    Check(
        "M34",
        "three sets inside the windows of Fig. 10, guesses from orbits at 0.99 b; simulation from"
        " rest by an adaptive integrator (DOP853, 1e-9), 30 periods, the last one taken; agreement"
        f" to {_AGREES:g}; work: evaluations of F against steps of the integrator, on any machine",
        _costs,
        _judge_costs,
    ),
)
