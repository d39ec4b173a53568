"""``nonsmooth simulate``: run a system, print a summary, draw and save."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nonsmooth.cli.arguments import build_system, constants, names, settings, time_range
from nonsmooth.cli.console import MODEL_HELP, PARAMETERS_HELP
from nonsmooth.cli.output import check_files, exit_by_status, save_dataset
from nonsmooth.errors import OptionError, RunWarning, unknown_name

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["simulate"]

_PERIODS = 20.0  # as long as the chapter's time histories
_LENGTH = 50.0  # oscillations, without a period
_OSCILLATIONS = 5.0  # in a window of the clock, which is 32 radians of the fastest one
_WIDTH, _HEIGHT = 12.0, 7.5  # centimetres, between one column and two


def simulate(
    model: Annotated[str, typer.Argument(metavar="MODEL", help=MODEL_HELP)],
    parameters: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME=VALUE...", help=PARAMETERS_HELP),
    ] = None,
    *,
    periods: Annotated[
        float | None, typer.Option(help="Length of the run in periods; 20 by default.")
    ] = None,
    t_end: Annotated[
        float | None,
        typer.Option(help="Time at which the run ends; without a period some 50 oscillations."),
    ] = None,
    start: Annotated[
        str | None, typer.Option(metavar="p=0.1,y=0", help="States at the start.")
    ] = None,
    samples_per_period: Annotated[int, typer.Option(help="Samples per period.")] = 100,
    max_seconds: Annotated[
        float | None, typer.Option(help="End the run when it has taken so long.")
    ] = None,
    max_events: Annotated[
        int | None, typer.Option(help="End the run after so many events.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw a time history: .png or .pdf.")
    ] = None,
    portrait: Annotated[
        str | None,
        typer.Option(metavar="x,v", help="Draw the second over the first instead, in colours."),
    ] = None,
    modes: Annotated[
        bool, typer.Option("--modes", help="Colour the modes behind the time history.")
    ] = False,
    variables: Annotated[
        str | None, typer.Option(metavar="x,v", help="States and outputs to draw.")
    ] = None,
    orbit: Annotated[
        str | None, typer.Option(metavar="x,y", help="Draw the orbit of two coordinates.")
    ] = None,
    first_period: Annotated[
        float | None, typer.Option("--from", metavar="PERIOD", help="Draw from this period on.")
    ] = None,
    times: Annotated[
        str | None, typer.Option("--time-range", metavar="A,B", help="Draw between two times.")
    ] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the run as netCDF: .nc.")
    ] = None,
) -> None:
    """Simulate a ready-made system, or one of a file, and print a summary."""
    check_files(plot, save)
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    shown = _variables(system, variables)
    if portrait is not None and orbit is not None:
        raise OptionError("give one of --portrait and --orbit, not both")
    option = "--portrait" if orbit is None else "--orbit"
    pair = _pair(system, option, orbit or portrait, variables, modes)
    if plot is None and (pair is not None or modes):
        raise OptionError(
            f"{option} and --modes are drawn into a file: name it, such as --plot picture.png"
        )
    length: dict[str, Any] = {"periods": periods, "t_end": t_end}
    if periods is None and t_end is None:
        length = _default_length(system, samples_per_period)
    window = _window(system, first_period, times)
    _check_window(system, window, length)
    run = _run(
        system,
        constants(settings(names(start), "--start"), "--start"),
        samples_per_period=samples_per_period,
        max_seconds=max_seconds,
        max_events=max_events,
        **length,
    )
    from nonsmooth.cli.summary import summary
    from nonsmooth.system.columns import harmless

    typer.echo(harmless(summary(run)))
    if save is not None:
        save_dataset(run, save)
    if plot is not None:
        _plot(run, shown, window, plot, pair=pair, modes=modes, orbit=orbit is not None)
    exit_by_status(run.attrs["status"])


def _variables(system: System, text: str | None) -> list[str]:
    """Variables to draw; by default the motion, and what it drifts by."""
    known = [*system.states, *system.outputs]
    chosen = names(text)
    for name in chosen:
        if name not in known:
            raise OptionError(f"--variables: {unknown_name('variable', name, known)}")
    if chosen:
        return chosen
    drifting = list(system.drift_states)
    # states beside a drift are relative to it, and the motion itself is an output
    return [*list(system.outputs)[:1], *drifting] if drifting else list(system.states[:1])


def _pair(
    system: System, option: str, text: str | None, variables: str | None, modes: bool
) -> tuple[str, str] | None:
    """Two variables of a portrait, or coordinates of an orbit."""
    if text is None:
        return None
    if variables is not None or modes:
        raise OptionError(f"{option} draws no time history: leave out --variables and --modes")
    pair = names(text)
    if len(pair) != 2:
        raise OptionError(f"{option}: {text!r} is not two variables, such as x,v")
    known = [*system.states, *system.outputs]
    for name in pair:
        if name not in known:
            raise OptionError(f"{option}: {unknown_name('variable', name, known)}")
    return pair[0], pair[1]


def _default_length(system: System, samples_per_period: int) -> dict[str, Any]:
    """Length of a run where none is given; without a period, by the fastest oscillation."""
    if system.period is not None:
        return {"periods": _PERIODS}
    from nonsmooth.runs.runner import build_tables

    oscillation = build_tables(system).window / _OSCILLATIONS
    samples = math.ceil(_LENGTH * samples_per_period)
    return {"times": [k * oscillation * _LENGTH / samples for k in range(samples + 1)]}


def _window(
    system: System, first_period: float | None, times: str | None
) -> tuple[float, float] | None:
    """Times to draw, with infinity for the end of the run."""
    if first_period is not None and times is not None:
        raise OptionError("give one of --from and --time-range, not both")
    if times is not None:
        return time_range(times)
    if first_period is None:
        return None
    if system.period_value is None:
        raise OptionError(f"--from counts periods, and {system.name!r} has none; use --time-range")
    return first_period * system.period_value, math.inf


def _check_window(
    system: System, window: tuple[float, float] | None, length: dict[str, Any]
) -> None:
    """Refuse times to draw that a run of this length does not reach."""
    begin, end, periods = 0.0, length.get("t_end"), length.get("periods")
    if "times" in length:
        begin, end = length["times"][0], length["times"][-1]
    elif end is None and periods is not None and system.period_value is not None:
        end = periods * system.period_value
    if window is None or end is None:
        return
    if not max(window[0], begin) < window[1] or not window[0] < end:
        last = f"{window[1]:g}" if window[1] < math.inf else "the end"
        raise OptionError(
            f"the times to draw, {window[0]:g} to {last}, must run forward, end after the run"
            f" begins at t = {begin:g} and begin before the run ends at t = {end:g}"
        )


def _run(system: System, initial: dict[str, float], **options: Any) -> xr.Dataset:
    from nonsmooth.runs.simulate import simulate as run_system

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)  # the summary says the same
        return run_system(system, initial, **options)


def _plot(
    run: xr.Dataset,
    variables: list[str],
    window: tuple[float, float] | None,
    path: Path,
    *,
    pair: tuple[str, str] | None,
    modes: bool,
    orbit: bool,
) -> None:
    from nonsmooth import plot

    first, last = float(run["time"][0]), float(run["time"][-1])
    if window is not None:
        window = window[0], min(window[1], last)
        if run.attrs["status"] != "completed" and not first <= window[0] < window[1]:
            typer.echo("the run ended before the times to draw; all of it is drawn", err=True)
            window = None
    figure, (ax,) = plot.print_figure(width=_WIDTH, height=_HEIGHT)
    if pair is not None and orbit:
        plot.orbit(run, *pair, ax=ax, time_range=window)
    elif pair is not None:
        several = len(run["mode"].attrs["flag_meanings"].split()) > 1
        plot.phase_portrait(run, *pair, ax=ax, phases=several, surfaces=True, time_range=window)
    elif modes:
        plot.phases(run, variables, ax=ax, time_range=window)
    else:
        plot.time_history(run, variables, ax=ax, time_range=window)
    plot.save_figure(figure, path)
    typer.echo(f"drawn {path}")
