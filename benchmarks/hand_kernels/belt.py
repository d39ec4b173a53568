"""Block on a belt with dry friction, written out by hand in belt.c."""

from .compiled import INTEGER, REAL, REALS, Counts, function, library

_simulate = function(library("belt"), "simulate", Counts, REALS, INTEGER, *[REAL] * 6)


def simulate(strobes, F_c, v_b, F, omega, x, v):
    """Fill strobes[i] = (x, x') at the end of period i; numbers of events and evaluations."""
    counts = _simulate(strobes, len(strobes), F_c, v_b, F, omega, x, v)
    return counts.events, counts.evaluations
