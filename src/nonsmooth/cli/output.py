"""What commands leave behind: files, a table of results, an exit code.

Files that could not be written are refused before a long run and not after it.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from nonsmooth.cli.console import ENDED_EARLY, INTERRUPTED

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["certified", "certified_runs", "check_files", "exit_by_status", "save_dataset", "table"]


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


def table(title: str, rows: Sequence[tuple[str, str]]) -> str:
    """Labels with their texts below each other, under a title."""
    width = max(len(label) for label, _ in rows)
    return "\n".join([title, *(f"  {label:<{width}}  {text}" for label, text in rows)])


def certified(uncertain: int, estimated: int) -> str:
    """Whether a run is certified, or what stands against it."""
    if uncertain:
        return f"no, {uncertain} within rounding of a tangency"
    return f"no, the error of {estimated} steps is estimated" if estimated else "yes"


def certified_runs(result: xr.Dataset) -> str:
    """Whether all runs of a result are certified, or how many are not."""
    uncertain, estimated = (
        int((result[name].values > 0).sum()) for name in ("n_uncertain", "n_estimated")
    )
    against = []
    if uncertain:
        against.append(f"{uncertain} within rounding of a tangency")
    if estimated:
        against.append(f"{estimated} with estimated errors of steps")
    return "all runs but " + ", ".join(against) if against else "yes"


def exit_by_status(status: str) -> None:
    """Leave with the code of a run that did not come to its end; files are written by then."""
    if status == "interrupted":
        raise typer.Exit(INTERRUPTED)
    if status not in ("completed", "stopped"):
        raise typer.Exit(ENDED_EARLY)
