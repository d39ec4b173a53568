"""What the regime of a point of a map takes: with few periods each, and with the usual ones.

python benchmarks/bench_regimes.py [--points N]

N times N points of the soft impact oscillator in one process. Motions are looked at in groups,
whose derivatives are followed in one call of the engine. So the time per point is told once more
with one motion in each group, and the command fails where a result differs from that in any digit.
"""

import argparse
import sys
from time import process_time

import numpy as np
import xarray as xr

import nonsmooth as ns
from nonsmooth.runs import sweep_runner

SYSTEM = ns.models.soft_impact(zeta=0.03)
OVER = {"omega": (0.7, 1.0), "a": (0.4, 1.0)}
MAPS = {
    "few periods": {"transient": 30, "record": 10, "evidence": 20, "confirm": 0, "longest": 30},
    "many periods": {"confirm": 0},
}
ROUNDS = 3


def measure(points, protocol, together):
    """The map, and milliseconds of processor time per point, with so many motions together."""
    over = {name: np.linspace(*ends, points) for name, ends in OVER.items()}
    before, best = sweep_runner._MOST, np.inf
    sweep_runner._MOST = together
    try:
        for _ in range(ROUNDS):
            start = process_time()
            found = ns.regime_map(SYSTEM, over, threads=1, **protocol)
            best = min(best, process_time() - start)
    finally:
        sweep_runner._MOST = before
    return found, 1e3 * best / points**2


def main(arguments=None):
    parser = argparse.ArgumentParser()
    parser.add_argument("--points", type=int, default=32)
    points = parser.parse_args(arguments).points
    print(f"{'map':<14} {'without a period':>17} {'ms per point':>13} {'one by one':>11}")
    good = True
    for name, protocol in MAPS.items():
        found, time = measure(points, protocol, sweep_runner._MOST)
        alone, other = measure(points, protocol, 1)
        try:
            xr.testing.assert_identical(found, alone)
        except AssertionError as fault:
            print(fault)
            good = False
        share = float((found["period"] == 0).mean())
        print(f"{name:<14} {share:>16.0%} {time:>13.2f} {other:>11.2f}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
