"""Soft impact oscillator, written out by hand in soft_impact.c."""

from .compiled import INTEGER, REAL, REALS, Counts, function, library

_simulate = function(library("soft_impact"), "simulate", Counts, REALS, INTEGER, *[REAL] * 7)


def simulate(strobes, zeta, e, beta, a, omega, x, v):
    """Fill strobes[i] = (x, x') at the end of period i; numbers of events and evaluations."""
    counts = _simulate(strobes, len(strobes), zeta, e, beta, a, omega, x, v)
    return counts.events, counts.evaluations
