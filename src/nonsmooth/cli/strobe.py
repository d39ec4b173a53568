"""``nonsmooth strobe``: points of a motion, one per period."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli import options
from nonsmooth.cli.arguments import build_system, constants, names, settings
from nonsmooth.cli.output import certified, check_files, exit_by_status, save_dataset, table
from nonsmooth.cli.points import pair_of_variables, strobe_points
from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["strobe"]

_WIDTH, _HEIGHT = 10.0, 8.0  # centimetres
_MATCH = 1e-6  # of the largest size of each state, as in diagrams


def strobe(
    model: options.Model,
    parameters: options.Parameters = None,
    *,
    transient: Annotated[int, typer.Option(help="Strobes to drop first.")] = 200,
    record: Annotated[int, typer.Option(help="Strobes to keep.")] = 1000,
    phase: options.Phase = None,
    period: options.Period = None,
    start: options.Start = None,
    mode: options.StartMode = None,
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
    """Points of a motion, one per period of the forcing."""
    check_files(plot, save)
    if plot is None and (variables is not None or modes):
        raise OptionError(
            "--variables and --modes are drawn into a file: name it, such as --plot picture.png"
        )
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    pair = pair_of_variables(system, variables)
    points = strobe_points(
        system,
        constants(settings(names(start), "--start"), "--start"),
        transient=transient,
        record=record,
        phase=phase or 0.0,
        period=period,
        mode=mode,
    )
    from nonsmooth.system.columns import harmless

    typer.echo(harmless(table(points.attrs["system_name"], list(_rows(system, points)))))
    if save is not None:
        save_dataset(points, save)
    if plot is not None:
        _plot(points, pair, plot, modes)
    exit_by_status(points.attrs["status"])


def _rows(system: System, points: xr.Dataset) -> Iterator[tuple[str, str]]:
    attrs, count = points.attrs, points.sizes["point"]
    yield "status", attrs["message"]
    yield "points", f"{count} of {attrs['record']}"
    yield "certified", certified(attrs["n_uncertain"], attrs["n_estimated"])
    if not count:
        return
    time = points["time"].values
    yield "time", f"{time[0]:.7g} to {time[-1]:.7g}"
    yield "repeats", _repeats(system, points)
    values = ", ".join(f"{name} = {float(points[name][-1]):.7g}" for name in system.states)
    yield "last point", values


def _repeats(system: System, points: xr.Dataset) -> str:
    """After how many points the motion repeats, drifts apart."""
    import numpy as np

    from nonsmooth.analysis.statistics.periodicity import primitive_period, scales

    states = np.column_stack([points[name].values for name in system.states])
    drifting = np.array([name in system.drift_states for name in system.states])
    period = primitive_period(states, drifting, scales(states, drifting), _MATCH)
    return f"after {period} points" if period else "not within these points"


def _plot(points: xr.Dataset, pair: tuple[str, str], path: Path, modes: bool) -> None:
    from nonsmooth.plot import print_figure, save_figure
    from nonsmooth.plot.sections import section as draw

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    draw(points, *pair, ax=ax, phases=modes)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
