"""Soft impact oscillator by Runge-Kutta with a fixed step, in soft_impact_rk4.c."""

from .compiled import INTEGER, REAL, REALS, function, library

_simulate = function(
    library("soft_impact_rk4"), "simulate", None, REALS, INTEGER, INTEGER, *[REAL] * 7
)


def simulate(strobes, steps, zeta, e, beta, a, omega, x, v):
    """Fill strobes[i] = (x, x') at the end of period i."""
    _simulate(strobes, len(strobes), steps, zeta, e, beta, a, omega, x, v)
