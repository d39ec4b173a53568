"""``nonsmooth zero-one``: whether a motion looks chaotic by the 0-1 test."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli import options
from nonsmooth.cli.arguments import build_system, constants, names, settings
from nonsmooth.cli.output import check_files, save_dataset, table
from nonsmooth.cli.points import strobe_points
from nonsmooth.errors import OptionError, ResultWarning, RunError, unknown_name

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["zero_one"]

_WIDTH, _HEIGHT = 10.0, 9.0  # centimetres


def zero_one(
    model: options.Model,
    parameters: options.Parameters = None,
    *,
    variable: Annotated[
        str | None, typer.Option(metavar="x", help="State or output; the first state by default.")
    ] = None,
    transient: Annotated[int, typer.Option(help="Strobes to drop first.")] = 200,
    record: Annotated[int, typer.Option(help="Strobes to test.")] = 2000,
    period: options.Period = None,
    frequencies: Annotated[int, typer.Option(help="Random numbers c; K is the median.")] = 100,
    seed: Annotated[int, typer.Option(help="Of these numbers.")] = 0,
    start: options.Start = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the translation: .png or .pdf.")
    ] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the result as netCDF: .nc.")
    ] = None,
) -> None:
    """0-1 test for chaos: K near 1 is chaotic, near 0 regular."""
    from nonsmooth.analysis.zero_one_test import zero_one_test

    check_files(plot, save)
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    known = [*system.states, *system.outputs]
    tested = variable or system.states[0]
    if tested not in known:
        raise OptionError(f"--variable: {unknown_name('variable', tested, known)}")
    initial = constants(settings(names(start), "--start"), "--start")
    points = strobe_points(system, initial, transient=transient, record=record, period=period)
    if points.attrs["status"] != "completed":
        raise RunError(f"{system.name}: {points.attrs['message']}")
    with warnings.catch_warnings(record=True) as raised:
        warnings.simplefilter("always", ResultWarning)
        result = zero_one_test(points, tested, frequencies=frequencies, seed=seed)
    from nonsmooth.system.columns import harmless

    doubts = [str(one.message) for one in raised if issubclass(one.category, ResultWarning)]
    typer.echo(harmless(_summary(result, doubts)))
    if save is not None:
        save_dataset(result, save)
    if plot is not None:
        _plot(result, plot)


def _summary(result: xr.Dataset, doubts: list[str]) -> str:
    attrs = result.attrs
    rows = [
        ("variable", f"{attrs['variable']}, {attrs['n_points']} strobes"),
        ("K", f"{float(result['K']):.4g}"),
        ("nine of ten", f"{float(result['K_low']):.4g} to {float(result['K_high']):.4g}"),
        *(("doubt", text) for text in doubts),
    ]
    return table(str(attrs["system_name"]), rows)


def _plot(result: xr.Dataset, path: Path) -> None:
    from nonsmooth.plot import print_figure, save_figure, translation

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    translation(result, ax=ax)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
