"""Spikes: single samples that are off, in a way that no impact explains."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np
import numpy.typing as npt

from nonsmooth.measured.quality.flaw import Flaw, Readings

__all__ = ["spike_findings"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_REACH = 6  # neighbours on either side
_DEGREE = 3  # of the polynomial through them
_WIDTHS = (3.0, 4.0, 6.0, 9.0)  # samples that a contact spans; shorter ones look like spikes
_PLACES = np.arange(-_REACH, _REACH + 0.01, 0.25)  # where an impact may be, in samples
_AGREE = 0.99  # of clean neighbourhoods pass as smooth
_SHARPER = 3.0  # times the distance of its neighbours from their polynomial that a spike is off
_LEAST_STEPS = 3.0  # of the recorder: rounding is no spike


def spike_findings(data: Readings, bad: Mask) -> Iterator[Flaw]:
    """Samples that stand out of a cubic through the twelve about them.

    These are six on either side; at the ends of the record the first or the last thirteen samples
    are the neighbourhood of each that has fewer before or behind it.

    bad: samples that are known to be bad already; what has one about it is not judged
    """
    length = 2 * _REACH + 1
    if data.values.size < length:
        return
    clear = np.convolve((bad | ~np.isfinite(data.values)).astype(float), np.ones(length), "valid")
    windows = np.lib.stride_tricks.sliding_window_view(data.values, length)
    last = len(windows) - 1
    found: list[tuple[int, Floats, int]] = []  # sample, those about it, and its place among them
    for at in range(length):
        # only in the middle, but for the first and the last window
        chosen = slice(None) if at == _REACH else slice(0, 1) if at < _REACH else slice(last, None)
        off, away = _off_and_away(windows[chosen], at)
        limit, smooth = _limits(data, at)
        with np.errstate(invalid="ignore"):
            out = (np.abs(off) > limit) & ((away < smooth) | (np.abs(off) > _SHARPER * away))
        first = chosen.start or 0
        places = np.flatnonzero(out & (clear[chosen] < 0.5)) + first
        found += [(int(k) + at, windows[k], at) for k in places]
    for k, about, at in sorted(found, key=lambda one: one[0]):
        if not _is_no_impact(about, at, data) and not _is_beyond(data.values, k):
            continue
        size, time = float(_off_and_away(about[None], at)[0][0]), float(data.times[k])
        yield Flaw(
            data.name, "spike", time, time, 1, size,
            f"{data.name} has a spike of {data.size(size)} at t = {time:.7g}, one sample",
            np.array([k]),
        )  # fmt: skip


def _deviations(data: Readings) -> float:
    """Standard deviations that none of the samples exceeds by chance."""
    from scipy.stats import norm

    return float(norm.isf(0.5 * data.rate / data.values.size))


def _limits(data: Readings, at: int) -> tuple[float, float]:
    """How far off a sample may be by chance, and how far its neighbours from their cubic."""
    from scipy.stats import chi2

    noise = data.noise
    fit = _neighbours(at)[1]
    limit = _deviations(data) * float(np.sqrt(1.0 + fit[0] @ fit[0])) * noise.most
    free = 2 * _REACH - _DEGREE - 1
    smooth = noise.most * float(np.sqrt(chi2.ppf(_AGREE, free) / (2 * _REACH)))
    # without noise to compare with, only the shape tells
    return max(limit, _LEAST_STEPS * noise.step), smooth if noise.visible else 0.0


@cache
def _neighbours(at: int) -> tuple[npt.NDArray[np.int64], Floats, Floats]:
    """Places of the neighbours, from the sample on, the fit of a cubic, and its values there."""
    places = np.delete(np.arange(2 * _REACH + 1), at) - at
    powers = np.vander(places, _DEGREE + 1, increasing=True).astype(float)
    fit = np.linalg.pinv(powers)
    return places, fit, powers @ fit


def _off_and_away(about: Floats, at: int) -> tuple[Floats, Floats]:
    """Distance of one sample of windows from the cubic through the others, and theirs from it."""
    places, fit, projection = _neighbours(at)
    around = about[:, places + at]
    left = around - around @ projection.T
    return about[:, at] - around @ fit[0], np.sqrt(np.mean(left * left, axis=1))


def _is_no_impact(about: Floats, at: int, data: Readings) -> bool:
    """Whether a spike explains samples so much better than any impact that chance does not.

    Both models are a cubic and one shape more. If an impact is the truth, the sum of squares that
    a spike leaves is smaller by z^2 s^2 with a probability of at most that of z deviations, however
    high the impact (s the standard deviation of the noise): the difference of both sums is normal
    with mean d^2 s^2 and deviation 2 d s^2, and (d^2 + z^2) / 2 d is at least z.
    """
    spike, impacts = _shapes(at)
    by_spike = float(spike @ about) ** 2
    by_impact = float(np.max((impacts @ about) ** 2))
    return by_spike - by_impact > (_deviations(data) * data.noise.most) ** 2


def _is_beyond(values: Floats, k: int) -> bool:
    """Whether the first or the last sample is farther off all others than these are apart.

    A jump between it and the next sample explains it as well as a spike, but for its size.
    """
    if k not in (0, values.size - 1):
        return False
    low, high = np.nanmin(others := np.delete(values, k)), np.nanmax(others)
    return bool(max(low - values[k], values[k] - high) > high - low)


@cache
def _shapes(spike: int) -> tuple[Floats, Floats]:
    """What is left of a spike, and of impacts, when a cubic has been taken off; of length one."""
    places = np.arange(-_REACH, _REACH + 1)
    powers = np.vander(places, _DEGREE + 1, increasing=True).astype(float)
    q = np.linalg.qr(powers)[0]
    shapes = [(places == spike - _REACH).astype(float)]
    for at in _PLACES:
        since = places - at
        shapes += [np.abs(since), np.sign(since)]  # a velocity that jumps, or what is seen of it
        for width in _WIDTHS:
            inside = np.clip(since / width, -0.5, 0.5)
            outside = np.abs(since) - 0.5 * width
            # a half sine, and its integrals: the acceleration, velocity, displacement of a contact
            shapes += [
                np.where(outside < 0.0, np.cos(np.pi * inside), 0.0),
                np.sin(np.pi * inside),
                np.maximum(outside, 0.0) - width / np.pi * np.cos(np.pi * inside),
            ]
    table = np.array(shapes)
    table = table - (table @ q) @ q.T
    lengths = np.sqrt((table * table).sum(axis=1))
    table = table[lengths > 1e-6] / lengths[lengths > 1e-6, None]
    return table[0], table[1:]
