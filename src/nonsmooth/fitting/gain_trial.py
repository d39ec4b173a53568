"""Whether a constant gain would explain a record that a fit does not.

A record in degrees of a model in radians, or in mm of one in m, makes a fit fail that would succeed
with a gain, or makes it explain next to nothing. Then the spread of each channel is put beside that
of the same quantity on a motion of the model. If they are far apart, one more start finds the
gains.

Where nothing drives the model, its motion from rest has no spread, and that of a free decay may be
of any size. Then the usual factors between units are tried: those with which single segments fit
best, each in a fit of its own. The gain is fixed there, for that of a free decay may not be
determined beside the parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from nonsmooth.fitting.channels import ObservedChannel, Range
from nonsmooth.fitting.cuts import GivenRecord
from nonsmooth.fitting.report import Search
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.fitting.solver import misfit_of_start

__all__ = [
    "LITTLE",
    "MOST",
    "explaining_gains",
    "explains",
    "height_of_explaining",
    "said_of_gains",
]

Floats = npt.NDArray[np.float64]

_APART = 3.0  # factor between spreads from which on a gain is tried: motions differ by less
_WIDE = 5.0  # factor on either side of the ratio of the spreads in which it is sought
_TRIED = 3  # usual factors that are tried in a fit of their own
_SAMPLES = 2000  # of a motion of the model
LITTLE, MOST = 0.1, 0.1  # noise beside the record: it explains little; it explains most of it
_NEAR = 0.03  # of a factor between units, by which the gain of a record may be off
_FACTORS = {
    180.0 / np.pi: "degrees for radians",
    1e3: "thousandths, such as mm for m",
    1e6: "millionths, such as um for m",
    9.80665: "m/s^2 for g",
    2.0 * np.pi: "rad/s for Hz",
    30.0 / np.pi: "rpm for rad/s",
}


def explaining_gains(
    records: Sequence[GivenRecord],
    failed: Search,
    initial: Floats,
    begin: Callable[[Sequence[GivenRecord]], Shooting],
    search: Callable[[Sequence[GivenRecord]], Search],
) -> dict[str, float]:
    """Gains with which a fit explains its records, by the names of the channels.

    Empty where no gains do. ``begin`` makes the equations of other records, and ``search`` looks
    for their minimum from one start.
    """
    tried = _with_gains(records, failed.shooting, initial)
    if tried is None:
        return _usual_gains(records, failed.shooting, initial, begin, search)
    found = search(tried)
    if not (found.best.closed and explains(found, MOST)):
        return {}
    shooting = found.shooting
    estimates = dict(zip(shooting.names, shooting.head_values(found.best.u), strict=True))
    return {
        name.removesuffix(" gain"): float(value)
        for name, value in estimates.items()
        if name.endswith(" gain")
    }


def _usual_gains(
    records: Sequence[GivenRecord],
    shooting: Shooting,
    initial: Floats,
    begin: Callable[[Sequence[GivenRecord]], Shooting],
    search: Callable[[Sequence[GivenRecord]], Search],
) -> dict[str, float]:
    """A usual factor between units by which a fit explains its records; empty where none does."""
    if not _is_at_rest(shooting, initial):
        return {}
    noise = np.array([channel.noise.guess for channel in shooting.channels])
    looked = []
    for factor in sorted({each for exact in _FACTORS for each in (exact, 1.0 / exact)}):
        scaled = _scaled(records, factor)
        if scaled != list(records):
            looked.append((misfit_of_start(begin(scaled), initial, noise, 0), factor))
    for misfit, factor in sorted(looked)[:_TRIED]:
        if not np.isfinite(misfit):
            break
        found = search(_scaled(records, factor))
        if found.best.closed and explains(found, MOST):
            return {
                channel.name: factor * channel.gain.guess
                for each in records
                for channel in each.channels
                if _may_be_scaled(channel)
            }
    return {}


def _is_at_rest(shooting: Shooting, initial: Floats) -> bool:
    """Whether the motion of the model stays where it begins, so that it has no size."""
    if not shooting.set_up(shooting.head_of(shooting.guess())):
        return False
    spreads = [
        spread
        for k in range(len(shooting.records))
        for spread in _spreads_of_model(shooting, k, initial).values()
    ]
    return bool(spreads) and max(spreads) == 0.0


def _may_be_scaled(channel: ObservedChannel) -> bool:
    return not (channel.shows_events or channel.gain.is_free)


def _scaled(records: Sequence[GivenRecord], factor: float) -> list[GivenRecord]:
    """Records whose gains are so many times as large, but for those that are found."""

    def scaled(channel: ObservedChannel) -> ObservedChannel:
        value = factor * channel.gain.guess
        wanted = channel._replace(gain=Range(value, value, value))
        return wanted if _may_be_scaled(channel) else channel

    return [
        each._replace(channels=[scaled(channel) for channel in each.channels]) for each in records
    ]


def explains(found: Search, share: float) -> bool:
    """Whether the noise is less than a share of the spread of each sampled channel."""
    channels = [one for record in found.shooting.records for one in record.channels]
    return all(
        noise < share * channel.spread
        for noise, channel in zip(found.best.noise, channels, strict=True)
        if not channel.shows_events
    )


def height_of_explaining(shooting: Shooting, share: float = MOST) -> float:
    """Minus the logarithm of the likelihood at which a fit just explains its records.

    The noise is then a share of the spread of each channel. A search that lies higher while its
    segments need not join yet explains nothing in the end. It is not known for instants of events,
    whose matches count, too.
    """
    height = 0.0
    for channel in shooting.channels:
        if channel.shows_events:
            return np.inf
        count = int(np.isfinite(channel.values).sum())
        height += count * (0.5 + float(np.log(max(share * channel.spread, channel.least_noise))))
    return height


def _with_gains(
    records: Sequence[GivenRecord], shooting: Shooting, initial: Floats
) -> list[GivenRecord] | None:
    """Records some of whose channels have a gain to be found; None where none asks for one."""
    if not shooting.set_up(shooting.head_of(shooting.guess())):
        return None
    changed, found = False, []
    for k, each in enumerate(records):
        spreads = _spreads_of_model(shooting, k, initial)
        channels = [_with_gain(one, spreads.get(one.name, np.nan)) for one in each.channels]
        changed |= channels != each.channels
        found.append(each._replace(channels=channels))
    return found if changed else None


def _spreads_of_model(shooting: Shooting, k: int, initial: Floats) -> dict[str, float]:
    """Standard deviation of each sampled quantity over the second half of a motion of the model."""
    record = shooting.records[k]
    times = np.linspace(float(record.bounds[0]), float(record.bounds[-1]), _SAMPLES)
    flight = record.flights.fly(initial, float(times[0]), times)
    sampled = [one for one in record.channels if not one.shows_events]
    if flight is None or not sampled:
        return {}
    flights = record.flights
    seen = record.observation.look(flight.samples, flights.window, flights.values, record.step)
    later = seen.values[:, _SAMPLES // 2 :]
    spreads = np.std(later, axis=1)
    turns = record.ways_of_turns(flight.samples)
    for k, one in enumerate(sampled):
        if turns[k] > 0.0 and one.is_within(one.extent):
            # the record jumps back, and a turn is as wide as it; the angle of the model goes on
            spreads[k] = one.spread * turns[k] / one.extent
    return {one.name: float(each) for one, each in zip(sampled, spreads, strict=True)}


def _with_gain(channel: ObservedChannel, spread: float) -> ObservedChannel:
    """A channel whose gain is to be found, if its spread and that of the model are far apart."""
    gain = channel.gain
    if channel.shows_events or gain.is_free or not (spread > 0.0 and channel.spread > 0.0):
        return channel
    ratio = channel.spread / spread
    if 1.0 / _APART < ratio / abs(gain.low) < _APART:
        return channel
    ratio *= np.sign(gain.low)
    ends = sorted((ratio / _WIDE, ratio * _WIDE))
    return channel._replace(gain=Range(ends[0], ends[1], ratio))


def said_of_gains(gains: Mapping[str, float]) -> str:
    """What gains that explain a record say, in words; empty without any."""
    if not gains:
        return ""
    told = ", ".join(f"{value:.4g} for {name}{_unit(value)}" for name, value in gains.items())
    given = ", ".join(f"{name!r}: {value:.4g}" for name, value in gains.items())
    return (
        f"a constant gain would explain the record, {told}: the record and the model may be in"
        f" different units; convert one of them, or give gain={{{given}}}"
    )


def _unit(value: float) -> str:
    """The units between which a factor lies, where it is a usual one."""
    for factor, words in _FACTORS.items():
        for exact, way in ((factor, ""), (1.0 / factor, ", the other way round")):
            if abs(value / exact - 1.0) <= _NEAR:
                return f" (near {exact:.6g}, {words}{way})"
    return ""
