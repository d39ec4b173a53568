"""Soft impact oscillator by looking often, in soft_impact_scan.c."""

from .compiled import INTEGER, REAL, REALS, function, library

_simulate = function(library("soft_impact_scan"), "simulate", None, REALS, INTEGER, *[REAL] * 7)


def simulate(strobes, zeta, e, beta, a, omega, x, v):
    """Fill strobes[i] = (x, x') at the end of period i."""
    _simulate(strobes, len(strobes), zeta, e, beta, a, omega, x, v)
