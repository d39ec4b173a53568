"""Amplitude and power density of segments by the fast Fourier transform."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["Lines", "lines_of", "phases"]

Floats = npt.NDArray[np.float64]


class Lines(NamedTuple):
    """A spectrum line by line; ``number`` counts periods in the length of a segment."""

    number: npt.NDArray[np.int64]
    amplitude: Floats
    density: Floats


def lines_of(values: npt.NDArray[Any], weights: Floats, step: float) -> Lines:
    """Spectrum of segments (segment, sample); of real ones sines, of complex ones circles.

    The size of the mean of all segments is the amplitude at zero, and its square the power there,
    whatever the window: a window would spread it over the lines beside.
    """
    mean = values.mean()
    make: Any = _two_sided if np.iscomplexobj(values) else _one_sided
    lines: Lines = make(values - mean, weights, step)
    zero = lines.number == 0
    lines.amplitude[zero] = abs(mean)
    lines.density[zero] += abs(mean) ** 2 * values.shape[1] * step
    return lines


def _one_sided(values: Floats, weights: Floats, step: float) -> Lines:
    """Spectrum of real segments: amplitudes of sines."""
    length = values.shape[1]
    power = (np.abs(np.fft.rfft(values * weights, axis=1)) ** 2).mean(axis=0)
    sides = np.full(power.size, 2.0)
    sides[0] = 1.0
    if length % 2 == 0:
        sides[-1] = 1.0
    amplitude = sides * np.sqrt(power) / weights.sum()
    density = sides * power * step / (weights @ weights)
    return Lines(np.arange(power.size), amplitude, density)


def _two_sided(values: npt.NDArray[np.complex128], weights: Floats, step: float) -> Lines:
    """Spectrum of complex segments, from the lowest negative frequency on: radii of circles.

    Of an even number of samples the line at half their frequency, which has no sign, is the
    lowest one.
    """
    length = values.shape[1]
    power = (np.abs(np.fft.fft(values * weights, axis=1)) ** 2).mean(axis=0)
    power = np.fft.fftshift(power)
    number = np.arange(length) - length // 2
    return Lines(number, np.sqrt(power) / weights.sum(), power * step / (weights @ weights))


def phases(values: npt.NDArray[Any], weights: Floats) -> Floats:
    """Phase of each line of one segment at the time one step before its first sample.

    That at zero is the direction of the mean, as the amplitude there is its size: pi of a mean
    below zero.
    """
    length, mean = values.size, values.mean()
    weighted = (values - mean) * weights
    if np.iscomplexobj(values):
        transform, number = np.fft.fftshift(np.fft.fft(weighted)), np.arange(length) - length // 2
    else:
        transform, number = np.fft.rfft(weighted), np.arange(length // 2 + 1)
    found = np.asarray(np.angle(transform * np.exp(-2j * np.pi * number / length)))
    found[number == 0] = np.angle(mean)
    return found
