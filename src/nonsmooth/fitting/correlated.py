"""Residuals that are correlated: whether they are, and how far estimates vary because of it.

Least squares takes residuals to be white. Where they are not, it still finds the right parameters,
but says too small an error: 100 samples that follow each other closely tell no more than ten.
Residuals of each channel are described by an autoregression whose order is chosen by Akaike's
criterion, innovations of channels may be correlated, and the covariance of the estimates follows
from that.

Residuals remember less than the noise does: a fit takes out of them what looks like a change of
its unknowns, and that is what varies slowly. Their autocovariances are made larger by what it takes
out of noise of such a memory, on average (Worsley and others). The memory itself is known only so
well, which gives the variance of an estimate degrees of freedom (Satterthwaite).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import solve_toeplitz, toeplitz
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
_ROUNDS = 4  # of the memory and of what a fit takes out of noise with it


class Correlation(NamedTuple):
    """Autoregressions of the residuals of C channels on K samples."""

    filters: list[Floats]  # 1, -a1, -a2 ... for each channel
    innovations: Floats  # (C, C) covariance of what is new in each sample
    rows: Residuals
    n_samples: int

    def covariance_of(self, weights: Floats) -> Floats:
        """Covariance (r, r) of sums of residuals with some weights (N, r)."""
        carried = self._carried(weights)
        found: Floats = np.einsum("cd,ckr,dks->rs", self.innovations, carried, carried)
        return found

    def freedom_of(self, weights: Floats, root: Floats) -> Floats:
        """Degrees of freedom (m,) of the variances of m combinations (m, r) of such sums.

        Two over the variance of the logarithm. What is known of an autoregression is taken as that
        of its channel alone, by the asymptotic covariance of Yule and Walker.
        """
        carried, counts = self._carried(weights), self._counts
        along = np.einsum("cd,dkr->ckr", self.innovations, carried)
        products = np.einsum("ckr,dks->cdrs", carried, carried)
        each = np.einsum("ir,cdrs,is->icd", root, products, root)  # of one combination
        shares = self.innovations @ each
        whole = np.trace(shares, axis1=1, axis2=2)
        among = np.sqrt(counts[:, None] * counts)
        spread = 2.0 * np.einsum("icd,idc->i", shares / among, shares)
        for c, back in enumerate(self.filters):
            order = back.size - 1
            if not order:
                continue
            changed = lfilter([1.0], back, carried[c], axis=0)
            later = [changed[: changed.shape[0] - j].T @ along[c, j:] for j in range(1, order + 1)]
            slopes = 2.0 * np.einsum("ir,jrs,is->ij", root, np.array(later), root)
            known = self._autocovariances(c, order - 1)
            error = self.innovations[c, c] / counts[c] * np.linalg.inv(toeplitz(known))
            spread += np.einsum("ij,jk,ik->i", slopes, error, slopes)
        found = np.full(whole.shape, np.inf)
        np.divide(2.0 * whole**2, spread, out=found, where=spread > 0.0)
        return found

    def lost_to(self, tangents: Floats, lags: int) -> Floats:
        """What a fit takes out of sums (C, lags + 1) of products of residuals, on average.

        tangents: orthonormal derivatives (N, r) of the residuals by what was fitted
        """
        carried = self._carried(tangents)
        inner = np.einsum("cd,ckr,dks->rs", self.innovations, carried, carried)
        lost = np.zeros((len(self.filters), lags + 1))
        for c, back in enumerate(self.filters):
            own = np.flatnonzero((self.rows.channel == c) & self.rows.matched)
            news = np.einsum("d,dkr->kr", self.innovations[c], carried)[::-1]
            shared = lfilter([1.0], back, news, axis=0)[-self.n_samples :]  # with the residuals
            weights, place = np.zeros_like(shared), self.rows.place[own]
            weights[place] = tangents[own]
            known = np.zeros((self.n_samples, 1))
            known[place] = 1.0
            shared = known * shared
            half = shared - 0.5 * weights @ inner
            for lag in range(lags + 1):
                last = self.n_samples - lag
                lost[c, lag] = np.sum(weights[:last] * half[lag:]) + np.sum(
                    half[:last] * weights[lag:]
                )
        return lost

    def _carried(self, weights: Floats) -> Floats:
        """What an innovation brings to sums over all later samples: (C, K', r), last one first."""
        before = _BEFORE * max(map(len, self.filters))
        carried = []
        for c, back in enumerate(self.filters):
            own = self.rows.channel == c
            series = np.zeros((before + self.n_samples, weights.shape[1]))
            series[before + self.rows.place[own]] = weights[own]
            carried.append(lfilter([1.0], back, series[::-1], axis=0))
        return np.array(carried)

    def _autocovariances(self, c: int, lags: int) -> Floats:
        """Autocovariance of a channel at lags 0, 1 ... by the response of its filter."""
        last = _BEFORE * self.filters[c].size
        response = lfilter([1.0], self.filters[c], np.eye(1, last + lags)[0])
        found = [response[:last] @ response[lag : lag + last] for lag in range(lags + 1)]
        return self.innovations[c, c] * np.array(found)

    @property
    def _counts(self) -> Floats:
        """Number of residuals of each channel."""
        own = self.rows.channel[self.rows.matched]
        return np.maximum(np.bincount(own, minlength=len(self.filters)), 1).astype(float)


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
    tangents: Floats,
    n_spent: float = 0.0,
    at_least: npt.NDArray[np.bool_] | None = None,
    *,
    even_white: bool = False,
) -> Correlation | None:
    """How residuals are correlated; None where no channel speaks against white ones.

    Channels of different records know nothing of each other. Channels of ``at_least`` have a noise
    that is known to be no smaller, however small their residuals are. ``even_white`` asks for an
    answer where they are white, too: for their size.

    tangents: orthonormal derivatives (N, r) of the residuals by what was fitted
    n_spent: how many coefficients beside these were fitted to the residuals
    """
    n_samples = int(rows.place.max(initial=-1)) + 1
    series = np.full((record_of_channel.size, n_samples), np.nan)
    series[rows.channel[rows.matched], rows.place[rows.matched]] = rows.residual[rows.matched]
    if not even_white and all(ljung_box(each)[1] >= NOT_WHITE for each in series):
        return None
    counts = np.maximum(np.isfinite(series).sum(axis=1), 1)
    lags = [_highest_order(count) for count in counts]
    # residuals are smaller than the noise by what was spent on coefficients
    grown = 1.0 / (1.0 - min(0.5, n_spent / np.count_nonzero(rows.matched)))
    seen = [grown * products(each, most) for each, most in zip(series, lags, strict=True)]
    whole = seen
    found = _described(seen, series, counts, record_of_channel, rows)
    for _ in range(_ROUNDS if tangents.size else 0):
        lost = found.lost_to(tangents, max(lags))
        whole = [
            # not where noise of other channels has come in by the fit, more than that
            each + (other[: each.size] if each[0] + other[0] > 0.0 else 0.0)
            for each, other in zip(seen, lost, strict=True)
        ]
        found = _described(whole, series, counts, record_of_channel, rows)
    lift = np.ones(len(series))
    if at_least is not None:
        size = np.sqrt([each[0] for each in whole] / counts)
        lift[at_least] = 1.0 / np.clip(size[at_least], 1e-300, 1.0)
    return found._replace(innovations=found.innovations * np.outer(lift, lift))


