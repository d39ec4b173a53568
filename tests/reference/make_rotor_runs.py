"""Writes rotor_runs.json: ``python -m tests.reference.make_rotor_runs`` at the top (10 minutes).

Parameters stand there as JSON numbers, exact doubles, results as text with 25 digits. All runs
start with x = y = vx = vy = 0, the ring in its centre, and last ten periods. Samples are taken
four times a period; ``tangent`` is [final x, y, vx, vy][initial x, y, vx, vy]. Names of runs after
the command are made anew, the others kept.
"""

import json
import re
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

from mpmath import mp, mpf

from .nonlinear import DIGITS, SmoothEvent, SmoothRun, smooth_run
from .rotor import STATES, period, plain, rotor_case

FILE = Path(__file__).with_name("rotor_runs.json")
PRINTED_DIGITS = 25
N_PERIODS, PER_PERIOD = 10, 4
MOVED = mpf(10) ** -14  # forward differences at about 34 digits
TANGENT = {"order": 36, "tolerance": mpf(10) ** -34}

SET_A = {
    "eta": 2.442, "nu1": 0.125, "nu2": 0.002, "K": 30.0, "eta_m": 0.0017, "rho": 70.0,
    "eps_x": 0.9, "eps_y": 0.0, "delta_x": 0.1, "delta_y": 0.1, "phi0": 0.0,
}  # fmt: skip
SET_B = SET_A | {
    "eta": 2.5, "nu1": 0.06, "eta_m": 0.00289, "eps_x": 0.4, "eps_y": 0.5,
    "delta_x": 0.05, "delta_y": 0.05,
}  # fmt: skip
NO_PRELOAD = {"delta_x": 0.0, "delta_y": 0.0}

# name: parameters, what the run is there for
RUNS = {
    "set A": (SET_A, "I and II only: the ring stays within its preload"),
    "set A without preload": (SET_A | NO_PRELOAD, "I and V only"),
    "set B": (SET_B, "all regimes, single passages of 0.001"),
    "set B without preload": (SET_B | NO_PRELOAD, "I and V only"),
    "unequal preloads": (
        SET_A | {"eta_m": 0.004, "delta_x": 0.03},
        "all regimes, strong growth of the tangent",
    ),
    "strong": (
        SET_B | {"eta_m": 0.008, "delta_x": 0.02},
        "long contacts, the ring goes round through V, III and IV",
    ),
    "weak preload": (
        SET_A | {"eta_m": 0.003, "delta_x": 1e-4, "delta_y": 2e-4},
        "several regimes within 1e-4; the switch to II releases at once",
    ),
    "excursion": (
        SET_A | {"delta_x": 0.06023701862428 * (1 - 1e-8), "delta_y": 2.0},
        "one excursion past the preload, 3e-5 long and 6e-10 high",
    ),
    "no excursion": (
        SET_A | {"delta_x": 0.06023701862428 * (1 + 1e-6), "delta_y": 2.0},
        "the ring comes within 6e-8 of its preload",
    ),
    "damped ring": (
        SET_B | {"eta_m": 0.004, "nu2": 0.2, "delta_x": 0.01, "delta_y": 0.01},
        "most releases come with a switch from III or IV to II",
    ),
    "slow ring": (
        SET_B | {"eta_m": 0.006, "nu2": 10.0, "delta_x": 0.002, "delta_y": 0.002},
        "releases beyond the preload, from III too, and contacts with a ring that is on its way",
    ),
    "slow ring without preload": (
        SET_B | NO_PRELOAD | {"eta_m": 0.006, "nu2": 10.0},
        "contacts with a ring that is on its way",
    ),
    "sluggish ring": (
        SET_B | {"eta_m": 0.006, "nu2": 2.0, "delta_x": 0.02, "delta_y": 0.02},
        "a flight of 2e-4, a release by a switch and one from IV with unequal dampers",
    ),
    "undecided, unequal": (
        SET_A | {"delta_x": 0.0},
        "after the first release from III rotor and ring would still approach",
    ),
    "undecided, equal": (
        SET_B | {"eta_m": 0.006, "nu2": 5.0, "delta_x": 0.02, "delta_y": 0.02},
        "the same after a release from II, by the second rates: the ring is too slow",
    ),
    "undecided by a switch": (
        SET_B | {"eta_m": 0.004, "nu2": 1.0, "delta_x": 0.02, "delta_y": 0.02},
        "the switch from V to IV ends contact, and rotor and ring would still approach",
    ),
}


