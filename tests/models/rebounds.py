"""Rebounds at a wall one by one in 40 digits, for any flight that is known in closed form."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from mpmath import mp, mpf

DIGITS = 40
_GAP = 16 * np.finfo(float).eps  # rounding of a gap whose terms are of order 1
_SMALL = mpf("1e-18")  # speed after which the rest is a geometric series to well below doubles
_PARTS = 16  # in which a flight is looked through for the first return
_MOST = 0.05  # step where the flight is not pressed back


class Instant(NamedTuple):
    """Distance from the wall, its rate, and the rate of that."""

    gap: mpf
    rate: mpf
    push: mpf


Flight = Callable[[mpf, mpf], Callable[[mpf], Instant]]  # (start, rate of leaving) -> motion


def first_return(motion: Callable[[mpf], Instant], began: mpf) -> mpf:
    """First time after a start at the wall at which the distance is zero again."""
    leaving = motion(began)
    step = mpf(_MOST)
    if leaving.push < 0 < leaving.rate:
        step = min(step, 2 * leaving.rate / -leaving.push / _PARTS)
    low = began + step
    while motion(low + step).gap > 0:
        low += step
    return mp.findroot(lambda t: motion(t).gap, (low, low + step), solver="anderson", tol=1e-70)


def rebounds(flight: Flight, began, rate, r) -> tuple[list[float], float]:
    """Times of the impacts that follow a start, and the time at which they are over."""
    with mp.workdps(DIGITS):
        time, rate, r = mpf(began), mpf(rate), mpf(r)
        times = []
        while rate > _SMALL:
            motion = flight(time, rate)
            time = first_return(motion, time)
            arrived = motion(time)
            rate = -r * arrived.rate
            times.append(float(time))
        return times, float(time + 2 * rate / (-arrived.push * (1 - r)))


def of_rounding(speeds: np.ndarray) -> np.ndarray:
    """What rounding may have done to the times of impacts by then, from the speeds of arrival.

    A gap is a difference of terms that do not shrink with it, and its rounding over the speed is a
    time. Times of flights add up, so their errors do.
    """
    return 1e-13 + _GAP * np.cumsum(1 / speeds)


def of_the_end(speeds: np.ndarray, r: float, period: float) -> float:
    """What rounding, and what is left out, may have done to the time at which impacts are over.

    What is left out is of third order in the time that is not followed, 1e-6 of a period.
    """
    return float(of_rounding(speeds)[-1] + _GAP / speeds[-1] / (1 - r) + (1e-6 * period) ** 3)
