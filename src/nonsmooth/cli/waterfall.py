"""``nonsmooth waterfall``: spectra over a parameter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli.arguments import build_system, constants, names, settings, value_range
from nonsmooth.cli.console import ENDED_EARLY, INTERRUPTED, STORE_HELP
from nonsmooth.cli.options import Model, Parameters, Start
from nonsmooth.cli.output import check_files, save_dataset, table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["waterfall"]

_WIDTH, _HEIGHT = 12.0, 9.0  # centimetres, between one column and two
_SHOWN = 8  # harmonics in the summary


def waterfall(
    model: Model,
    parameters: Parameters = None,
    *,
    over: Annotated[
        str,
        typer.Option(metavar="NAME=A:B:N", help="Parameter, first and last value, how many."),
    ],
    variable: Annotated[
        str | None,
        typer.Option(metavar="x[,y]", help="State or output; two for forward and backward whirl."),
    ] = None,
    begin: Annotated[
        str,
        typer.Option("--start", help="restart, follow up or follow down: where motions begin."),
    ] = "restart",
    initial: Start = None,
    transient: Annotated[int, typer.Option(help="Periods to drop first.")] = 200,
    record: Annotated[int, typer.Option(help="Periods of each record.")] = 60,
    samples: Annotated[int, typer.Option(help="Samples per period.")] = 64,
    window: Annotated[str, typer.Option(help="Such as hann; boxcar is none.")] = "hann",
    segments: Annotated[int, typer.Option(help="Parts whose power is averaged.")] = 1,
    threads: Annotated[int | None, typer.Option(help="Threads; all processors by default.")] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the spectra: .png or .pdf.")
    ] = None,
    kind: Annotated[str, typer.Option(help="Of the drawing: cascade or map.")] = "cascade",
    axis: Annotated[str, typer.Option(help="Of the drawing: frequency or harmonic.")] = "frequency",
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the result as netCDF: .nc.")
    ] = None,
    store: Annotated[Path | None, typer.Option(metavar="FOLDER", help=STORE_HELP)] = None,
) -> None:
    """Spectra of settled motions for many values of a parameter."""
    from nonsmooth.analysis.waterfall import waterfall as compute
    from nonsmooth.plot.cascades import check_drawing
    from nonsmooth.system.columns import harmless

    check_files(plot, save)
    check_drawing({"--kind": kind, "--axis": axis})
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    parameter, values = value_range(over)
    start = constants(settings(names(initial), "--initial"), "--initial")
    result = compute(
        system,
        parameter,
        values,
        names(variable) or system.states[0],
        initial=start or None,
        start=begin,
        transient=transient,
        record=record,
        samples_per_period=samples,
        window=window,
        segments=segments,
        threads=threads,
        store=store,
    )
    typer.echo(harmless(_summary(result)))
    if save is not None:
        save_dataset(result, save)
    if plot is not None:
        _plot(result, kind, axis, plot)
    if result.attrs["status"] == "interrupted":
        raise typer.Exit(INTERRUPTED)
    if result.attrs["message"] != "completed":
        raise typer.Exit(ENDED_EARLY)


def _summary(result: xr.Dataset) -> str:
    """The harmonics that are largest anywhere, and where that is."""
    import numpy as np

    attrs = result.attrs
    amplitude = result["amplitude"].where(result["harmonic"] != 0.0, 0.0).fillna(0.0)
    largest = amplitude.max("parameter").values
    place = result["parameter"].values[amplitude.argmax("parameter").values]
    neighbours = np.pad(largest, 1)
    peaks = np.flatnonzero((largest > neighbours[:-2]) & (largest >= neighbours[2:]))
    chosen = peaks[np.argsort(-largest[peaks], kind="stable")][:_SHOWN]
    of = ", ".join(name for name in (attrs["variable"], attrs["second_variable"]) if name)
    rows = [("spectra", f"{result.sizes['parameter']} over {attrs['parameter']}, of {of}")]
    rows += [
        (
            f"harmonic {float(result['harmonic'][k]):.6g}",
            f"amplitude up to {largest[k]:.6g}, at {attrs['parameter']} = {place[k]:.6g}",
        )
        for k in sorted(chosen)
    ]
    return table(str(attrs["system_name"]), rows)


def _plot(result: xr.Dataset, kind: str, axis: str, path: Path) -> None:
    from nonsmooth.plot import print_figure, save_figure
    from nonsmooth.plot import waterfall as draw

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    draw(result, ax=ax, kind=kind, over=axis)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
