"""When rebounds have accumulated: the last of infinitely many impacts, and the time until it.

An impact leaves with the rate w of its guard, pressed back by the acceleration -P. The next ones
come after 2 w/P, 2 r w/P, ... with the ratio r of the rates after and before an impact, so that
all of them are over after T = 2 w/(P (1 - r)). Where the acceleration is -(A + a t + c g') with
the time t and the rate g', flights and ratios change, and to first order T is 1 - a T/(3 A) - c T/6
times that. Where friction makes it -P up and -Q down, T is w (1/P + (P Q)^(-1/2)) over
1 - r (Q/P)^(1/2). Impacts are passed one by one until little is left of the row and the
acceleration is as good as constant, or until flights are so low that rounding would swallow them.
Then the rest is one exit: onto the surface, with the momentum gone that is left along the jump.
What it leaves out in the state is of third order in T.
See A. Nordmark and P. Piiroinen, Nonlinear Dynamics 58, 2009; C. Budd and F. Dux, Philosophical
Transactions of the Royal Society A 347, 1994.
"""

from __future__ import annotations

import math

from nonsmooth.engine import layout as at
from nonsmooth.engine.guard_values import sum_of_terms
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.velocity import velocity_of

__all__ = ["NEVER", "rate_of_guard", "rest_time"]

NEVER = -1.0
_SHORT = 1e-6  # part of a period
_SHORTER = 1e-12  # likewise; or of the unit of time, beside which motions may be quick
_STEADY = 1e-5  # part of the acceleration by which it changes while rebounds die out
_NEARLY_STEADY = 1e-2  # likewise, where flights are too low to be followed
_LOW = 1e-12  # height of a flight beside the terms of its guard
_GONE = 1e-12  # of the largest rate at the same instant


@kernel
def rate_of_guard(n, generator, affine, wiring, m, e, z):
    """Rate of guard e of mode m at z, where the rows of the mode are up to date."""
    row, total = at.guard_row(e, 0), 0.0
    for i in range(z.size):
        if affine[m, row, i] != 0.0:
            velocity = velocity_of(n, generator, affine, wiring, m, z, i)
            total += affine[m, row, i] * velocity
    return total


@kernel
def rest_time(affine, clock, m, e, z, extent, arrival, push_before, largest, tolerance):
    """Time until the rebounds of exit e of mode m are over; NEVER while they go on.

    z: coordinates behind the impact, whose guard came in at the rate ``arrival`` and with the
    second derivative ``push_before``; rows of the derivatives of the guard are up to date.
    ``largest`` of such rates at the same instant
    """
    rate, rate_size = sum_of_terms(affine, m, at.guard_row(e, 1), z, extent)
    push, push_size = sum_of_terms(affine, m, at.guard_row(e, 2), z, extent)
    jerk, jerk_size = sum_of_terms(affine, m, at.guard_row(e, 3), z, extent)
    pressed = push < -tolerance * push_size
    if abs(rate) <= tolerance * rate_size or abs(rate) <= _GONE * largest:
        soon = abs(push) <= tolerance * push_size and jerk < -tolerance * jerk_size
        return 0.0 if pressed or soon else NEVER
    ratio = -rate / arrival if arrival < 0.0 else 1.0
    if rate < 0.0 or not pressed or ratio >= 1.0:
        return NEVER
    # the acceleration is -(steady + drift t + damping g')
    damping = (push_before - push) * ratio / (rate * (1.0 + ratio))
    steady = -push - damping * rate
    drift = -jerk - damping * push
    if steady <= 0.0:
        return NEVER
    wait = 2.0 * rate / (steady * (1.0 - ratio))
    change = (abs(drift) / steady + abs(damping)) * wait
    size = sum_of_terms(affine, m, at.guard_row(e, 0), z, extent)[1]
    low = 0.5 * (ratio * rate) ** 2 / steady <= _LOW * size  # of the next one: rounding hides it
    low = low or wait <= _SHORTER * clock[at.WINDOW]
    if change <= _NEARLY_STEADY:
        wait *= 1.0 - drift * wait / (3.0 * steady) - damping * wait / 6.0
        short = clock[at.IS_PERIOD] != 0.0 and wait <= _SHORT * clock[at.WINDOW]
        return wait if low or (short and change <= _STEADY) else NEVER
    # friction: flights fall with one acceleration and have risen with another
    uneven = low and push_before < 0.0 and ratio * ratio * push_before > push
    if uneven and abs(jerk) * wait <= _NEARLY_STEADY * -push:
        down = math.sqrt(push * push_before)
        return rate * (1.0 / down - 1.0 / push) / (1.0 + ratio * down / push)
    return NEVER