def record(parameters: dict[str, float], purpose: str) -> dict[str, Any]:
    """One run as it stands in the file."""
    with mp.workdps(DIGITS):
        step = period(parameters) / PER_PERIOD
        times = [k * step for k in range(1, N_PERIODS * PER_PERIOD + 1)]
        run = smooth_run(*rotor_case(parameters, [0.0] * 4, times))
        stuck = run.modes[-1] == "stuck"
        ends = run.events[-1].time if stuck else times[-1]
        kept = [i for i, t in enumerate(times) if t <= ends]
        found = {
            "purpose": purpose,
            "parameters": parameters,
            "status": "undecided" if stuck else "completed",
            "events": [event(each) for each in run.events if kind(each) != "rest"],
            "times": [text(times[i]) for i in kept],
            "regimes": [plain(run.modes[i]) for i in kept],
            "samples": [[text(x) for x in run.samples[i][: len(STATES) - 1]] for i in kept],
        }
        return found if stuck else found | tangent(parameters, times[PER_PERIOD - 1 :: PER_PERIOD])


def event(each: SmoothEvent) -> dict[str, Any]:
    """An instant. I to I: a free ring beyond its preload has come back within it."""
    return {
        "t": text(each.time),
        "from": plain(each.mode_from),
        "to": plain(each.mode_to),
        "kind": kind(each),
        "path": [plain(mode) for mode, _ in each.path if not mode.startswith("let go")],
        "guard_rate": text(each.rate),
        "before": [text(x) for x in each.before[: len(STATES) - 1]],
    }


def kind(each: SmoothEvent) -> str:
    before, after = plain(each.mode_from), plain(each.mode_to)
    if after == "stuck":
        return "undecided"
    if before == "I":
        if after != "I":
            return "contact"
        return "rest" if each.mode_to == "I" else "second spring"
    return "release" if after == "I" else "switch"


def tangent(parameters: dict[str, float], times: list[mpf]) -> dict[str, Any]:
    """The tangent of the whole run, and the largest singular values of it and of its parts."""

    def states(number: int | None) -> SmoothRun:
        start = [MOVED if i == number else mpf(0) for i in range(4)]
        return smooth_run(*rotor_case(parameters, start, times), **TANGENT)

    base, moved = states(None), [states(i) for i in range(4)]
    if any(path_of(each) != path_of(base) for each in moved):
        raise RuntimeError("a moved run passes other regimes")
    matrices = [mp.eye(4)]
    for k in range(len(times)):
        columns = [
            [(c.samples[k][i] - base.samples[k][i]) / MOVED for i in range(4)] for c in moved
        ]
        matrices.append(mp.matrix(columns).T)
    growths = [
        largest(later * earlier**-1)
        for i, earlier in enumerate(matrices)
        for later in matrices[i + 1 :]
    ]
    return {
        "tangent": [[mp.nstr(x, 12) for x in row] for row in matrices[-1].tolist()],
        "tangent_growth": {
            "total": mp.nstr(largest(matrices[-1]), 8),
            "worst": mp.nstr(max(growths), 8),
        },
    }


def path_of(run: SmoothRun) -> list[Any]:
    return [each.path for each in run.events]


def largest(matrix: mp.matrix) -> mpf:
    return max(mp.svd_r(matrix, compute_uv=False))


def text(x: mpf) -> str:
    return mp.nstr(x, PRINTED_DIGITS)


def rows_on_a_line(words: str) -> str:
    """The innermost lists on one line each."""
    return re.sub(r"\[[^][{}]*\]", lambda found: " ".join(found[0].split()), words)


def main(names: list[str]) -> None:
    runs = json.loads(FILE.read_text(encoding="utf-8")) if names else {}
    for name in names or RUNS:
        runs[name] = record(*RUNS[name])
        times = [float(each["t"]) for each in runs[name]["events"]]
        shortest = min((b - a for a, b in pairwise(times)), default=0.0)
        growth = runs[name].get("tangent_growth")
        print(f"{name}: {len(times)} events, {shortest:.1e} apart, {growth}", flush=True)
    ordered = {name: runs[name] for name in RUNS if name in runs}
    FILE.write_text(rows_on_a_line(json.dumps(ordered, indent=1)) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