def _described(
    whole: Sequence[Floats],
    series: Floats,
    counts: npt.NDArray[np.int64],
    record_of_channel: npt.NDArray[np.int64],
    rows: Residuals,
) -> Correlation:
    """Autoregressions by sums of products of residuals, and what is new in each sample."""
    filters, left = [], []
    for each, count in zip(whole, counts, strict=True):
        known = np.eye(1, each.size)[0]  # that of no residuals at all
        np.divide(each, each[0], out=known, where=each[0] > 0.0)
        back, part = _yule_walker(known, int(count))
        filters.append(back)
        left.append(part * float(each[0]) / count)
    news = np.array([
        np.isfinite(each) * lfilter(back, [1.0], np.nan_to_num(each))
        for back, each in zip(filters, series, strict=True)
    ])  # fmt: skip
    size = np.sqrt(np.maximum((news**2).sum(axis=1), 1e-300))
    innovations = (news / size[:, None]) @ (news / size[:, None]).T
    np.fill_diagonal(innovations, 1.0)
    innovations[record_of_channel[:, None] != record_of_channel] = 0.0
    deviations = np.sqrt(left)
    innovations *= np.outer(deviations, deviations)
    return Correlation(filters, innovations, rows, series.shape[1])


def products(series: Floats, lags: int) -> Floats:
    """Sums of products of samples that lie 0, 1 ... apart; those that are nan add nothing."""
    known = np.where(np.isfinite(series), series, 0.0)
    return np.array([float(known[k:] @ known[: known.size - k]) for k in range(lags + 1)])


def autoregression(series: Floats) -> Floats:
    """Autoregression of the order that Akaike's criterion likes best, by Yule and Walker."""
    count = max(1, int(np.isfinite(series).sum()))
    return _yule_walker(autocorrelation(series, _highest_order(count)), count)[0]


def _highest_order(count: int) -> int:
    return max(1, min(int(_ORDER * np.log10(count)), count // 10))


def _yule_walker(known: Floats, count: int) -> tuple[Floats, float]:
    """The autoregression that Akaike's criterion likes best, and what it leaves of the variance.

    known: autocorrelation at lags 0, 1 ...
    """
    best, lowest, part = np.array([1.0]), 0.0, 1.0
    for order in range(1, known.size):
        ahead = solve_toeplitz(known[:order], known[1 : order + 1])
        left = 1.0 - float(ahead @ known[1 : order + 1])
        if left <= 0.0:  # no autocorrelation: too much was added to that of residuals
            break
        criterion = count * np.log(left) + 2.0 * order
        if criterion < lowest:
            best, lowest, part = np.append(1.0, -ahead), criterion, left
    return best, part


def block_length(residual: Floats) -> int:
    """Length of blocks for a bootstrap: the rule of Carlstein for a first-order autoregression."""
    near = min(0.99, abs(float(autocorrelation(residual, 1)[1])))
    reach = (1.5 * (2.0 * near / (1.0 - near**2)) ** 2) ** (1.0 / 3.0)
    return max(1, round(residual.size ** (1.0 / 3.0) * max(2.0, reach)))
