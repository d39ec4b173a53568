"""Measured input: piecewise cubics of time, each with its rates as four coordinates.

The coordinates of a signal are its value, rate, second and third derivative. Each is the rate
of the one before it, so that a signal is a chain in the generator, the same in all pieces; the
values are filled from the piece that holds at the start of a segment, and segments end at knots.
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import kernel

__all__ = ["fill_chains", "fill_first_pieces", "fill_signals"]

_UNIT = 2.220446049250313e-16
_ROUNDINGS = 4.0  # that may lie between a knot and the end of the segment that it ended


@kernel
def fill_signals(signals, knots, first, window, number, phase, z):
    """Values and derivatives of the signals at a phase.

    shapes: signals, knots as in Tables; z (N,), the coordinates of signals from ``first`` on
    returns: time to the next knot of any signal; behind the last one, the length of its piece
    """
    before = number * window
    slack = _ROUNDINGS * _UNIT * (abs(before) + window)
    soonest = at.WINDOWS * window
    for j in range(signals.shape[0]):
        k = _piece_at(knots, signals[j, at.FIRST], signals[j, at.KNOTS], before, phase + slack)
        _fill(knots, k, (before - knots[k, at.TIME]) + phase, first + at.CHAIN * j, z)
        rest = (knots[k + 1, at.TIME] - before) - phase
        if rest <= slack:
            rest = knots[k + 1, at.TIME] - knots[k, at.TIME]
        soonest = min(soonest, rest)
    return soonest


@kernel
def fill_first_pieces(signals, knots, first, z):
    """Values and derivatives of the signals, each at its own beginning.

    shapes: as in fill_signals
    """
    for j in range(signals.shape[0]):
        _fill(knots, signals[j, at.FIRST], 0.0, first + at.CHAIN * j, z)


@kernel
def fill_chains(generator, first, count):
    """Rows of the generator that make each derivative the rate of the one before it.

    shapes: generator (N, N)
    """
    for j in range(count):
        for i in range(at.CHAIN - 1):
            generator[first + at.CHAIN * j + i, first + at.CHAIN * j + i + 1] = 1.0


@kernel
def _piece_at(knots, first, count, before, phase):
    """Last piece that begins at a time or before; the first one and the last one go on."""
    low, high = first, first + count - 1
    while high - low > 1:
        middle = (low + high) // 2
        if knots[middle, at.TIME] - before <= phase:
            low = middle
        else:
            high = middle
    return low


@kernel
def _fill(knots, k, s, i, z):
    """Value and derivatives of the piece at row k, a time s after it began."""
    c0, c1, c2, c3 = knots[k, 1], knots[k, 2], knots[k, 3], knots[k, 4]
    z[i] = c0 + s * (c1 + s * (c2 + s * c3))
    z[i + 1] = c1 + s * (2.0 * c2 + s * 3.0 * c3)
    z[i + 2] = 2.0 * c2 + 6.0 * c3 * s
    z[i + 3] = 6.0 * c3
