"""Periodic orbits of the mole: found and followed, beside root-finding on shooting.

python benchmarks/bench_orbits.py [--rounds N]

The orbit of period one at a 0.3, b 0.15, xi 0.05, omega 0.1 from a settled run: `find_orbit` with
its multipliers and the certified check; `scipy.optimize.root` (hybr) on the stroboscopic map of
nonsmooth, with and without its derivative; the same on a map of scipy alone, `solve_ivp` (DOP853,
rtol 1e-10) with terminal events, restarted at each. Then 500 points of the branch over b by
`continue_orbit`, through the fold, beside scipy's root at one b after the other on the map of
nonsmooth, which cannot pass the fold and knows no stability. The truth has 25 digits
(tests/periodic_orbits/references). The command fails where a result is off.
"""

import argparse
import json
import sys
import warnings
from pathlib import Path
from time import perf_counter

import numpy as np
from peer_scipy import TOLERANCES, mole
from scipy.integrate import solve_ivp
from scipy.optimize import root

import nonsmooth as ns

TRUTH = json.loads(
    (Path(__file__).parents[1] / "tests/periodic_orbits/references/orbits.json").read_text("utf-8")
)
VALUES = {"a": 0.3, "b": 0.15, "xi": 0.05, "omega": 0.1}
GAP = 0.02
FREE = ("y", "q")  # p is slaved where the orbit begins, in progression
BOUNDS = {"find_orbit": 1e-11, "map": 1e-9, "scipy": 1e-6, "fold": 1e-11}
POINTS = 500


def best(way, rounds):
    """Best time of some rounds, and the last result."""
    seconds = np.inf
    for _ in range(rounds):
        began = perf_counter()
        result = way()
        seconds = min(seconds, perf_counter() - began)
    return seconds, result


def by_map(system, guess, derivative):
    """Root of the stroboscopic map of nonsmooth."""
    turn = ns.StroboscopicMap(system)

    def start(u):
        return {"y": u[0], "q": u[1], "p": u[1] + GAP}

    def gap(u):
        image = turn.iterate(start(u), 1)
        return np.array([image[name].item() for name in FREE]) - u

    def slope(u):
        full = turn.tangent(start(u))
        both = np.array([[full.sel(state=i, state_0=j).item() for j in FREE] for i in FREE])
        return both - np.eye(2)

    answer = root(gap, guess, jac=slope if derivative else None, tol=1e-12)
    # at the end of its digits hybr says that it makes no progress
    assert np.abs(answer.fun).max() < 1e-9, answer.message
    return answer.x


def by_scipy(guess):
    """The same root, the motion being solved by scipy."""
    modes, _ = mole(VALUES | {"g": GAP})
    end = 2.0 * np.pi / VALUES["omega"]

    def gap(u):
        t, z, mode = 0.0, np.array([u[1] + GAP, u[0], u[1], 0.0]), "progression"
        while True:
            flow, guards, transition = modes[mode]
            part = solve_ivp(flow, (t, end), z, events=guards, **TOLERANCES)
            if part.status == 0:
                return part.y[1:3, -1] - u
            fired = next(i for i, found in enumerate(part.t_events) if len(found))
            t, z = part.t_events[fired][0], part.y_events[fired][0]
            mode, _ = transition(fired, z)

    answer = root(gap, guess, tol=1e-12)
    assert np.abs(answer.fun).max() < 1e-6, answer.message
    return answer.x


def branch_by_map(system, first, count):
    """One b after the other up to the fold, the answer before being the guess."""
    found, guess = 0, first
    for b in np.linspace(0.15, 0.166, count):
        guess = by_map(system.with_parameters(b=float(b)), guess, True)
        found += 1
    return found


def main(arguments=None):
    """Print the tables; 1 where something is off."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=20)
    rounds = parser.parse_args(arguments).rounds
    warnings.simplefilter("ignore")
    system = ns.models.moling(**VALUES)
    run = ns.simulate(system, periods=60)
    ns.find_orbit(system, run)
    guess = np.array([run[name].values[-1] for name in FREE]) * (1 + 1e-3)
    start = {"y": guess[0], "q": guess[1], "p": guess[1] + GAP}
    faults = []
    print(f"{'one orbit':<40} {'ms':>10} {'ratio':>8} {'error of y':>12}")
    seconds, orbit = best(lambda: ns.find_orbit(system, run), rounds)
    exact = float(TRUTH["mole_orbits"]["four_phases"]["state"][1])
    rows = [("find_orbit, from a run", seconds, float(orbit["y"]), "find_orbit")]
    seconds, orbit = best(lambda: ns.find_orbit(system, start), rounds)
    rows.append(("find_orbit, 1e-3 off", seconds, float(orbit["y"]), "find_orbit"))
    few = max(1, rounds // 5)
    for name, derivative in (("with derivative", True), ("without", False)):
        seconds, u = best(lambda d=derivative: by_map(system, guess, d), few)
        rows.append((f"scipy root on the map of nonsmooth, {name}", seconds, u[0], "map"))
    seconds, u = best(lambda: by_scipy(guess), 1)
    rows.append(("scipy root on solve_ivp", seconds, u[0], "scipy"))
    for name, seconds, y, bound in rows:
        error = abs(y - exact)
        print(f"{name:<40} {seconds * 1e3:>10.2f} {seconds / rows[0][1]:>8.1f} {error:>12.1e}")
        if not error <= BOUNDS[bound]:
            faults.append(f"{name}: off by {error:.1e}")
    faults += branches(system, guess, few)
    for fault in faults:
        print("FAILED", fault)
    return 1 if faults else 0


def branches(system, guess, rounds):
    """The second table; what is wrong with it."""

    def followed():
        return ns.continue_orbit(
            system, "b", (0.1, 0.17), steps=POINTS // 2, step=0.004, largest_step=0.004
        )

    print(f"\n{'branch over b':<40} {'points':>6} {'ms':>8} {'us/point':>10}")
    seconds, branch = best(followed, rounds)
    count = branch.sizes["point"]
    print(f"{'continue_orbit':<40} {count:>6} {seconds * 1e3:>8.0f} {seconds / count * 1e6:>10.0f}")
    few = 40
    seconds, done = best(lambda: branch_by_map(system, guess, few), 1)
    print(f"{'scipy root, one b after the other':<40} {done:>6} {seconds * 1e3:>8.0f}"
          f" {seconds / done * 1e6:>10.0f}")  # fmt: skip
    kinds = branch["special_kind"].values.tolist()
    fold = float(branch["special_value"][kinds.index("fold")])
    error = abs(fold - float(TRUTH["mole_points"]["fold"]["value"]))
    print(f"fold at b = {fold:.12f}, error {error:.1e}; special points: {', '.join(kinds)}")
    return [] if error <= BOUNDS["fold"] else [f"fold off by {error:.1e}"]


if __name__ == "__main__":
    sys.exit(main())
