"""Many motions at once on a graphics device, beside all threads of the processor.

`python benchmarks/bench_gpu.py [PART ...]`. The parts are ``lanes`` (the kernel alone: many starts
of one system, beside one thread of the processor), ``basins`` (the basins of the soft impact
oscillator and of the impact oscillator) and ``map`` (regimes over two parameters after a long
transient). Each part runs on both, in turns, in one process, and prints seconds, their ratio and
the share of equal labels. The command fails where the first strobes of lanes differ by more than
rounding, or where fewer than 99.9 % of the labels agree: single cells on a fractal border may fall
on the other side after a change of the last digit. Needs CuPy and a device.
"""

import argparse
import sys
import time
from functools import partial

import numpy as np

import nonsmooth as ns
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.lane_runner import LaneRunner

LANES, PERIODS = 200_000, 200
ON_PROCESSOR = 2_000  # of the lanes, which are enough for a time per period
FEW = 3  # strobes that rounding has not spread yet
CLOSE = 1e-12
EQUAL = 0.999
CELLS = 500  # along each side of a plane of initial states
POINTS = 160  # along each side of a plane of parameters
TRANSIENT = 20_000

SYSTEMS = {
    "soft impact": (ns.models.soft_impact, {"x": (-1.0, 1.0), "v": (-1.0, 1.0)}),
    "ground mole": (ns.models.moling, {"p": (-1.0, 0.0), "y": (-1.0, 1.0)}),
    "impact oscillator": (ns.models.impact_oscillator, {"x": (-1.0, 0.0), "v": (-1.0, 1.0)}),
}


def seconds(work):
    """Result of some work, and how long it took."""
    began = time.perf_counter()
    result = work()
    return result, time.perf_counter() - began


def starts_of(system, box, count):
    """Starts drawn evenly from a box of states; the others rest."""
    rng = np.random.default_rng(0)
    states = np.tile([system.open_state.get(name, 0.0) for name in system.states], (count, 1))
    for name, (low, high) in box.items():
        states[:, system.states.index(name)] = rng.uniform(low, high, count)
    return np.nan_to_num(states)


def run_lanes(system, states):
    """Some strobes of lanes, and how they ended."""
    runner = LaneRunner(system, 1e-12)
    lanes = runner.start(states, Instant(0, 0.0))
    numbers = np.concatenate([np.arange(1, 1 + FEW), [PERIODS]])
    strobes, _ = runner.run(lanes, Instant(PERIODS, 0.0), numbers, np.zeros(numbers.size))
    return strobes, lanes.status


def lanes() -> bool:
    """Many starts of one system."""
    good = True
    for name, (make, box) in SYSTEMS.items():
        system = make()
        states = starts_of(system, box, LANES)
        (ours, ended), on_processor = seconds(partial(run_lanes, system, states[:ON_PROCESSOR]))
        with ns.use_device("gpu"):
            run_lanes(system, states[:4096])  # scratch is allocated
            (theirs, they_ended), on_device = seconds(partial(run_lanes, system, states))
        per_period = on_processor / ON_PROCESSOR / PERIODS, on_device / LANES / PERIODS
        difference = np.nanmax(np.abs(ours[:, :FEW] - theirs[:ON_PROCESSOR, :FEW]))
        same = np.mean(ended == they_ended[:ON_PROCESSOR])
        print(
            f"{name}: one thread {per_period[0] * 1e6:.3f} us per period, device"
            f" {per_period[1] * 1e6:.4f}, ratio {per_period[0] / per_period[1]:.0f}; first"
            f" {FEW} strobes differ by {difference:.1e}, ends equal {same:.4f}",
            flush=True,
        )
        good &= difference < CLOSE and same == 1.0
    return good


def compared(name, work, label) -> bool:
    """Whether work on the device gives the labels that the processor gives."""
    ours, on_processor = seconds(work)
    with ns.use_device("gpu"):
        work_again, on_device = seconds(work)
    same = float(np.mean(ours[label].values == work_again[label].values))
    print(
        f"{name}: processor {on_processor:.1f} s, device {on_device:.1f} s, ratio"
        f" {on_processor / on_device:.1f}; equal labels {same:.5f}",
        flush=True,
    )
    return same >= EQUAL


def basins() -> bool:
    """Basins of attraction over a grid of initial states."""
    good = True
    for name in ("soft impact", "impact oscillator"):
        make, box = SYSTEMS[name]
        grid = {each: np.linspace(*ends, CELLS) for each, ends in box.items()}
        good &= compared(
            f"basins, {name}, {CELLS} x {CELLS}",
            partial(ns.basins_of_attraction, make(), grid),
            "label",
        )
    return good


def regimes() -> bool:
    """Regimes over a plane of parameters."""
    over = {"omega": np.linspace(0.7, 1.0, POINTS), "a": np.linspace(0.4, 1.0, POINTS)}
    return compared(
        f"regimes of the soft impact oscillator, {POINTS} x {POINTS}, transient {TRANSIENT}",
        lambda: ns.regime_map(
            ns.models.soft_impact(),
            over,
            transient=TRANSIENT,
            record=32,
            longest=TRANSIENT,
            confirm=0,
        ),
        "period",
    )  # fmt: skip


PARTS = {"lanes": lanes, "basins": basins, "map": regimes}


def main() -> int:
    """Run the parts that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], help="all by default")
    asked = parser.parse_args().parts or list(PARTS)
    _, compiling = seconds(lambda: ns.use_device("gpu"))
    ns.use_device("cpu")
    print(f"the device was ready after {compiling:.1f} s", flush=True)
    return 0 if all([PARTS[part]() for part in asked]) else 1


if __name__ == "__main__":
    sys.exit(main())
