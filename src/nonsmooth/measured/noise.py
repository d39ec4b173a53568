"""Noise of a measured variable, told from its samples."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr

__all__ = ["noise_before_filters", "white_noise"]

_NOISE_ORDER = 6  # of the differences by which noise is told from a sampled motion
_NORMAL = 0.674489750196082  # median of the size of a standard normal variable


def white_noise(values: npt.NDArray[np.float64]) -> float:
    """Standard deviation of white noise on a motion that is smooth from sample to sample.

    Differences of sixth order leave next to nothing of the motion; their median size does not
    feel the few samples about a contact.
    """
    differences = np.diff(values, _NOISE_ORDER)
    gain = math.sqrt(math.comb(2 * _NOISE_ORDER, _NOISE_ORDER))
    return float(np.median(np.abs(differences))) / _NORMAL / gain


def noise_before_filters(variable: xr.DataArray) -> float:
    """Standard deviation of its white noise; of a filtered variable that before the filter.

    What a low-pass leaves of noise looks smooth, and is as strong as ever at low frequencies.
    """
    words = variable.attrs
    if "low_pass" in words and "noise" in words:
        return float(words["noise"]) / float(words["noise_gain"])
    return white_noise(variable.values.astype(float))
