"""Data files that appear whole or not at all: written beside their place, then moved there."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
    return _replace(path, lambda draft: data.to_netcdf(draft, engine="h5netcdf"))


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

    def write(draft: Path) -> None:
        with draft.open("w", newline="", encoding="utf-8") as file:
            table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            table.writeheader()
            table.writerows(rows)

    return _replace(path, write)


def _replace(path: Path, write: Callable[[Path], Any]) -> Path:
    # the process number keeps two programs that write the same file apart
    draft = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        write(draft)
        os.replace(draft, path)
    finally:
        draft.unlink(missing_ok=True)
    return path
