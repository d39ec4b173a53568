"""Jeffcott rotor in a preloaded snubber ring by DOP853, written out by hand in rotor.c."""

import ctypes

import numpy as np

from .compiled import INTEGER, REAL, REALS, function, library


class Outcome(ctypes.Structure):
    """Counts of events and steps, and a status that is 0 when the run is complete."""

    _fields_ = (("events", INTEGER), ("steps", INTEGER), ("status", INTEGER))


_simulate = function(
    library("rotor"), "simulate", Outcome, REALS, INTEGER, REALS, INTEGER, REALS, REALS, REAL
)


def simulate(strobes, log, start, p, tolerance):
    """Fill strobes[i] at the end of period i and log[k] = (period, time in it, from, to).

    Counts of events and steps, and a status: 0, or 1 where no regime holds, or 2 where steps
    become too short. Constants p: eta, nu1, nu2, K, load, eps_x, eps_y, delta_x, delta_y, phi0.
    """
    constants = np.array(p)
    found = _simulate(strobes, len(strobes), log, len(log), start, constants, tolerance)
    return found.events, found.steps, found.status
