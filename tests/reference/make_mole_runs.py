"""Writes mole_runs.json: ``python -m tests.reference.make_mole_runs`` at the top of the checkout.

Parameters and initial states stand there as JSON numbers, exact doubles. All results are text
with 25 digits. Times count from the start of the run.
"""

import json
import math
from pathlib import Path
from typing import Any

from mpmath import mp, mpf

from . import engineered
from .mole import DEFAULTS, DIGITS, MoleRun, Strobe, mole_events, mole_tangent_growth

FILE = Path(__file__).with_name("mole_runs.json")
N_PERIODS = 10
PRINTED_DIGITS = 25


def parameters(a: float, b: float, xi: float, omega: float) -> dict[str, float]:
    return {"a": a, "b": b, "xi": xi, "omega": omega, **DEFAULTS}


MANY_CONTACTS = parameters(0.3, 0.27, 0.05, 0.1)

# name: parameters, initial state, phase omega t at the start, what the run is there for
PLAIN = {
    "b 0.05": (parameters(0.3, 0.05, 0.05, 0.1), {}, 0.0, "irregular, few contacts"),
    "b 0.095": (parameters(0.3, 0.095, 0.05, 0.1), {}, 0.0, "irregular, long flights"),
    "b 0.15": (parameters(0.3, 0.15, 0.05, 0.1), {}, 0.0, "settles to one contact per period"),
    "b 0.19": (
        parameters(0.3, 0.19, 0.05, 0.1),
        {},
        0.0,
        "irregular, one to three contacts per period",
    ),
    "b 0.27": (MANY_CONTACTS, {}, 0.0, "several contacts per period"),
    "direct passage": (
        parameters(0.9, 0.3, 0.05, 0.1),
        {},
        0.0,
        "no contact to progression in one instant, every period",
    ),
    "fast forcing": (parameters(0.3, 0.1, 0.1, 1.6), {}, 0.0, "contact, but no progression"),
    "critical": (parameters(0.3, 0.15, 1.0, 0.1), {}, 0.0, "xi = 1, direct passages"),
    "overdamped": (parameters(0.3, 0.15, 1.5, 0.1), {}, 0.0, "xi > 1, direct passages"),
    "heavy damping": (parameters(0.5, 0.456, 0.35, 0.11), {}, 0.0, "all modes"),
    "lasting contact": (parameters(0.1, 0.6, 0.2, 0.5), {}, 0.0, "one impact, no release after it"),
    "retreat": (parameters(0.2, 0.0, 0.1, 0.5), {"p": -0.5}, 0.0, "b = 0: flies away, no event"),
    "advance": (
        parameters(0.2, 0.0, 0.1, 0.5),
        {"p": -0.5},
        math.pi,
        "the same, started half a period later",
    ),
}


def engineered_runs() -> dict[str, tuple[dict[str, float], dict[str, float], float, str]]:
    """Runs that graze in the second period, or early; the velocity at the start is solved for."""
    grazes = {
        "impact graze": (engineered.hit, -0.117, -0.112, "an impact with h' = 1e-6"),
        "impact miss": (engineered.miss, -0.117, -0.112, "the gap closes to 1e-6, no impact"),
        "release graze": (engineered.hit, 0.5, 0.503, "a flight of 0.002 that ends at h' = 1e-6"),
        "progression graze": (engineered.hit, 0.4544, 0.456, "a progression at F' = 1e-6"),
    }
    return {
        name: (
            MANY_CONTACTS,
            {"y": solve(MANY_CONTACTS, low, high, 1e-6)},
            0.0,
            purpose,
        )
        for name, (solve, low, high, purpose) in grazes.items()
    }


def record(
    parameters: dict[str, float], initial: dict[str, float], start_phase: float, purpose: str
) -> dict[str, Any]:
    """One run as it stands in the file."""
    run = mole_events(parameters, initial, N_PERIODS, start_phase=start_phase)
    growth = mole_tangent_growth(parameters, initial, N_PERIODS, start_phase=start_phase)
    with mp.workdps(DIGITS):
        period = text(2 * mp.pi / mpf(parameters["omega"]))
    return {
        "purpose": purpose,
        "parameters": parameters,
        "initial": {name: float(initial.get(name, 0.0)) for name in "pyqv"},
        "start_phase": start_phase,
        "period": period,
        "n_periods": N_PERIODS,
        "events": events(run),
        "strobes": [strobe(each) for each in run.strobes],
        "nearest_miss": text(run.nearest_miss),
        "tangent_growth": growth._asdict(),
    }


def events(run: MoleRun) -> list[dict[str, str]]:
    rows = zip(run.events, run.event_states, run.guard_rates, strict=True)
    return [
        {
            "t": text(t),
            "from": mode_from,
            "to": mode_to,
            **{name: text(x) for name, x in state._asdict().items()},
            "guard_rate": text(rate),
        }
        for (t, mode_from, mode_to), state, rate in rows
    ]


def strobe(each: Strobe) -> dict[str, str]:
    return {name: x if name == "mode" else text(x) for name, x in each._asdict().items()}


def text(x: mpf) -> str:
    return mp.nstr(x, PRINTED_DIGITS)


def main() -> None:
    runs = {}
    for name, row in {**PLAIN, **engineered_runs()}.items():
        runs[name] = record(*row)
        print(f"{name}: {len(runs[name]['events'])} events")
    FILE.write_text(json.dumps(runs, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
