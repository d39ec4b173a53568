"""`harmonic`: a sine of base acceleration."""

from __future__ import annotations

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.excitation.record import Excitation, sample_count
from nonsmooth.fatigue.checks import finite, positive

__all__ = ["harmonic"]


def harmonic(
    frequency: float = 20.0,
    amplitude: float = 1.0,
    *,
    duration: float = 20.0,
    phase: float = 0.0,
    samples_per_period: int = 64,
) -> Excitation:
    """Harmonic base acceleration, sampled.

    Parameters
    ----------
    frequency : float
        Frequency in Hz.
    amplitude : float
        Amplitude of the acceleration, m/s^2.

    Other Parameters
    ----------------
    duration : float, optional
        Length in s, a whole number of periods.
    phase : float, optional
        Phase at time zero, in rad.
    samples_per_period : int, optional
        Samples in a period; the cubic curve of `as_signal` through 64 is off by 5e-7 of the
        amplitude.

    Returns
    -------
    Excitation
        The record; it is periodic.

    Raises
    ------
    OptionError
        For a duration that holds no whole number of periods, and numbers out of range.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> sine = ns.excitation.harmonic(20.0, 3.0, duration=5.0)
    >>> round(sine.power(), 9), sine.dominant_frequency
    (4.5, 20.0)
    """
    size = positive("amplitude", amplitude, "m/s^2")
    count, step = sample_count(duration, frequency, samples_per_period)
    turns = duration * frequency
    if abs(turns - round(turns)) > 1e-9 * turns:
        raise OptionError(
            f"duration = {duration:g} s holds {turns:.9g} periods of frequency = {frequency:g} Hz;"
            " give a duration of a whole number of them"
        )
    angle = 2.0 * np.pi * (np.arange(count) % samples_per_period) / samples_per_period
    values = size * np.sin(angle + finite("phase", phase))
    details = {"frequency": float(frequency), "gain": size, "phase": float(phase)}
    return Excitation(step * np.arange(count), values, "harmonic", True, details)
