"""`check`: flaws of a record, with channel and place; `flagged`: a record with its mask."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth.errors import OptionError, is_known, quote, unknown_name
from nonsmooth.measured.even_samples import FEWEST, listed
from nonsmooth.measured.quality.flaw import FLAGS, KINDS, Flaw, Readings
from nonsmooth.measured.quality.mains import hum_findings
from nonsmooth.measured.quality.masks import mask_words, masked, quality_of
from nonsmooth.measured.quality.noise import longest_by_chance, noise_of
from nonsmooth.measured.quality.spikes import spike_findings
from nonsmooth.measured.quality.stillness import still_findings
from nonsmooth.measured.quality.timing import mark_findings, missing_findings, time_findings
from nonsmooth.measured.quality.trends import trend_findings
from nonsmooth.runs.options import finite_number
from nonsmooth.version import __version__

__all__ = ["check", "flagged"]

_TESTS = 5  # that may give a false alarm: frozen, clipped, spike, drift, hum


def check(
    record: xr.Dataset,
    *,
    channels: str | list[str] | None = None,
    false_alarms: float = 1e-3,
    mains: tuple[float, ...] = (50.0, 60.0),
    leave_out: str | Iterable[str] = (),
) -> xr.Dataset:
    r"""Find what is wrong with a record before anything is computed from it.

    Parameters
    ----------
    record : xarray.Dataset
        Any dataset over ``time``: of `read_csv` or `from_arrays`, with ``bad_samples="keep"`` and
        ``bad_marks="keep"`` where they would refuse it, or one made by hand.

    Other Parameters
    ----------------
    channels : str or list of str, optional
        What is checked; all variables over time by default.
    false_alarms : float, optional
        Probability that a channel without a flaw gives a finding. Each of the five tests that
        chance can deceive gets a fifth of it.
    mains : tuple of float, optional
        Frequencies of the mains in Hz; none are looked for where it is empty.
    leave_out : str or list of str, optional
        Kinds that are not looked for, such as ``"drift"`` of a machine that progresses.

    Returns
    -------
    xarray.Dataset
        Over ``finding``: ``channel``, ``kind``, ``begin`` and ``end`` in time, ``n_samples``,
        ``size``, ``doubtful`` (whether results may be wrong by it) and ``sentence``, which says it
        in words. Over ``time``: ``x_quality`` of each channel ``x``, zero for good samples, else a
        sum of the flags ``missing`` (1), ``frozen`` (2), ``clipped`` (4) and ``spike`` (8), with
        attributes as the CF conventions have them; further attributes are ``noise``, ``step``, the
        least difference between two values, ``noise_visible``, and ``longest_by_chance``, how many
        equal samples in a row chance gives. Attributes: ``n_findings`` and ``n_doubtful``.

    Raises
    ------
    OptionError
        For data without ``time``, too few samples, or an option out of its range.

    See Also
    --------
    flagged : the record with the mask, which filters and integrals carry on.
    nonsmooth.plot.quality : a picture of a channel with its flaws.

    Notes
    -----
    ``size`` is of ``frozen``, ``clipped`` and ``constant`` the value, of ``spike`` how far the
    sample is off, of ``drift`` and ``runaway`` the change of the mean, of ``hum`` the amplitude, of
    ``gap`` and ``uneven`` the step of time, of ``missing`` and ``marks`` how many (negative: too
    few).

    *Frozen.* White noise before rounding makes L equal samples in a row with a known probability; a
    longer row than that is frozen. Where the noise is too small to move the last digit, a motion at
    rest stands still, too: then a stretch is frozen only if it is much longer than the second
    longest. *Clipped.* More samples at an extreme value than the top of a smooth arch has; or one
    flat top of three samples or more that parabolas through its neighbours on either side both lead
    beyond, by more than rounding and noise explain. *Spike.* One sample off the cubic through its
    eight neighbours, while these are on it. An impact bends them; contacts that span fewer than
    three samples cannot be told from spikes, nor can spikes of two samples be told from impacts.
    *Drift.* A parabola through means of blocks, against their scatter. *Hum.* A line at the mains
    against the lines beside it, left out where a multiple of the speed falls on it.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(4000) / 2000.0
    >>> x = np.round(np.cos(100 * t) + np.random.default_rng(0).normal(0, 0.01, t.size), 3)
    >>> x[1000:1400] = x[1000]
    >>> found = ns.measured.check(ns.measured.from_arrays({"x": x}, times=t, units="mm"))
    >>> found["kind"].values.tolist(), found["begin"].values, found["n_samples"].values
    (['frozen'], array([0.5]), array([400]))
    """
    times = _times(record)
    names = _channels(record, channels)
    left = _kinds(leave_out)
    rate = finite_number("false_alarms", false_alarms)
    if not 0.0 < rate < 1.0:
        raise OptionError(f"false_alarms = {rate:g} must lie between 0 and 1")
    lines = _mains(mains)
    if record["time"].attrs.get("units") != "s":
        lines = ()
    speed = float(record.attrs["speed"]) / (2.0 * math.pi) if "speed" in record.attrs else None
    found = [*time_findings(times), *mark_findings(record)]
    flags: dict[str, Any] = {}
    for name in names:
        values = record[name].values.astype(float)
        units = str(record[name].attrs.get("units", ""))
        data = Readings(name, times, values, units, noise_of(values), rate / _TESTS)
        own = [one for one in _of_channel(data, lines, speed) if one.kind not in left]
        found += own
        mask = _mask(own, values.size)
        good = np.where(mask > 0, np.nan, values)
        flags[f"{name}_quality"] = "time", mask, _words(data._replace(noise=noise_of(good)))
    kept = sorted((one for one in found if one.kind not in left), key=lambda one: one.begin)
    return _dataset(record, kept, flags, rate)


def flagged(record: xr.Dataset, found: xr.Dataset | None = None) -> xr.Dataset:
    """Record with its quality mask, so that what is made of bad samples is known as such.

    Parameters
    ----------
    record : xarray.Dataset
        The record.
    found : xarray.Dataset, optional
        Result of `check` for it; without it the record is checked.

    Returns
    -------
    xarray.Dataset
        The record with a coordinate ``x_quality`` for each channel ``x`` that was checked; flags
        that it had before stay.
        `low_pass`, `velocities`, `displacements`, `dimensionless`, `synchronous`, `section` and
        `diagram` carry it on: a sample of theirs has the flags of all samples that it was made of.

    Raises
    ------
    OptionError
        When the check is of other samples.

    See Also
    --------
    check : what is looked for.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(4000) / 2000.0
    >>> x = np.round(np.cos(100 * t) + np.random.default_rng(0).normal(0, 0.01, t.size), 3)
    >>> x[1000:1400] = x[1000]
    >>> record = ns.measured.flagged(ns.measured.from_arrays({"x": x}, times=t))
    >>> smooth = ns.measured.low_pass(record, 200.0)
    >>> int((record["x_quality"] > 0).sum()), int((smooth["x_quality"] > 0).sum())
    (400, 456)
    """
    if found is None:
        found = check(record)
    if not isinstance(found, xr.Dataset) or "finding" not in found.dims:
        raise OptionError(f"found = {type(found).__name__}: give a result of measured.check")
    times = _times(record)
    if found.sizes["time"] != times.size or not np.array_equal(found["time"].values, times):
        raise OptionError("found: it is a check of other samples; check this record")
    masks = {}
    for name in map(str, record.data_vars):
        new, known = quality_of(found, name), quality_of(record, name)
        if new is not None:
            masks[name] = new if known is None else new | known
    return masked(record, masks)


def _of_channel(data: Readings, mains: tuple[float, ...], speed: float | None) -> Iterator[Flaw]:
    """Findings of one channel; what is known as bad is left out of the later tests."""
    own = [*missing_findings(data), *still_findings(data)]
    bad = _mask(own, data.values.size) > 0
    noise = noise_of(np.where(bad, np.nan, data.values))
    own += spike_findings(data._replace(noise=noise), bad)
    yield from own
    values = np.where(_mask(own, bad.size) > 0, np.nan, data.values)
    good = data._replace(values=values, noise=noise)
    if good.values.size and np.isfinite(good.values).mean() > 0.5:
        low, high = np.nanmin(good.values), np.nanmax(good.values)
        if high > low:
            yield from trend_findings(good)
            yield from hum_findings(good, mains, speed)


def _mask(findings: Iterable[Flaw], count: int) -> np.ndarray[Any, np.dtype[np.uint8]]:
    flags = np.zeros(count, dtype=np.uint8)
    for one in findings:
        if one.places is not None:
            flags[one.places] |= FLAGS[one.kind]
    return flags


def _words(data: Readings) -> dict[str, Any]:
    noise = data.noise
    longest = longest_by_chance(noise, data.values.size, data.rate)
    return mask_words(data.name) | {
        "noise": noise.deviation,
        "step": noise.step,
        "noise_visible": int(noise.least > 0.0),
        "longest_by_chance": longest,
    }


def _dataset(
    record: xr.Dataset, found: list[Flaw], flags: dict[str, Any], rate: float
) -> xr.Dataset:
    units = {key: record["time"].attrs[key] for key in ("units",) if key in record["time"].attrs}
    columns: dict[str, Any] = {
        "channel": (np.array([one.channel for one in found], dtype=str), "channel"),
        "kind": (np.array([one.kind for one in found], dtype=str), "kind of flaw"),
        "begin": (np.array([one.begin for one in found], dtype=float), "begin"),
        "end": (np.array([one.end for one in found], dtype=float), "end"),
        "n_samples": (np.array([one.n_samples for one in found], dtype=np.int64), "samples"),
        "size": (np.array([one.size for one in found], dtype=float), "size of the flaw"),
        "doubtful": (
            np.array([one.doubtful for one in found], dtype=bool), "results may be wrong by it",
        ),
        "sentence": (np.array([one.sentence for one in found], dtype=str), "in words"),
    }  # fmt: skip
    rows: dict[str, Any] = {
        name: ("finding", values, {"long_name": text} | (units if name in ("begin", "end") else {}))
        for name, (values, text) in columns.items()
    }
    attrs = {
        "system_name": str(record.attrs.get("system_name", "measured")),
        "nonsmooth_version": __version__,
        "status": "completed",
        "message": "completed",
        "false_alarms": rate,
        "n_findings": len(found),
        "n_doubtful": sum(one.doubtful for one in found),
    }
    time = ("time", record["time"].values, dict(record["time"].attrs))
    return xr.Dataset(rows | flags, {"time": time}, attrs)


def _times(record: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    if not isinstance(record, xr.Dataset) or "time" not in record.dims:
        raise OptionError("record: give a dataset over time, such as that of measured.read_csv")
    if "time" not in record.coords or record["time"].dtype.kind not in "fiu":
        raise OptionError("record: its time must be a coordinate of numbers, such as seconds")
    times = record["time"].values.astype(float)
    if times.size < FEWEST:
        raise OptionError(f"record: {times.size} samples are too few; {FEWEST} are needed at least")
    if not np.all(np.isfinite(times)):
        raise OptionError("record: some of its times are not finite; give it even ones")
    return times


def _channels(record: xr.Dataset, channels: Any) -> list[str]:
    known = [
        str(name)
        for name, v in record.data_vars.items()
        if v.dims == ("time",) and v.dtype.kind == "f"
    ]
    chosen = known if channels is None else listed(channels, "channels")
    if not chosen:
        raise OptionError("channels: the data have no variable over time to check")
    for name in chosen:
        if not is_known(name, known):
            raise OptionError(f"channels: {unknown_name('variable', name, known)}")
    return chosen


def _kinds(leave_out: Any) -> list[str]:
    chosen = listed(leave_out, "leave_out")
    for kind in chosen:
        if not is_known(kind, KINDS):
            raise OptionError(f"leave_out: {unknown_name('kind', kind, KINDS)}")
    return chosen


def _mains(mains: Any) -> tuple[float, ...]:
    if isinstance(mains, str) or not isinstance(mains, Iterable):
        raise OptionError(f"mains = {quote(mains)}: give frequencies in Hz, such as (50, 60)")
    found = tuple(finite_number("mains", each) for each in mains)
    if any(each <= 0.0 for each in found):
        raise OptionError(f"mains = {quote(mains)}: frequencies must be positive, in Hz")
    return found
