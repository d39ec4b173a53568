"""Mains hum: lines at 50 or 60 Hz that stand out of what is beside them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from nonsmooth.measured.quality.flaw import Flaw, Readings

__all__ = ["hum_findings"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_OFF = 0.2  # Hz, that the mains may be off
_CYCLES = 20.0  # of the mains in a record, at least
_BESIDE = (12, 40)  # lines on either side that are compared with: a broad hump is no line
_AROUND = 2.0  # factor by which a line of the motion may be off to be counted
_WEAKER = 10.0  # times in power that such a line may be below that of the mains
_FRACTIONS = (1, 2, 3, 4)  # of the speed, whose multiples are those of a machine


def hum_findings(data: Readings, mains: Sequence[float], speed: float | None) -> Iterator[Flaw]:
    """Lines of the mains in a channel over a time in s.

    speed: revolutions per s, where known; else the strongest line stands for them
    """
    from scipy.signal import detrend, periodogram

    good = np.isfinite(data.values)
    if not good.any():
        return
    values = np.interp(data.times, data.times[good], data.values[good])
    rate = 1.0 / data.step
    length = values.size / rate
    frequencies, power = periodogram(detrend(values), rate, window="hann", scaling="spectrum")
    usual = float(frequencies[int(np.argmax(power))]) if speed is None else speed
    apart = 2.0 / length
    others = ~_are_of_machine(frequencies, usual, 2.0 * apart)
    for line in mains:
        nearest = np.maximum(np.round(frequencies / line), 1.0)
        others &= np.abs(frequencies - nearest * line) > nearest * _OFF + apart
    for line in mains:
        if line + _OFF + apart >= 0.5 * rate or line * length < _CYCLES:
            continue
        if _are_of_machine(np.array([line]), usual, apart + _OFF)[0]:
            continue
        found = _line(frequencies, power, line, others, data.rate)
        if found is not None:
            at, height = found
            yield Flaw(
                data.name, "hum", *data.span, values.size, height,
                f"{data.name} has a line of {data.size(height)} at {at:.5g} Hz, which is that of"
                " the mains and no multiple of the motion",
            )  # fmt: skip


def _are_of_machine(lines: Floats, speed: float, apart: float) -> Mask:
    """Whether multiples of the speed, or of a fraction of it, fall on lines."""
    found = np.zeros(lines.size, dtype=bool)
    for part in _FRACTIONS if speed > 0.0 else ():
        nearest = np.round(lines * part / speed)
        found |= (nearest > 0) & (np.abs(lines - nearest * speed / part) <= apart)
    return found


def _chances(power: Floats) -> Floats:
    """Chance that noise gives each line of a spectrum, against the lines beside it.

    The power of noise in one line is exponential. Its mean is that of the lines about it, from
    their median, which single lines do not move; it counts as the mean of half as many.
    """
    from scipy.ndimage import median_filter

    found: Floats = np.zeros(power.size)
    for beside in _BESIDE:
        usual = median_filter(power, size=2 * beside + 1, mode="nearest") / math.log(2.0)
        half = 0.5 * beside  # lines next to each other have a part in common, by the window
        with np.errstate(divide="ignore", invalid="ignore"):
            chance = (1.0 + np.where(usual > 0.0, power / usual, 0.0) / half) ** -half
        found = np.maximum(found, chance)
    return found


def _line(
    frequencies: Floats, power: Floats, line: float, others: Mask, rate: float
) -> tuple[float, float] | None:
    """Frequency and amplitude of a line that neither chance nor the motion gives.

    others: lines that are neither of the mains nor multiples of the speed. Where some of these
    stand out as well, the motion has lines of its own, and may have this one.
    """
    near = np.flatnonzero(np.abs(frequencies - line) <= _OFF + 0.5 * frequencies[1])
    if near.size == 0:
        return None
    chance = _chances(power)
    top = int(near[np.argmax(power[near])])
    if near.size * chance[top] >= rate:
        return None
    about = others & (frequencies > line / _AROUND) & (frequencies < line * _AROUND)
    own = about & (chance * max(int(about.sum()), 1) < rate) & (power > power[top] / _WEAKER)
    if own.any():
        return None
    return float(frequencies[top]), math.sqrt(2.0 * float(power[top]))
