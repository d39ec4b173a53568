"""Time per event of the stiff fatigue rig beside the same rig without stiffness.

python benchmarks/bench_rig.py [--periods N]

All have five states and four modes. The rig of the chapter relaxes at a rate of 3.4e4; the
second one, with a thousand times the damping of the specimen, at 2.4, with the same contact springs
and forcing; the third one has soft springs as well, hence slower motions and fewer looks per event.
Stiffness should cost nothing: the ratio is that of the first two. The first period of each is
compared with a run at 50 digits, and the command fails when that is off by more than 1e-12.
"""

# ruff: noqa: E402 - One thread each, decided before any library reads its environment.
import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import argparse
import gc
import sys
from pathlib import Path
from time import process_time

import numpy as np
from mpmath import mp, mpf

import nonsmooth as ns

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from contract.rig import DIGITS, automaton, rig
from reference.hybrid import hybrid_run
from reference.modal import first_crossing

ROUNDS = 15
BOUND = 1e-12
RATIO = 1.0  # time per event, stiff over slow relaxation: the aim
SYSTEMS = {
    "stiff": {},
    "slow relaxation": {"xi_s": 2.0},
    "soft springs": {"epsilon": 0.2, "theta": 2.0, "xi_s": 0.5},
}


def error_of_first_period(system):
    """Largest error of event times and final state; inf when the events differ."""
    p = system.parameter_values
    with mp.workdps(DIGITS):
        end, start = 2 * mp.pi / mpf(p["eta"]), [0] * 5 + [1, 0, 1]
        true = hybrid_run(automaton(p), start, "both", end, search=first_crossing)
    run = ns.simulate(system, periods=1, samples_per_period=1)
    times = run["event_time"].values[run["event_kind"].values != "start"]
    if times.size != len(true.events):
        return np.inf
    errors = [abs(float(e.time - mpf(float(t)))) for e, t in zip(true.events, times, strict=True)]
    errors += [abs(float(true.state[i] - mpf(float(run[f"X{i + 1}"][-1])))) for i in range(5)]
    return max(errors)


def measure(periods):
    """Rows by name: microseconds per event and per period, events, error."""
    rows = {}
    for name, changes in SYSTEMS.items():
        system = rig(**changes)
        rows[name] = {"system": system, "error": error_of_first_period(system), "seconds": []}
    for _ in range(ROUNDS):
        for row in rows.values():
            gc.collect()
            start = process_time()
            run = ns.simulate(row["system"], periods=periods, samples_per_period=1)
            long = process_time() - start
            start = process_time()
            ns.simulate(row["system"], periods=1, samples_per_period=1)
            # the cost of a run that is not its events: set-up and the dataset
            row["seconds"].append((long, process_time() - start))
            row["events"] = int(run.attrs["n_events"])
            assert run.attrs["status"] == "completed", run.attrs["message"]
    for row in rows.values():
        seconds = min(a for a, _ in row["seconds"]) - min(b for _, b in row["seconds"])
        row["per_event"], row["per_period"] = seconds / row["events"] * 1e6, seconds / periods * 1e6
    return rows


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--periods", type=int, default=5000)
    rows = measure(parser.parse_args(arguments).periods)
    print(f"{'rig':<16} {'us/event':>9} {'us/period':>10} {'events':>8} {'error':>9}")
    for name, row in rows.items():
        line = f"{name:<16} {row['per_event']:>9.3f} {row['per_period']:>10.3f}"
        print(line + f" {row['events']:>8} {row['error']:>9.1e}")
    ratio = rows["stiff"]["per_event"] / rows["slow relaxation"]["per_event"]
    print(f"ratio of the times per event: {ratio:.2f} (aim: at most {RATIO:g})")
    wrong = [name for name, row in rows.items() if not row["error"] <= BOUND]
    for name in wrong:
        print(f"FAILED {name}: error above {BOUND:g}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
