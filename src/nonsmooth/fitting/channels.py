"""What is fitted: the channels of a record, what the model says of each, and how it was measured.

A channel over ``time`` shows ``gain * quantity(t - delay) + offset`` and noise. Each of the four is
fixed by a number, bounded by a pair, or free. A channel over a dimension of its own has the
instants of events, of which only delay and noise can be said.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, ResultWarning, is_known, quote, unknown_name
from nonsmooth.measured.clock import LARGEST
from nonsmooth.measured.quality.masks import quality_of
from nonsmooth.real_numbers import finite_real
from nonsmooth.runs.section_search import event_names
from nonsmooth.system.model.value_checks import condition_of
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.expressions import name_set

__all__ = [
    "FREE",
    "ObservedChannel",
    "Range",
    "check_allowed",
    "check_free",
    "check_record_times",
    "read_channels",
    "read_shift",
]

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

FREE = "free"
_DEFAULTS = {"gain": 1.0, "offset": 0.0, "delay": 0.0}
_OF_EVENTS = {"gain": 1.0, "offset": 0.0}
_SMALLEST = 1e-9  # noise, in parts of the spread of a channel
_FEWEST = 10  # samples of a channel that are numbers
_FEWEST_EVENTS = 3
_ONE_TURN = 1.25  # turns that an angle within one may seem to fill, with noise
_BORDER = 1e-9  # of bounds, beside their ends
_LOOKS = 1000  # within bounds, at random
_KINDS = "iuf"  # of numpy: numbers that may be instants


class Range(NamedTuple):
    """A number that is fixed, where both ends are equal, or that lies between them."""

    low: float
    high: float
    guess: float

    @property
    def is_free(self) -> bool:
        """Whether the fit finds it."""
        return self.low < self.high

    @property
    def scale(self) -> float:
        """Unit in which the solver counts it."""
        width = self.high - self.low
        return width if np.isfinite(width) else max(1.0, abs(self.guess))


class ObservedChannel(NamedTuple):
    """One channel of a record, and how the model sees it."""

    name: str
    text: str  # the observed quantity, or the name of the events
    values: Floats  # (K,) samples, or instants of events; nan where one is left out
    gain: Range
    offset: Range
    delay: Range
    noise: Range
    shows_events: bool = False
    extent: float = np.nan  # greatest sample less least
    jump: float = 0.0  # largest change from one sample to the next

    def is_within(self, turn: float) -> bool:
        """Whether an angle is given within one turn, as an encoder does, and jumps back there.

        ``turn`` is in units of the channel.
        """
        return self.jump > 0.5 * turn > 0.0 and self.extent <= _ONE_TURN * turn

    @property
    def spread(self) -> float:
        """Standard deviation of the samples; half the usual time between events."""
        if self.shows_events:
            return _half_a_wait(self.values)
        return float(np.nanstd(self.values))

    @property
    def least_noise(self) -> float:
        """Noise below which none is taken: that which is given, or where none is, rounding."""
        return max(self.noise.low, _SMALLEST * (self.spread or 1.0))


def _half_a_wait(values: Floats) -> float:
    """Half the usual time between events."""
    return 0.5 * float(np.median(np.diff(values[np.isfinite(values)])))


def check_free(system: System, free: Any) -> dict[str, Range]:
    """Parameters to be found with their bounds."""
    if not isinstance(free, Mapping) or not free:
        raise OptionError(
            f"free = {quote(free)}: give the bounds of each parameter to be found, such as"
            f" {{{next(iter(system.parameters), 'k')!r}: (0.5, 2.0)}}"
        )
    found = {}
    for name, bounds in free.items():
        if not is_known(name, system.parameters):
            raise OptionError(f"free: {unknown_name('parameter', name, system.parameters)}")
        if name in system.slow:
            raise OptionError(f"free: {name!r} is in slow= of the system, so it is no number")
        found[name] = _bounds(f"free[{name!r}]", bounds, None)
    return found


def check_allowed(system: System, free: Mapping[str, Range]) -> None:
    """Refuse bounds in which the system is nowhere allowed, and warn of an end at which it is not.

    Where a condition reads several of the parameters to be found, bounds that leave a corner out
    are as good as any; those in which it never holds are not. A bound may lie on the border of what
    is allowed, as 0 for a mass.
    """
    for condition, reason in system.require.items():
        tree = condition_of(condition)
        own = [name for name in free if name in name_set(tree)]
        if not own:
            continue
        ends = np.array(list(product((_BORDER, 1.0 - _BORDER), repeat=len(own))))
        inside = np.random.default_rng(0).random((_LOOKS, len(own)))
        parts = np.concatenate([ends, inside]).T
        looks = {name: free[name].low + free[name].scale * parts[k] for k, name in enumerate(own)}
        with np.errstate(all="ignore"):
            found = np.asarray(evaluate(tree, {**system.parameter_values, **looks}), bool)
        holds = np.broadcast_to(found, parts.shape[1])
        if not holds.any():
            raise OptionError(
                f"free: {condition} is required, and holds nowhere within the bounds of"
                f" {', '.join(own)}: {reason}; give other bounds"
            )
        if len(own) == 1 and not holds[:2].all():
            low, high = free[own[0]].low, free[own[0]].high
            outside = [
                f"{end:g}" for end, is_met in zip((low, high), holds, strict=False) if not is_met
            ]
            warnings.warn(
                f"free[{own[0]!r}] = ({low:g}, {high:g}): {condition} is required, and does not"
                f" hold at {' and '.join(outside)}: {reason}; the fit passes such values by, and"
                " bounds in which it holds lead it better",
                ResultWarning,
                stacklevel=3,
            )


def _bounds(where: str, bounds: Any, guess: float | None) -> Range:
    """A pair of finite numbers in order."""
    try:
        low, high = bounds
    except (TypeError, ValueError):
        raise OptionError(f"{where} = {quote(bounds)}: give two numbers, (low, high)") from None
    low, high = finite_real(f"{where}[0]", low), finite_real(f"{where}[1]", high)
    if not low < high:
        raise OptionError(f"{where} = ({low:g}, {high:g}): the first must be below the second")
    middle = 0.5 * (low + high)
    return Range(low, high, middle if guess is None or not low < guess < high else guess)


def check_record_times(where: str, record: Any) -> Floats:
    """Times of the samples of a record, none where it has events only."""
    samples = hasattr(record, "data_vars") and "time" in record.dims and "time" in record.coords
    if not samples and not (hasattr(record, "data_vars") and _event_channels(record)):
        raise OptionError(
            f"{where} = {type(record).__name__}: give a dataset over time, such as a result of"
            " measured.read_csv, or xarray.Dataset({'x': ('time', x)}, {'time': t})"
        )
    times = np.asarray(record["time"].values, dtype=float) if samples else np.zeros(0)
    if not np.all(np.isfinite(times)) or np.any(np.diff(times) <= 0.0):
        raise OptionError(f"{where}: its times must be finite numbers that increase")
    return times


def _event_channels(record: Any) -> list[str]:
    """Variables that may be instants of events: numbers over a dimension that is not the time."""
    return [
        str(name) for name, each in record.variables.items()
        if len(each.dims) == 1 and each.dims != ("time",) and each.dtype.kind in _KINDS
    ]  # fmt: skip


def read_shift(given: Any) -> Range:
    """Time of the system at time zero of the record."""
    if given is None:
        return Range(0.0, 0.0, 0.0)
    if not hasattr(given, "__len__") or isinstance(given, str):
        value = finite_real("shift", given)
        return Range(value, value, value)
    return _bounds("shift", given, None)


def read_channels(
    system: System, record: Any, observe: Any, nuisances: Mapping[str, Any], noise: Any
) -> list[ObservedChannel]:
    """Channels of a record with what the model says of each."""
    texts = _observed(system, record, observe)
    settings = {key: _settings(key, given, texts) for key, given in nuisances.items()}
    levels = _settings("noise", noise, texts)
    events, known = _event_channels(record), event_names(system)
    found = []
    for name, text in texts.items():
        shows_events = name in events
        if shows_events and text not in known:
            raise OptionError(
                f"observe[{name!r}]: {unknown_name('event', text, known)}; a channel that is not"
                " over time has the instants of an event"
            )
        if shows_events:
            values = _instants(record, name, check_record_times("record", record))
        else:
            values = _samples(record, name)
        ranges = {key: _range(key, name, given.get(name)) for key, given in settings.items()}
        if shows_events:
            _check_sensor_of_events(name, nuisances, ranges)
            ranges |= {key: Range(each, each, each) for key, each in _OF_EVENTS.items()}
        size = 2.0 * _half_a_wait(values) if shows_events else float(np.nanstd(values))
        level = _noise(name, levels, 0.05 * size or 1.0)
        known_ones = values[np.isfinite(values)]
        found.append(
            ObservedChannel(
                name, text, values, **ranges, noise=level, shows_events=shows_events,
                extent=float(np.ptp(known_ones)),
                jump=float(np.abs(np.diff(known_ones)).max(initial=0.0)),
            )
        )  # fmt: skip
    return found


def _check_sensor_of_events(
    name: str, nuisances: Mapping[str, Any], ranges: Mapping[str, Range]
) -> None:
    """Refuse a gain or an offset that was given for instants of events."""
    for key, fixed in _OF_EVENTS.items():
        asked = isinstance(nuisances[key], Mapping) and name in nuisances[key]
        if asked and ranges[key] != (fixed, fixed, fixed):
            raise OptionError(
                f"{key}[{name!r}]: the channel has instants of events, which have no {key}; give"
                " delay="
            )


def _observed(system: System, record: Any, observe: Any) -> dict[str, str]:
    """Expressions by channel; without any, channels that are called like a state or an output."""
    channels = [str(name) for name in record.data_vars if record[name].dims == ("time",)]
    events = _event_channels(record)
    if observe is None:
        same = [name for name in channels if name in (*system.states, *system.outputs)]
        same += [name for name in events if name in event_names(system)]
        if not same:
            raise OptionError(
                f"observe: no channel of the record ({', '.join(channels) or 'none'}) is called"
                " like a state or an output, nor one of instants like an event; say what each"
                " shows, such as"
                f" {{{channels[0] if channels else 'a1'!r}: {system.states[0]!r}}}"
            )
        return {name: name for name in same}
    if not isinstance(observe, Mapping) or not observe:
        raise OptionError(
            f"observe = {quote(observe)}: give an expression of states, outputs and rates for each"
            f" channel, such as {{'a1': 'rate({system.states[-1]})'}}"
        )
    for name, text in observe.items():
        if name not in channels + events:
            raise OptionError(f"observe: {unknown_name('channel', name, channels + events)}")
        if not isinstance(text, str):
            raise OptionError(f"observe[{name!r}] = {quote(text)}: give an expression as a text")
    return dict(observe)


def _samples(record: Any, name: str) -> Floats:
    try:
        values = np.array(record[name].values, dtype=float)
    except (TypeError, ValueError):
        raise OptionError(f"record[{name!r}]: its samples must be numbers") from None
    values[~np.isfinite(values)] = np.nan
    flags = quality_of(record, name)
    if flags is not None:
        values[flags != 0] = np.nan
    beyond = np.flatnonzero(np.abs(values) > LARGEST)
    if beyond.size:
        raise OptionError(
            f"record[{name!r}]: {values[beyond[0]]:g} (sample {beyond[0]} from 0) is beyond"
            f" {LARGEST:g}, far too large beside any motion; make samples without a reading nan,"
            " and convert others to units of the model"
        )
    count = int(np.count_nonzero(np.isfinite(values)))
    if count < _FEWEST:
        raise OptionError(
            f"record[{name!r}]: {count} samples are numbers without a flaw; at least {_FEWEST} are"
            " needed"
        )
    return values


def _instants(record: Any, name: str, times: Floats) -> Floats:
    """Instants of events, in order, within the times of the samples where there are some."""
    values = np.array(record[name].values, dtype=float)
    if not np.all(np.isfinite(values)) or np.any(np.diff(values) <= 0.0):
        raise OptionError(f"record[{name!r}]: instants of events must be numbers that increase")
    if values.size < _FEWEST_EVENTS:
        raise OptionError(
            f"record[{name!r}]: {values.size} events; at least {_FEWEST_EVENTS} are needed"
        )
    if times.size > 1:
        _check_inside(name, values, times)
    return values


def _check_inside(name: str, values: Floats, times: Floats) -> None:
    """Refuse instants at which no sample was taken: they are often in another unit of time."""
    step = float(np.median(np.diff(times)))  # an event may be between samples
    outside = np.count_nonzero((values < times[0] - step) | (values > times[-1] + step))
    if outside:
        raise OptionError(
            f"record[{name!r}]: {outside} of {values.size} instants lie outside of the samples. The"
            f" instants run from {values[0]:.6g} to {values[-1]:.6g}, the samples from"
            f" {times[0]:.6g} to {times[-1]:.6g}; give both in one unit of time, and leave out"
            " instants before and after the samples"
        )


def _settings(key: str, given: Any, texts: Mapping[str, str]) -> dict[str, Any]:
    """What is given for each channel; what is no mapping holds for all of them."""
    if not isinstance(given, Mapping):
        return dict.fromkeys(texts, given)
    for name in given:
        if name not in texts:
            raise OptionError(f"{key}: {unknown_name('channel', name, texts)}")
    return dict(given)


def _range(key: str, name: str, given: Any) -> Range:
    """Gain, offset or delay of a channel."""
    default, where = _DEFAULTS[key], f"{key}[{name!r}]"
    if given is None:
        return Range(default, default, default)
    if isinstance(given, str):
        if given != FREE or key == "delay":
            allowed = "a number or (low, high)" if key == "delay" else "a number, (low, high), free"
            raise OptionError(f"{where} = {quote(given)}: give {allowed}")
        return Range(-np.inf, np.inf, default)
    if not hasattr(given, "__len__"):
        value = finite_real(where, given)
        if key == "gain" and value == 0.0:
            raise OptionError(
                f"{where} = 0: the channel would show nothing of the motion; give another number,"
                f" (low, high), or {FREE!r}"
            )
        return Range(value, value, value)
    return _bounds(where, given, default)


def _noise(name: str, levels: Mapping[str, Any], first: float) -> Range:
    """Standard deviation of the noise: what is not given is found, from a first guess on."""
    given, where = levels.get(name), f"noise[{name!r}]"
    if given is None or (isinstance(given, str) and given == FREE):
        return Range(0.0, np.inf, first)
    if isinstance(given, str):
        raise OptionError(f"{where} = {quote(given)}: give a number, (low, high), or {FREE!r}")
    if not hasattr(given, "__len__"):
        value = finite_real(where, given)
        found = Range(value, value, value)
    else:
        found = _bounds(where, given, first)
    if not found.guess > 0.0 or found.low < 0.0:
        raise OptionError(f"{where} = {quote(given)}: noise is a standard deviation, above zero")
    return found
