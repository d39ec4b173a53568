"""Files that commands write: refused before a long run and not after it, and whole."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["check_files", "save_dataset"]


def check_files(plot: Path | None, save: Path | None) -> None:
    """Refuse files that could not be written."""
    from nonsmooth.files import check_target

    if plot is not None:
        check_target(plot, (".png", ".pdf"))
    if save is not None:
        check_target(save, (".nc",))


def save_dataset(result: xr.Dataset, path: Path) -> None:
    """Save a result as netCDF and say so."""
    from nonsmooth.files import replacing

    with replacing(path) as draft:
        result.to_netcdf(draft, engine="h5netcdf")
    typer.echo(f"saved {path}")
