"""Time of the set-up for one set of parameter values: what a sweep pays for each point.

python benchmarks/bench_setup.py

From a compiled system and parameter values to the tables that the engine runs: coefficients,
natural motions of every mode, weights of guards, orders of zero. The command fails when the
eigenvalues in the tables differ from those of numpy by more than their rounding.
"""

import sys
from pathlib import Path
from time import process_time

import numpy as np

from nonsmooth.engine.tables import allocate_stack, set_up

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from ours import SYSTEMS
from problems import PROBLEMS

from contract.rig import rig

ROUNDS, CALLS = 25, 200
AIM = 20.0  # microseconds, for the models of the package
BOUND = 1e-10  # relative to the largest eigenvalue; none of these spectra is defective but at zero


def error_of_spectrum(tables):
    """Largest distance of an eigenvalue in the tables from the nearest one of numpy."""
    worst = 0.0
    for generator, spectrum, slots in zip(
        tables.generator, tables.spectrum, tables.slots, strict=True
    ):
        expected = np.linalg.eigvals(generator)
        for value in spectrum[: slots["count"]]:
            if abs(value) > 0.0:
                worst = max(worst, np.abs(expected - value).min() / np.abs(expected).max())
    return worst


def measure(system):
    """Microseconds per set-up and the error of the spectrum."""
    program = system.compiled.program
    stack = allocate_stack(program, 1)
    values = np.array([list(system.parameter_values.values())])
    set_up(program, values, stack)
    best = np.inf
    for _ in range(ROUNDS):
        start = process_time()
        for _ in range(CALLS):
            set_up(program, values, stack)
        best = min(best, (process_time() - start) / CALLS)
    return best * 1e6, error_of_spectrum(stack.part(0))


def main():
    systems = {p.name: SYSTEMS[p.name](p.parameters) for p in PROBLEMS.values()}
    systems["fatigue rig"] = rig()
    print(f"{'system':<14} {'modes':>6} {'coordinates':>12} {'us':>8} {'error':>9}")
    faults = []
    for name, system in systems.items():
        microseconds, error = measure(system)
        size = system.compiled.program.sizes.augmented
        line = f"{name:<14} {len(system.modes):>6} {size:>12} {microseconds:>8.1f} {error:>9.1e}"
        print(line)
        if not error <= BOUND:
            faults.append(f"{name}: an eigenvalue is off by {error:.1e}")
    print(f"aim for the models of the package: {AIM:g} us")
    for fault in faults:
        print("FAILED", fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
