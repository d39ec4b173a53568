"""Errors that follow the motion: of the time base, of the sensor, of the forces, of the model.

Noise does not know where the machine is. Other errors do, and come again whenever the motion does:

- the time base: the times of the samples come early or late, anew in each period, as where they
  are read from marks of a shaft that jitter. The error is the rate of the signal times the delay;
- the sensor: a filter of a few samples acts on the signal, such as that of a sensor whose band is
  not wide. It acts on second differences, as gain and delay are options of a fit;
- the motion: any filter as long as a period acts on the signal. It says nothing of the cause: the
  model or the sensor is wrong, in a way that repeats with the motion;
- linear and nonlinear forces: the forces of the model are wrong, by random functions of position
  and velocity (`nonsmooth.fitting.force_errors`). All channels show one and the same error.

Each is a family of random errors with one variance, which is found by restricted maximum likelihood
(`nonsmooth.fitting.variance_components`). The covariance of the estimates follows from that. This
is the discrepancy of Kennedy and O'Hagan, whose covariance is that of the filtered signal, or that
which a random force brings to the record: what the fit cannot absorb of an error tells the size of
that which it has absorbed. So a small rest may stand for a large error of the estimates: where
residuals are not white, a family counts already where its variance would have a probability below a
quarter in noise. It is named below 0.01.

A sample whose residual is far from all others, as beside a jump of the signal, tells nothing of the
forces. What it does to the estimates counts by its square, as in the sandwich of Eicker and White.

Each channel by itself tells which families it needs. The variances of the forces are then found
from all channels together, each of them with the errors that are its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt
from scipy.signal import lfilter
from scipy.sparse import csr_array

from nonsmooth.fitting.correlated import NOT_WHITE, autoregression, ljung_box
from nonsmooth.fitting.force_errors import ForceErrors, force_errors
from nonsmooth.fitting.residuals import Residuals
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.fitting.solver import Fitted
from nonsmooth.fitting.variance_components import Components, variance_components

__all__ = ["LINEAR", "MOTION", "NONLINEAR", "SENSOR", "SOURCES", "TIME_BASE", "Discrepancies",
           "Discrepancy", "discrepancies_of"]  # fmt: skip

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

TIME_BASE, SENSOR, MOTION, LINEAR, NONLINEAR = SOURCES = (
    "time base", "sensor", "motion", "linear forces", "nonlinear forces",
)  # fmt: skip
_OWN = 3  # of these are of one channel, the rest are common to all

_REACH = 2  # of the filter of a sensor, in samples to each side
_PER_PERIOD = 30  # lags of the filter over a period, to each side
_NO_PERIOD = 50.0  # samples that take its place
_COUNTED = 0.25  # probability in noise below which a family counts: as in tests before pooling
_FEWEST = 50  # samples of a channel that is looked at
_MOST, _MOST_PERIODS = 20_000, 200  # from which variances are found: more tell little more
_EXACT = 1e-6  # of the spread of a channel: errors of the integration follow the motion, too
_FAR = 6.0  # standard deviations, which noise of 1e6 samples hardly reaches
_MEDIAN = 0.6744897501960817  # of the size of a normal variable
_SMALL = 0.3  # error of forces, or of what is shown, as a part of it, that may count as small
_ROUNDS = 3  # of families and the correlation of what they leave


class Discrepancy(NamedTuple):
    """Random errors of one source."""

    source: str
    sizes: dict[int, float]  # by channel, root mean square in units of its noise
    unit: float  # standard deviation of times, or as a part of the forces; nan of a filter
    freedom: float  # degrees of freedom with which the size is known
    is_named: bool  # whether residuals surely speak for it
    factor: Floats  # (m, r): its product with itself is the covariance of r sums of residuals


class Discrepancies(NamedTuple):
    """What follows the motion in the residuals, and what does not."""

    found: list[Discrepancy]
    rows: Residuals  # residuals without it; rows that were not looked at do not match
    n_spent: float  # how many coefficients were found
    far: Floats  # (m, r): residuals that nothing explains, times the weights of r sums


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


class _Columns(NamedTuple):
    """Columns that are known."""

    matrix: Floats  # (K, m)

    def columns(self, last: int) -> Floats:
        return self.matrix[:last]

    def loads(self, weights: Floats) -> Floats:
        found: Floats = self.matrix.T @ weights
        return found


def discrepancies_of(shooting: Shooting, fitted: Fitted, tangents: Floats) -> Discrepancies:
    """Errors that follow the motion, in all channels of samples.

    tangents: orthonormal derivatives (N, r) of all residuals by what was fitted; the covariances
    that are found are those of the sums of residuals with these weights
    """
    looked, rows = _looked_at(shooting, fitted), fitted.evaluation.rows
    forces = force_errors(shooting, fitted) if looked else None
    found, explained = [], []
    if forces is not None:
        families = [forces.linear, forces.nonlinear]
        explained = [each.with_common(families).explained(tangents[each.own]) for each in looked]
        if any(each.needs_common for each in explained):
            found = _of_forces(forces, explained, rows.channel, tangents)
    if not found:
        explained = [each.explained(tangents[each.own]) for each in looked]
    found += [part for each in explained for part in each.discrepancies(tangents)]
    residual, matched = rows.residual.copy(), rows.matched.copy()
    for each in explained:
        each.clean(residual, matched, tangents)
    spent = sum(each.parts.n_spent for each in explained if each.parts is not None)
    far = np.zeros(residual.size, bool)
    for each in explained:
        far[each.looked.own] = each.is_far
    return Discrepancies(
        found, rows._replace(residual=residual, matched=matched), spent,
        rows.residual[far, None] * tangents[far],
    )  # fmt: skip


def _looked_at(shooting: Shooting, fitted: Fitted) -> list[_Looked]:
    """Channels with samples enough, and with errors larger than those of the integration."""
    rows, found = fitted.evaluation.rows, []
    for c, channel in enumerate(shooting.channels):
        own = np.flatnonzero(rows.channel == c)
        size = np.sqrt(np.mean(rows.residual[own] ** 2)) * fitted.noise[c] if own.size else 0.0
        if channel.shows_events or own.size < _FEWEST or size <= _EXACT * channel.spread:
            continue
        looked = _Looked.at(shooting, fitted, c, own)
        if np.count_nonzero(looked.is_early) >= _FEWEST:
            found.append(looked)
    return found


def _of_forces(
    forces: ForceErrors, explained: Sequence[_Explained], channel: Integers, tangents: Floats
) -> list[Discrepancy]:
    """Errors of the forces, with coefficients that all data share; none where these speak of none.

    Errors that are not small beside the forces themselves count as none: motions are no longer
    linear in them, and a channel that asks for so much has some other error.
    """
    families = [forces.linear, forces.nonlinear]
    whole = np.concatenate([each.whitened(families, tangents) for each in explained])
    residual, *columns, along = np.split(
        whole, np.cumsum([1, *(each.shape[1] for each in families)]), axis=1
    )
    for counted in max((each.looked.levels for each in explained), key=len):
        joint = variance_components(residual[:, 0], columns, along, NOT_WHITE, counted)
        found = [] if joint is None else _force_errors(forces, joint, channel, tangents)
        if found and max(each.unit for each in found) < _SMALL:
            named = any(each.names_common for each in explained)
            return [each._replace(is_named=each.is_named and named) for each in found]
    return []


def _force_errors(
    forces: ForceErrors, joint: Components, channel: Integers, tangents: Floats
) -> list[Discrepancy]:
    """Errors of the forces with some variances."""
    families, found = [forces.linear, forces.nonlinear], []
    each = zip(joint.families, joint.variances, joint.freedom, joint.named, strict=True)
    for k, variance, freedom, is_named in each:
        own, deviation = families[k], float(np.sqrt(variance))
        squares = (own**2).sum(axis=1)
        sizes = {
            int(c): deviation * float(np.sqrt(squares[channel == c].mean()))
            for c in np.unique(channel)
        }
        share = deviation * float(np.sqrt(own.shape[1] / forces.n_masses))
        factor = deviation * own.T @ tangents
        found.append(Discrepancy(SOURCES[_OWN + k], sizes, share, float(freedom), is_named, factor))
    return found


class _Looked(NamedTuple):
    """A channel with its families."""

    channel: int
    own: Integers  # (N,) its rows
    place: Integers  # (N,) samples of its rows
    residual: Floats  # (K,) nan where there is none, or one that is no noise
    spread: float  # standard deviation of the signal, over the noise
    rate: float  # root mean square of its rate, over the noise
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
        deviation = float(np.sqrt(np.mean(rate**2)))
        return cls(c, own, place, residual, float(signal.std()), deviation, families, last)

    def with_common(self, common: Sequence[Floats]) -> _Looked:
        """The channel with families of all rows of a fit, without samples where these fail."""
        added = [_Columns(self._placed(each[self.own], self.residual.size)) for each in common]
        near = np.where(_far(self.residual), np.nan, self.residual)
        return self._replace(families=[*self.families, *added], residual=near)

    @property
    def is_early(self) -> npt.NDArray[np.bool_]:
        """Which rows variances are found from."""
        return self.place < self.last

    def explained(self, tangents: Floats) -> _Explained:
        """Families for which the residuals speak, beside noise that is an autoregression."""
        known = np.isfinite(self.early)
        along = known[:, None] * self._placed(tangents, self.last)
        columns = [known[:, None] * each.columns(self.last) for each in self.families]
        residual = np.where(known, self.early, 0.0)
        back, found = autoregression(self.early), None
        for _ in range(_ROUNDS):
            whitened = [lfilter(back, [1.0], each, axis=0) for each in (residual, along, *columns)]
            for counted in self.levels:
                found = variance_components(
                    whitened[0], whitened[2:], whitened[1], NOT_WHITE, counted
                )  # fmt: skip
                if found is None or self._are_small(found, columns):
                    break
            if found is None:
                break
            left = self.early - np.concatenate(columns, axis=1) @ found.coefficients
            back = autoregression(left)
        return _Explained(self, back if found is not None else autoregression(self.early), found)

    @property
    def levels(self) -> tuple[float | None, ...]:
        """Levels at which families count without a name, the first one that will do; None: never.

        Residuals that pass for white keep the intervals of white noise.
        """
        return (None,) if ljung_box(self.early)[1] >= NOT_WHITE else (_COUNTED, None)

    def _are_small(self, found: Components, columns: Sequence[Floats]) -> bool:
        """Whether errors of its own are small beside the signal; those of forces are seen later."""
        sizes = [
            variance * np.mean((columns[k] ** 2).sum(axis=1))
            for k, variance in zip(found.families, found.variances, strict=True)
            if k < _OWN
        ]
        return max(sizes, default=0.0) < (_SMALL * self.spread) ** 2

    @property
    def early(self) -> Floats:
        """Residuals that variances are found from, nan where there is none."""
        return self.residual[: self.last]

    def _placed(self, values: Floats, count: int) -> Floats:
        """Values of its rows at the first samples, zero where there are none."""
        found = np.zeros((count, values.shape[1]))
        here = self.place < count
        found[self.place[here]] = values[here]
        return found


class _Explained(NamedTuple):
    """A channel with what its residuals speak for."""

    looked: _Looked
    back: Floats  # autoregression of what that leaves
    parts: Components | None

    @property
    def needs_common(self) -> bool:
        """Whether a family of all channels is among its families."""
        return self.parts is not None and max(self.parts.families) >= _OWN

    @property
    def names_common(self) -> bool:
        """Whether a family of all channels is named."""
        parts = self.parts
        return parts is not None and any(
            is_named and k >= _OWN for k, is_named in zip(parts.families, parts.named, strict=True)
        )

    def _own(self) -> list[tuple[int, float, float, bool]]:
        """Number, variance, its degrees of freedom, and whether it is named: of this channel's."""
        parts = self.parts
        if parts is None:
            return []
        each = zip(parts.families, parts.variances, parts.freedom, parts.named, strict=True)
        return [
            (int(k), float(variance), float(freedom), is_named)
            for k, variance, freedom, is_named in each
            if k < _OWN
        ]

    def whitened(self, common: Sequence[Floats], tangents: Floats) -> Floats:
        """Residuals, common columns and tangents, as if noise and errors of its own were white."""
        looked = self.looked
        known = np.isfinite(looked.early)
        rows = [columns[looked.own] for columns in (*common, tangents)]
        whole = np.column_stack(
            [
                np.where(known, looked.early, 0.0),
                *(looked._placed(each, looked.last) for each in rows),
            ]
        )
        whole = lfilter(self.back, [1.0], known[:, None] * whole, axis=0)
        noise = float(np.mean(whole[known, 0] ** 2)) if self.parts is None else self.parts.noise
        errors = [
            np.sqrt(variance) * known[:, None] * looked.families[k].columns(looked.last)
            for k, variance, _, _ in self._own()
        ]
        if errors:
            filtered = lfilter(self.back, [1.0], np.concatenate(errors, axis=1), axis=0)
            along, sizes, _ = np.linalg.svd(filtered, full_matrices=False)
            smaller = 1.0 - 1.0 / np.sqrt(1.0 + sizes**2 / noise)
            whole = whole - (along * smaller) @ (along.T @ whole)
        found: Floats = whole / np.sqrt(noise)
        return found

    def discrepancies(self, tangents: Floats) -> list[Discrepancy]:
        """The families that are of this channel as errors."""
        looked, found = self.looked, []
        weights = looked._placed(tangents[looked.own], looked.residual.size)
        for family, variance, freedom, is_named in self._own():
            each, deviation = looked.families[family], float(np.sqrt(variance))
            size = deviation * np.sqrt(np.mean((each.columns(looked.last) ** 2).sum(axis=1)))
            time = deviation / looked.rate if SOURCES[family] == TIME_BASE else np.nan
            factor = deviation * each.loads(weights)
            sizes = {looked.channel: float(size)}
            found.append(Discrepancy(SOURCES[family], sizes, time, freedom, is_named, factor))
        return found

    def clean(self, residual: Floats, matched: npt.NDArray[np.bool_], tangents: Floats) -> None:
        """Take the most likely errors out of residuals; later ones that may have some match not.

        What the fit has taken of these errors is not in the residuals.
        """
        looked = self.looked
        if self.parts is None:
            return
        early = looked.is_early
        rows, place = looked.own[early], looked.place[early]
        columns = [each.columns(looked.last)[place] for each in looked.families]
        likely = np.concatenate(columns, axis=1) @ self.parts.coefficients
        residual[rows] -= _without(likely, tangents[rows])
        matched[looked.own[~early | self.is_far]] = False

    @property
    def is_far(self) -> npt.NDArray[np.bool_]:
        """Which rows have a residual that neither noise nor a family explains."""
        looked = self.looked
        far: npt.NDArray[np.bool_] = np.isnan(looked.residual[looked.place])
        return far if self.parts is not None else np.zeros_like(far)


