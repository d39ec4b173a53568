"""``nonsmooth lyapunov``: Lyapunov exponents of a system."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nonsmooth.cli.arguments import build_system, constants, names, settings
from nonsmooth.cli.console import MODEL_HELP, PARAMETERS_HELP
from nonsmooth.cli.output import certified, check_files, exit_by_status, save_dataset, table
from nonsmooth.errors import RunWarning

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["lyapunov"]

_WIDTH, _HEIGHT = 12.0, 7.5  # centimetres


def lyapunov(
    model: Annotated[str, typer.Argument(metavar="MODEL", help=MODEL_HELP)],
    parameters: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME=VALUE...", help=PARAMETERS_HELP),
    ] = None,
    *,
    transient: Annotated[
        float, typer.Option(help="Dropped first: periods, or time without a period.")
    ] = 200.0,
    record: Annotated[
        float, typer.Option(help="Averaged over: periods, or time without a period.")
    ] = 1000.0,
    exponents: Annotated[
        int | None, typer.Option(help="How many, from the largest on; all by default.")
    ] = None,
    confirm: Annotated[
        int, typer.Option(help="Periods for which a chaotic motion is run on, to see it stay so.")
    ] = 10_000,
    start: Annotated[
        str | None, typer.Option(metavar="p=0.1,y=0", help="States at the start.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw how they settle: .png or .pdf.")
    ] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the result as netCDF: .nc.")
    ] = None,
) -> None:
    """Lyapunov exponents of a ready-made system, or of one in a file."""
    check_files(plot, save)
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    initial = constants(settings(names(start), "--start"), "--start")
    from nonsmooth.analysis.lyapunov_spectrum import lyapunov_spectrum
    from nonsmooth.system.columns import harmless

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)  # the summary says the same
        result = lyapunov_spectrum(
            system,
            initial,
            transient=transient,
            record=record,
            exponents=exponents,
            confirm=confirm,
        )
    typer.echo(harmless(_summary(result)))
    if save is not None:
        save_dataset(result, save)
    if plot is not None and result.sizes["time"]:
        _plot(result, plot)
    exit_by_status(result.attrs["status"])


def _summary(result: xr.Dataset) -> str:
    """Exponents with their errors, sum, dimension and what they were averaged over."""
    attrs = result.attrs
    rows = [("status", str(attrs["message"]))]
    pairs = zip(result["lyapunov_exponent"].values, result["standard_error"].values, strict=True)
    for number, (value, error) in enumerate(pairs, start=1):
        text = f"{value:.6g}" + (f" +- {error:.2g}" if error == error else "")
        rows.append((f"exponent {number}", text))
    for name, label in (("exponent_sum", "sum"), ("kaplan_yorke_dimension", "dimension")):
        value = float(result[name])
        if value == value:
            rows.append((label, f"{value:.9g}"))
    rows.append(("averaged over", _length(attrs)))
    rows.append(("certified", certified(attrs["n_uncertain"], attrs["n_estimated"])))
    if not attrs["blocks_independent"]:
        rows.append(("errors", "too small, blocks are correlated or few; take a longer --record"))
    return table(attrs["system_name"], rows)


def _length(attrs: dict[Any, Any]) -> str:
    """Length of the record in time, periods and events."""
    text = f"time {attrs['duration']:.7g}"
    if "period" in attrs:
        text += f", {attrs['duration'] / attrs['period']:.7g} periods"
    return f"{text}, {attrs['n_events']} events, {attrs['n_impacts']} impacts"


def _plot(result: xr.Dataset, path: Path) -> None:
    from nonsmooth.plot import exponents, print_figure, save_figure

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    exponents(result, ax=ax)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
