"""Writes contact_runs.json: ``python -m tests.reference.make_contact_runs`` at the top.

As `make_tangent_runs.py`, for the runs of `contact_models.py`: some minutes. Of the impacts only
those that change the mode are written, each with the number of impacts up to it.
"""

import json
from pathlib import Path
from typing import Any

from mpmath import mp

from .contact_models import ACCUMULATIONS, CASES
from .differences import derivatives
from .make_tangent_runs import events_of, one_row_a_line, text
from .nonlinear import SmoothRun, smooth_run
from .nonlinear_models import Case
from .resting import RestingRoute

FILE = Path(__file__).with_name("contact_runs.json")
# At the end of their range, or where the system would be another one: no central differences.
FIXED = (("r", 0.0), ("k3", 0.0))


def record(case: Case, with_tangents: bool) -> dict[str, Any]:
    """One run as it stands in the file."""
    run = smooth_run(
        case.model, case.parameters, case.start, case.mode, case.times, route=RestingRoute
    )
    words = {
        "states": list(case.model.states),
        "parameters": dict(case.parameters),
        "start": list(case.start),
        "mode": case.mode,
        "times": list(case.times),
        "modes": run.modes,
        "changes": changes(run),
        "samples": [list(map(text, row)) for row in run.samples],
    }
    if with_tangents:
        moved = [name for name in case.parameters if (name, case.parameters[name]) not in FIXED]
        found = derivatives(case, range(len(case.start)), moved, route=RestingRoute)
        words["moved"] = moved
        words["tangent"] = [[list(map(text, row)) for row in rows] for rows in found.tangent]
        words["sensitivity"] = [
            [list(map(text, row)) for row in rows] for rows in found.sensitivity
        ]
    return words


def changes(run: SmoothRun) -> list[dict[str, Any]]:
    """Events that change the mode."""
    return [
        {**events_of(run, i), "number": i}
        for i, event in enumerate(run.events)
        if event.mode_from != event.mode_to
    ]


def main() -> None:
    runs: dict[str, dict[str, Any]] = {"tangents": {}, "accumulations": {}}
    for kind, cases in (("tangents", CASES), ("accumulations", ACCUMULATIONS)):
        for name, case in cases.items():
            runs[kind][name] = record(case, kind == "tangents")
            print(f"{name}: {len(runs[kind][name]['changes'])} changes of mode", flush=True)
            FILE.write_text(one_row_a_line(json.dumps(runs, indent=1)) + "\n", encoding="utf-8")


if __name__ == "__main__":
    with mp.workdps(60):
        main()
