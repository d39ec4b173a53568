"""`read_columns`: columns of numbers out of a CSV file, such as those of a calibration."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping

import numpy as np
import xarray as xr

from nonsmooth.errors import OptionError
from nonsmooth.measured.channel import Channel, channels_of, units_of
from nonsmooth.measured.csv_text import numbers_of, read_table

__all__ = ["read_columns"]


def read_columns(
    path: str | os.PathLike[str],
    columns: Mapping[str, str | int | Channel] | Iterable[str],
    *,
    delimiter: str | None = None,
    decimal: str | None = None,
) -> xr.Dataset:
    """Columns of a CSV file whose rows need be neither even in time nor in time at all.

    For what is no motion: displacement steps and voltages of a calibration, crack lengths over
    time, loads. The file may look as one for `read_csv`.

    Parameters
    ----------
    path : str or path-like
        The file.
    columns : mapping or iterable of str
        Names of variables to headers, numbers of columns (from 0) or `Channel`; or just headers
        that are to be the names too.
    delimiter : str, optional
        Character between columns; found out without it.
    decimal : {".", ","}, optional
        Decimal sign; found out without it.

    Returns
    -------
    xarray.Dataset
        The variables over ``row``, with their ``units`` as in the header or of the channel; the
        coordinate ``line`` is the number of the line in the file, from 1. Attribute ``source`` is
        the name of the file.

    Raises
    ------
    OptionError
        For a file that is no table of numbers, a column that is not there, and a cell that is no
        finite number, with its line.

    See Also
    --------
    read_csv : records of a motion.
    nonsmooth.fatigue.calibrate : the gain of a sensor from such columns.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import nonsmooth as ns
    >>> text = "step (mm);output (V)" + chr(10) + "0,0;0,01" + chr(10) + "0,1;0,51"
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "steps.csv")
    ...     _ = file.write_text(text)
    ...     data = ns.measured.read_columns(file, {"displacement": "step", "voltage": "output"})
    >>> data["voltage"].values.tolist(), data["voltage"].attrs["units"]
    ([0.01, 0.51], 'V')
    """
    channels = channels_of(columns, reserved=False)
    table = read_table(path, delimiter, decimal)
    places = {name: table.column(one.column, name) for name, one in channels.items()}
    numbers = numbers_of(table, [place for place, _ in places.values()])
    lines = 1 + np.array(table.row_lines, dtype=int)
    if not np.all(np.isfinite(numbers)):
        k = int(np.flatnonzero(~np.all(np.isfinite(numbers), axis=0))[0])
        name = list(channels)[int(np.flatnonzero(~np.isfinite(numbers[:, k]))[0])]
        raise OptionError(
            f"{table.name}, line {lines[k]}: {name} is missing or not finite; delete the line, or"
            " write the number"
        )
    data = {}
    for (name, one), values in zip(channels.items(), numbers, strict=True):
        attrs = {"units": units_of(name, one, places[name][1]), "long_name": one.long_name or name}
        data[name] = ("row", one.displacement(values), attrs)
    return xr.Dataset(data, coords={"line": ("row", lines)}, attrs={"source": table.name})
