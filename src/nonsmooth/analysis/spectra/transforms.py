"""Amplitude and power density of segments by the fast Fourier transform."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["Lines", "about_mean", "one_sided", "phases", "two_sided"]

Floats = npt.NDArray[np.float64]


class Lines(NamedTuple):
    """A spectrum line by line; ``number`` counts periods in the length of a segment."""

    number: npt.NDArray[np.int64]
    amplitude: Floats
    density: Floats


def one_sided(values: Floats, weights: Floats, step: float) -> Lines:
    """Spectrum of real segments (segment, sample): amplitudes of sines, the mean at zero."""
    length = values.shape[1]
    power = (np.abs(np.fft.rfft(values * weights, axis=1)) ** 2).mean(axis=0)
    sides = np.full(power.size, 2.0)
    sides[0] = 1.0
    if length % 2 == 0:
        sides[-1] = 1.0
    amplitude = sides * np.sqrt(power) / weights.sum()
    density = sides * power * step / (weights @ weights)
    return Lines(np.arange(power.size), amplitude, density)


def two_sided(values: npt.NDArray[np.complex128], weights: Floats, step: float) -> Lines:
    """Spectrum of complex segments, from the lowest negative frequency on: radii of circles.

    Of an even number of samples the line at half their frequency, which has no sign, is the
    lowest one.
    """
    length = values.shape[1]
    power = (np.abs(np.fft.fft(values * weights, axis=1)) ** 2).mean(axis=0)
    power = np.fft.fftshift(power)
    number = np.arange(length) - length // 2
    return Lines(number, np.sqrt(power) / weights.sum(), power * step / (weights @ weights))


def about_mean(values: npt.NDArray[Any], weights: Floats, step: float) -> Lines:
    """Spectrum of segments about their mean, which no window spreads; real or complex ones.

    The amplitude at zero is the mean, the power density there that about it.
    """
    mean = values.mean()
    make: Any = two_sided if np.iscomplexobj(values) else one_sided
    lines: Lines = make(values - mean, weights, step)
    lines.amplitude[lines.number == 0] = abs(mean)
    return lines


def phases(values: npt.NDArray[Any], weights: Floats) -> Floats:
    """Phase of each line of one segment at the time one step before its first sample."""
    length = values.size
    weighted = (values - values.mean()) * weights
    if np.iscomplexobj(values):
        transform, number = np.fft.fftshift(np.fft.fft(weighted)), np.arange(length) - length // 2
    else:
        transform, number = np.fft.rfft(weighted), np.arange(length // 2 + 1)
    return np.asarray(np.angle(transform * np.exp(-2j * np.pi * number / length)))
