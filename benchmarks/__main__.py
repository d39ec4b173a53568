"""`python benchmarks` runs all benchmarks: long trajectories, set-up, the stiff rig."""

import sys

import bench_rig
import bench_setup
import bench_simulate

sys.exit(max([bench_simulate.main(), bench_setup.main(), bench_rig.main([])]))