def _between_marks(phase: Floats, rate: Floats) -> csr_array:
    """A rate times the share that each mark has in the time of a sample; marks at whole phases."""
    before = np.floor(phase).astype(int)
    part, sample = phase - before, np.arange(phase.size)
    entries = np.concatenate([(1.0 - part) * rate, part * rate])
    places = np.tile(sample, 2), np.concatenate([before, before + 1])
    return csr_array((entries, places), shape=(phase.size, int(before.max()) + 2))


def _far(residual: Floats) -> npt.NDArray[np.bool_]:
    """Residuals far from what those before let expect: where a quantity jumps, say.

    An instant of a jump that is slightly wrong leaves the whole jump in one sample. No error of
    the forces is linear in that.
    """
    size = _FAR * float(np.nanmedian(np.abs(residual))) / _MEDIAN
    near = np.clip(residual, -size, size)
    filled = np.where(np.isfinite(near), near, 0.0)
    news = residual - filled + lfilter(autoregression(near), [1.0], filled)
    far: npt.NDArray[np.bool_] = np.abs(news) > _FAR * np.nanmedian(np.abs(news)) / _MEDIAN
    return far


def _without(series: Floats, tangents: Floats) -> Floats:
    """What tangents leave of a series."""
    found: Floats = series - tangents @ np.linalg.lstsq(tangents, series)[0]
    return found


def _scaled(series: Floats) -> Floats:
    """With a root mean square of one."""
    found: Floats = series / max(float(np.sqrt(np.mean(series**2))), 1e-300)
    return found
