"""`from_arrays`: displacements or accelerations, with marks or without, as a dataset over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError, is_known, quote
from nonsmooth.measured.channel import check_name
from nonsmooth.measured.clock import FEWEST, Places, check_finite, clock_of, numbers
from nonsmooth.measured.marking import Marking, marks_of
from nonsmooth.version import __version__

__all__ = ["check_record", "from_arrays", "record_of"]

Floats = npt.NDArray[np.float64]


def from_arrays(
    displacements: Mapping[str, npt.ArrayLike],
    *,
    times: npt.ArrayLike | None = None,
    sample_rate: float | None = None,
    marks: npt.ArrayLike | None = None,
    pulse: npt.ArrayLike | None = None,
    units: str | Mapping[str, str] = "",
    labels: Mapping[str, str] | None = None,
    threshold: float | None = None,
    hysteresis: float | None = None,
    edge: str = "rising",
    bad_marks: str = "refuse",
    bad_samples: str = "refuse",
    time_range: tuple[float, float] | None = None,
    name: str = "measured",
) -> xr.Dataset:
    """Record of a measured motion out of arrays.

    Parameters
    ----------
    displacements : mapping of str to array_like
        Samples by the name of the variable; of accelerations, too.

    Other Parameters
    ----------------
    times : array_like, optional
        Time of each sample in s: increasing, and at most a tenth of a step off an even grid,
        which is then used in place of them. Or ``sample_rate``.
    sample_rate : float, optional
        Samples per s, the first one at time 0.
    marks : array_like, optional
        Times of the marks, one per revolution or period of the forcing. Or ``pulse``; neither
        where the record has none: `section`, `diagram` and `synchronous` want them, `velocities`
        does without ``highest``.
    pulse : array_like, optional
        Samples of the signal that marks revolutions, whose edges are taken.
    units : str or mapping of str to str, optional
        Units of all displacements, or of each.
    labels : mapping of str to str, optional
        ``long_name`` of variables, for the labels of axes.
    threshold : float, optional
        Level of an edge; by default midway between the lowest and the highest sample.
    hysteresis : float, optional
        Width of the band about the threshold that an edge has to cross; by default a fifth of
        the range of the signal.
    edge : {"rising", "falling"}, optional
        Which edges are marks.
    bad_marks : {"refuse", "repair", "keep"}, optional
        What to do about revolutions shorter than 2/3 or longer than 3/2 of the median of eleven:
        refuse the record, or leave double marks out and put missing ones in evenly, but not where
        all channels stand still for half a turn. Marks that are kept as they are can be looked at
        by `check`.
    bad_samples : {"refuse", "keep"}, optional
        What to do about samples that are not finite, and times that are not even: refuse the
        record, or keep both as they are for `check`.
    time_range : tuple of float, optional
        First and last time of the part that is kept; before anything else is checked.
    name : str, optional
        Title of the record.

    Returns
    -------
    xarray.Dataset
        The displacements over ``time``. Attributes: ``sample_rate``; ``time_off``, how far times
        were off the even grid, in steps. With marks ``mark_time`` over ``mark``, and ``speed`` in
        rad/s (that of the whole revolutions between the first and
        the last mark) and ``speed_spread``, the standard deviation over single revolutions;
        ``mark_error``, a bound of what sampling the pulse does to the time of a mark;
        ``n_marks``, ``n_repaired``.

    Raises
    ------
    OptionError
        For samples that are not finite or not even in time, and marks that are not one per
        revolution; the message says where.

    See Also
    --------
    read_csv : the same from a file.
    velocities : the next step.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(5000) / 2000.0
    >>> record = ns.measured.from_arrays(
    ...     {"x": np.cos(100 * t)}, times=t, marks=np.arange(39) * np.pi / 50, units="mm"
    ... )
    >>> round(record.attrs["speed"], 6), record.sizes["mark"]
    (100.0, 39)
    """
    return record_of(
        displacements,
        (times, sample_rate, time_range),
        Marking(marks, pulse, threshold, hysteresis, edge, bad_marks),
        (units, labels),
        name,
        Places(),
        bad_samples,
    )


def record_of(
    displacements: Any,
    timing: tuple[Any, Any, Any],
    marking: Marking,
    words: tuple[Any, Any],
    name: str,
    places: Places,
    bad_samples: str = "refuse",
) -> xr.Dataset:
    """Record of checked arrays.

    timing: times, sample rate and the range of time that is kept; words: units and labels
    """
    if not is_known(bad_samples, ("refuse", "keep")):
        raise OptionError(f"bad_samples = {quote(bad_samples)}: give 'refuse' or 'keep'")
    if not isinstance(name, str):
        raise OptionError(f"name = {quote(name)}: give a text")
    keep = bad_samples == "keep"
    arrays = _arrays(displacements)
    times, sample_rate, time_range = timing
    count = next(iter(arrays.values())).size
    clock = clock_of(times, sample_rate, count, time_range, places, keep)
    arrays = {key: values[clock.first : clock.last] for key, values in arrays.items()}
    count = clock.last - clock.first
    if count < FEWEST:
        raise OptionError(f"{count} samples are too few; {FEWEST} are needed at least")
    if keep:
        arrays = {key: np.where(np.isfinite(each), each, np.nan) for key, each in arrays.items()}
    else:
        check_finite(arrays, clock.start, clock.step, clock.first, places)
    marks = marks_of(marking, clock, places, arrays)
    attrs: dict[str, Any] = {
        "system_name": name,
        "nonsmooth_version": __version__,
        "status": "completed",
        "message": "completed",
        "sample_rate": 1.0 / clock.step,
        "time_off": clock.off,
    }
    about = {"long_name": "time", "units": "s"}
    coords: dict[str, Any] = {"time": ("time", clock.times, about)}
    if marks is not None:
        about = {"long_name": "time of the mark", "units": "s"}
        coords["mark_time"] = "mark", marks[0], about
        attrs |= marks[1]
    said = _words(arrays, *words)
    return xr.Dataset(
        {key: ("time", values, said[key]) for key, values in arrays.items()}, coords, attrs
    )


def check_record(record: Any) -> xr.Dataset:
    """The record of a measured motion, or an error that says what is one.

    Marks it may have or not; what has been resampled by angle is no record any more.
    """
    if (
        not isinstance(record, xr.Dataset)
        or "time" not in record.dims
        or "sample_rate" not in record.attrs
        or "measured_time" in record.coords
    ):
        raise OptionError("record: give a result of measured.read_csv or measured.from_arrays")
    count, rate = record.sizes["time"], float(record.attrs["sample_rate"])
    if count < 2:
        raise OptionError("record: it has no samples")
    span = float(record["time"][-1] - record["time"][0]) * rate
    if not abs(span / (count - 1) - 1.0) < 1e-6:
        raise OptionError(
            "record: its samples are no longer one after the other, as its sample_rate has it; cut"
            " it by read_csv(..., time_range=) or by a slice of time without a step"
        )
    return record


def _arrays(displacements: Any) -> dict[str, Floats]:
    if not isinstance(displacements, Mapping) or not displacements:
        raise OptionError("displacements: give arrays by name, such as {'x': [...], 'y': [...]}")
    found: dict[str, Floats] = {}
    for name, values in displacements.items():
        check_name(name, found)
        found[name] = numbers(name, values)
    sizes = {name: values.size for name, values in found.items()}
    if len(set(sizes.values())) > 1:
        raise OptionError(f"displacements differ in their number of samples: {sizes}")
    return found


def _words(arrays: dict[str, Floats], units: Any, labels: Any) -> dict[str, Any]:
    """Attributes of each displacement."""
    labels = {} if labels is None else labels
    if not isinstance(labels, Mapping) or not isinstance(units, (str, Mapping)):
        raise OptionError("units= is a text or a mapping by name, labels= a mapping by name")
    found = {}
    for name in arrays:
        unit = str(units.get(name, "")) if isinstance(units, Mapping) else units
        words = {"long_name": labels.get(name) or f"displacement {name}"}
        found[name] = words | ({"units": unit} if unit else {})
    return found
