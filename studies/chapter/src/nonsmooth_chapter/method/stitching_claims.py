"""Claim on the method: a global solution stitched from local ones (section 1)."""

from __future__ import annotations

import numpy as np

from nonsmooth import simulate
from nonsmooth.models import moling
from nonsmooth_chapter.judgement import Check, Evidence, Finding
from nonsmooth_chapter.mole.adaptive_mole import adaptive_mole_run
from nonsmooth_chapter.mole.stitched_mole import solve_switching_times, stitched_states

__all__ = ["CHECKS"]

_STATES = "pyqv"


def _three_routes(b: float = 0.15, periods: int = 12, tolerance: float = 1e-12) -> Evidence:
    """Stitched closed forms, an adaptive integrator, and the library's engine."""
    system = moling(b=b)
    values = system.parameter_values
    times = np.linspace(0.0, periods * 2.0 * np.pi / values["omega"], 50 * periods + 1)
    adaptive = adaptive_mole_run(values, times, tolerance=tolerance)
    # the order of the modes and three digits of their times are all that is handed over
    guesses = [round(time, 3) for time in adaptive.switch_times]
    roots = solve_switching_times(values, adaptive.switch_modes, guesses)
    stitched = stitched_states(values, adaptive.switch_modes, roots, times)
    run = simulate(system, times=times)
    engine = np.column_stack([run[name].values for name in _STATES])
    scale = np.abs(stitched).max(axis=0)
    last_period = times[-1] - system.period_value
    return {
        "periods": periods,
        "unknowns": len(roots),
        "unknowns_in_last_period": int(np.sum(np.array(roots) > last_period)),
        "adaptive_steps": adaptive.n_steps,
        "tolerance": tolerance,
        "adaptive_difference": float((np.abs(stitched - adaptive.states) / scale).max()),
        "engine_difference": float((np.abs(stitched - engine) / scale).max()),
        "engine_switches": int(run.attrs["n_events"]),
    }


def _judge_routes(evidence: Evidence) -> Finding:
    # a step of the integrator errs by its tolerance at worst, and all errors may add up
    allowed = evidence["adaptive_steps"] * evidence["tolerance"]
    same = evidence["adaptive_difference"] <= allowed
    only_times = evidence["engine_switches"] == evidence["unknowns"]
    text = (
        f"{evidence['unknowns']} unknown switching times over {evidence['periods']} periods"
        f" ({evidence['unknowns_in_last_period']} per period in the end), one equation each;"
        f" states agree with {evidence['adaptive_steps']} steps of DOP853 to"
        f" {evidence['adaptive_difference']:.1e} of their size, and with the engine to"
        f" {evidence['engine_difference']:.1e}"
    )
    return Finding(bool(same and only_times), text)


CHECKS = (
    Check(
        "G1",
        "from rest, 12 periods, nothing dropped; closed forms with roots by Brent's method,"
        " against DOP853 with event functions and steps of at most 0.25",
        _three_routes,
        _judge_routes,
    ),
)
