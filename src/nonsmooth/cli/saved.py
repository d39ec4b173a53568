"""Results that a command has saved, read again by another one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["saved_dataset"]


def saved_dataset(file: str | Path, option: str = "", cure: str = "") -> xr.Dataset:
    """Dataset of a netCDF file.

    option: what names the file, where it is no argument; cure: which command writes such a file
    """
    import xarray as xr

    before = f"{option}: " if option else ""
    after = f"; {cure}" if cure else ""
    if not Path(file).is_file():
        raise OptionError(f"{before}there is no file {str(file)!r}{after}")
    try:
        with xr.open_dataset(file, engine="h5netcdf") as data:
            return data.load()
    except (OSError, ValueError, KeyError):  # of the library below, about its own workings
        raise OptionError(f"{before}{str(file)!r} is no netCDF file{after}") from None
