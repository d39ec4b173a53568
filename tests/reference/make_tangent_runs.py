"""Writes tangent_runs.json: ``python -m tests.reference.make_tangent_runs`` at the top.

Parameters, starts and times stand there as JSON numbers, exact doubles; results as text with 20
digits. ``tangent`` is [time][state][state_0], ``sensitivity`` [time][state][parameter], with the
parameters in the order of ``parameters``.
"""

import json
from pathlib import Path
from typing import Any

from mpmath import mp, mpf

from .differences import derivatives
from .nonlinear import SmoothRun, smooth_run
from .nonlinear_models import CASES, Case

FILE = Path(__file__).with_name("tangent_runs.json")
PRINTED_DIGITS = 20


def record(case: Case) -> dict[str, Any]:
    """One run as it stands in the file."""
    run = run_of(case)
    found = derivatives(case, range(len(case.start)), list(case.parameters))
    return {
        "states": list(case.model.states),
        "parameters": dict(case.parameters),
        "start": list(case.start),
        "times": list(case.times),
        "modes": run.modes,
        "events": [events_of(run, i) for i in range(len(run.events))],
        "smallest_guard_rate": text(min(abs(event.rate) for event in run.events)),
        "samples": [list(map(text, row)) for row in run.samples],
        "tangent": [[list(map(text, row)) for row in rows] for rows in found.tangent],
        "sensitivity": [[list(map(text, row)) for row in rows] for rows in found.sensitivity],
    }


def run_of(case: Case) -> SmoothRun:
    return smooth_run(case.model, case.parameters, case.start, case.mode, case.times)


def events_of(run: SmoothRun, number: int) -> dict[str, Any]:
    event = run.events[number]
    return {
        "t": text(event.time),
        "from": event.mode_from,
        "to": event.mode_to,
        "n_exits": len(event.path),
        "guard_rate": text(event.rate),
        "before": list(map(text, event.before)),
        "after": list(map(text, event.after)),
    }


def text(x: mpf) -> str:
    return mp.nstr(x, PRINTED_DIGITS)


def main() -> None:
    runs = {}
    for name, case in CASES.items():
        runs[name] = record(case)
        print(f"{name}: {len(runs[name]['events'])} events")
    FILE.write_text(one_row_a_line(json.dumps(runs, indent=1)) + "\n", encoding="utf-8")


def one_row_a_line(words: str) -> str:
    """The innermost lists on one line each."""
    parts = words.split("[")
    joined = [part if "{" in part.split("]")[0] else _flat(part) for part in parts]
    return "[".join(joined)


def _flat(part: str) -> str:
    inside, bracket, rest = part.partition("]")
    return " ".join(inside.split()) + bracket + rest if bracket else part


if __name__ == "__main__":
    main()
