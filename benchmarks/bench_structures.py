"""A shaft of 200 coordinates with a stop: reduction, set-up, revolutions and a run-up.

python benchmarks/bench_structures.py [--revolutions N]

Then chains with one gap spring: time of building, of setting up and of a period over the number of
states. The command fails where a run is not completed or not certified, where the reduced shaft is
off its estimate or the largest contact force off that of a better reduced one by more than that,
and where events of a chain are not those that scipy finds.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np

import nonsmooth as ns
from nonsmooth.structures import Beam, Bearing, Disc, Force, GapSpring, Unbalance, machine, reduce
from nonsmooth.structures import shaft as shaft_of

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from structures.contact_truth import Bench, Spring, chain

ACCURACY = 1e-3
SIZES = (10, 20, 40, 80, 160)
EVENTS = 6
OMEGA = 2.1
BOUND = 1e-9  # of event times; DOP853 at 3e-14


def timed(function, *args, **words):
    start = process_time()
    found = function(*args, **words)
    return process_time() - start, found


def shaft(elements=49):
    """Two discs, two bearings whose coefficients are tables over the speed."""
    speeds = np.linspace(50.0, 650.0, 7)
    film = {"stiffness": 4e6 + 3e4 * speeds, "damping": 2e5 / speeds, "speeds": speeds}
    return shaft_of(
        [Beam(1.5 / elements, 0.05)] * elements,
        discs=[Disc.from_geometry(16, 0.07, 0.28, 0.05), Disc.from_geometry(32, 0.07, 0.35, 0.05)],
        bearings=[Bearing([f"{node}x", f"{node}y"], **film) for node in (0, elements)],
        damping=(0.0, 2e-5),
    )


def stopped(model):
    contacts, loads = [GapSpring("24x", 2e-4, 2e7)], [Unbalance("32x", "32y", 0.01)]
    return machine(model, contacts, loads, Omega=130.0)


def bench_shaft(revolutions):
    """Lines of the table, and what is wrong."""
    words = {"frequency_range": (0.0, 3000.0), "speeds": [60.0, 600.0], "driven": ["32x", "32y"]}
    keep = ["24x", "24y"]
    full = shaft()
    reducing, small = timed(reduce, full, keep, accuracy=ACCURACY, **words)
    finer = reduce(full, keep, accuracy=ACCURACY / 100, **words)
    building, system = timed(stopped, small)
    again, _ = timed(stopped, small)
    ns.simulate(system, periods=1)  # what is loaded once
    one, _ = timed(ns.simulate, system, periods=1)
    many, run = timed(ns.simulate, system, periods=revolutions)
    rising = replace(system, slow={"Omega": "100 + 2*t"})
    up, rise = timed(ns.simulate, rising, periods=revolutions)
    print(f"shaft of {full.size} coordinates, {small.size} when reduced to {ACCURACY:g}")
    for name, seconds in (
        ("reduce", reducing),
        ("build", building),
        ("build again", again),
        ("one revolution", one),
        (f"{revolutions} revolutions", many),
        (f"run-up of {revolutions} revolutions", up),
    ):
        print(f"  {name:<32} {seconds:>9.4f} s")
    print(f"  events: {run.attrs['n_events']}, in the run-up {rise.attrs['n_events']}")
    faults = [
        f"{name}: {each.attrs['status']}, certified {each.attrs['certified']}"
        for name, each in (("revolutions", run), ("run-up", rise))
        if each.attrs["status"] != "completed" or not each.attrs["certified"]
    ]
    if not float(small.estimate["error"].max()) <= ACCURACY:
        faults.append("the estimate of the reduced shaft is beyond what was asked for")
    forces = [
        float(ns.simulate(stopped(each), periods=20)["spring1_force"].max())
        for each in (small, finer)
    ]
    off = abs(forces[0] / forces[1] - 1)
    print(f"  largest force off that of {finer.size} coordinates by {off:.1e}")
    if not off <= ACCURACY:
        faults.append(f"the largest force is off by {off:.1e}")
    return faults


def bench_sizes():
    """The same for chains of more and more masses."""
    print(
        f"{'states':>8} {'build s':>9} {'set-up, period s':>20} {'period s':>9} {'off scipy':>10}"
    )
    faults = []
    for n in SIZES:
        mass, stiffness = chain(n)
        damping = 0.05 * mass + 0.02 * stiffness
        names = [f"{i}x" for i in range(n)]
        structure = ns.Structure(mass, stiffness, damping=damping, coordinates=names)
        whole = reduce(structure, [names[-1]], modes=n)
        building, system = timed(
            machine,
            whole,
            [GapSpring(names[-1], 0.1, 30.0)],
            [Force(names[n // 2], "2*cos(omega*t)")],
            parameters={"omega": OMEGA},
            period="2*pi/omega",
        )
        ns.simulate(system, periods=1)
        one, _ = timed(ns.simulate, system, periods=1)
        many, _ = timed(ns.simulate, system, periods=101)
        unit = np.eye(n)
        bench = Bench(
            mass,
            damping,
            stiffness,
            lambda t, at=unit[n // 2]: 2 * np.cos(OMEGA * t) * at,
            [Spring(unit[-1], 0.1, 30.0)],
        )
        truth = bench.run(np.zeros(2 * n), EVENTS, 100.0)
        run = ns.simulate(system, t_end=truth[-1].time + 1e-3)
        times = run["event_time"].values[run["event_kind"].values != "start"][:EVENTS]
        off = np.abs(times - [event.time for event in truth]).max()
        print(f"{2 * n:>8} {building:>9.3f} {one:>20.4f} {(many - one) / 100:>9.6f} {off:>10.1e}")
        if not off <= BOUND:
            faults.append(f"{2 * n} states: events are off by {off:.1e}")
    return faults


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--revolutions", type=int, default=1000)
    options = parser.parse_args(arguments)
    faults = bench_shaft(options.revolutions) + bench_sizes()
    for fault in faults:
        print("FAILED", fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
