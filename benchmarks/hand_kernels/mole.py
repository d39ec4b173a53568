"""Ground mole, written out by hand in mole.c."""

import numpy as np

from .compiled import INTEGER, REAL, REALS, Counts, function, library

_mole = library("mole")
_simulate = function(_mole, "simulate", Counts, REALS, INTEGER, *[REAL] * 9)
_last_states = function(
    _mole, "last_states", None, REALS, REALS, INTEGER, REALS, INTEGER, *[REAL] * 5
)


def simulate(strobes, a, b, xi, omega, g, p, y, q, v):
    """Fill strobes[i] = (p, y, q, v) at the end of period i; numbers of events and evaluations."""
    counts = _simulate(strobes, len(strobes), a, b, xi, omega, g, p, y, q, v)
    return counts.events, counts.evaluations


def last_states(starts, periods, a, b, xi, omega, g):
    """The states after some periods; starts (L, 4)."""
    ends, strobes = np.empty(starts.shape), np.empty((periods, 4))
    _last_states(ends, starts, len(starts), strobes, periods, a, b, xi, omega, g)
    return ends
