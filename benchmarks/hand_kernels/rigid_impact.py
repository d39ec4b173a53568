"""Rigid impact oscillator with rest at the wall, written out by hand in rigid_impact.c."""

from .compiled import INTEGER, REAL, REALS, Counts, function, library

_simulate = function(library("rigid_impact"), "simulate", Counts, REALS, INTEGER, *[REAL] * 6)


def simulate(strobes, F, omega, sigma, r, x, v):
    """Fill strobes[i] = (x, x') at the end of period i; numbers of events and evaluations."""
    counts = _simulate(strobes, len(strobes), F, omega, sigma, r, x, v)
    return counts.events, counts.evaluations
