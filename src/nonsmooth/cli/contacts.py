"""``nonsmooth contacts``: how often, how long and how hard, over a parameter or of one motion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli.arguments import build_system, constants, names, settings, value_range
from nonsmooth.cli.console import ENDED_EARLY, INTERRUPTED, STORE_HELP
from nonsmooth.cli.options import Model, Parameters, Start
from nonsmooth.cli.output import check_files, save_dataset, table
from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["contacts"]

_WIDTH, _HEIGHT = 12.0, 8.0  # centimetres, between one column and two


def contacts(
    model: Model,
    parameters: Parameters = None,
    *,
    over: Annotated[
        str | None,
        typer.Option(metavar="NAME=A:B:N", help="Parameter, first and last value, how many."),
    ] = None,
    contact: Annotated[
        str, typer.Option(metavar="MODE", help="Mode, or modes, that are contact.")
    ] = "contact",
    of: Annotated[
        str | None, typer.Option(metavar="force", help="States or outputs to tell statistics of.")
    ] = None,
    begin: Annotated[
        str,
        typer.Option("--start", help="restart, follow up or follow down: where motions begin."),
    ] = "restart",
    initial: Start = None,
    transient: Annotated[int, typer.Option(help="Periods to drop first.")] = 200,
    record: Annotated[int, typer.Option(help="Periods to look at.")] = 100,
    threads: Annotated[int | None, typer.Option(help="Threads; all processors by default.")] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw over the parameter: .png or .pdf.")
    ] = None,
    variable: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="What to draw; --of, or the contacts, by default."),
    ] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the result as netCDF: .nc.")
    ] = None,
    store: Annotated[Path | None, typer.Option(metavar="FOLDER", help=STORE_HELP)] = None,
) -> None:
    """Contacts of settled motions: counts, durations, statistics of a force."""
    from nonsmooth.analysis.contact_statistics import contact_statistics
    from nonsmooth.system.columns import harmless

    check_files(plot, save)
    if plot is None and variable is not None:
        raise OptionError("--variable is drawn into a file: name it, such as --plot picture.png")
    if plot is not None and over is None:
        raise OptionError(
            "--plot draws over a parameter: give its range, such as --over eta=2:3:40"
        )
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    parameter, values = value_range(over) if over is not None else (None, None)
    start = constants(settings(names(initial), "--initial"), "--initial")
    result = contact_statistics(
        system,
        parameter,
        values,
        contact=names(contact),
        of=names(of),
        initial=start or None,
        start=begin,
        transient=transient,
        record=record,
        threads=threads,
        store=store,
    )
    typer.echo(harmless(_summary(result)))
    if save is not None:
        save_dataset(result, save)
    if plot is not None:
        _plot(result, variable or next(iter(names(of)), "contacts"), plot)
    if result.attrs["status"] == "interrupted":
        raise typer.Exit(INTERRUPTED)
    if result.attrs["message"] != "completed":
        raise typer.Exit(ENDED_EARLY)


def _summary(result: xr.Dataset) -> str:
    """Every number, or its range over the parameter."""
    import numpy as np

    rows = []
    for name, values in result.data_vars.items():
        if values.dtype.kind != "f" or "percentile" in values.dims:
            continue
        finite = values.values[np.isfinite(values.values)]
        if finite.size == 0:
            text = "none"
        elif values.ndim == 0:
            text = f"{float(values):.6g}"
        else:
            text = f"{finite.min():.6g} to {finite.max():.6g}"
        rows.append((str(name), text))
    return table(str(result.attrs["system_name"]), rows)


def _plot(result: xr.Dataset, variable: str, path: Path) -> None:
    from nonsmooth.plot import print_figure, save_figure, statistics

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    statistics(result, variable, ax=ax)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
