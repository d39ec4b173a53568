"""How much a run magnifies what rounding does to it anywhere on the way."""

from itertools import pairwise

import numpy as np

import nonsmooth as ns


def growth(system, initial, times):
    """Largest entry of the tangent of any part of the run up to each time, 1 at least.

    Parts begin and end at the times given; the run goes on from one to the next.
    """
    run, parts, worst = initial, [], [1.0]
    for start, end in pairwise(times):
        run = ns.simulate(system, run, times=[start, end], tangent=[])
        piece = run["tangent"].values[-1]
        parts = [*(piece @ part for part in parts), piece]
        worst.append(max(worst[-1], *(np.abs(part).max() for part in parts)))
    return np.array(worst)
