"""Time per forcing period of one long trajectory, side by side, accuracy asserted.

python benchmarks/bench_simulate.py [--periods N] [--problem NAME] [--no-scipy] [--json FILE]
"""

# ruff: noqa: E402 - One thread each, decided before any library reads its environment.
import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import argparse
import gc
import importlib
import json
import platform
import sys
from time import process_time

import numpy as np
import taylor_reference
from hand_kernels import compiled
from problems import PROBLEMS

COMPARED = 20  # periods compared with the reference
ROUNDS = 9
SCIPY_PERIODS, SCIPY_ROUNDS = 200, 2
SCIPY_BOUND = 1e-6  # rtol 1e-10 per step, times the growth along the orbit
YARDSTICK = 5.0  # a hand kernel less than this much faster than heyoka measures nothing
IMPLEMENTATIONS = {
    "hand kernel": "hand",
    "nonsmooth": "ours",
    "heyoka": "peer_heyoka",
    "scipy DOP853": "peer_scipy",
}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--periods", type=int, default=10_000)
    parser.add_argument("--problem", choices=PROBLEMS, action="append", help="may be repeated")
    parser.add_argument("--no-scipy", action="store_true")
    parser.add_argument("--json", metavar="FILE")
    options = parser.parse_args()
    if options.periods < COMPARED:
        parser.error(f"--periods must be at least {COMPARED}, the periods that are compared")
    return options


def load(no_scipy):
    """Modules by implementation; None where the library is missing."""
    loaded = {}
    for name, module in IMPLEMENTATIONS.items():
        if no_scipy and module == "peer_scipy":
            continue
        try:
            loaded[name] = importlib.import_module(module)
        except ImportError as reason:
            if module == "hand":
                raise
            print(f"{name}: not available yet ({reason})", file=sys.stderr)
            loaded[name] = None
    return loaded


def measure(problem, modules, periods):
    """One row per implementation: the best time of interleaved rounds, error, events."""
    truth, true_events = taylor_reference.strobes(problem, COMPARED)
    rows, runs = [], {}
    for name, module in modules.items():
        row = {"problem": problem.name, "implementation": name}
        rows.append(row)
        if module is None:
            continue
        run, read = module.prepare(problem)
        short_strobes, short_events = read(run(COMPARED))
        row |= {
            "periods": min(periods, SCIPY_PERIODS) if name.startswith("scipy") else periods,
            "rounds": SCIPY_ROUNDS if name.startswith("scipy") else ROUNDS,
            "seconds": [],
            "bound": SCIPY_BOUND if name.startswith("scipy") else problem.error_bound,
            "short_error": float(np.abs(short_strobes - truth).max()),
            "short_events": short_events,
            "true_events": true_events,
        }
        runs[name] = run, read, row
    for turn in range(ROUNDS):
        for run, read, row in runs.values():
            if turn >= row["rounds"]:
                continue
            gc.collect()
            start = process_time()
            result = run(row["periods"])
            row["seconds"].append(process_time() - start)
            strobes, row["events"] = read(result)
            assert strobes.shape == (row["periods"], len(problem.states)), strobes.shape
            row["error"] = float(np.abs(strobes[:COMPARED] - truth).max())
    for *_, row in runs.values():
        row["us_per_period"] = min(row["seconds"]) / row["periods"] * 1e6
    hand = runs["hand kernel"][2]["us_per_period"]
    for *_, row in runs.values():
        row["ratio"] = row["us_per_period"] / hand
    return rows


def table(rows):
    head = f"{'problem':<12} {'implementation':<15} {'us/period':>10} {'ratio':>8} {'error':>9}"
    lines = [head + f" {'events':>8} {'periods':>8}"]
    for row in rows:
        line = f"{row['problem']:<12} {row['implementation']:<15}"
        if "us_per_period" not in row:
            lines.append(line + " not available yet")
            continue
        line += f" {row['us_per_period']:>10.3f} {row['ratio']:>8.2f} {row['error']:>9.1e}"
        lines.append(line + f" {row['events']:>8} {row['periods']:>8}")
    return "\n".join(lines)


def faults(rows):
    """What makes a time worthless: a wrong answer, or a yardstick that is no yardstick."""
    found = []
    for row in rows:
        if "us_per_period" not in row:
            continue
        label = f"{row['problem']}, {row['implementation']}"
        error = max(row["error"], row["short_error"])
        if not error <= row["bound"]:
            found.append(f"{label}: error {error:.1e} above {row['bound']:.0e}")
        if row["short_events"] != row["true_events"]:
            found.append(f"{label}: {row['short_events']} events, reference {row['true_events']}")
        if row["implementation"] == "heyoka" and row["ratio"] < YARDSTICK:
            found.append(f"{label}: only {row['ratio']:.1f} times the hand kernel's time")
    return found


def main():
    options = arguments()
    modules = load(options.no_scipy)
    versions = {"python": platform.python_version()}
    versions |= {"numpy": np.__version__, "hand kernel": compiled.version()}
    versions |= {n: m.VERSION for n, m in modules.items() if hasattr(m, "VERSION")}
    print(", ".join(f"{name} {version}" for name, version in versions.items()))
    rows = []
    for key in options.problem or PROBLEMS:
        rows += measure(PROBLEMS[key], modules, options.periods)
    print(table(rows))
    print(f"error: largest over all states and the first {COMPARED} strobes, against 40 digits")
    print(f"scipy: {SCIPY_PERIODS} periods at most; its time per period stands for longer runs")
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump({"versions": versions, "rows": rows}, file, indent=1)
    found = faults(rows)
    for fault in found:
        print("FAILED", fault)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
