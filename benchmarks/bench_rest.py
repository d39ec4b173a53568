"""Impacts, rest and dry friction beside kernels written by hand: time per period, error, events.

python benchmarks/bench_rest.py [--periods N] [--rounds N] [--no-scipy] [--no-heyoka]

Rigid impacts (r .8, omega 2.8, sigma 0), rebounds that accumulate and end at rest (omega .3), and
a block on a belt that slips and sticks (F_c .4, v_b .3, F .5, omega .7). All programs run side by
side in one process and one thread. The first twenty strobes are compared with 40 digits; the
command fails where one is off by more than its bound, or where numbers of events differ.
"""

import argparse
import gc
import sys

import numpy as np
import rest_reference
from crowd import Clocks
from hand_kernels import belt, rigid_impact

import nonsmooth as ns

COMPARED = 20
BOUND = 1e-12  # the growth along these orbits, times rounding, with room for a factor of a hundred
SCIPY_BOUND = 1e-6  # rtol 1e-10 per step, times the growth along the orbit
SCIPY_PERIODS, HEYOKA_PERIODS = 100, 1000
HEYOKA_BOUND = 1e-10  # rounding at events, which rebounds pass on to the times of the next ones
AIM = 1.2  # time of nonsmooth over that of the hand kernel
START = {"x": -0.2, "v": 0.0}


class Problem:
    """A system with its parameters, and how each program is told to run it."""

    def __init__(self, name, system, kernel, parameters, peer):
        self.name, self.system, self.kernel = name, system, kernel
        self.parameters, self.peer = parameters, peer

    def ours(self, periods):
        return ns.simulate(self.system, START, periods=periods, samples_per_period=1)

    def by_hand(self, periods):
        strobes = np.empty((periods, 2))
        events, _ = self.kernel(strobes, *self.parameters.values(), *START.values())
        return strobes, events


def wall(omega):
    """Rigid wall at zero: motion comes to rest there where impacts accumulate."""
    return ns.models.impact_oscillator(F=1.0, omega=omega, zeta=0.0, sigma=0.0, r=0.8)


def problems():
    impacts = {"F": 1.0, "omega": 2.8, "sigma": 0.0, "r": 0.8}
    chatter = impacts | {"omega": 0.3}
    friction = {"F_c": 0.4, "v_b": 0.3, "F": 0.5, "omega": 0.7}
    block = ns.System(
        name="belt",
        states=["x", "v"],
        parameters=friction,
        period="2*pi/omega",
        equations={"x": "v", "v": "F*cos(omega*t) - x - F_c*sign(v - v_b)"},
    )
    simulate = rigid_impact.simulate
    return (
        Problem("rigid impacts", wall(2.8), simulate, impacts, "impacts"),
        Problem("rest at the wall", wall(0.3), simulate, chatter, "impacts"),
        Problem("stick and slip", block, belt.simulate, friction, "belt"),
    )


def strobes_of(run):
    """States at the ends of periods, and the number of events."""
    assert run.attrs["status"] == "completed", run.attrs["message"]
    found = np.stack([run[name].values for name in ("x", "v")], axis=1)[1:]
    return found, int((run["event_kind"].values != "start").sum())


def measure(problem, clocks, periods, rounds, scipy, heyoka):
    """Lines of the table, and what failed."""
    true, true_events = rest_reference.strobes(problem.peer, problem.parameters, START, COMPARED)
    runs = {"hand kernel": problem.by_hand, "nonsmooth": problem.ours}
    if scipy is not None:
        runs["scipy DOP853"] = lambda n: scipy.strobes(problem.peer, problem.parameters, START, n)
    if heyoka is not None:
        runs["heyoka"] = heyoka.prepare(problem.peer, problem.parameters, START)
    shorter = {"scipy DOP853": SCIPY_PERIODS, "heyoka": HEYOKA_PERIODS}
    lengths = {who: min(periods, shorter.get(who, periods)) for who in runs}
    found = {}
    for turn in range(rounds):
        for who, run in runs.items():
            if "scipy" in who and turn > 0:
                continue
            gc.collect()
            found[who] = clocks.time((problem.name, who), lambda r=run, w=who: r(lengths[w]))
    lines, faults = [], []
    hand = clocks.processor[problem.name, "hand kernel"] / periods
    for who, result in found.items():
        strobes, events = strobes_of(result) if who == "nonsmooth" else result
        error = float(np.abs(strobes[:COMPARED] - true).max())
        seconds = clocks.processor[problem.name, who] / lengths[who]
        lines.append(
            f"{problem.name:<17} {who:<13} {seconds * 1e6:>9.2f} {seconds / hand:>7.2f}"
            f" {error:>9.1e} {events:>9} {lengths[who]:>8}"
        )
        if not error <= {"scipy DOP853": SCIPY_BOUND, "heyoka": HEYOKA_BOUND}.get(who, BOUND):
            faults.append(f"{problem.name}, {who}: error {error:.1e}")
    short = strobes_of(problem.ours(COMPARED))[1]
    if problem.peer == "belt" and short != true_events:
        faults.append(f"{problem.name}: {short} events, reference {true_events}")
    return lines, faults


def main(given=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--periods", type=int, default=5000)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--no-scipy", action="store_true")
    parser.add_argument("--no-heyoka", action="store_true")
    options = parser.parse_args(given)
    if options.periods < COMPARED:
        parser.error(f"--periods must be at least {COMPARED}, the periods that are compared")
    scipy = heyoka = None
    if not options.no_scipy:
        import peer_scipy_rest as scipy
    if not options.no_heyoka:
        import peer_heyoka_rest as heyoka
    clocks, lines, faults = Clocks(), [], []
    for problem in problems():
        problem.ours(1)  # what is only done once
        more, wrong = measure(problem, clocks, options.periods, options.rounds, scipy, heyoka)
        lines += more
        faults += wrong
    head = f"{'problem':<17} {'program':<13} {'us/period':>9} {'ratio':>7} {'error':>9}"
    print(head + f" {'events':>9} {'periods':>8}")
    print("\n".join(lines))
    print(f"error: largest over both states and the first {COMPARED} strobes, against 40 digits")
    print(f"The aim for the ratio of nonsmooth is {AIM:g}.")
    for fault in faults:
        print("FAILED", fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
