"""Measured, fitted and residual of each channel, what was held back included, and tests of them.

Samples lie over ``time``, for several records over the times of all of them. Picked events lie over
``picked``, those of all channels one after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.fitting.channels import ObservedChannel
from nonsmooth.fitting.correlated import ljung_box
from nonsmooth.fitting.residuals import Residuals
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.fitting.solver import Fitted

__all__ = ["ChannelSeries", "residual_series", "series_variables", "tests_of_series"]

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Variables = dict[str, Any]


class ChannelSeries(NamedTuple):
    """What belongs to one channel of one record, in order of its samples or picked events."""

    record: int
    channel: ObservedChannel  # with all its data
    measured: Floats  # (K,)
    residual: Floats  # (K,): measured less fitted; nan where there is none
    held_back: Bools  # (K,)
    missed: Bools  # (K,): picked events that the motion does not have

    @property
    def fitted(self) -> Floats:
        """What the model says at the same places."""
        values: Floats = self.measured - self.residual
        return values


def residual_series(
    shooting: Shooting, channels: Sequence[ObservedChannel], best: Fitted
) -> list[ChannelSeries]:
    """ChannelSeries of all channels; what was held back is predicted by a run that goes on.

    channels: those of the shooting with all their data, what was held back included
    """
    found = []
    for channel, kept in zip(channels, shooting.channels, strict=True):
        measured = channel.values
        held = np.isfinite(measured) & ~np.isfinite(kept.values)
        none = np.full(measured.shape, np.nan)
        found.append(
            ChannelSeries(-1, channel, measured, none, held, np.zeros(measured.shape, bool))
        )
    _enter(found, best.evaluation.rows, best.noise)
    for r in range(len(shooting.records)):
        for c in shooting.channels_in(r):
            found[c] = found[c]._replace(record=r)
        _predict(shooting, r, found, best)
    return found


def _enter(series: list[ChannelSeries], rows: Residuals, noise: Floats, first: int = 0) -> None:
    """Take residuals into the series, those of channel 0 into the first one."""
    for c in np.unique(rows.channel):
        own = (rows.channel == c) & rows.matched
        each = series[first + c]
        each.residual[rows.place[own]] = -rows.residual[own] * noise[c]
        each.missed[rows.place[(rows.channel == c) & ~rows.matched]] = True


def _predict(shooting: Shooting, r: int, series: list[ChannelSeries], best: Fitted) -> None:
    """Residuals of what was held back of a record."""
    record, own = shooting.records[r], shooting.channels_in(r)
    if not any(series[c].held_back.any() for c in own):
        return
    values = shooting.values_in(r, shooting.head_values(best.u))
    noise = shooting.noise_in(r, best.noise)
    if not record.set_up(values):
        return
    states = shooting.states_of(best.u)[shooting.segments_in(r)]
    modes = best.evaluation.modes[shooting.segments_in(r)]
    left = [np.where(series[c].held_back, series[c].measured, np.nan) for c in own]
    for m, plan in enumerate(record.plans_of(left, values, np.inf)):
        last = np.concatenate([plan.times[-1:], plan.event_time[-1:] + record.wait])
        if not last.size:
            continue
        times = np.append(plan.times, last.max())
        flight = record.flights.fly(
            states[m], float(record.bounds[m]), times, modes[m], events=bool(plan.event_time.size)
        )
        if flight is not None:
            flight = record.without_events_before(flight, plan)
            rows = record.rows([m], [flight], [plan], values, noise)
            if rows is not None:
                _enter(series, rows, noise, own.start)


def series_variables(
    series: Sequence[ChannelSeries], times: Floats, record_times: Sequence[Floats]
) -> Variables:
    """Variables of a dataset: samples over ``time``, picked events over ``picked``."""
    both, shape = ("channel", "time"), (len(series), times.size)
    parts = {name: np.full(shape, np.nan) for name in ("measured", "fitted", "residual")}
    held = np.zeros(shape, bool)
    for c, each in enumerate(series):
        if each.channel.shows_events:
            continue
        place = np.searchsorted(times, record_times[each.record])
        for name, values in parts.items():
            values[c, place] = getattr(each, name)
        held[c, place] = each.held_back
    words = {
        "measured": "measured",
        "fitted": "fitted, and predicted where it was held back",
        "residual": "measured less fitted",
    }
    found: Variables = {
        name: (both, parts[name], {"long_name": text}) for name, text in words.items()
    }
    found["held_back"] = both, held, {"long_name": "whether it was held back"}
    events = [(c, each) for c, each in enumerate(series) if each.channel.shows_events]
    if events:
        names = np.repeat([c for c, _ in events], [each.measured.size for _, each in events])
        found["picked_channel"] = "picked", names, {"long_name": "number of the channel"}
        for name, text in words.items():
            joint = np.concatenate([getattr(each, name) for _, each in events])
            found[f"picked_{name}"] = "picked", joint, {"long_name": f"instant, {text}"}
        for name, text in (("held_back", "whether it was held back"),
                           ("missed", "whether the motion has no such event")):  # fmt: skip
            joint = np.concatenate([getattr(each, name) for _, each in events])
            found[f"picked_{name}"] = "picked", joint, {"long_name": text}
    return found


def tests_of_series(series: Sequence[ChannelSeries], noise: Floats) -> Variables:
    """Whiteness of the fitted residuals of each channel, and the error of its prediction."""
    statistics, chances = [], []
    errors = np.full(noise.size, np.nan)
    for c, each in enumerate(series):
        good = np.isfinite(each.residual)
        statistic, chance = ljung_box(each.residual[good & ~each.held_back])
        statistics.append(statistic)
        chances.append(chance)
        ahead = each.residual[good & each.held_back]
        if ahead.size:
            errors[c] = np.sqrt(np.mean(ahead**2)) / noise[c]
    words = {
        "ljung_box": "Ljung-Box statistic",
        "whiteness": "probability of so large a Ljung-Box statistic of white residuals",
        "prediction_error": "error of the prediction of what was held back, in units of the noise",
    }
    values = (np.array(statistics), np.array(chances), errors)
    return {
        name: ("channel", each, {"long_name": words[name]})
        for name, each in zip(words, values, strict=True)
    }
