"""`read_csv`: a record out of a file that a recorder wrote."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterable, Mapping
from typing import Any

import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError, ResultWarning
from nonsmooth.measured.channel import Channel, channels_of, units_of
from nonsmooth.measured.clock import FilePlaces
from nonsmooth.measured.csv_text import Table, numbers_of, read_table
from nonsmooth.measured.marking import Marking
from nonsmooth.measured.record import record_of

__all__ = ["read_csv", "seconds_of", "unit_of_times"]

# behind a sign or a blank; not the last letters of a word
_UNIT_AT_END = re.compile(
    r"[\W_]((?:m|u|\N{MICRO SIGN}|\N{GREEK SMALL LETTER MU})?s(?:ec)?|ns|min|h)\W*$", re.IGNORECASE
)
_SECONDS = {"": 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6,
            "msec": 1e-3, "usec": 1e-6, "µsec": 1e-6, "μsec": 1e-6}  # fmt: skip
_TIMES = ("time", "Time", "t")  # headers that are looked for


def read_csv(
    path: str | os.PathLike[str],
    columns: Mapping[str, str | int | Channel] | Iterable[str],
    *,
    time: str | int | None = None,
    sample_rate: float | None = None,
    mark: str | int | None = None,
    marks: npt.ArrayLike | None = None,
    threshold: float | None = None,
    hysteresis: float | None = None,
    edge: str = "rising",
    bad_marks: str = "refuse",
    bad_samples: str = "refuse",
    time_range: tuple[float, float] | None = None,
    delimiter: str | None = None,
    decimal: str | None = None,
) -> xr.Dataset:
    r"""Record of a measured motion from a CSV file, with one mark per revolution or without.

    Columns are found by their headers, with or without units in brackets behind the name, or by
    number. Lines above the header are skipped, and so are those that begin with # or % between the
    numbers; commas, semicolons, tabs, bars or spaces part the columns; a decimal comma is noticed
    where no points are about. Columns of text, such as stamps and comments, are left alone. Nothing
    in a file is run.

    Parameters
    ----------
    path : str or path-like
        The file.
    columns : mapping or iterable of str
        Names of variables to headers, numbers of columns (from 0) or `Channel`; or just headers
        that are to be the names too.

    Other Parameters
    ----------------
    time : str or int, optional
        Column of the time in s, or in the unit of its header: ms or us, in brackets, in a row of
        units or at the end, as in ``time_ms``. ``time``, ``Time`` or ``t`` without it.
    sample_rate : float, optional
        Samples per s, in place of a column of times.
    mark : str or int, optional
        Column of the signal that marks revolutions, such as that of a tacho or an optoswitch.
    marks : array_like, optional
        Times of the marks in s, in place of a column. With neither the record has no marks, as
        one of accelerometers that `low_pass` and `displacements` take; `section`, `diagram` and
        `synchronous` want them.
    threshold : float, optional
        Level of an edge, in units of the column; midway between its extremes without it.
    hysteresis : float, optional
        Width of the band about the threshold that an edge has to cross; by default a fifth of
        the range of the column.
    edge : {"rising", "falling"}, optional
        Which edges are marks.
    bad_marks : {"refuse", "repair", "keep"}, optional
        What to do about double and missing marks, as in `from_arrays`.
    bad_samples : {"refuse", "keep"}, optional
        What to do about samples that are not finite and times that are not even, as in
        `from_arrays`.
    time_range : tuple of float, optional
        First and last time in s of the part that is kept, such as one without a gap.
    delimiter : str, optional
        Character between columns; found out without it.
    decimal : {".", ","}, optional
        Decimal sign; found out without it.

    Returns
    -------
    xarray.Dataset
        As of `from_arrays`; attribute ``source`` is the name of the file.

    Raises
    ------
    OptionError
        For a file that is no table of numbers, a column that is not there, samples that are not
        even in time or missing, with their line, rows with fewer cells than the first one, and
        marks that are not one per revolution.

    Warns
    -----
    ResultWarning
        When a displacement does not change at all: a probe may be dead.

    See Also
    --------
    from_arrays : the same from arrays, with what is checked.
    velocities, section, diagram : what comes next.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(2000) / 2000.0
    >>> rows = zip(t, -9.6 + 4 * np.cos(100 * t), 5.0 * (np.cos(100 * t) > 0.99))
    >>> text = "time [s];CH1 [V];tacho [V]\n" + "\n".join("%.4f;%.4f;%.1f" % row for row in rows)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "run.csv")
    ...     _ = file.write_text(text)
    ...     probe = ns.measured.Channel("CH1", sensitivity=8.0, offset=-9.6, units="mm")
    ...     record = ns.measured.read_csv(file, {"x": probe}, mark="tacho")
    >>> record["x"].attrs["units"], round(float(record["x"].max()), 3), record.sizes["mark"]
    ('mm', 0.5, 15)
    >>> round(record.attrs["speed"])
    100
    """
    table = read_table(path, delimiter, decimal)
    channels = channels_of(columns)
    if time is not None and sample_rate is not None:
        raise OptionError("give either the column time= or sample_rate=")
    if mark is not None and marks is not None:
        raise OptionError(
            "give the marks of revolutions by either the column mark= or their times marks="
        )
    found = {name: table.column(one.column, name) for name, one in channels.items()}
    places = {name: place for name, (place, _) in found.items()}
    factor = 1.0
    if sample_rate is None:
        places["time"], factor = _time_column(table, time)
    if mark is not None:
        places["mark"] = table.column(mark, "mark")[0]
    numbers = list(numbers_of(table, list(places.values())))
    pulse = numbers.pop() if mark is not None else None
    times = numbers.pop() * factor if sample_rate is None else None
    values = {
        name: one.displacement(array)
        for (name, one), array in zip(channels.items(), numbers, strict=True)
    }
    try:
        units = {name: units_of(name, one, found[name][1]) for name, one in channels.items()}
        record = record_of(
            values,
            (times, sample_rate, time_range),
            Marking(marks, pulse, threshold, hysteresis, edge, bad_marks),
            (units, {name: one.long_name for name, one in channels.items()}),
            os.path.splitext(table.name)[0],
            FilePlaces(table, places),
            bad_samples,
        )
    except OptionError as error:
        between = ", " if str(error).startswith("line ") else ": "
        raise OptionError(f"{table.name}{between}{error}") from None
    still = [name for name in channels if float(record[name].min()) == float(record[name].max())]
    if still:
        warnings.warn(
            f"{table.name}: {', '.join(still)} does not change at all; is the probe connected?",
            ResultWarning,
            stacklevel=2,
        )
    return record.assign_attrs(source=table.name)


def _time_column(table: Table, wanted: Any) -> tuple[int, float]:
    """Column of the times, and the unit of its header in s."""
    if wanted is None:
        for name in _TIMES:
            try:
                place, units = table.column(name, "time")
                break
            except OptionError:
                continue
        else:
            raise OptionError(
                f"{table.name} has no column called {', '.join(_TIMES)}; name that of the times by"
                " time=, or give sample_rate="
            )
    else:
        place, units = table.column(wanted, "time")
    units = units or unit_of_times(table.header(place))
    return place, seconds_of(units, table.name, "give sample_rate=")


def unit_of_times(header: str) -> str:
    """Unit that a header of times ends with, not in brackets: ``time_ms``, ``t/ms``, ``time in s``.

    Units that are refused are found too; other words are no unit.
    """
    found = _UNIT_AT_END.search(header)
    return found[1] if found else ""


def seconds_of(units: str, where: str, cure: str) -> float:
    """Unit of times in s, as a header has it."""
    if units.lower() not in _SECONDS:
        raise OptionError(f"{where}: times are in {units!r}, known are s, ms and us; {cure}")
    return _SECONDS[units.lower()]
