"""Natural sizes of states that are known as points of a system, and no motion to follow.

A state at rest leaves rounding, which any unit of its own would make a motion of. Its natural size
is what the rates of a system make of it while all other states move by their sizes, for as long as
that takes: the time in which states turn into each other.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.runs.outputs import StateRates
from nonsmooth.runs.runner import build_tables
from nonsmooth.system.system import System

__all__ = ["AT_REST", "sizes_by_rates"]

Floats = npt.NDArray[np.float64]

AT_REST = 1e-9  # of the natural size of a state: a spread below it is rounding


def sizes_by_rates(system: System, states: Floats, mode: int) -> Floats:
    """Natural sizes of the states (K, n) of a system, (n,), in the last of them and its mode.

    The matrix of the changes of rates by states, beside the changes of these, has the spectral
    radius of the rates at which they turn into each other, in any units.
    """
    sizes, here = np.abs(states).max(axis=0), states[-1]
    count = sizes.size
    shifted = here + np.diag(sizes)
    rates = StateRates(system, build_tables(system))
    numbers, modes = np.zeros(count + 1, np.int64), np.full(count + 1, mode)
    with np.errstate(all="ignore"):  # a state that is shifted may lie where rates are not defined
        found = rates.of_many(numbers, np.zeros(count + 1), modes, np.vstack([here, shifted]))
        changes = np.nan_to_num(np.abs(found[1:] - found[0]).T, posinf=0.0)  # (n, n) by states
        matrix = np.divide(changes, sizes, out=np.zeros_like(changes), where=sizes > 0.0)
    rate = float(np.abs(np.linalg.eigvals(matrix)).max(initial=0.0))
    return np.maximum(sizes, changes.sum(axis=1) / rate) if rate > 0.0 else sizes
