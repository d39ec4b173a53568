"""Where a branch of orbits doubles its period, what it doubles into, and on which side."""

from collections.abc import Callable
from typing import NamedTuple

from mpmath import matrix, mp, mpf

from .turn import NoOrbit, Orbit, characteristic, close, repeated, take_turn, where

AMPLITUDE = mpf(10) ** -4


class Flip(NamedTuple):
    """``curvature``: the doubled orbits lie at value + curvature amplitude^2, along ``along``."""

    value: mpf
    orbit: Orbit
    along: matrix
    curvature: mpf
    doubled: Orbit

    @property
    def supercritical(self) -> bool:
        """The doubled orbits next to it are stable, where those that doubled are not."""
        return abs(self.doubled.multipliers[0]) < 1


def flip(make: Callable, near: tuple, orbit, amplitude=AMPLITUDE) -> Flip:
    """The flip between two values nearby, and the doubled orbit at an amplitude."""
    value, found = where(make, lambda each: characteristic(each, -1), near, orbit)
    along = _kernel(found.tangent + mp.eye(len(found.free)))
    # even part in the amplitude: the two points of one doubled orbit are both ends
    shifts, doubled = [], None
    for sign in (1, -1):
        at, doubled = doubled_orbit(make, value, found, along, sign * amplitude)
        shifts.append(at - value)
    return Flip(value, found, along, sum(shifts) / (2 * amplitude**2), doubled)


def doubled_orbit(make: Callable, value, orbit: Orbit, along: matrix, amplitude) -> tuple:
    """The orbit of twice the period whose start is ``amplitude`` away, and its parameter."""
    n = len(orbit.free)
    guesses = [*orbit.turn.durations, *orbit.turn.durations]
    unknown = [*(x + amplitude * along[i] for i, x in enumerate(orbit.free)), mpf(value)]
    small = mpf(10) ** -22

    def miss(values: list) -> list:
        course = repeated(make(values[n]), 2)
        end = take_turn(course, values[:n], guesses).end
        gaps = [a - b for a, b in zip(course.off(end), values[:n], strict=True)]
        reach = sum(along[i] * (values[i] - orbit.free[i]) for i in range(n)) - amplitude
        return [*gaps, reach]

    for _ in range(40):
        here = miss(unknown)
        columns = []
        for j in range(n + 1):
            moved = [x + small if i == j else x for i, x in enumerate(unknown)]
            columns.append([(a - b) / small for a, b in zip(miss(moved), here, strict=True)])
        change = mp.lu_solve(matrix(columns).T, -matrix(here))
        unknown = [x + c for x, c in zip(unknown, change, strict=True)]
        if mp.norm(change) < mpf(10) ** -30:
            course = repeated(make(unknown[n]), 2)
            return unknown[n], close(course, unknown[:n], guesses)
    raise NoOrbit("no doubled orbit of this amplitude")


def _kernel(singular: matrix) -> matrix:
    """Unit vector that a singular matrix takes to zero, by inverse iteration."""
    n = singular.rows
    vector = matrix([1] * n)
    shifted = singular + mpf(10) ** -30 * mp.eye(n)
    for _ in range(6):
        vector = mp.lu_solve(shifted, vector)
        vector /= mp.norm(vector)
    return vector
