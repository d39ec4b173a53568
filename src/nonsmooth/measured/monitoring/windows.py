"""`indicators`: numbers that a fault would move, over windows of whole periods of a record."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError, ResultWarning, is_known, quote, unknown_name
from nonsmooth.measured.even_samples import listed
from nonsmooth.measured.marking import speed_attributes
from nonsmooth.measured.quality.masks import quality_of
from nonsmooth.measured.record import check_record
from nonsmooth.measured.resampling import synchronous
from nonsmooth.runs.options import finite_number, positive_number, whole_number
from nonsmooth.version import __version__

__all__ = ["indicators"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_HARMONICS = (2, 3)
_SUBHARMONICS = (2, 3)  # a half and a third of the frequency
_FEWEST_IN_PERIOD = 2  # samples
_FEWEST_CYCLES = 3  # in a window, for the scatter about a cycle


class _Windows(NamedTuple):
    """Samples of one channel by window, period and phase, the flawed ones filled."""

    values: Floats
    known: Mask  # windows that hold enough good samples


def indicators(
    record: xr.Dataset,
    channels: str | Iterable[str] | None = None,
    *,
    periods: int = 24,
    period: float | None = None,
    contact: Mapping[str, Any] | None = None,
    most_period: int = 8,
    most_flawed: float = 0.01,
) -> xr.Dataset:
    r"""Indicators over windows of a record: harmonics, subharmonics, strobes, contact, kurtosis.

    Parameters
    ----------
    record : xarray.Dataset
        Result of `read_csv` or `from_arrays`. With marks, windows hold whole revolutions, however
        the speed wanders.
    channels : str or list of str, optional
        Variables that are looked at, all by default.

    Other Parameters
    ----------------
    periods : int, optional
        Periods, or revolutions, of one window. A multiple of 6 gives the subharmonics 1/2 and 1/3.
    period : float, optional
        Period of a record without marks, exactly known: that of the forcing.
    contact : mapping, optional
        Channels that show a contact, such as a force or a gap, with the range in which they are
        while there is one: ``{"force": (5, numpy.inf)}``, ``{"gap": (-0.01, 0.01)}``.
    most_period : int, optional
        Longest period, in periods of the forcing, of a cycle that is no scatter of strobes; at
        most a third of ``periods``.
    most_flawed : float, optional
        Share of samples of a channel that may be flawed in a window. With more the window is left
        out.

    Returns
    -------
    xarray.Dataset
        Over ``window`` for each channel ``x``: ``x_rms`` (without the mean), ``x_kurtosis``,
        ``x_strobes``, the scatter of strobes about a cycle, ``x_harmonic_1``, the amplitude at the
        frequency of the forcing, and relative to it ``x_harmonic_2``, ``x_harmonic_3``,
        ``x_subharmonic_2`` (at a half of the frequency) and ``x_subharmonic_3``; of channels of
        ``contact`` also ``x_contact``, the share of time in contact. Coordinates: ``begin`` and
        ``time``, those of the first and of the last sample of the window. Attributes:
        ``n_windows`` and ``n_left_out``.

    Raises
    ------
    OptionError
        If the record has neither marks nor a known period, or is shorter than a window.

    Warns
    -----
    ResultWarning
        If windows are left out.

    See Also
    --------
    alarm : a limit for them, from those of healthy records.
    flagged : a record whose flawed samples are known.

    Notes
    -----
    The record is resampled at equal angles (`synchronous`), so harmonics lie on lines of the
    discrete Fourier transform of a window. Flawed samples that are allowed are replaced by the mean
    at the same phase of the other periods of the window. The scatter of strobes is the least root
    mean square about the points of a cycle of n points, n up to ``most_period``, with a degree of
    freedom less for each point. *Of a motion that repeats, strobes hold nothing but noise*: this
    indicator tells that a motion has become irregular or longer than the cycles, and nothing
    before that.

    Any further variable over ``window`` is an indicator, too: assign it to the result, such as a
    stiffness that `nonsmooth.fit` finds in each window.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(20_000) / 1000.0
    >>> x = np.cos(2 * np.pi * 20 * t) + 0.1 * np.cos(2 * np.pi * 10 * t)
    >>> record = ns.measured.from_arrays({"x": x}, times=t, units="mm")
    >>> found = ns.measured.indicators(record, period=0.05)
    >>> found.sizes["window"], found["x_subharmonic_2"].values[0].round(6)
    (16, np.float64(0.1))
    """
    count = whole_number("periods", periods)
    longest = whole_number("most_period", most_period)
    if longest * _FEWEST_CYCLES > count:
        most = count // _FEWEST_CYCLES
        fewer = f"give at most {most}, or more periods=" if most else "give more periods="
        raise OptionError(
            f"most_period = {longest}: a window of {count} periods holds fewer than"
            f" {_FEWEST_CYCLES} such cycles; {fewer}"
        )
    flawed = finite_number("most_flawed", most_flawed)
    if not 0.0 <= flawed < 1.0:
        raise OptionError(f"most_flawed = {flawed:g} must lie between 0 and less than 1")
    record = _marked(check_record(record), period)
    ranges = _ranges(record, contact)
    names = _channels(record, channels, "channels")
    whole = _turned(record, [*dict.fromkeys([*names, *ranges])], count)
    samples = whole.attrs["samples_per_period"]
    shape = (-1, count, samples)
    windows = {
        name: _filled(whole[name].values.reshape(shape), quality_of(whole, name), flawed)
        for name in map(str, whole.data_vars)
    }
    found: dict[str, Any] = {}
    for name in names:
        found |= _of_channel(name, windows[name], longest, record[name])
    for name, (low, high) in ranges.items():
        values = windows[name].values
        inside = ((values >= low) & (values <= high)).mean(axis=(1, 2))
        words = {
            "long_name": f"share of time in contact, by {name}",
            "resolution": 1.0 / (count * samples),
        }
        found[f"{name}_contact"] = "window", inside, words
    times = whole["measured_time"].values.reshape(-1, count * samples)
    return _kept(found, times, windows, record)


def _kept(
    found: dict[str, Any], times: Floats, windows: dict[str, _Windows], record: xr.Dataset
) -> xr.Dataset:
    """Dataset of the windows that are known in all channels; the others are told."""
    known = np.logical_and.reduce([one.known for one in windows.values()])
    left = int((~known).sum())
    message = "completed"
    if left:
        begins = ", ".join(f"{each:.6g}" for each in times[~known, 0][:5])
        message = (
            f"{left} of {known.size} windows are left out, for their flawed samples; they begin at"
            f" {begins}{' and later' if left > 5 else ''}"
        )
        if left == known.size:
            raise OptionError(f"record: {message}; see measured.check, or raise most_flawed=")
        warnings.warn(message, ResultWarning, stacklevel=3)
    units = {key: record["time"].attrs[key] for key in ("units",) if key in record["time"].attrs}
    coords: dict[str, Any] = {
        "begin": ("window", times[:, 0], {"long_name": "time at the begin of the window"} | units),
        "time": ("window", times[:, -1], {"long_name": "time at the end of the window"} | units),
    }
    attrs = {
        "system_name": str(record.attrs.get("system_name", "measured")),
        "nonsmooth_version": __version__,
        "status": "completed",
        "message": message,
        "n_windows": int(known.sum()),
        "n_left_out": left,
    }
    return xr.Dataset(found, coords, attrs).isel(window=np.flatnonzero(known))


def _of_channel(name: str, data: _Windows, longest: int, variable: xr.DataArray) -> dict[str, Any]:
    """Indicators of one channel."""
    count, periods, samples = data.values.shape
    away = data.values - data.values.mean(axis=(1, 2), keepdims=True)
    power = (away**2).mean(axis=(1, 2))
    spectrum = np.fft.rfft(data.values.reshape(count, -1), axis=1)
    lines = np.abs(spectrum) * (2.0 / (periods * samples))
    first = lines[:, periods]
    with np.errstate(divide="ignore", invalid="ignore"):
        kurtosis = (away**4).mean(axis=(1, 2)) / power**2
        relative = lines / first[:, None]
    label = str(variable.attrs.get("long_name") or name)
    units = {key: variable.attrs[key] for key in ("units",) if key in variable.attrs}
    found: dict[str, Any] = {
        f"{name}_rms": (np.sqrt(power), {"long_name": f"{label}: rms"} | units),
        f"{name}_kurtosis": (kurtosis, {"long_name": f"{label}: kurtosis"}),
        f"{name}_harmonic_1": (first, {"long_name": f"{label}: first harmonic"} | units),
    }
    for order in _HARMONICS:
        if 2 * order < samples:
            words = {"long_name": f"{label}: harmonic {order} over the first"}
            found[f"{name}_harmonic_{order}"] = relative[:, order * periods], words
    for order in _SUBHARMONICS:
        if periods % order == 0:
            words = {"long_name": f"{label}: subharmonic 1/{order} over the first harmonic"}
            found[f"{name}_subharmonic_{order}"] = relative[:, periods // order], words
    words = {"long_name": f"{label}: scatter of strobes"} | units
    found[f"{name}_strobes"] = _scatter(data.values[:, :, 0], longest), words
    return {key: ("window", values, words) for key, (values, words) in found.items()}


def _scatter(strobes: Floats, longest: int) -> Floats:
    """Least root mean square of the strobes of each window about the points of a cycle."""
    least = np.full(strobes.shape[0], math.inf)
    for points in range(1, longest + 1):
        cycles = strobes.shape[1] // points
        whole = strobes[:, : cycles * points].reshape(-1, cycles, points)
        left = ((whole - whole.mean(axis=1, keepdims=True)) ** 2).sum(axis=(1, 2))
        least = np.minimum(least, left / ((cycles - 1) * points))
    found: Floats = np.sqrt(least)
    return found


def _filled(values: Floats, flags: Any, most_flawed: float) -> _Windows:
    """Samples of a channel, the flawed ones replaced by the mean at the same phase."""
    good = np.isfinite(values)
    if flags is not None:
        good &= flags.reshape(values.shape) == 0
    number = good.sum(axis=1, keepdims=True)
    sums = np.where(good, values, 0.0).sum(axis=1, keepdims=True)
    typical = sums / np.maximum(number, 1)
    known = (number > 0).all(axis=(1, 2)) & ((~good).mean(axis=(1, 2)) <= most_flawed)
    return _Windows(np.where(good, values, typical), known)


def _turned(record: xr.Dataset, names: list[str], periods: int) -> xr.Dataset:
    """Whole windows of a record at equal angles, with at least as many samples as it has."""
    turn = 2.0 * math.pi / float(record.attrs["speed"]) * float(record.attrs["sample_rate"])
    others = [name for name in record.data_vars if name not in names]
    found = synchronous(record.drop_vars(others), max(math.ceil(turn - 1e-6), 4))
    samples = int(found.attrs["samples_per_period"])
    first = int(np.argmax(found["phase"].values == 0.0))
    count = (found.sizes["time"] - first) // (periods * samples)
    if count < 1:
        raise OptionError(
            f"record: it holds {(found.sizes['time'] - first) // samples} whole periods, and a"
            f" window has periods = {periods}; take a longer record, or shorter windows"
        )
    return found.isel(time=slice(first, first + count * periods * samples))


def _marked(record: xr.Dataset, period: Any) -> xr.Dataset:
    """The record with marks, which a known period gives as well."""
    if "mark_time" in record.coords:
        if period is not None:
            raise OptionError("period= is for a record without marks, and this one has marks")
        return record
    if period is None:
        raise OptionError(
            "record: it has no marks; give period=, that of the forcing, or read it with mark="
        )
    length = positive_number("period", period)
    times = record["time"].values
    held = length * float(record.attrs["sample_rate"])
    if held < _FEWEST_IN_PERIOD:
        raise OptionError(
            f"period = {length:g} holds {held:.3g} samples, and at least {_FEWEST_IN_PERIOD} are"
            " needed; is it in the unit of time of the record?"
        )
    turns = math.floor((float(times[-1]) - float(times[0])) / length + 1e-9)
    if turns < 2:
        raise OptionError(f"period = {length:g}: the record holds fewer than two of them")
    marks = float(times[0]) + length * np.arange(turns + 1, dtype=np.float64)
    found = record.assign_coords(mark_time=("mark", marks, dict(record["time"].attrs)))
    return found.assign_attrs(speed_attributes(marks))


def _channels(record: xr.Dataset, channels: Any, option: str) -> list[str]:
    known = [str(name) for name, values in record.data_vars.items() if values.dims == ("time",)]
    chosen = known if channels is None else listed(channels, option)
    if not chosen:
        raise OptionError(f"{option}: name some of {', '.join(known)}")
    for name in chosen:
        if not is_known(name, known):
            raise OptionError(f"{option}: {unknown_name('variable', name, known)}")
    return chosen


def _ranges(record: xr.Dataset, contact: Any) -> dict[str, tuple[float, float]]:
    """Least and largest value of each channel while there is contact."""
    if contact is None:
        return {}
    if not isinstance(contact, Mapping):
        raise OptionError(f"contact = {quote(contact)}: give ranges by name, such as {_RANGE}")
    found = {}
    for name in _channels(record, list(contact), "contact") if contact else ():
        try:
            low, high = (float(each) for each in contact[name])
        except (TypeError, ValueError):
            raise OptionError(
                f"contact: {quote(contact[name])} is no range of {name}; give two numbers, such as"
                f" {_RANGE}"
            ) from None
        if not low < high:
            raise OptionError(f"contact: the range of {name} from {low:g} to {high:g} is empty")
        found[name] = low, high
    return found


_RANGE = "{'force': (5.0, numpy.inf)}"
