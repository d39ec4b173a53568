"""``nonsmooth ensemble``: many initial states and parameter values."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nonsmooth.cli.arguments import build_system, constants, names, settings, value_range
from nonsmooth.cli.console import (
    ENDED_EARLY,
    INTERRUPTED,
    MODEL_HELP,
    PARAMETERS_HELP,
    STORE_HELP,
)
from nonsmooth.cli.output import certified_runs, check_files, save_dataset, table
from nonsmooth.errors import OptionError, unknown_name

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["ensemble"]


def ensemble(
    model: Annotated[str, typer.Argument(metavar="MODEL", help=MODEL_HELP)],
    parameters: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME=VALUE...", help=PARAMETERS_HELP),
    ] = None,
    *,
    over: Annotated[
        list[str],
        typer.Option(
            metavar="NAME=A:B:N",
            help="State or parameter, first and last value, how many; may be given several times.",
        ),
    ],
    start: Annotated[
        str | None, typer.Option(metavar="x=0.1,v=0", help="Other states at the start.")
    ] = None,
    transient: Annotated[int, typer.Option(help="Periods to drop first.")] = 0,
    record: Annotated[int, typer.Option(help="Strobes to keep.")] = 100,
    phase: Annotated[float, typer.Option(help="Part of the period at which strobes are.")] = 0.0,
    mode: Annotated[str | None, typer.Option(help="Mode at the start.")] = None,
    threads: Annotated[int | None, typer.Option(help="Threads; all processors by default.")] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the result as netCDF: .nc.")
    ] = None,
    store: Annotated[Path | None, typer.Option(metavar="FOLDER", help=STORE_HELP)] = None,
) -> None:
    """Every combination of initial states and parameter values, by its strobes."""
    from nonsmooth.analysis.ensemble import ensemble as run

    check_files(None, save)
    if save is not None and store is not None:
        raise OptionError(f"--save: the result is in {store / 'result.nc'}; leave out --save")
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    initial, several = _lists(system, over)
    for name, value in constants(settings(names(start), "--start"), "--start").items():
        if name in initial:
            raise OptionError(f"--start: {name} is given by --over already")
        initial[name] = value
    result = run(
        system,
        initial,
        parameters=several,
        transient=transient,
        record=record,
        phase=phase,
        mode=mode,
        threads=threads,
        store=store,
    )
    from nonsmooth.system.columns import harmless

    typer.echo(harmless(_summary(result)))
    if save is not None:
        save_dataset(result, save)
    if store is not None:
        typer.echo(f"saved {store / 'result.nc'}")
    if result.attrs["status"] == "interrupted":
        raise typer.Exit(INTERRUPTED)
    if result.attrs["message"] != "completed":
        raise typer.Exit(ENDED_EARLY)


def _lists(system: System, over: list[str]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Initial states in every combination, and values of parameters."""
    import numpy as np

    states: dict[str, np.ndarray] = {}
    several: dict[str, np.ndarray] = {}
    for text in over:
        name, values = value_range(text)
        if name in states or name in several:
            raise OptionError(f"--over: {name!r} is given twice")
        if name not in system.states and name not in system.parameters:
            known = [*system.states, *system.parameters]
            raise OptionError(f"--over: {unknown_name('state or parameter', name, known)}")
        (states if name in system.states else several)[name] = values
    grids = np.meshgrid(*states.values(), indexing="ij") if states else []
    return dict(zip(states, (grid.ravel() for grid in grids), strict=True)), several


def _summary(result: xr.Dataset) -> str:
    """How many runs there are, and how they ended."""
    import numpy as np

    words, counts = np.unique(result["status"].values.astype(str), return_counts=True)
    told = ", ".join(f"{count} {word}" for word, count in zip(words, counts, strict=True))
    rows = [
        ("runs", f"{result.sizes['lane']}"),
        ("status", told),
        ("strobes", f"{result.sizes['point']} of each"),
        ("certified", certified_runs(result)),
    ]
    return table(result.attrs["system_name"], rows)
