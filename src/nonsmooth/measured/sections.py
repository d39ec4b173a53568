"""`section`: a measured motion once per revolution, between its samples."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError, quote
from nonsmooth.measured.marking import check_marked, speed_attributes
from nonsmooth.measured.quality.masks import masked, masks_at
from nonsmooth.measured.record import check_record
from nonsmooth.runs.options import finite_number

__all__ = ["first_samples", "inside", "interpolated", "revolutions_of", "section", "speed_words"]

Floats = npt.NDArray[np.float64]

_KEPT = ("system_name", "nonsmooth_version", "status", "message", "sample_rate", "mark_error",
         "n_repaired", "length", "natural_frequency")  # fmt: skip


def inside(places: Floats, count: int) -> npt.NDArray[np.bool_]:
    """Whether places, in samples from the first one, lie within the record."""
    slack = 1e-6
    found: npt.NDArray[np.bool_] = (places >= -slack) & (places <= count - 1 + slack)
    return found


def interpolated(values: Floats, places: Floats) -> Floats:
    """Values at some places, in samples from the first one.

    Local, so that a contact is felt one sample away and not, as with a spline, by all others. Its
    error is at most 3/128 of the fourth derivative by the step; white noise is not enlarged.
    """
    first = first_samples(places, values.size)
    s = places - first  # from 0 to 3, between 1 and 2 but at the ends
    total: Floats = values[first] * (-(s - 1.0) * (s - 2.0) * (s - 3.0) / 6.0)
    total += values[first + 1] * (s * (s - 2.0) * (s - 3.0) / 2.0)
    total += values[first + 2] * (-s * (s - 1.0) * (s - 3.0) / 2.0)
    total += values[first + 3] * (s * (s - 1.0) * (s - 2.0) / 6.0)
    return total


def first_samples(places: Floats, count: int) -> npt.NDArray[np.int64]:
    """The first of the four samples about each place."""
    return np.clip(np.floor(places).astype(np.int64) - 1, 0, count - 4)


def section(record: xr.Dataset, *, transient: int = 0, phase: float = 0.0) -> xr.Dataset:
    """Poincaré section of a record: its variables once per revolution, at the marks.

    Parameters
    ----------
    record : xarray.Dataset
        Result of `read_csv` or `from_arrays`, with `velocities` where they are wanted.
    transient : int, optional
        Marks left out at the beginning.
    phase : float, optional
        Part of the revolution after its mark at which points are taken, from 0 to less than 1.

    Returns
    -------
    xarray.Dataset
        Over ``point``: every variable of the record, its ``time`` and the ``speed`` of the
        revolution it belongs to. Attributes: ``speed``, ``speed_spread``, ``period`` (the mean
        one), ``mark_error``, ``phase`` and ``transient``.

    Raises
    ------
    OptionError
        When the record has no marks, no mark is left, or for an option out of its range.

    See Also
    --------
    nonsmooth.stroboscopic_map : the same of a system.
    diagram : sections over the speed.

    Notes
    -----
    Between samples the cubic through the four about the mark counts. An error of a mark moves a
    point along the motion by that time: ``mark_error`` times the velocity, at most. Between two
    marks the speed is taken as constant.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(5000) / 2000.0
    >>> record = ns.measured.from_arrays(
    ...     {"x": np.cos(100 * t)}, times=t, marks=np.arange(39) * np.pi / 50
    ... )
    >>> points = ns.measured.section(ns.measured.velocities(record), phase=0.25)
    >>> points.sizes["point"], float(abs(points["x"]).max().round(6)), float(points["vx"][0])
    (38, 0.0, -99.99997)
    """
    record = check_record(record)
    check_marked(record, "a section")
    part = finite_number("phase", phase)
    if not 0.0 <= part < 1.0:
        raise OptionError(f"phase = {part:g} must lie between 0 and less than 1")
    first = finite_number("transient", transient)
    if first < 0.0 or first != int(first):
        raise OptionError(f"transient = {quote(transient)} must be a whole number of marks")
    times, number, speeds = revolutions_of(record, np.array([part]))
    start, rate = float(record["time"][0]), float(record.attrs["sample_rate"])
    places = (times - start) * rate
    here = inside(places, record.sizes["time"])
    here &= np.cumsum(here) > int(first)
    if not here.any():
        raise OptionError(
            f"no point of the section is left of {record.sizes['mark']} marks, after transient ="
            f" {int(first)}; take a longer record"
        )
    variables: dict[str, Any] = {
        str(name): ("point", interpolated(values.values, places[here]), dict(values.attrs))
        for name, values in record.data_vars.items()
    }
    chosen = number[here]
    marks = record["mark_time"].values[chosen[0] : chosen[-1] + 2]
    summary = speed_attributes(marks) if marks.size > 1 else {}
    attrs = {key: record.attrs[key] for key in _KEPT if key in record.attrs}
    attrs |= {key: summary[key] for key in ("speed", "speed_spread") if key in summary}
    if summary:
        attrs["period"] = 2.0 * math.pi / summary["speed"]
    attrs |= {"n_points": int(here.sum()), "phase": part, "transient": int(first)}
    points = xr.Dataset(
        variables,
        {
            "point": ("point", np.arange(chosen.size), {"long_name": "revolution"}),
            "time": ("point", times[here], dict(record["time"].attrs)),
            "speed": ("point", speeds[here], speed_words(record)),
        },
        attrs,
    ).drop_indexes("point")
    flags = masks_at(record, first_samples(places[here], record.sizes["time"]), 4)
    return masked(points, flags, "point") if flags else points


def speed_words(record: xr.Dataset) -> dict[str, str]:
    """Label of speeds: in rad/s, or over the natural frequency."""
    if "natural_frequency" in record.attrs:
        return {"long_name": "speed over the natural frequency"}
    return {"long_name": "speed", "units": f"rad/{record['time'].attrs.get('units', 's')}"}


def revolutions_of(
    record: xr.Dataset, parts: Floats
) -> tuple[Floats, npt.NDArray[np.int64], Floats]:
    """Times at parts of each revolution, its number and its speed there.

    Behind the last mark there is no revolution, but the mark itself is a point of the part zero,
    with the speed before it.
    """
    marks = record["mark_time"].values
    lengths = np.diff(marks)
    times = (marks[:-1, None] + lengths[:, None] * parts).ravel()
    number = np.repeat(np.arange(lengths.size), parts.size)
    if parts[0] == 0.0:
        times, number = np.append(times, marks[-1]), np.append(number, lengths.size)
    speeds = 2.0 * math.pi / lengths[np.minimum(number, lengths.size - 1)]
    return times, number, speeds
