"""A section of the mole's basins, side by side with a kernel written by hand.

python benchmarks/bench_basins.py [--cells N] [--rounds N]

400 x 400 cells in p and y, q = max(0, p - g) above them, v = 0. Three measures: all cells for 300
periods, through the runner of the stroboscopic map with one thread and with two, and by the hand
kernel, on every tenth row for the ratios and on all rows once; then `basins_of_attraction` as a
whole. The command fails when states of runs that do not end in chaos differ, or labels do.
"""

import argparse
import gc
import platform
import sys
import threading

import numpy as np
from crowd import Clocks, timed
from hand_kernels import compiled, mole
from ours import VERSION

import nonsmooth as ns

PARAMETERS = {"a": 0.3, "b": 0.1, "xi": 0.1, "omega": 1.45}
GAP = 0.02
PERIODS = 300
EVERY = 10  # rows of which one is in the rounds
TOGETHER = 1024  # cells in a task
AIM = 60.0  # seconds for the basins
ON = 1e-6  # distance from a point of a cycle that counts as being on it
STAYING = 3  # states that do not drift: p, y, q
SAME = 1e-8  # difference of two exact solutions on a cycle
AGREE = 0.999  # of the cells: some may settle later than the runs end


def by_hand(starts):
    """Last states of runs; starts (L, 4)."""
    return mole.last_states(starts, PERIODS, *PARAMETERS.values(), GAP)


def axes(cells):
    return {"p": np.linspace(-3.0, 1.0, cells), "y": np.linspace(-1.0, 1.0, cells)}


def grid(cells, every=1):
    """States of the cells, row by row; (L, 4)."""
    region = axes(cells)
    p, y = np.meshgrid(region["p"], region["y"][::every])
    columns = p.ravel(), y.ravel(), np.maximum(0.0, p - GAP).ravel(), np.zeros(p.size)
    return np.column_stack(columns)


def by_runner(year, starts, threads, periods=PERIODS):
    """Last states of runs by the map, in tasks over threads that take the next one."""
    last, left, lock = (
        np.empty(starts.shape),
        iter(range(0, len(starts), TOGETHER)),
        threading.Lock(),
    )

    def work():
        runner = year.runner(1e-12)
        while True:
            with lock:
                first = next(left, None)
            if first is None:
                return
            some = slice(first, first + TOGETHER)
            last[some], _ = runner.last(runner.start(starts[some]), periods)

    others = [threading.Thread(target=work) for _ in range(threads - 1)]
    for each in others:
        each.start()
    work()
    for each in others:
        each.join()
    return last


def cycle_of(basins, states, on, count):
    """Number of the cycle on which each state lies by its first ``count`` entries, 0 for none.

    on: distance from a point of a cycle that counts as being on it
    """
    found = np.zeros(len(states), int)
    for number in basins["attractor"].values:
        one = basins.sel(attractor=number)
        for point in one["points"].values[: int(one["period"])]:
            near = np.abs(states[:, :count] - point[:count]).max(axis=1) <= on
            found[near] = number
    return found


def measure(system, starts, rounds):
    """Times of interleaved rounds and the last states of each."""
    clocks, year = Clocks(), ns.StroboscopicMap(system)
    by_runner(year, starts[:1], 1)
    for _ in range(rounds):
        gc.collect()
        clocks.spin()
        hand = clocks.time(("hand kernel", 1), lambda: by_hand(starts))
        for n in (1, 2):
            ours = clocks.time(("map runner", n), lambda n=n: by_runner(year, starts, n))
    return clocks, hand, ours


def compare(basins, starts, hand, ours):
    """Faults, after saying how the runs agree with each other and with the labels."""
    labels = basins["label"].values.ravel()
    ends = [cycle_of(basins, each, ON, STAYING) for each in (hand, ours)]
    settled = (ends[0] > 0) & (ends[1] > 0)
    apart = np.abs(hand - ours)[settled, :3].max(initial=0.0)
    cycles = basins["attractor"].values[basins["period"].values > 0]
    expected = np.where(np.isin(labels, cycles), labels, 0)
    agree = [float(np.mean(each == expected)) for each in ends]
    print(f"label of the basins, and cycles on which the runs are after {PERIODS} periods:")
    print(f"{'label':>6} {'kind':<10} {'period':>6} {'cells':>8}  by hand on each cycle or none")
    for number in basins["attractor"].values:
        one = basins.sel(attractor=number)
        counts = {k: int(np.sum(ends[0][labels == number] == k)) for k in (*cycles, 0)}
        said = ", ".join(f"{k or 'none'}: {count}" for k, count in counts.items())
        print(
            f"{number:>6} {one['kind'].item():<10} {one['period'].item():>6}"
            f" {int(np.sum(labels == number)):>8}  {said}"
        )
    print(f"cells as labelled: by hand {agree[0]:.2%}, by the runner {agree[1]:.2%}")
    print(f"largest difference of the two on the same cycle: {apart:.1e}")
    faults = []
    same = float(np.mean(ends[0] == ends[1]))
    if not apart <= SAME:
        faults.append(f"states on cycles differ by {apart:.1e}")
    if min(*agree, same) < AGREE:
        faults.append(f"cells agree with labels in {min(agree):.2%}, with each other in {same:.2%}")
    return faults


def main(given=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=400, help="along each side")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args(given)
    system = ns.models.moling(**PARAMETERS, g=GAP)
    print(f"python {platform.python_version()}, nonsmooth {VERSION}, numpy {np.__version__}")
    print(f"hand kernel: {compiled.version()}")

    rows = grid(options.cells, EVERY)
    clocks, *_ = measure(system, rows, options.rounds)
    unit = clocks.processor["hand kernel", 1]
    print(f"{len(rows)} cells, {PERIODS} periods each, best of {options.rounds} rounds")
    print(f"{'':<12} {'threads':>7} {'us per period':>13} {'ratio':>6} {'wall s':>7}")
    for name, n in (("hand kernel", 1), ("map runner", 1), ("map runner", 2)):
        each = clocks.processor[name, n]
        print(
            f"{name:<12} {n:>7} {each / len(rows) / PERIODS * 1e6:>13.3f} {each / unit:>6.2f}"
            f" {clocks.wall[name, n]:>7.2f}"
        )
    print(clocks.report(["map runner"]))

    starts, year = grid(options.cells), ns.StroboscopicMap(system)
    (wall, processor), ours = timed(lambda: by_runner(year, starts, 2))
    print(f"all {len(starts)} cells, two threads: {wall:.1f} s, {processor:.1f} s of processors")
    hand = by_hand(starts)
    (wall, processor), basins = timed(
        lambda: ns.basins_of_attraction(
            system, axes(options.cells), completion={"q": "max(0, p - g)"}, threads=2
        )
    )
    print(
        f"basins_of_attraction, two threads: {wall:.1f} s, {processor:.1f} s of processors"
        f" (aim {AIM:g} s)"
    )
    faults = compare(basins, starts, hand, ours)
    for fault in faults:
        print("FAILED", fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
