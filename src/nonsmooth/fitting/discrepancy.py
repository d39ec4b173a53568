"""Errors that follow the motion: of the time base, of the sensor, of the model.

Noise does not know where the machine is. Other errors do, and come again whenever the motion does:

- the time base: the times of the samples come early or late, anew in each period, as where they
  are read from marks of a shaft that jitter. The error is the rate of the signal times the delay;
- the sensor: a filter of a few samples acts on the signal, such as that of a sensor whose band is
  not wide. It acts on second differences, as gain and delay are options of a fit;
- the motion: any filter as long as a period acts on the signal. It says nothing of the cause: the
  model or the sensor is wrong, in a way that repeats with the motion.

Each is a family of random errors with one variance, which is found by restricted maximum likelihood
(`nonsmooth.fitting.variance_components`). The covariance of the estimates follows from that. This
is the discrepancy of Kennedy and O'Hagan with the filtered signal as its covariance: what the fit
cannot absorb of an error tells the size of that which it has absorbed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt
from scipy.signal import lfilter
from scipy.sparse import csr_array

from nonsmooth.fitting.correlated import NOT_WHITE, autoregression
from nonsmooth.fitting.residuals import Residuals
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.fitting.solver import Fitted
from nonsmooth.fitting.variance_components import Components, variance_components

__all__ = ["MOTION", "SENSOR", "SOURCES", "TIME_BASE", "Discrepancies", "Discrepancy",
           "discrepancies_of"]  # fmt: skip

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

TIME_BASE, SENSOR, MOTION = SOURCES = ("time base", "sensor", "motion")

_REACH = 2  # of the filter of a sensor, in samples to each side
_PER_PERIOD = 30  # lags of the filter over a period, to each side
_NO_PERIOD = 50.0  # samples that take its place
_FEWEST = 50  # samples of a channel that is looked at
_MOST, _MOST_PERIODS = 20_000, 200  # from which variances are found: more tell little more
_EXACT = 1e-6  # of the spread of a channel: errors of the integration follow the motion, too
_ROUNDS = 3  # of families and the correlation of what they leave


class Discrepancy(NamedTuple):
    """Random errors of one source in one channel."""

    channel: int
    source: str
    size: float  # root mean square, in units of the noise of the channel
    time: float  # standard deviation of the time of a sample; nan but for the time base
    freedom: float  # degrees of freedom with which the size is known
    factor: Floats  # (m, r): its product with itself is the covariance of r sums of residuals


class Discrepancies(NamedTuple):
    """What follows the motion in the residuals, and what does not."""

    found: list[Discrepancy]
    rows: Residuals  # residuals without it; rows that were not looked at do not match
    n_spent: float  # how many coefficients were found


class _Family(Protocol):
    """Columns with random coefficients, over all samples of a channel."""

    def columns(self, last: int) -> Floats:
        """Those (last, m) that are not zero in the first samples."""

    def loads(self, weights: Floats) -> Floats:
        """Sums (m, r) of all columns with weights (K, r)."""


class _Filter(NamedTuple):
    """A filter with random coefficients that acts on a series."""

    series: Floats
    lags: Integers

    def _late(self, lag: int, last: int) -> Floats:
        reach = int(np.abs(self.lags).max())
        wide = np.pad(self.series, reach, mode="edge")
        return wide[reach - lag : reach - lag + last]

    def columns(self, last: int) -> Floats:
        return np.stack([self._late(int(lag), last) for lag in self.lags], axis=1)

    def loads(self, weights: Floats) -> Floats:
        count = self.series.size
        return np.array([self._late(int(lag), count) @ weights for lag in self.lags])


class _Clock(NamedTuple):
    """Delays at marks, between which they change in proportion to the time, times a rate."""

    matrix: csr_array  # (K, marks)

    def columns(self, last: int) -> Floats:
        found: Floats = self.matrix[:last].toarray()
        return found[:, np.abs(found).max(axis=0, initial=0.0) > 0.0]

    def loads(self, weights: Floats) -> Floats:
        found: Floats = self.matrix.T @ weights
        return found


def discrepancies_of(shooting: Shooting, fitted: Fitted, tangents: Floats) -> Discrepancies:
    """Errors that follow the motion, in all channels of samples.

    tangents: orthonormal derivatives (N, r) of all residuals by what was fitted; the covariances
    that are found are those of the sums of residuals with these weights
    """
    rows = fitted.evaluation.rows
    found: list[Discrepancy] = []
    residual, matched, spent = rows.residual.copy(), rows.matched.copy(), 0.0
    for c, channel in enumerate(shooting.channels):
        own = np.flatnonzero(rows.channel == c)
        size = np.sqrt(np.mean(residual[own] ** 2)) * fitted.noise[c] if own.size else 0.0
        if channel.shows_events or own.size < _FEWEST or size <= _EXACT * channel.spread:
            continue
        looked = _Looked.at(shooting, fitted, c, own)
        parts = looked.components(tangents[own])
        if parts is None:
            continue
        found += looked.discrepancies(parts, tangents[own])
        inside = rows.place[own] < looked.last
        residual[own[inside]] -= looked.likely(parts)[rows.place[own[inside]]]
        matched[own[~inside]] = False
        spent += parts.n_spent
    return Discrepancies(found, rows._replace(residual=residual, matched=matched), spent)


class _Looked(NamedTuple):
    """A channel with its families."""

    channel: int
    place: Integers  # (N,) samples of its rows
    residual: Floats  # (K,) nan where there is none
    rate: float  # root mean square of the rate of the signal, over the noise
    families: Sequence[_Family]
    last: int  # how many samples variances are found from

    @classmethod
    def at(cls, shooting: Shooting, fitted: Fitted, c: int, own: Integers) -> _Looked:
        """A channel at a minimum, and what its errors would follow."""
        rows, r = fitted.evaluation.rows, int(shooting.record_of_channel[c])
        record, place = shooting.records[r], rows.place[own]
        count = int(place.max()) + 1
        residual, data = np.full(count, np.nan), shooting.channels[c].values
        residual[place] = rows.residual[own]
        signal = data[place] / fitted.noise[c] + rows.residual[own]
        order = np.argsort(place)
        signal = np.interp(np.arange(count), place[order], signal[order])
        times = record.times[:count]
        period = record.period(shooting.values_in(r, shooting.head_values(fitted.u)))
        if period is None:
            period = _NO_PERIOD * record.step
        rate = np.gradient(signal, times)
        bent = np.pad(np.diff(signal, 2), 1)
        half = max(1.0, 0.5 * period / record.step)
        long = np.unique(np.round(np.linspace(-half, half, 2 * _PER_PERIOD + 1)).astype(int))
        families = (
            _Clock(_between_marks((times - times[0]) / period, _scaled(rate))),
            _Filter(_scaled(bent), np.arange(-_REACH, _REACH + 1)),
            _Filter(_scaled(signal - signal.mean()), long),
        )
        last = min(count, _MOST, int(np.searchsorted(times - times[0], _MOST_PERIODS * period)))
        return cls(c, place, residual, float(np.sqrt(np.mean(rate**2))), families, last)

    def components(self, tangents: Floats) -> Components | None:
        """Families for which the residuals speak, beside noise that is an autoregression."""
        known = np.isfinite(self.residual[: self.last])
        own = self.place < self.last
        if np.count_nonzero(own) < _FEWEST:
            return None
        along = np.zeros((self.last, tangents.shape[1]))
        along[self.place[own]] = tangents[own]
        columns = [known[:, None] * each.columns(self.last) for each in self.families]
        residual = np.where(known, self.residual[: self.last], 0.0)
        left, found = self.residual[: self.last], None
        for _ in range(_ROUNDS):
            back = autoregression(left)
            found = variance_components(
                lfilter(back, [1.0], residual),
                [lfilter(back, [1.0], each, axis=0) for each in columns],
                lfilter(back, [1.0], along, axis=0),
                NOT_WHITE,
            )
            if found is None:
                break
            left = self.residual[: self.last] - np.concatenate(columns, axis=1) @ found.coefficients
        return found

    def likely(self, found: Components) -> Floats:
        """The most likely errors (last,) that follow the motion."""
        columns = np.concatenate([each.columns(self.last) for each in self.families], axis=1)
        errors: Floats = columns @ found.coefficients
        return errors

    def discrepancies(self, found: Components, tangents: Floats) -> list[Discrepancy]:
        """The families as errors of the channel."""
        weights = np.zeros((self.residual.size, tangents.shape[1]))
        weights[self.place] = tangents
        parts = []
        for family, variance, freedom in zip(
            found.families, found.variances, found.freedom, strict=True
        ):
            each, deviation = self.families[family], float(np.sqrt(variance))
            size = deviation * np.sqrt(np.mean((each.columns(self.last) ** 2).sum(axis=1)))
            time = deviation / self.rate if SOURCES[family] == TIME_BASE else np.nan
            factor = deviation * each.loads(weights)
            parts.append(
                Discrepancy(
                    self.channel, SOURCES[family], float(size), time, float(freedom), factor
                )
            )
        return parts


def _between_marks(phase: Floats, rate: Floats) -> csr_array:
    """A rate times the share that each mark has in the time of a sample; marks at whole phases."""
    before = np.floor(phase).astype(int)
    part, sample = phase - before, np.arange(phase.size)
    entries = np.concatenate([(1.0 - part) * rate, part * rate])
    places = np.tile(sample, 2), np.concatenate([before, before + 1])
    return csr_array((entries, places), shape=(phase.size, int(before.max()) + 2))


def _scaled(series: Floats) -> Floats:
    """With a root mean square of one."""
    found: Floats = series / max(float(np.sqrt(np.mean(series**2))), 1e-300)
    return found
