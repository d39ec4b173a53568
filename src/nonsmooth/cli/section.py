"""``nonsmooth section``: points of a trajectory on a section, or at events."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nonsmooth.cli.arguments import build_system, constants, names, settings
from nonsmooth.cli.console import MODEL_HELP, PARAMETERS_HELP
from nonsmooth.cli.output import certified, check_files, exit_by_status, save_dataset, table
from nonsmooth.errors import OptionError, RunWarning, unknown_name

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["section"]

_WIDTH, _HEIGHT = 10.0, 8.0  # centimetres


def section(
    model: Annotated[str, typer.Argument(metavar="MODEL", help=MODEL_HELP)],
    parameters: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME=VALUE...", help=PARAMETERS_HELP),
    ] = None,
    *,
    at: Annotated[
        str,
        typer.Option(
            "--section", metavar="x-0.5", help="Expression that vanishes, or name of an event."
        ),
    ],
    direction: Annotated[
        int | None, typer.Option(help="1 where it grows (default), -1 where it falls, 0 both.")
    ] = None,
    side: Annotated[str, typer.Option(help="States just before or just after.")] = "before",
    transient: Annotated[
        float, typer.Option(help="To drop first: periods, or time units without a period.")
    ] = 0.0,
    record: Annotated[int, typer.Option(help="Number of points.")] = 1000,
    t_end: Annotated[float | None, typer.Option(help="Time at which the search ends.")] = None,
    start: Annotated[
        str | None, typer.Option(metavar="x=0.1,v=0", help="States at the start.")
    ] = None,
    mode: Annotated[str | None, typer.Option(help="Mode to start in.")] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the points: .png or .pdf.")
    ] = None,
    variables: Annotated[
        str | None, typer.Option(metavar="x,v", help="Draw the second over the first.")
    ] = None,
    modes: Annotated[bool, typer.Option("--modes", help="Colour the points by mode.")] = False,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the points as netCDF: .nc.")
    ] = None,
) -> None:
    """Points of a trajectory where an expression vanishes, or at an event."""
    check_files(plot, save)
    if plot is None and (variables is not None or modes):
        raise OptionError(
            "--variables and --modes are drawn into a file: name it, such as --plot picture.png"
        )
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    pair = _pair(system, variables)
    points = _points(
        system,
        constants(settings(names(start), "--start"), "--start"),
        section=at,
        direction=direction,
        side=side,
        transient=transient,
        record=record,
        t_end=t_end,
        mode=mode,
    )
    from nonsmooth.system.columns import harmless

    typer.echo(harmless(_summary(points)))
    if save is not None:
        save_dataset(points, save)
    if plot is not None:
        _plot(points, pair, plot, modes)
    exit_by_status(points.attrs["status"])


def _pair(system: System, text: str | None) -> tuple[str, str]:
    """Two variables to draw; by default the first two states, or the state in time."""
    if text is None:
        return (system.states[0], system.states[1]) if len(system.states) > 1 else (
            "time", system.states[0],
        )  # fmt: skip
    pair = names(text)
    if len(pair) != 2:
        raise OptionError(f"--variables: {text!r} is not two variables, such as x,v")
    known = [*system.states, *system.outputs, "time"]
    if system.period_value is not None:
        known += ["phase", "period_number"]
    for name in pair:
        if name not in known:
            raise OptionError(f"--variables: {unknown_name('variable', name, known)}")
    return pair[0], pair[1]


def _points(system: System, initial: dict[str, float], **options: Any) -> xr.Dataset:
    from nonsmooth.analysis.poincare_section import poincare_section

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)  # the summary says the same
        return poincare_section(system, initial, **options)


def _summary(points: xr.Dataset) -> str:
    return table(points.attrs["system_name"], list(_rows(points)))


def _rows(points: xr.Dataset) -> Iterator[tuple[str, str]]:
    attrs = points.attrs
    yield "status", attrs["message"]
    yield "points", f"{attrs['n_points']} of {attrs['record']}"
    yield "certified", certified(attrs["n_uncertain"], attrs["n_estimated"])
    if not attrs["n_points"]:
        return
    time = points["time"].values
    yield "time", f"{time[0]:.7g} to {time[-1]:.7g}"
    for k, label in ((0, "first point"), (-1, "last point")):
        states = [str(name) for name in points.data_vars if points[name].dtype.kind == "f"]
        values = ", ".join(f"{name} = {float(points[name][k]):.7g}" for name in states)
        yield label, values


def _plot(points: xr.Dataset, pair: tuple[str, str], path: Path, modes: bool) -> None:
    from nonsmooth.plot import print_figure, save_figure
    from nonsmooth.plot.sections import section as draw

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    draw(points, *pair, ax=ax, phases=modes)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
