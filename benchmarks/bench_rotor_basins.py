"""A section of the basins of a rotor that rubs on a ring, beside heyoka in batches.

python benchmarks/bench_rotor_basins.py [--cells N] [--rounds N]

The rotor of `clearance_rotor` above its critical speed runs free or rubs all the way round, as it
began. Two measures, one thread each: all cells for the same number of periods, by the runner of the
stroboscopic map and by heyoka; and `basins_of_attraction` as a whole, which finds the attractors
and stops each motion when it knows where it goes, beside heyoka's run alone, which is long enough
for nearly all cells and is not asked to find anything. The command fails when the two label more
cells differently than the starts on the border between them.
"""

# ruff: noqa: E402 - One thread each, decided before any library reads its environment.
import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import argparse
import gc
import platform
import sys

import heyoka as hy
import numpy as np
from bench_basins import by_runner, cycle_of
from crowd import Clocks
from ours import VERSION

import nonsmooth as ns

PARAMETERS = {"omega": 2.0, "zeta": 0.04, "kappa": 5.0, "rho": 0.4}
REACH = 2.5  # clearances
PERIODS = 150
ON = (
    1e-3  # distance from a cycle that counts as being on it: transients decay by 1e-2 in 30 periods
)
SAME = 1e-8  # difference of the two on the same cycle, where both have settled
AGREE = 0.99  # of the cells: on the border rounding decides


def axes(cells):
    """Cells of x and y, none of them at the centre, where heyoka's equations are singular."""
    side = np.linspace(-REACH, REACH, 2 * (cells // 2))
    return {"x": side, "y": side}


def grid(cells):
    """States x, u, y, v of the cells, row by row; (L, 4)."""
    x, y = np.meshgrid(*axes(cells).values())
    rest = np.zeros(x.size)
    return np.column_stack([x.ravel(), rest, y.ravel(), rest])


class Switch:
    """Callback at the ring, of an integrator of batches: outside it the ring pushes."""

    def __call__(self, integrator, direction, lane):
        integrator.pars[0, lane] = PARAMETERS["kappa"] if direction > 0 else 0.0
        return True


def batches():
    """run(starts, periods) that gives the last states; one compiled integrator for all of them."""
    p, size = PARAMETERS, hy.recommended_simd_size()
    x, u, y, v = hy.make_vars("x", "u", "y", "v")
    square, drive = x * x + y * y, p["rho"] * p["omega"] ** 2
    pull = 1.0 + hy.par[0] * (1.0 - square**-0.5)
    turn = p["omega"] * hy.time
    rates = [
        (x, u), (u, drive * hy.cos(turn) - 2.0 * p["zeta"] * u - pull * x),
        (y, v), (v, drive * hy.sin(turn) - 2.0 * p["zeta"] * v - pull * y),
    ]  # fmt: skip
    integrator = hy.taylor_adaptive_batch(
        rates, np.ones((4, size)), pars=np.zeros((1, size)), fast_math=True,
        t_events=[hy.t_event_batch(square - 1.0, callback=Switch())],
    )  # fmt: skip

    def run(starts, periods):
        last, end = np.empty(starts.shape), np.full(size, 2.0 * np.pi * periods / p["omega"])
        for first in range(0, len(starts), size):
            some = starts[first : first + size]
            padded = np.resize(some, (size, 4))
            integrator.set_time(0.0)
            integrator.state[:] = padded.T
            outside = padded[:, 0] ** 2 + padded[:, 2] ** 2 > 1.0
            integrator.pars[0] = np.where(outside, p["kappa"], 0.0)
            integrator.reset_cooldowns()
            integrator.propagate_until(end)
            last[first : first + size] = integrator.state.T[: len(some)]
        return last

    return run


def compare(basins, ours, theirs):
    """Faults, after saying how the runs agree with each other and with the labels."""
    labels = basins["label"].values.ravel()
    ends = {
        name: cycle_of(basins, states, ON, 4)
        for name, states in (("nonsmooth", ours), ("heyoka", theirs))
    }
    for number in basins["attractor"].values:
        count = int(np.sum(labels == number))
        point = basins.sel(attractor=number)["points"].values[0]
        print(f"label {number}: {count} cells, radius {np.hypot(point[0], point[2]):.6f}")
    faults = []
    for name, end in ends.items():
        agree = float(np.mean(end == labels))
        print(f"{name:<10} after {PERIODS} periods: {agree:.2%} of the cells are as labelled")
        if agree < AGREE:
            faults.append(f"{name} agrees with the labels in {agree:.2%} of the cells")
    same = (ends["nonsmooth"] == ends["heyoka"]) & (ends["heyoka"] > 0)
    apart = float(np.abs(ours - theirs)[same].max(initial=0.0))
    print(f"largest difference of the two on the same cycle: {apart:.1e}")
    if not apart <= SAME:
        faults.append(f"states on the same cycle differ by {apart:.1e}")
    return faults


def main(given=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=40, help="along each side")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args(given)
    system = ns.models.clearance_rotor(**PARAMETERS)
    print(f"python {platform.python_version()}, nonsmooth {VERSION}, heyoka {hy.__version__}")
    starts, year = grid(options.cells), ns.StroboscopicMap(system)
    run, clocks = batches(), Clocks()
    run(starts[:4], 1), by_runner(year, starts[:1], 1, 1)
    for _ in range(options.rounds):
        gc.collect()
        theirs = clocks.time("heyoka, batches", lambda: run(starts, PERIODS))
        ours = clocks.time("map runner", lambda: by_runner(year, starts, 1, PERIODS))
        basins = clocks.time(
            "basins_of_attraction",
            lambda: ns.basins_of_attraction(
                system, axes(options.cells), completion={"u": 0, "v": 0}, threads=1
            ),
        )
    unit = clocks.processor["heyoka, batches"]
    print(
        f"{len(starts)} cells, {PERIODS} periods each, best of {options.rounds} rounds, one thread"
    )
    print(f"{'':<22} {'processor s':>12} {'ratio':>6}")
    for name, each in clocks.processor.items():
        print(f"{name:<22} {each:>12.2f} {each / unit:>6.2f}")
    faults = compare(basins, ours, theirs)
    for fault in faults:
        print("FAILED", fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
