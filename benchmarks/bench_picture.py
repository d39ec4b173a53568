"""The bifurcation picture of the mole over its static force, beside a plain diagram.

python benchmarks/bench_picture.py [--columns N]

The picture holds attractors from 50 starts at each value, and all branches of orbits of one and two
periods. Its time is compared with that of `bifurcation_diagram` for the same values, from rest,
with 1000 periods of transient. The command fails when a stable cycle is none for the kernel that is
written by hand, when a stable cycle of one or two periods lies on no branch, or when the picture
takes longer than a minute.
"""

import argparse
import sys
import time

import numpy as np
from hand_kernels import mole

import nonsmooth as ns

PARAMETERS = {"a": 0.3, "xi": 0.05, "omega": 0.1}
GAP = 0.02
BETWEEN = (0.02, 0.3)
REGION = {"p": (-60.0, 1.0), "y": (-3.0, 8.0)}
AIM = 60.0  # seconds
SAME = 1e-7  # of the size of a state: exact solutions on a stable cycle, after some turns
TURNS = 20
NEAR = 0.02  # of the spread: a branch beside a settled point, between two points of the branch


def timed(work):
    """What work gives, and its seconds on the clock."""
    begun = time.perf_counter()
    found = work()
    return found, time.perf_counter() - begun


def wrong_cycles(picture):
    """How many stable cycles do not come back to their first point by hand."""
    wrong = cycles = 0
    for column in range(picture.sizes["parameter"]):
        here = picture.isel(parameter=column)
        b = float(here["parameter"])
        for k in np.flatnonzero(here["period"].values > 0):
            period = int(here["period"][k])
            start = here["settled"][k, 0].values[None]
            last = mole.last_states(
                start, TURNS * period, PARAMETERS["a"], b, PARAMETERS["xi"],
                PARAMETERS["omega"], GAP,
            )  # fmt: skip
            apart = np.abs(last - start)[0, :3] / (1.0 + np.abs(start[0, :3]))
            cycles += 1
            wrong += bool(apart.max() > SAME)
    return wrong, cycles


def beside_branches(picture):
    """How many stable cycles of one and two periods lie beside no branch."""
    b, states = picture["b"].values, picture["strobes"].values
    owner, period = picture["branch_of_point"].values, picture["branch_period"].values
    spread = np.nanmax(states[..., :3], axis=(0, 1)) - np.nanmin(states[..., :3], axis=(0, 1))
    missed = 0
    for column in range(picture.sizes["parameter"]):
        here = picture.isel(parameter=column)
        value = float(here["parameter"])
        ways = np.flatnonzero((b[:-1] - value) * (b[1:] - value) <= 0.0)
        ways = ways[owner[ways] == owner[ways + 1]]
        for k in np.flatnonzero(np.isin(here["period"].values, (1, 2))):
            own = ways[period[owner[ways]] == here["period"].values[k]]
            share = (value - b[own]) / np.where(b[own + 1] == b[own], 1.0, b[own + 1] - b[own])
            between = states[own] + share[:, None, None] * (states[own + 1] - states[own])
            at = here["settled"][k, 0].values[:3]
            gaps = np.max(np.abs(between[..., :3] - at) / spread, axis=2)  # nan: no such point
            missed += not np.any(gaps < NEAR)
    return missed


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--columns", type=int, default=101)
    columns = parser.parse_args().columns
    system = ns.models.moling(**PARAMETERS)
    picture, seconds = timed(
        lambda: ns.bifurcation_picture(
            system, "b", BETWEEN, REGION, columns=columns, completion={"q": "max(0, p - g)"}
        )
    )
    _, plain = timed(
        lambda: ns.bifurcation_diagram(
            system, "b", np.linspace(*BETWEEN, columns), transient=1000, record=100
        )
    )
    wrong, cycles = wrong_cycles(picture)
    missed = beside_branches(picture)
    print(picture.attrs["message"])
    print(f"picture: {seconds:.1f} s; diagram: {plain:.2f} s; ratio {seconds / plain:.0f}")
    print(f"{cycles} stable cycles, {wrong} of them none by hand, {missed} beside no branch")
    return int(wrong > 0 or missed > 0 or seconds > AIM)


if __name__ == "__main__":
    sys.exit(main())
