"""Data files of figures and tables, as netCDF and CSV; they appear whole or not at all."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.files import replacing

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["save_data", "save_table"]


def save_data(data: xr.Dataset, path: Path) -> Path:
    """Write a dataset as netCDF.

    Parameters
    ----------
    data : xarray.Dataset
        The data.
    path : pathlib.Path
        File to write; its folder exists.

    Returns
    -------
    pathlib.Path
        The file.

    Examples
    --------
    >>> import tempfile
    >>> import xarray as xr
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_data(xr.Dataset({"x": 1.0}), Path(folder) / "x.nc").name
    'x.nc'
    """
    with replacing(path) as draft:
        data.to_netcdf(draft, engine="h5netcdf")
    return path


def save_table(rows: Sequence[Mapping[str, Any]], path: Path) -> Path:
    """Write rows with the same keys as a CSV file with a header.

    Parameters
    ----------
    rows : sequence of mapping
        The rows, at least one.
    path : pathlib.Path
        File to write; its folder exists.

    Returns
    -------
    pathlib.Path
        The file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_table([{"b": 0.15, "v": 31.3}], Path(folder) / "t.csv").read_text().split()
    ['b,v', '0.15,31.3']
    """
    with replacing(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    return path
