"""A bifurcation diagram of the soft impact oscillator, side by side, wrong columns counted.

python benchmarks/bench_ensembles.py [--columns N] [--rounds N] [--digits N]

500 values of omega, 400 periods each from rest, the last 100 recorded. Truth: see `column_truth`;
columns in which the two exact solutions differ, and N columns about which others are wrong, are
worked out again with 40 digits. The command fails when nonsmooth has a wrong column.
"""

import argparse
import gc
import importlib
import platform
import sys
from dataclasses import replace
from functools import partial

import column_truth
import numpy as np
import peer_rk4
import taylor_reference
from crowd import Clocks
from hand_kernels import compiled, soft_impact
from ours import VERSION
from problems import SOFT_IMPACT

import nonsmooth as ns

PERIODS, TRANSIENT = 400, 300
RECORDED = slice(TRANSIENT, PERIODS)  # strobes; the first one is the start
RANGE = 0.7, 0.95
SAME = 1e-6  # of the size of a state: exact solutions that differ by more are looked at again
STEPS = (200, 1000)


def ours(p, omegas):
    system = ns.models.soft_impact(**p)

    def run(threads):
        return ns.bifurcation_diagram(
            system, "omega", omegas, transient=TRANSIENT, record=PERIODS - TRANSIENT,
            threads=threads,
        )  # fmt: skip

    def read(diagram):
        assert np.all(diagram["status"] == "completed")
        points = np.stack([diagram[name].values[:, 0] for name in ("x", "v")], axis=2)
        return points, diagram["period"].values[:, 0]

    return run, read


def hand(p, omegas):
    strobes = np.zeros((omegas.size, PERIODS + 1, 2))
    fixed = tuple(p[name] for name in ("zeta", "e", "beta", "a"))

    def run(_):
        for own, omega in zip(strobes, omegas, strict=True):
            soft_impact.simulate(own[1:], *fixed, omega, 0.0, 0.0)

    return run, lambda _: labelled(strobes[:, RECORDED])


def rk4(steps, p, omegas):
    fixed = PERIODS, steps, p["zeta"], p["e"], p["beta"], p["a"]
    return lambda n: peer_rk4.sweep(*fixed, omegas, n), lambda found: labelled(found[:, RECORDED])


def heyoka(kind, p, omegas):
    module = importlib.import_module("peer_heyoka_sweep")
    return getattr(module, kind)(p, omegas, PERIODS), lambda found: labelled(found[:, RECORDED])


def labelled(points):
    return points, np.array([column_truth.period(each) for each in points])


IMPLEMENTATIONS = {
    "hand kernel": (hand, (1,)),
    "nonsmooth": (ours, (1, 2)),
    "heyoka ensemble": (partial(heyoka, "scalar"), (1, 2)),
    "heyoka batches": (partial(heyoka, "batch"), (1, 2)),
    **{f"RK4, {steps} steps": (partial(rk4, steps), (2,)) for steps in STEPS},
}


def measure(p, omegas, rounds):
    """Best times and (points, labels) of every implementation that is there."""
    clocks, results, runs = Clocks(), {}, {}
    for name, (prepare, threads) in IMPLEMENTATIONS.items():
        try:
            runs[name] = (*prepare(p, omegas), threads)
        except ImportError as reason:
            print(f"{name}: not available ({reason})", file=sys.stderr)
            continue
        runs[name][0](threads[0])  # what is only done once
    for _ in range(rounds):
        clocks.spin()
        for name, (run, read, threads) in runs.items():
            for n in threads:
                gc.collect()
                results[name] = read(clocks.time((name, n), lambda run=run, n=n: run(n)))
    return clocks, results


def check_digits(p, omegas, columns, true):
    """Whether the truth holds in some columns by Taylor series at 40 digits."""
    faults = []
    for i in columns:
        problem = replace(SOFT_IMPACT, parameters=p | {"omega": float(omegas[i])})
        strobes, _ = taylor_reference.strobes(problem, PERIODS)
        apart = column_truth.distance(strobes[TRANSIENT - 1 : -1], true.points[i], true.scale[i])
        print(f"40 digits, omega = {omegas[i]:.6f}: the truth is off by {apart:.1e}")
        if not apart <= SAME:
            faults.append(f"the truth at omega = {omegas[i]:.6f} is off by {apart:.1e}")
    return faults


def disputed(true, results, verdicts, digits):
    """Columns in which exact solutions differ, and some about which others are wrong."""
    points, labels = results["hand kernel"]
    apart = np.array(
        [column_truth.distance(*each) for each in zip(points, true.points, true.scale, strict=True)]
    )
    found = np.flatnonzero(true.decided & ((apart > SAME) | (labels != true.label)))
    wrong = np.unique(np.concatenate([each.wrong for each in verdicts.values()]))
    chosen = wrong[np.linspace(0, wrong.size - 1, min(digits, wrong.size)).astype(int)]
    return np.union1d(found, chosen).astype(int)


def table(clocks, verdicts):
    head = f"{'implementation':<16} {'threads':>7} {'processor s':>11} {'ratio':>6} {'wall s':>7}"
    lines = [head + f" {'periods':>8} {'open':>5} {'points':>7} {'chaos':>6} {'median error':>13}"]
    unit = clocks.processor["hand kernel", 1]
    for (name, threads), processor in clocks.processor.items():
        if name == "spin":
            continue
        line = f"{name:<16} {threads:>7} {processor:>11.3f} {processor / unit:>6.1f}"
        line += f" {clocks.wall[name, threads]:>7.3f}"
        found = verdicts[name]
        line += f" {found.labels:>8} {found.open:>5} {found.points:>7} {found.chaos:>6}"
        line += f" {found.error:>13.1e}"
        lines.append(line)
    return "\n".join(lines)


def main(given=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--columns", type=int, default=500)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--digits", type=int, default=0, help="columns, half a minute each")
    options = parser.parse_args(given)
    p, omegas = SOFT_IMPACT.parameters, np.linspace(*RANGE, options.columns)
    p = {name: value for name, value in p.items() if name != "omega"}
    clocks, results = measure(p, omegas, options.rounds)
    versions = {"numpy": np.__version__}
    if "heyoka batches" in results:
        versions["heyoka"] = importlib.import_module("heyoka").__version__
    print(f"python {platform.python_version()}, nonsmooth {VERSION},", end=" ")
    print(", ".join(f"{name} {version}" for name, version in versions.items()))
    print(f"hand kernel and RK4: {compiled.version()}")
    true = column_truth.truth(p, omegas, PERIODS, RECORDED)
    verdicts = {name: column_truth.judge(true, *result) for name, result in results.items()}
    print(
        f"{omegas.size} columns, {PERIODS} periods each: {true.decided.sum()} decided,"
        f" {true.chaotic.sum()} chaotic, the others a matter of rounding"
    )
    print(table(clocks, verdicts))
    print("wrong columns: another period, points off by 1e-3 of their size, a period in chaos (a")
    print("transient may have ended); open: no period told of a column that is decided; median")
    print("error of the decided columns, relative")
    print(clocks.report([n for n in results if len(IMPLEMENTATIONS[n][1]) == 2]))
    faults = check_digits(p, omegas, disputed(true, results, verdicts, options.digits), true)
    if verdicts["nonsmooth"].wrong.size:
        faults.append(f"nonsmooth is wrong in columns {verdicts['nonsmooth'].wrong.tolist()}")
    for fault in faults:
        print("FAILED", fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
