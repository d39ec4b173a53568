"""A fit as a dataset: estimates, intervals, residuals, and what is wrong, in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.options import result_attributes
from nonsmooth.fitting.channels import ObservedChannel
from nonsmooth.fitting.correlated import NOT_WHITE
from nonsmooth.fitting.course import Course
from nonsmooth.fitting.discrepancy import (
    LINEAR,
    MOTION,
    NONLINEAR,
    SENSOR,
    SOURCES,
    TIME_BASE,
    Discrepancy,
)
from nonsmooth.fitting.intervals import (
    Allowance,
    Better,
    Direction,
    GivenUp,
    Interval,
    Spread,
    block_bootstrap,
    open_directions,
    profile_intervals,
    spread_of,
    threshold,
)
from nonsmooth.fitting.residual_series import (
    ChannelSeries,
    residual_series,
    series_variables,
    tests_of_series,
)
from nonsmooth.fitting.restart import restart_text
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.fitting.solver import Fitted, close_gaps, height

__all__ = ["Search", "fit_dataset"]

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Variables = dict[str, Any]

_FEWEST_MOTIONS = 100  # along profiles, of a search that has not converged
_LOWER_MINIMA = 3  # that profiles may find before they are taken as they are
_PLAIN = "profile of the likelihood, residuals white"
_WIDENED = "profile of the likelihood, widened for correlated residuals"
_FOLLOWING = _WIDENED + " and for errors that follow the motion"
_PERHAPS = _WIDENED + " and for errors that perhaps follow the motion"
_NEUTRAL = 1e-6  # above 1: a multiplier of 1, of a motion without damping, is known about so well
_LARGE, _SHARE_OF_LARGE = 2.0, 0.0455  # residual beside its noise; the share of those above it
_RARE = 1e-3  # probability with which noise alone makes so many of them
_FEW = 20  # data of a channel: their standard deviation is known to a sixth only
_FORCE_WORDS = {
    LINEAR: "a mass, a stiffness, a damper or a dead load of the model were off",
    NONLINEAR: "the model lacked a nonlinear force, such as that of a cubic spring",
}
_POOR = 2.0  # prediction error in units of the noise that is worth a word


_CURES = "give narrower bounds in free=, more starts=, or another number of segments="


class Search:
    """What each start has come to, with its own cuts; None where it could not begin."""

    def __init__(self, found: Sequence[Fitted | None], shootings: Sequence[Shooting]) -> None:
        self.found = list(found)
        self.heights = np.array([np.inf if each is None else height(each) for each in found])
        place = int(self.heights.argmin())
        best, self.shooting = self.found[place], shootings[place]
        assert best is not None
        self.best: Fitted = best

    @property
    def n_evaluations(self) -> int:
        """Evaluations of all starts."""
        return sum(each.n_evaluations for each in self.found if each is not None)


def fit_dataset(
    channels: Sequence[ObservedChannel],
    search: Search,
    options: dict[str, Any],
    loss: str,
    drawn: int,
    seed: int,
    marks: Floats | None,
    course: Course,
) -> xr.Dataset:
    """Dataset of a fit; without marks of the record those of the forcing stand in it."""
    shooting = search.shooting
    best, spread, intervals, given_up = _certain(shooting, search.best, loss)
    course.end_phase()
    directions = open_directions(shooting, spread)
    variables = _estimates(shooting, best, spread, intervals, directions)
    variables |= _profiles(shooting, intervals)
    if drawn:
        variables |= _bootstrap(shooting, best, loss, drawn, seed)
    series = residual_series(shooting, channels, best)
    record_times = [record.times for record in shooting.records]
    times = np.unique(np.concatenate(record_times))
    variables |= series_variables(series, times, record_times)
    variables |= tests_of_series(series, best.noise) | _segments(shooting, best)
    variables["noise"] = ("channel", best.noise, {"long_name": "standard deviation of the noise"})
    most_risen = float(threshold(shooting.n_free_data(best.evaluation)))
    agrees = search.heights - height(best) < 0.5 * most_risen
    variables |= _starts(shooting, search, agrees, height(best))
    variables |= _directions(directions)
    named = [each for each in spread.discrepancies if each.is_named]
    variables |= _discrepancies(named, best.noise)
    words = _open_words(shooting, best, directions)
    names_of_channels = _names_of_channels(shooting)
    late = [channel.delay.is_free for channel in shooting.channels]
    ending = "completed"
    if not best.closed:
        ending = f"not_converged: {_why_not(search, given_up)}; {_CURES}"
    told = _message(ending, agrees, words, variables, names_of_channels, late, named)
    told += _few_words(shooting, best, names_of_channels) + _events_words(best, series)
    told += _large_words(shooting, best, names_of_channels)
    steady: dict[str, Any] = {}
    if growth := shooting.multipliers(best.evaluation):
        steady["largest_multiplier"] = float(np.abs(growth).max())
        if steady["largest_multiplier"] > 1.0 + _NEUTRAL:
            told += (
                "; the fitted orbit is unstable, so a machine does not stay on it: give other"
                " bounds in free=, or form='transient'"
            )
    status = "completed" if best.closed else "not_converged"
    gap = float(np.abs(best.evaluation.gap).max(initial=0.0)) * shooting.gap_unit
    attrs = result_attributes(shooting.system, status, told, options) | {
        "open_parameters": words,
        "interval_method": _method(spread),
        "largest_gap": gap,
        **steady,
        "profile_threshold": most_risen,
        "restart": restart_text(shooting),
        "cost": best.cost,
        "n_fitted": int(best.evaluation.rows.residual.size),
        "n_evaluations": search.n_evaluations,
    }
    names = np.array(shooting.names)
    coords = {
        "parameter": ("parameter", names, {"long_name": "what is found"}),
        "parameter_0": ("parameter_0", names, {"long_name": "what is found"}),
        "channel": ("channel", np.array(names_of_channels)),
        "source": ("source", np.array(SOURCES), {"long_name": "source of errors"}),
        "time": ("time", times, {"long_name": "time"}),
        "mark_time": (
            "mark",
            _marks(shooting, best) if marks is None else marks,
            {"long_name": "marks of the record, or where periods of the forcing begin"},
        ),
        "state": ("state", np.array(shooting.system.states)),
    }
    return xr.Dataset(variables, coords, attrs)


def _certain(
    shooting: Shooting, best: Fitted, loss: str
) -> tuple[Fitted, Spread, list[Interval], int]:
    """The minimum with its intervals; a lower one that a profile finds takes its place.

    A search that has not converged has no intervals, but profiles may lead to where it does. They
    get as many motions as the search has taken; where that is not enough, their number is returned,
    too.
    """
    most = max(best.n_evaluations, _FEWEST_MOTIONS)
    allowance, given_up = Allowance(np.inf if best.closed else most), 0
    spread = spread_of(shooting, best, loss)
    for _ in range(_LOWER_MINIMA):
        try:
            return best, spread, profile_intervals(shooting, best, spread, loss, allowance), 0
        except GivenUp:
            given_up = most
            break
        except Better as lower:
            u, noise, shift = lower.found.u, best.noise, best.multipliers
            again = close_gaps(shooting, u, noise, shift, loss)
            if again is None or height(again) >= height(best):
                break
            best, spread = again, spread_of(shooting, again, loss)
            allowance.left = np.inf if best.closed else allowance.left - best.n_evaluations
    nothing = Interval(np.nan, np.nan, (False, False), np.zeros((0, 2)))
    return best._replace(closed=False), spread, [nothing] * shooting.h, given_up


def _estimates(
    shooting: Shooting,
    best: Fitted,
    spread: Spread,
    intervals: list[Interval],
    directions: list[Direction],
) -> Variables:
    """Everything over ``parameter``."""
    head = spread.covariance[: shooting.h, : shooting.h]
    units, deviation = shooting.head_units(), np.sqrt(np.diag(head))
    low, high = (
        shooting.head_values(np.array([getattr(each, side) for each in intervals]))
        for side in ("low", "high")
    )
    touched = np.array([each.is_open for each in intervals]).reshape(-1, 2)
    is_open = np.zeros(shooting.h, bool)
    for each in directions:
        is_open |= each.parts != 0.0
    identified = ~(is_open | touched.all(axis=1))
    over = "parameter"
    square = (over, "parameter_0")
    columns = {
        "estimate": (over, shooting.head_values(best.u), "estimate"),
        "standard_error": (over, deviation * units, "standard error of the estimate"),
        "variance_ratio": (
            over,
            spread.ratio[: shooting.h],
            "variance over that with white residuals",
        ),
        "interval_low": (over, low, "lower end of the 95 % interval"),
        "interval_high": (over, high, "upper end of the 95 % interval"),
        "interval_open": (over, touched.any(axis=1), "whether a bound cuts the interval off"),
        "profile_followed": (
            over,
            np.array([each.is_followed for each in intervals]),
            "whether the ends of the interval are those of the profile",
        ),
        "identified": (over, identified, "whether the record determines it"),
        "lower_bound": (over, np.array([r.low for r in shooting.ranges]), "least value allowed"),
        "upper_bound": (over, np.array([r.high for r in shooting.ranges]), "largest allowed"),
        "covariance": (square, head * np.outer(units, units), "covariance of the estimates"),
        "correlation": (square, head / np.outer(deviation, deviation), "correlation"),
    }
    return {
        name: (dims, values, {"long_name": words}) for name, (dims, values, words) in
        columns.items()
    }  # fmt: skip


def _profiles(shooting: Shooting, intervals: list[Interval]) -> Variables:
    """Points of the profiles of the likelihood; nan behind those of a parameter with fewer."""
    most = max(len(each.profile) for each in intervals)
    values, rises = np.full((2, shooting.h, most), np.nan)
    origin, units = shooting.head_values(np.zeros(shooting.h)), shooting.head_units()
    for i, each in enumerate(intervals):
        count = len(each.profile)
        values[i, :count] = origin[i] + units[i] * each.profile[:, 0]
        rises[i, :count] = each.profile[:, 1]
    both, words = ("parameter", "profile_point"), "fall of twice the logarithm of the likelihood"
    return {
        "profile_value": (both, values, {"long_name": "value at which everything else is found"}),
        "profile_rise": (both, rises, {"long_name": words}),
    }


def _bootstrap(shooting: Shooting, best: Fitted, loss: str, drawn: int, seed: int) -> Variables:
    """Estimates and 95 % intervals from residuals drawn anew in blocks."""
    found = block_bootstrap(shooting, best, loss, drawn, seed)
    ends = np.full((2, shooting.h), np.nan)
    if found is not None:
        ends = np.quantile(found, [0.025, 0.975], axis=0)
    heads = np.zeros((0, shooting.h)) if found is None else found
    about = {"long_name": "estimate from residuals drawn anew in blocks"}
    estimates = np.array([shooting.head_values(each) for each in heads]).reshape(heads.shape)
    return {"bootstrap_estimate": (("draw", "parameter"), estimates, about)} | {
        f"bootstrap_{side}": (
            "parameter",
            shooting.head_values(end),
            {"long_name": f"{side} end of the 95 % interval by block bootstrap"},
        )
        for side, end in zip(("low", "high"), ends, strict=True)
    }


def _marks(shooting: Shooting, best: Fitted) -> Floats:
    """Instants of the only record at which periods of the forcing begin."""
    record, values = shooting.records[0], shooting.head_values(best.u)
    own = shooting.values_in(0, values)
    period = record.period(own)
    if len(shooting.records) > 1 or period is None or not record.times.size:
        return np.zeros(0)
    shift = record.nuisance(-1, "shift", own)
    first, last = (np.array([record.times[0], record.times[-1]]) + shift) / period
    marks: Floats = period * np.arange(np.ceil(first), np.floor(last) + 1.0) - shift
    return marks


def _names_of_channels(shooting: Shooting) -> list[str]:
    """Names of all channels, with their record where there are several."""
    return [
        f"{label} {channel.name}" if label else channel.name
        for label, record in zip(shooting.labels, shooting.records, strict=True)
        for channel in record.channels
    ]


def _few_words(shooting: Shooting, best: Fitted, channels: Sequence[str]) -> str:
    """Channels whose noise is found from few data."""
    counts = np.bincount(best.evaluation.rows.channel, minlength=len(channels))
    few = [
        f"; the noise of {name} is found from {count} data, so that intervals may be too narrow;"
        " give noise= if you know it"
        for name, channel, count in zip(channels, shooting.channels, counts, strict=True)
        if channel.noise.is_free and count < _FEW
    ]
    return "".join(few)


def _large_words(shooting: Shooting, best: Fitted, channels: Sequence[str]) -> str:
    """Channels whose residuals are larger than the noise that is given allows for."""
    from scipy.stats import binom

    rows, words = best.evaluation.rows, ""
    for c, (name, channel) in enumerate(zip(channels, shooting.channels, strict=True)):
        own = np.abs(rows.residual[(rows.channel == c) & rows.matched])
        large = int(np.count_nonzero(own > _LARGE))
        by_chance = binom.sf(large - 1, own.size, _SHARE_OF_LARGE)
        if not channel.noise.is_free and by_chance < _RARE:
            words += (
                f"; {large} of {own.size} residuals of {name} are more than twice the noise that"
                " noise= gives: the noise is larger, the model is wrong, or no start has come to"
                " the best values"
            )
    return words


def _events_words(best: Fitted, series: Sequence[ChannelSeries]) -> str:
    """Picked events that the motion does not have, and those of it that were not picked."""
    words = ""
    missed = sum(int(np.count_nonzero(each.missed & ~each.held_back)) for each in series)
    if missed:
        words += f"; the motion has no event near {missed} of those that were picked"
    if best.evaluation.rows.surplus.any():
        words += "; the motion has events that were not picked"
    return words


def _segments(shooting: Shooting, best: Fitted) -> Variables:
    about = {"long_name": "states at the starts of the segments"}
    of = np.repeat(np.arange(len(shooting.records)), [r.n_segments for r in shooting.records])
    return {
        "segment_record": ("segment", of, {"long_name": "number of the record of a segment"}),
        "segment_time": ("segment", shooting.bounds, {"long_name": "starts of the segments"}),
        "segment_state": (("segment", "state"), shooting.states_of(best.u), about),
    }


def _starts(shooting: Shooting, search: Search, agrees: Bools, lowest: float) -> Variables:
    estimates = np.array(
        [
            np.full(shooting.h, np.nan) if each is None else shooting.head_values(each.u)
            for each in search.found
        ]
    )
    rise = {"long_name": "how much less likely than the best, as a logarithm"}
    return {
        "start_estimate": (("start", "parameter"), estimates, {"long_name": "found from a start"}),
        "start_cost": ("start", search.heights - lowest, rise),
        "start_agrees": ("start", agrees, {"long_name": "whether a start leads to the best"}),
    }


def _directions(directions: list[Direction]) -> Variables:
    if not directions:
        return {}
    parts = np.array([each.parts for each in directions])
    spreads = np.array([each.spread for each in directions])
    return {
        "direction_part": (
            ("direction", "parameter"), parts, {"long_name": "part, in units of the range"},
        ),
        "direction_spread": (
            "direction", spreads, {"long_name": "standard deviation, in units of the ranges"},
        ),
    }  # fmt: skip


def _discrepancies(found: Sequence[Discrepancy], noise: Floats) -> Variables:
    """Sizes of the errors that follow the motion."""
    sizes, times = np.zeros((noise.size, len(SOURCES))), np.full(noise.size, np.nan)
    forces = np.full(len(SOURCES), np.nan)
    for each in found:
        place = SOURCES.index(each.source)
        for c, size in each.sizes.items():
            sizes[c, place] = size * noise[c]
            if each.source == TIME_BASE:
                times[c] = each.unit
        if each.source in _FORCE_WORDS:
            forces[place] = each.unit
    words = (
        "root mean square of the errors that follow the motion",
        "standard deviation of the times of the samples",
        "root mean square of the errors of the forces, as a part of the accelerations",
    )
    about = [{"long_name": each} for each in words]
    return {
        "discrepancy": (("channel", "source"), sizes, about[0]),
        "time_error": ("channel", times, about[1]),
        "force_error": ("source", forces, about[2]),
    }


def _method(spread: Spread) -> str:
    """What the intervals count in."""
    if any(each.is_named for each in spread.discrepancies):
        return _FOLLOWING
    if spread.discrepancies:
        return _PERHAPS
    return _WIDENED if spread.is_widened else _PLAIN


def _source_words(channel: str, found: Sequence[Discrepancy], *, late: bool) -> list[str]:
    """What errors that follow the motion speak of."""
    constant = (
        ""
        if late
        else f", but no delay that is the same all through: if {channel} may be late, give a range"
        " for it by delay="
    )
    words = {
        MOTION: (
            f"part of the residuals of {channel} repeats with the motion: the model or the sensor"
            " is wrong in a way that noise does not explain; intervals include it as a random"
            " error, and no interval covers a model that is wrong in any way"
        ),
        SENSOR: (
            f"residuals of {channel} are as if a filter of a few samples acted on it, such as a"
            " sensor whose band is not wide; intervals include it"
        ),
    }
    return [
        words.get(each.source)
        or f"residuals of {channel} are as if the times of its samples were off by about"
        f" {each.unit:.2g}, anew in each period; intervals include it{constant}"
        for each in found
        if each.source not in _FORCE_WORDS
    ]


def _force_words(found: Sequence[Discrepancy]) -> list[str]:
    """What errors of the forces speak of."""
    return [
        f"residuals are as if {_FORCE_WORDS[each.source]}, by about {100.0 * each.unit:.2g} % of"
        " all forces; intervals include it as a random error, and no interval covers a model that"
        " is wrong in any way"
        for each in found
        if each.source in _FORCE_WORDS
    ]


def _open_words(shooting: Shooting, best: Fitted, directions: list[Direction]) -> str:
    """What the record does not determine, a sentence each."""
    sentences = []
    for each in directions:
        members = np.flatnonzero(each.parts)
        if members.size == 1:
            sentences.append(f"the record does not determine {shooting.names[members[0]]}")
            continue
        names = [shooting.names[k] for k in members]
        steps = each.parts[members] * shooting.head_units()[members]
        steps = steps / steps[0]
        moves = ", ".join(
            f"{name} {'rises' if step > 0 else 'falls'} by {abs(step):.3g}"
            for name, step in zip(names, steps, strict=True)
        )
        sentences.append(
            f"the record determines {', '.join(names[:-1])} and {names[-1]} only together: it"
            f" hardly changes where {moves}"
        )
    return "; ".join(sentences)


def _why_not(search: Search, given_up: int) -> str:
    """Why a fit has not converged; given_up: motions after which profiles led no further."""
    if search.best.closed:
        return "intervals could not be found, as profiles of the likelihood lead on and on"
    told = f"segments do not join after {search.n_evaluations} motions through the record"
    if not given_up:
        return told
    return f"{told}, and {given_up} more along profiles of the likelihood have led no further"


def _message(
    ending: str,
    agrees: Bools,
    words: str,
    variables: Variables,
    channels: Sequence[str],
    late: Sequence[bool],
    discrepancies: Sequence[Discrepancy],
) -> str:
    """How the fit ended, and what speaks against it; late: whether delays of channels are found."""
    parts = [ending]
    if agrees.any():
        parts.append(f"{int(agrees.sum())} of {agrees.size} starts agree")
    else:
        parts.append(
            "a profile led to this minimum and no start did: give more starts=, or narrower bounds"
            " in free=, to see whether it is the lowest"
        )
    if words:
        parts.append(words)
    if variables["interval_open"][1].any():
        parts.append("bounds cut intervals off (interval_open)")
    if not variables["profile_followed"][1].all():
        parts.append(
            "some profiles could not be followed, and ends of their intervals are those of the"
            " standard error, see profile_followed"
        )
    for c, channel in enumerate(channels):
        own = [each for each in discrepancies if c in each.sizes]
        if variables["whiteness"][1][c] < NOT_WHITE:
            causes = (
                ", by coloured noise or a model that is wrong: intervals are widened for the first,"
                " but no interval tells of the second"
            )
            parts.append(f"residuals of {channel} are correlated{'' if own else causes}")
        parts += _source_words(channel, own, late=late[c])
        if variables["prediction_error"][1][c] > _POOR:
            parts.append(f"what was held back of {channel} is predicted poorly")
    parts += _force_words(discrepancies)
    return "; ".join(parts)
