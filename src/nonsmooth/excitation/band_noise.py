"""`band_noise`: Gaussian noise within a band of frequencies."""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.options import check_seed
from nonsmooth.errors import OptionError
from nonsmooth.excitation.record import Excitation, sample_count
from nonsmooth.fatigue.checks import positive

__all__ = ["band_noise"]

_FEWEST = 5  # lines; of less the sum is far from Gaussian, and one is a sine


def band_noise(
    low: float = 15.0,
    high: float = 25.0,
    rms: float = 1.0,
    *,
    duration: float = 20.0,
    samples_per_period: int = 32,
    seed: int = 0,
) -> Excitation:
    """Stochastic base acceleration: Gaussian lines within a band, nothing outside of it.

    Lines one over the duration apart have independent normal parts, so the record is a stationary
    Gaussian process that repeats itself after its duration.

    Parameters
    ----------
    low, high : float
        Ends of the band, in Hz, included.
    rms : float
        Root mean square of this record, m/s^2.

    Other Parameters
    ----------------
    duration : float, optional
        Length in s; the record repeats itself after it.
    samples_per_period : int, optional
        Samples in a period of the highest frequency.
    seed : int, optional
        Seed of the random numbers.

    Returns
    -------
    Excitation
        The record; it is periodic.

    Raises
    ------
    OptionError
        For a band that is empty or holds less than five lines, of which no noise is made.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> noise = ns.excitation.band_noise(15.0, 25.0, rms=2.0, seed=1)
    >>> round(noise.power(), 9), 15 <= noise.dominant_frequency <= 25
    (4.0, True)
    """
    first, last = positive("low", low, "Hz"), positive("high", high, "Hz")
    if last < first:
        raise OptionError(
            f"high = {last:g} Hz: the band ends below its beginning, low = {first:g} Hz"
        )
    size, drawn = positive("rms", rms, "m/s^2"), check_seed(seed)
    count, _ = sample_count(duration, last, samples_per_period)
    step = float(duration) / count  # the whole duration, if it holds no whole number of periods
    frequency = np.fft.rfftfreq(count, step)
    slack = 1e-9 * last
    inside = np.flatnonzero((frequency >= first - slack) & (frequency <= last + slack))
    if inside.size < _FEWEST:
        number = inside.size or "no"
        raise OptionError(
            f"a record of {duration:g} s has a line every {1 / duration:.4g} Hz, and {number} of"
            f" them between {first:.9g} and {last:.9g} Hz; noise needs {_FEWEST}: give a longer"
            " duration or a wider band"
        )
    rng = np.random.default_rng(drawn)
    lines = np.zeros(frequency.size, dtype=complex)
    lines[inside] = rng.standard_normal(inside.size) + 1j * rng.standard_normal(inside.size)
    values = np.fft.irfft(lines, count)
    values *= size / np.sqrt(np.mean(values**2))
    details = {"low": first, "high": last, "gain": size, "seed": drawn}
    return Excitation(step * np.arange(count), values, "noise", True, details)
