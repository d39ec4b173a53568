"""The rotor by hand: strobes of a long run, the columns of a diagram, period doublings.

    python benchmarks/hand_rotor.py [--flips]

compares the kernel of `hand_kernels/rotor.py` with the runs to 25 digits in
`tests/reference/rotor_runs.json`, and with --flips finds those of `tests/models/rotor_truth.py`.
"""

import sys
from math import pi
from pathlib import Path

import numpy as np
from crowd import spread
from hand_kernels import rotor
from scipy.optimize import brentq

TOLERANCE = 1e-12
NAMES = ("eta", "nu1", "nu2", "K", "eta_m", "rho", "eps_x", "eps_y", "delta_x", "delta_y", "phi0")
SET_A = {
    "eta": 2.442, "nu1": 0.125, "nu2": 0.002, "K": 30.0, "eta_m": 0.0017, "rho": 70.0,
    "eps_x": 0.9, "eps_y": 0.0, "delta_x": 0.1, "delta_y": 0.1, "phi0": 0.0,
}  # fmt: skip
SET_B = SET_A | {
    "eta": 2.5, "nu1": 0.06, "eta_m": 0.00289, "eps_x": 0.4, "eps_y": 0.5,
    "delta_x": 0.05, "delta_y": 0.05,
}  # fmt: skip
NO_LOG = np.empty((0, 4))


def constants(**changes):
    """The kernel's constants for set A with changes."""
    q = SET_A | changes
    load = q["eta_m"] * q["rho"] * q["eta"] ** 2
    head = (q["eta"], q["nu1"], q["nu2"], q["K"], load, q["eps_x"], q["eps_y"])
    return tuple(float(x) for x in (*head, q["delta_x"], q["delta_y"], q["phi0"]))


def strobes(p, periods, start=(0.0, 0.0, 0.0, 0.0), tolerance=TOLERANCE, events=0):
    """(strobes, log of events, count of events, count of steps, status)."""
    points, log = np.empty((periods, 8)), np.zeros((events, 4))
    found = rotor.simulate(points, log, np.array(start, dtype=float), p, tolerance)
    log = log[: found[0]]
    log[:, 1] += 2.0 * pi / p[0] * log[:, 0]
    return points, log[:, 1:], *found


def columns(etas, transient, kept, follow=False, threads=1, tolerance=TOLERANCE, **changes):
    """(points[column, strobe], events): each column from zero, or from the end of the last one."""
    points = np.empty((etas.size, kept, 8))
    events = np.zeros(etas.size, dtype=int)

    def column(i, start=(0.0, 0.0, 0.0, 0.0)):
        found, _, events[i], _, status = strobes(
            constants(**changes, eta=etas[i]), transient + kept, start, tolerance
        )
        points[i] = found[transient:]
        assert status == 0, etas[i]

    if follow:
        for i in range(etas.size):
            column(i, points[i - 1, -1, :4] if i else (0.0, 0.0, 0.0, 0.0))
    else:
        spread(column, etas.size, threads)
    return points, events


def errors(truth):
    """Largest error of the strobes of a run, and whether its events are those of 25 digits."""
    p = constants(**truth["parameters"])
    found, log, *_ = strobes(p, 10, events=1000)
    true = np.array(truth["samples"], dtype=float)[3::4]
    regimes = {"I": 1, "II": 2, "III": 3, "IV": 4, "V": 5, "stuck": 1}
    expected = [(regimes[e["from"]], regimes[e["to"]]) for e in truth["events"]]
    expected = [pair for pair in expected if pair[0] != pair[1]]
    same = expected == [(int(a), int(b)) for _, a, b in log]
    return np.abs(found[: len(true), :7] - true).max(initial=0.0), same


def jacobian(p, period, z, h=2e-5):
    """Central differences of order 6 of the map over some periods."""
    J = np.empty((4, 4))
    for i in range(4):
        ends = {}
        for k in (-3, -2, -1, 1, 2, 3):
            moved = np.array(z, dtype=float)
            moved[i] += k * h
            ends[k] = strobes(p, period, moved, 1e-14)[0][-1, :4]
        J[:, i] = (45 * (ends[1] - ends[-1]) - 9 * (ends[2] - ends[-2]) + ends[3] - ends[-3]) / (
            60 * h
        )
    return J


def flip(delta, period, eta, z, reach=1e-4):
    """(eta, orbit, multipliers) of the period doubling near eta, from an orbit near z."""

    def orbit(eta):
        p, x = constants(eta=eta, delta_x=delta, delta_y=delta), np.array(z, dtype=float)
        for _ in range(15):
            J = jacobian(p, period, x)
            miss = strobes(p, period, x, 1e-14)[0][-1, :4] - x
            step = np.linalg.solve(J - np.eye(4), miss)
            x -= step
            if np.abs(step).max() < 3e-13:
                break
        return x, jacobian(p, period, x)

    def test(eta):
        return np.linalg.det(orbit(eta)[1] + np.eye(4))

    eta = brentq(test, eta - reach, eta + reach, xtol=1e-13, rtol=1e-14)
    x, J = orbit(eta)
    return eta, x, np.linalg.eigvals(J)


def main(arguments):
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
    from models.rotor_truth import FLIPS, RUNS

    failed = []
    for name, truth in RUNS.items():
        error, same = errors(truth)
        growth = float(truth.get("tangent_growth", {"worst": 1.0})["worst"])
        print(f"{name:<28} error {error:.1e}, of the tangent's growth {error / growth:.1e}", end="")
        print("" if same else ", other events")
        if not same or error > 10.0 * TOLERANCE * growth:
            failed.append(name)
    for each in FLIPS if "--flips" in arguments else []:
        eta, _, multipliers = flip(each.delta, each.period, each.eta, each.state)
        nearest = np.abs(multipliers + 1.0).min()
        print(f"delta {each.delta} period {each.period}: {eta:.11f}, lambda + 1 = {nearest:.1e}")
        if abs(eta - each.eta) > 1e-9:
            failed.append(f"flip at {each.eta}")
    print("FAILED: " + ", ".join(failed) if failed else "all agree")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
