"""Following a branch through its fold, beside root-finding at one parameter after the other.

python benchmarks/bench_continuation.py [--rounds N]

Bratu's problem, u'' + p exp(u) = 0, u(0) = u(1) = 0, by collocation in Chebyshev points, whose
answer is known: with cosh t = exp(u/2) in the middle, p = 8 (t/cosh t)**2. 500 points through the
fold by `follow`; the same number of parameter values below the fold, each solved by scipy from
the one before, with the same derivatives (MINPACK's hybr). The overhead is the time outside of the
residual. Then second differences with 1000 unknowns, whose derivatives are sparse. The command
fails where a point or the fold is off, and when 500 points take more than 0.25 s beyond the
residual.
"""

import argparse
import math
import sys
from pathlib import Path
from time import process_time

import numpy as np
from scipy.optimize import root

from nonsmooth.continuation import follow

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from continuation.curves import chebyshev_bratu, sparse_bratu

POINTS = 500
FOLD = 3.513830719125162  # where t tanh t = 1
BOUNDS = {"points": 1e-9, "fold": 1e-11, "overhead": 0.25}


class Counted:
    """A residual that knows how often it was asked and for how long."""

    def __init__(self, residual):
        self.residual, self.calls, self.seconds = residual, 0, 0.0

    def __call__(self, u, p):
        began = process_time()
        found = self.residual(u, p)
        self.calls += 1
        self.seconds += process_time() - began
        return found


def off(u, p):
    """How far a point is from the curve, as a difference of p."""
    t = math.acosh(math.exp(u[len(u) // 2] / 2)) if u[len(u) // 2] > 0 else 0.0
    return abs(p - 8 * (t / math.cosh(t)) ** 2)


def integrated(m):
    """The problem times the inverse of the second derivative: less rounding, for scipy too."""
    residual, n = chebyshev_bratu(m)
    inverse = np.linalg.inv(residual(np.zeros(n), 0.0)[1])

    def better(u, p):
        e = np.exp(u)
        return u + p * (inverse @ e), np.eye(n) + inverse * (p * e), inverse @ e

    return better, n


def followed(residual, n):
    """Points and the fold; the step is such that 500 of them go well up the upper branch."""
    points = list(follow(residual, np.zeros(n), 0.0, step=0.01, largest_step=0.01, steps=POINTS))
    fold = [point.p for point in points if point.special == "fold"]
    return [(point.u, point.p) for point in points], fold


def natural(residual, n):
    """One parameter value after the other, up to the fold or to where scipy finds nothing."""
    u, found = np.zeros(n), []
    for p in np.linspace(0.0, 3.51, POINTS):
        answer = root(lambda x, p=p: residual(x, p)[:2], u, jac=True, method="hybr", tol=1e-11)
        if not answer.success:
            break
        u = answer.x
        found.append((u, p))
    return found, []


def measured(way, residual, n, rounds):
    """Best time, best time outside of the residual, calls, points and folds."""
    best, own = np.inf, np.inf
    for _ in range(rounds):
        counted = Counted(residual)
        began = process_time()
        points, fold = way(counted, n)
        seconds = process_time() - began
        best, own = min(best, seconds), min(own, seconds - counted.seconds)
    return best, own, counted.calls, points, fold


def row(name, seconds, own, calls, points, error):
    """A line of the table."""
    print(
        f"{name:<26} {points:>6} {seconds * 1e3:>8.1f} {own * 1e3:>12.1f}"
        f" {seconds / points * 1e6:>9.0f} {calls / points:>12.2f} {error:>9}"
    )


def main(arguments=None):
    """Print the table; 1 where something is off or too slow."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args(arguments).rounds
    print(f"{'':<26} points       ms  overhead ms  us/point  calls/point     error")
    faults = []
    for m in (30, 60):
        residual, n = integrated(m)
        for name, way in (("follow", followed), ("scipy, fixed p", natural)):
            seconds, own, calls, points, fold = measured(way, residual, n, rounds)
            worst = max(off(u, p) for u, p in points)
            row(f"{name}, {n} unknowns", seconds, own, calls, len(points), f"{worst:.1e}")
            faults += judged(f"{name}, {n} unknowns", worst, fold, own)
    thin, n = sparse_bratu(1000), 1000
    seconds, own, calls, points, _ = measured(followed, thin, n, 1)
    row("follow, 1000 unknowns", seconds, own, calls, len(points), "")
    for fault in faults:
        print("FAILED", fault)
    return 1 if faults else 0


def judged(name, worst, fold, own):
    """What is wrong with a run."""
    faults = []
    if not worst <= BOUNDS["points"]:
        faults.append(f"{name}: a point is off by {worst:.1e}")
    if name.startswith("follow"):
        if len(fold) != 1 or not abs(fold[0] - FOLD) <= BOUNDS["fold"]:
            faults.append(f"{name}: folds {fold}, not {FOLD}")
        if not own <= BOUNDS["overhead"]:
            faults.append(f"{name}: {own:.2f} s beyond the residual")
    return faults


if __name__ == "__main__":
    sys.exit(main())
