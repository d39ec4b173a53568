"""`python benchmarks` runs the benchmark of long trajectories."""

import sys

from bench_simulate import main

sys.exit(main())
