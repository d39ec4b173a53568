"""A sensor between a machine and its record: what it takes away and what it adds.

In this order: a filter of first or second order, a gain, an offset and a delay; noise that is white
or coloured; marks of the shaft that jitter, from which the times of the record come; and a
recorder that rounds. None of it is code of the package.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.signal import bilinear, lfilter

FINER = 8  # instants of the motion per sample of the record: a filter sees what lies between


class Sensor(NamedTuple):
    """Shares are of the standard deviation of what is shown, times of the sampling interval."""

    noise: float = 0.02  # standard deviation, as a share
    colour: float = 0.0  # correlation of the noise from sample to sample, first order
    band: float = np.inf  # corner frequency, as a part of the sampling rate
    order: int = 2  # of the filter; the second order has a damping ratio of 0.7
    gain: float = 1.0
    offset: float = 0.0  # as a share
    delay: float = 0.0  # in sampling intervals
    jitter: float = 0.0  # of a mark of the shaft, as a part of a period
    bits: int = 0  # of the recorder; 0 does not round


def fine_times(begin: float, step: float, count: int) -> np.ndarray:
    """Instants at which a motion is needed, from one sampling interval before the record on."""
    return begin + step * (np.arange(-FINER, FINER * (count - 1) + 1) / FINER)


def record(
    step: float,
    period: float,
    channels: dict[str, np.ndarray],
    sensors: dict[str, Sensor],
    times: np.ndarray,
    rng: np.random.Generator,
) -> xr.Dataset:
    """What is recorded of channels that are known at `fine_times`."""
    taken = times[FINER::FINER]
    shown = {}
    for name, values in channels.items():
        sensor = sensors[name]
        spread = float(np.std(values))
        through = _filtered(values, sensor, step / FINER)
        late = np.interp(taken - sensor.delay * step, times, through)
        read = sensor.gain * late + sensor.offset * spread
        read = read + sensor.noise * spread * coloured(read.size, sensor.colour, rng)
        shown[name] = ("time", _rounded(read, sensor.bits))
    jitter = max(each.jitter for each in sensors.values())
    return xr.Dataset(shown, {"time": by_marks(taken, period, jitter, rng)})


def coloured(count: int, colour: float, rng: np.random.Generator) -> np.ndarray:
    """Noise of variance one in which a sample remembers the one before."""
    white = rng.standard_normal(count)
    white[1:] *= np.sqrt(1.0 - colour**2)
    found: np.ndarray = lfilter([1.0], [1.0, -colour], white)
    return found


def by_marks(
    times: np.ndarray, period: float, jitter: float, rng: np.random.Generator
) -> np.ndarray:
    """Times as they are read from one mark per period, each of which comes early or late."""
    if not jitter:
        return times
    count = int(np.ceil((times[-1] - times[0]) / period)) + 3
    marks = times[0] + period * (np.arange(count) - 1.0)
    seen = marks + jitter * period * rng.standard_normal(count)
    return np.interp(
        times, np.append(seen, seen[-1] + period), np.append(marks, marks[-1] + period)
    )


def _filtered(values: np.ndarray, sensor: Sensor, step: float) -> np.ndarray:
    """Through the filter, which has been on for long and begins with what it sees first."""
    if not np.isfinite(sensor.band):
        return values
    corner = 2.0 * np.pi * sensor.band / (FINER * step)
    poles = [1.0, corner] if sensor.order == 1 else [1.0, 1.4 * corner, corner**2]
    above, below = bilinear([poles[-1]], poles, 1.0 / step)
    return values[0] + lfilter(above, below, values - values[0])


def _rounded(values: np.ndarray, bits: int) -> np.ndarray:
    """On the grid of a recorder whose range is a quarter wider than the record."""
    if not bits:
        return values
    step = 2.5 * np.abs(values).max() / 2**bits
    return np.round(values / step) * step
