"""`python benchmarks` runs all benchmarks: long runs, set-up, the stiff rig, Taylor steps."""

import sys

import bench_rig
import bench_setup
import bench_simulate
import bench_taylor

sys.exit(
    max([bench_simulate.main(), bench_setup.main(), bench_rig.main([]), bench_taylor.main([])])
)
