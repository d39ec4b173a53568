"""`python benchmarks` runs all: long runs, set-up, the stiff rig, Taylor steps, sweeps, basins,
rotor, growing crack, continuation, orbits, impacts and friction, starts, flaws of records, alarms.
"""

import subprocess
import sys
from os import environ
from pathlib import Path

# before the benchmarks of one run change it: sweeps take as many threads as there are processors
AS_FOUND = dict(environ)

import bench_rig  # noqa: E402
import bench_setup  # noqa: E402
import bench_simulate  # noqa: E402
import bench_taylor  # noqa: E402


def alone(name):
    """Exit status of a benchmark in a process of its own."""
    command = [sys.executable, str(Path(__file__).with_name(name))]
    sys.stdout.flush()
    return subprocess.run(command, env=AS_FOUND, check=False).returncode


runs = [bench_simulate.main(), bench_setup.main(), bench_rig.main([]), bench_taylor.main([])]
sys.exit(
    max(
        *runs,
        *map(
            alone,
            (
                "bench_ensembles.py",
                "bench_basins.py",
                "bench_rotor_basins.py",
                "bench_rotor.py",
                "bench_growth.py",
                "bench_structures.py",
                "bench_continuation.py",
                "bench_orbits.py",
                "bench_rest.py",
                "bench_start.py",
                "bench_record_flaws.py",
                "bench_alarm.py",
            ),
        ),
    )
)
