"""`dimensionless`: a record in the units of a model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr

from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.measured.record import check_record
from nonsmooth.measured.velocity import displacements_of
from nonsmooth.runs.options import finite_number

__all__ = ["dimensionless"]

_RATES = ("bandwidth", "highest", "lowest", "low_pass")  # attributes that are frequencies
_TIMES = ("edge", "period")
_SMALLEST = 1e-75  # unit, whose powers up to the third are numbers


def dimensionless(
    record: xr.Dataset,
    *,
    length: float,
    natural_frequency: float,
    origin: Mapping[str, float] | None = None,
) -> xr.Dataset:
    """Record with lengths in units of one, and times in units of 1 over a natural frequency.

    Parameters
    ----------
    record : xarray.Dataset
        Result of `read_csv` or `from_arrays`, with or without `velocities`.
    length : float
        Unit of length, such as the gap, in the units of the displacements.
    natural_frequency : float
        Angular frequency in rad/s; speeds are then ratios to it.
    origin : mapping of str to float, optional
        Displacement at the origin of the model, in the units of the record, by name; zero
        without it. Where a probe was zeroed elsewhere than the model has its origin.

    Returns
    -------
    xarray.Dataset
        The same without units, all attributes that are times, rates or noise scaled too;
        attributes ``length`` and ``natural_frequency``.

    Raises
    ------
    OptionError
        When displacements have different units, the record has been scaled, or a unit is not
        positive.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(5000) / 2000.0
    >>> record = ns.measured.from_arrays(
    ...     {"x": 0.9 + 0.5 * np.cos(100 * t)},
    ...     times=t,
    ...     marks=np.arange(39) * np.pi / 50,
    ...     units="mm",
    ... )
    >>> scaled = ns.measured.dimensionless(
    ...     record, length=0.5, natural_frequency=50.0, origin={"x": 0.4}
    ... )
    >>> round(scaled.attrs["speed"], 6), float(scaled["x"].max())
    (2.0, 2.0)
    """
    record = check_record(record)
    if "natural_frequency" in record.attrs:
        raise OptionError("the record is dimensionless already; scale the one in units")
    unit, rate = _positive("length", length), _positive("natural_frequency", natural_frequency)
    shifts = _shifts(record, origin)
    found = record.copy()
    for name in record.data_vars:
        values = record[name]
        moving = "derivative_of" in values.attrs
        factor = 1.0 / (unit * rate) if moving else 1.0 / unit
        words = {key: word for key, word in values.attrs.items() if key != "units"}
        if "noise" in words:
            words["noise"] = float(words["noise"]) * factor
        words = _scaled_words(words, unit, rate, moving, _is_integrated(record, str(name)))
        shifted = values.values - shifts.get(str(name), 0.0)
        found[name] = (values.dims, shifted * factor, words)
    for name in (name for name in ("time", "mark_time") if name in record.coords):
        words = {key: word for key, word in record[name].attrs.items() if key != "units"}
        found = found.assign_coords({name: (record[name].dims, record[name].values * rate, words)})
    attrs = dict(record.attrs)
    for key, power in (("sample_rate", -1), ("speed", -1), ("speed_spread", -1), ("mark_error", 1)):
        if key in attrs:  # without marks there is no speed
            attrs[key] = float(attrs[key]) * rate**power
    found.attrs = attrs | {"length": unit, "natural_frequency": rate}
    return found


def _scaled_words(
    words: dict[str, Any], unit: float, rate: float, moving: bool, integrated: bool
) -> dict[str, Any]:
    """Attributes that are frequencies, times, or what noise is multiplied with."""
    powers = dict.fromkeys(_RATES, -1) | dict.fromkeys(_TIMES, 1)
    # the noise is that of a displacement, or of the acceleration that was integrated
    # and of a low-pass a plain number
    powers["noise_gain"] = (2 if integrated else 0) - (1 if moving else 0)
    found = {key: float(words[key]) * rate**power for key, power in powers.items() if key in words}
    if "residual" in words:
        found["residual"] = float(words["residual"]) / (unit * rate**2)
    return words | found


def _is_integrated(record: xr.Dataset, name: str) -> bool:
    """Whether a displacement or a velocity comes from an acceleration."""
    source = record[name].attrs.get("derivative_of", name)
    return source in record and "integral_of" in record[source].attrs


def _positive(name: str, value: Any) -> float:
    number = finite_number(name, value)
    if number < _SMALLEST:
        raise OptionError(f"{name} = {number:g} must be positive, {_SMALLEST:g} at least")
    return number


def _shifts(record: xr.Dataset, origin: Any) -> dict[str, float]:
    """Displacements at the origin, of a record whose displacements have one unit."""
    known = displacements_of(record)
    units = {name: str(record[name].attrs.get("units", "")) for name in known}
    if len(set(units.values())) > 1:
        raise OptionError(f"displacements have different units, so one length cannot do: {units}")
    if origin is None:
        return {}
    if not isinstance(origin, Mapping):
        raise OptionError(f"origin = {quote(origin)}: give a mapping such as {{'x': 0.1}}")
    for name in origin:
        if name not in known:
            raise OptionError(f"origin: {unknown_name('displacement', name, known)}")
    return {name: finite_number(f"origin {name}", value) for name, value in origin.items()}
