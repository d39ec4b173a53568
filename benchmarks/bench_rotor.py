"""The rotor in its snubber ring beside DOP853 written by hand for it: a long run and a diagram.

python benchmarks/bench_rotor.py [--periods N] [--columns N] [--rounds N]

Run: strobes of set A (chaotic) and set B from rest; the first ten are compared with 25 digits.
Diagram: Fig. 36(b) of the chapter, eta from 2 to 5 at preload 0.1, 300 + 150 periods per column,
restarted from zero on one thread and two, and followed upwards, which only one thread can do.
A column counts as decided where the hand kernel at two tolerances settles to the same points; the
command fails when nonsmooth is elsewhere in one of them that it starts from zero.
"""

import argparse
import gc
import json
import sys
from pathlib import Path

import hand_rotor
import numpy as np
from column_truth import period
from crowd import Clocks

import nonsmooth as ns

RUNS = json.loads(
    (Path(__file__).parents[1] / "tests" / "reference" / "rotor_runs.json").read_text("utf-8")
)
STATES = ["x", "y", "vx", "vy", "sx", "sy", "mu"]
TRANSIENT, KEPT = 300, 150
OWN_BOUND, HAND_BOUND = 1e-12, 1e-11  # of the growth of the tangent; hand: ten times its tolerance
SAME = 1e-7  # points of a settled column
AIM = 1.0  # time of nonsmooth over that of the hand kernel


def first_strobes(name, found):
    """Error of the first ten strobes over the growth of the tangent."""
    true = np.array(RUNS[name]["samples"], dtype=float)[3::4]
    return np.abs(found[:10] - true).max() / float(RUNS[name]["tangent_growth"]["worst"])


def long_runs(clocks, periods, rounds):
    """Lines of the table of long runs, and what failed."""
    lines, faults = [], []
    for name in ("set A", "set A without preload", "set B"):
        parameters = RUNS[name]["parameters"]
        system, p = ns.models.rotor(**parameters), hand_rotor.constants(**parameters)
        runs = {
            "hand kernel": lambda p=p: hand_rotor.strobes(p, periods)[0][:, :7],
            "hand, 1e-14": lambda p=p: hand_rotor.strobes(p, periods, tolerance=1e-14)[0][:, :7],
            "nonsmooth": lambda s=system: ns.simulate(s, periods=periods, samples_per_period=1),
        }
        found = {}
        for _ in range(rounds):
            for who, run in runs.items():
                gc.collect()
                found[who] = clocks.time((name, who), run)
        run = found["nonsmooth"]
        assert run.attrs["status"] == "completed", run.attrs["message"]
        found["nonsmooth"] = np.stack([run[each].values for each in STATES], axis=1)[1:]
        for who in runs:
            bound = HAND_BOUND if who == "hand kernel" else OWN_BOUND
            error, seconds = first_strobes(name, found[who]), clocks.processor[name, who]
            ratio = seconds / clocks.processor[name, "hand kernel"]
            line = f"{name:<22} {who:<12} {seconds / periods * 1e6:>8.1f} {ratio:>6.2f}"
            lines.append(f"{line} {error:>9.1e}")
            if not error <= bound:
                faults.append(f"{name}, {who}: error of {error:.1e} times the growth")
    return lines, faults


def ours(etas, start, threads):
    """A diagram by the public function."""
    return ns.bifurcation_diagram(
        ns.models.rotor(), "eta", etas, start=start, transient=TRANSIENT, record=KEPT,
        threads=threads,
    )  # fmt: skip


def labels(points):
    """The period of each column, 0 where it has none."""
    return np.array([period(each[:, :4]) for each in points])


def diagrams(clocks, etas, rounds):
    """Processor and wall times of the diagrams, and what failed."""
    runs = {}
    for n in (1, 2):
        runs["hand kernel", n] = lambda n=n: hand_rotor.columns(etas, TRANSIENT, KEPT, threads=n)
        runs["nonsmooth", n] = lambda n=n: ours(etas, "restart", n)
    runs["hand kernel, following", 1] = lambda: hand_rotor.columns(etas, TRANSIENT, KEPT, True)
    runs["nonsmooth, following", 1] = lambda: ours(etas, "follow up", 1)
    found = {}
    for _ in range(rounds):
        clocks.spin()
        for key, run in runs.items():
            gc.collect()
            found[key] = clocks.time(key, run)
    hand = found["hand kernel", 1][0]
    again = hand_rotor.columns(etas, TRANSIENT, KEPT, tolerance=1e-13)[0]
    settled = labels(hand)
    apart = np.abs(hand - again)[:, :, :4].max(axis=(1, 2))
    decided = (settled > 0) & (settled == labels(again)) & (apart < SAME)
    faults = []
    for n in (1, 2):
        diagram = found["nonsmooth", n]
        points = np.stack([diagram[each].values[:, 0] for each in STATES[:4]], axis=2)
        # the diagram's first point is the strobe at which the transient ends
        off = np.abs(points[:, 1:] - again[:, :-1, :4]).max(axis=(1, 2))
        wrong = decided & ~(off < SAME)
        if wrong.any():
            faults.append(f"{n} threads: other points at eta {etas[wrong].tolist()}")
        print(
            f"nonsmooth, {n} threads: {decided.sum()} of {etas.size} columns decided,"
            f" {wrong.sum()} wrong, largest difference {off[decided & ~wrong].max():.1e}"
        )
    return list(runs), faults


def main(given=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--periods", type=int, default=2000)
    parser.add_argument("--columns", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args(given)
    clocks = Clocks()
    lines, faults = long_runs(clocks, options.periods, options.rounds)
    print(f"{'run':<22} {'program':<12} {'us/period':>8} {'ratio':>5} {'error/growth':>12}")
    print("\n".join(lines))
    etas = np.linspace(2.0, 5.0, options.columns)
    keys, wrong = diagrams(clocks, etas, max(1, options.rounds // 2))
    print(f"{'diagram':<24} {'threads':>7} {'processor s':>12} {'wall s':>7} {'ratio':>6}")
    for name, n in keys:
        base = "hand kernel, following" if "following" in name else "hand kernel"
        ratio = clocks.processor[name, n] / clocks.processor[base, 1]
        line = f"{name:<24} {n:>7} {clocks.processor[name, n]:>12.2f} {clocks.wall[name, n]:>7.2f}"
        print(f"{line} {ratio:>6.2f}")
    print(clocks.report(["hand kernel", "nonsmooth"]))
    print(f"The aim for the ratio is {AIM:g}.")
    for fault in faults + wrong:
        print("FAILED", fault)
    return 1 if faults or wrong else 0


if __name__ == "__main__":
    sys.exit(main())
