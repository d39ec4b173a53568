"""What starting costs: the import, the help page and a first run, each beside a yardstick.

`python benchmarks/bench_start.py [--rounds N]`. Every start is a process of its own, and its time
the least processor time of some rounds: other work on the machine only ever adds to it. What a
start may load is asserted without a clock, in tests/house/test_start.py.
"""

import argparse
import os
import subprocess
import sys
from typing import NamedTuple

import numpy as np

try:
    from resource import RUSAGE_CHILDREN, getrusage
except ImportError:
    sys.exit("the processor time of a process that has ended is not known on this system")

PAGE = """
import sys
sys.argv = [sys.argv[0], "--help"]
{get}
try:
    app()
except SystemExit as stop:
    assert not stop.code, stop.code
"""
# one command without an option: what click takes for any page
BARE = """import click
app = click.Command("bare", callback=lambda: None)
"""


class Start(NamedTuple):
    """A program, what it cannot do without, and the ratio of their times that is allowed."""

    name: str
    code: str
    yardstick: str
    needed: str
    limit: float


STARTS = (
    Start("import nonsmooth", "import nonsmooth", "python alone", "pass", 4.0),
    # more than twenty commands stand on the page; half of the rest finds and loads plug-ins
    Start(
        "nonsmooth --help",
        PAGE.format(get="from nonsmooth.cli import main as app"),
        "a page of click",
        PAGE.format(get=BARE),
        2.5,
    ),
    Start(
        "a first run",
        "import nonsmooth as ns; ns.simulate(ns.models.moling(), periods=1)",
        "import xarray",
        "import xarray",
        np.inf,
    ),
)


def processor_seconds(code):
    """Processor time of a new interpreter that runs this code."""
    # without its cached bytecode every start would compile the package again
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    before = getrusage(RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL, env=environment
    )
    after = getrusage(RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def measure(rounds):
    """Least times of all programs by code, in turn so that noise hits all alike."""
    codes = [code for start in STARTS for code in (start.code, start.needed)]
    for code in codes:  # bytecode and the files' places in memory
        processor_seconds(code)
    times = np.array([[processor_seconds(code) for code in codes] for _ in range(rounds)])
    return dict(zip(codes, times.min(axis=0), strict=True))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=9)
    seconds = measure(parser.parse_args().rounds)
    print(f"{'start':<18} {'ms':>7}  {'yardstick':<16} {'ms':>7} {'ratio':>7} {'limit':>6}")
    faults = []
    for start in STARTS:
        took, least = seconds[start.code], seconds[start.needed]
        line = f"{start.name:<18} {1e3 * took:>7.0f}  {start.yardstick:<16} {1e3 * least:>7.0f}"
        limit = f"{start.limit:>6g}" if start.limit < np.inf else ""
        print(f"{line} {took / least:>7.2f} {limit}")
        if took > start.limit * least:
            faults.append(f"{start.name}: more than {start.limit:g} times {start.yardstick}")
    for fault in faults:
        print("FAILED", fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
