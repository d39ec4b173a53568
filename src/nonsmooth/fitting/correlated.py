"""Residuals that are correlated: whether they are, and how far estimates vary because of it.

Least squares takes residuals to be white. Where they are not, it still finds the right parameters,
but says too small an error: 100 samples that follow each other closely tell no more than ten.
Residuals of each channel are described by an autoregression whose order is chosen by Akaike's
criterion, innovations of channels may be correlated, and the covariance of the estimates follows
from that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter
from scipy.stats import chi2

from nonsmooth.fitting.residuals import Residuals

__all__ = ["NOT_WHITE", "Correlation", "autoregression", "block_length", "correlation_of",
           "ljung_box"]  # fmt: skip

Floats = npt.NDArray[np.float64]

NOT_WHITE = 0.01  # probability below which residuals are taken to be correlated
_LAGS = 20
_ORDER = 10.0  # highest order of an autoregression, times the logarithm of the number of samples
_BEFORE = 50  # innovations before the first sample that count, in orders


class Correlation(NamedTuple):
    """Autoregressions of the residuals of C channels on K samples."""

    filters: list[Floats]  # 1, -a1, -a2 ... for each channel
    innovations: Floats  # (C, C) covariance of what is new in each sample
    rows: Residuals
    n_samples: int

    def covariance_of(self, weights: Floats) -> Floats:
        """Covariance (r, r) of sums of residuals with some weights (N, r)."""
        before = _BEFORE * max(map(len, self.filters))
        carried = []
        for c, back in enumerate(self.filters):
            own = self.rows.channel == c
            series = np.zeros((before + self.n_samples, weights.shape[1]))
            series[before + self.rows.place[own]] = weights[own]
            # what an innovation brings to all later samples: the filter runs backwards
            carried.append(lfilter([1.0], back, series[::-1], axis=0))
        found: Floats = np.einsum("cd,ckr,dks->rs", self.innovations, carried, carried)
        return found


def ljung_box(series: Floats) -> tuple[float, float]:
    """Statistic of Ljung and Box, and the probability of one so large of white residuals."""
    series = series[np.isfinite(series)]
    count, lags = series.size, max(1, min(_LAGS, series.size // 5))
    squares = autocorrelation(series, lags)[1:] ** 2 / (count - np.arange(1, lags + 1))
    statistic = float(count * (count + 2) * squares.sum())
    return statistic, float(chi2.sf(statistic, lags))


def autocorrelation(series: Floats, lags: int) -> Floats:
    """Autocorrelation (lags + 1,) of a series; samples that are nan add nothing."""
    centred = np.where(np.isfinite(series), series - np.nanmean(series), 0.0)
    total = float(centred @ centred) or 1.0
    later = [float(centred[k:] @ centred[: centred.size - k]) for k in range(1, lags + 1)]
    return np.array([1.0, *(each / total for each in later)])


def correlation_of(
    rows: Residuals,
    record_of_channel: npt.NDArray[np.int64],
    n_spent: float,
    at_least: npt.NDArray[np.bool_] | None = None,
    *,
    even_white: bool = False,
) -> Correlation | None:
    """How residuals are correlated; None where no channel speaks against white ones.

    Channels of different records know nothing of each other. Channels of ``at_least`` have a noise
    that is known to be no smaller, however small their residuals are. ``even_white`` asks for an
    answer where they are white, too: for their size.
    """
    n_samples = int(rows.place.max(initial=-1)) + 1
    series = np.full((record_of_channel.size, n_samples), np.nan)
    series[rows.channel[rows.matched], rows.place[rows.matched]] = rows.residual[rows.matched]
    if not even_white and all(ljung_box(each)[1] >= NOT_WHITE for each in series):
        return None
    filters = [autoregression(each) for each in series]
    news = [
        lfilter(back, [1.0], np.where(np.isfinite(each), each, 0.0))
        for back, each in zip(filters, series, strict=True)
    ]
    known = np.isfinite(series)
    together = np.maximum(known.astype(float) @ known.T, 1.0)
    # residuals are smaller than the noise by what the fit has spent on unknowns
    grown = 1.0 / (1.0 - min(0.5, n_spent / np.count_nonzero(rows.matched)))
    innovations = np.where(known, news, 0.0) @ np.where(known, news, 0.0).T / together
    innovations[record_of_channel[:, None] != record_of_channel] = 0.0
    lift = np.ones(len(series))
    if at_least is not None:
        size = np.sqrt(grown * np.nanmean(series[at_least] ** 2, axis=1))
        lift[at_least] = 1.0 / np.clip(size, 1e-300, 1.0)
    return Correlation(filters, innovations * grown * np.outer(lift, lift), rows, n_samples)


def autoregression(series: Floats) -> Floats:
    """Autoregression of the order that Akaike's criterion likes best, by Yule and Walker."""
    count = int(np.isfinite(series).sum())
    most = max(1, min(int(_ORDER * np.log10(count)), count // 10))
    known = autocorrelation(series, most)
    best, lowest = np.array([1.0]), 0.0
    for order in range(1, most + 1):
        ahead = solve_toeplitz(known[:order], known[1 : order + 1])
        left = 1.0 - float(ahead @ known[1 : order + 1])
        criterion = count * np.log(max(left, 1e-12)) + 2.0 * order
        if criterion < lowest:
            best, lowest = np.append(1.0, -ahead), criterion
    return best


def block_length(residual: Floats) -> int:
    """Length of blocks for a bootstrap: the rule of Carlstein for a first-order autoregression."""
    near = min(0.99, abs(float(autocorrelation(residual, 1)[1])))
    reach = (1.5 * (2.0 * near / (1.0 - near**2)) ** 2) ** (1.0 / 3.0)
    return max(1, round(residual.size ** (1.0 / 3.0) * max(2.0, reach)))
