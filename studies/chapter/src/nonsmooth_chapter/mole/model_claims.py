"""Claims on the model: scaling, geometry of contact, and which phase a state belongs to."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from nonsmooth import OptionError, simulate
from nonsmooth.models import MolingRig, moling
from nonsmooth_chapter.judgement import Check, Evidence, Finding
from nonsmooth_chapter.mole.absolute_mole import absolute_mole, unit_mole

__all__ = ["CHECKS", "STATIC_FORCES"]

STATIC_FORCES = (0.05, 0.095, 0.1, 0.15, 0.19, 0.27)
# Three rigs of our choice, with little, moderate and heavy damping and three phases.
_RIGS: tuple[dict[str, float], ...] = (
    {"damping": 31.6, "static_force": 30.0, "dynamic_force": 60.0, "phase": np.pi / 2},
    {"damping": 220.0, "static_force": 91.2, "dynamic_force": 100.0, "phase": 0.3},
    {"damping": 750.0, "static_force": 60.0, "dynamic_force": 180.0, "phase": -2.0},
)
_COMMON = {"mass": 2.0, "stiffness": 5e4, "friction_force": 200.0, "gap": 8e-5}
_NAMES = {"x": "X_m", "y": "Y_m", "z": "X_t", "v": "X_b"}
_UNIT = float(np.finfo(float).eps)
_ROUNDINGS = 100  # about one for each phase of the runs of M08


def _scaling(rigs: Sequence[dict[str, float]] = _RIGS, periods: int = 20) -> Evidence:
    differences = []
    for data in rigs:
        rig = MolingRig(**_COMMON, angular_frequency=15.8, **data)
        scaled = rig.to_si(simulate(rig.system(), periods=periods))
        direct = simulate(absolute_mole(rig), periods=periods)
        relative = [
            np.abs(scaled[ours].values - 1e3 * direct[theirs].values).max()
            / np.abs(scaled[ours].values).max()
            for ours, theirs in _NAMES.items()
        ]
        differences.append(float(max(relative)))
    return {"periods": periods, "rigs": len(rigs), "differences": differences}


def _judge_scaling(evidence: Evidence) -> Finding:
    largest = max(evidence["differences"])
    text = (
        f"displacements and velocity of {evidence['rigs']} rigs, simulated in SI units and in"
        f" scaled ones, agree to {largest:.1e} of their largest values over"
        f" {evidence['periods']} periods"
    )
    return Finding(largest <= 1e-10, text)


def _contact_offset(forces: Sequence[float] = STATIC_FORCES, periods: int = 50) -> Evidence:
    """Offset of mass and slider top in contact, both integrated by their own rates."""
    deviations, scales, contacts = [], [], 0
    for b in forces:
        system = unit_mole(b, apart=True)
        run = simulate(system, periods=periods, samples_per_period=400)
        touching = run["mode"].values != 0
        offset = (run["X_m"] - run["X_t"]).values[touching] - system.parameter_values["gap"]
        deviations.append(float(np.abs(offset).max()))
        scales.append(float(np.abs(run["X_m"].values).max()))
        contacts += int(np.sum(run["event_name"].values == "impact"))
    return {
        "static_forces": list(forces),
        "deviations": deviations,
        "largest_x": scales,
        "contacts": contacts,
    }


def _judge_offset(evidence: Evidence) -> Finding:
    # two sums of displacements, each rounded at every switch since the run began
    rounding = [_ROUNDINGS * _UNIT * scale for scale in evidence["largest_x"]]
    holds = all(d <= r for d, r in zip(evidence["deviations"], rounding, strict=True))
    text = (
        f"mass and slider top, integrated apart in absolute displacements: abs(x - z - g) in"
        f" {evidence['contacts']} contacts is at most {max(evidence['deviations']):.1e} while x"
        f" reaches {max(evidence['largest_x']):.0f} ({_ROUNDINGS} roundings of it are"
        f" {max(rounding):.1e}); an identity of Eqs. (3) and (4), where both move at y"
    )
    return Finding(holds, text)


def _phase_conditions(span: float = 3.0, steps: int = 13) -> Evidence:
    """States on a grid, by the chapter's three conditions and by the library's start."""
    system = moling()
    gap, xi = (system.parameter_values[name] for name in ("g", "xi"))
    counts = dict.fromkeys(("one", "none_inadmissible", "none_pulling", "other_mode"), 0)
    sample: dict[str, Any] = {}
    grid = np.linspace(-span, span, steps)
    for h, y, q in product((-1.0, 0.0, 1.0), grid / xi / 2.0, grid):
        state = {"p": h + q + gap, "y": float(y), "q": float(q)}
        force = 2.0 * xi * y + q
        named = _printed_phase(h, force)
        try:
            mode = simulate(system, state, times=[0.0]).attrs["phase_word"]
        except OptionError:
            mode = "inadmissible"
        if named == mode:
            counts["one"] += 1
        elif named is not None:
            counts["other_mode"] += 1
        elif mode == "inadmissible":
            counts["none_inadmissible"] += 1
        else:
            counts["none_pulling"] += 1
            sample = {**{name: float(x) for name, x in state.items()}, "mode": mode}
    return {"states": 3 * steps**2, **counts, "example": sample}


def _printed_phase(h: float, force: float) -> str | None:
    """Phase by the three conditions that the chapter states."""
    if h < 0.0:
        return "no_contact"
    if h == 0.0 and 0.0 < force < 1.0:
        return "contact"
    if h == 0.0 and force >= 1.0:
        return "progression"
    return None


def _judge_conditions(evidence: Evidence) -> Finding:
    left_out = evidence["none_pulling"]
    text = (
        f"of {evidence['states']} states {evidence['one']} are decided as the run starts;"
        f" {evidence['none_inadmissible']} with p > q + g are no states of the mole;"
        f" {left_out} on p = q + g with 2 xi y + q <= 0 fall under no condition"
        f" (the mass leaves at once, or stays if the force is zero and rising), and"
        f" {evidence['other_mode']} on the edge 2 xi y + q = 1 start in the phase that the"
        f" conditions do not name, the force falling"
    )
    return Finding(left_out == 0 and evidence["other_mode"] == 0, text)


CHECKS = (
    Check("M07", "three rigs of our choice, from rest, nothing dropped", _scaling, _judge_scaling),
    Check(
        "M08",
        "six b of Fig. 6 in absolute displacements, mass and slider top integrated apart, from"
        " rest, 50 periods",
        _contact_offset,
        _judge_offset,
    ),
    Check(
        "M46",
        "grid of (y0, q0) on p0 - q0 - g = -1, 0 and 1 at tau = 0, parameters of Fig. 7d",
        _phase_conditions,
        _judge_conditions,
    ),
)
