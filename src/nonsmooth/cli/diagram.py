"""``nonsmooth diagram``: settled motions over a parameter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli.arguments import build_system, constants, names, settings, value_range
from nonsmooth.cli.console import (
    ENDED_EARLY,
    INTERRUPTED,
    MODEL_HELP,
    PARAMETERS_HELP,
    STORE_HELP,
)
from nonsmooth.cli.output import certified_runs, check_files, save_dataset
from nonsmooth.errors import OptionError, unknown_name

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.runs.poincare_map import PoincareMap
    from nonsmooth.system.system import System

__all__ = ["diagram"]

_WIDTH, _HEIGHT = 12.0, 8.0  # centimetres, between one column and two


def diagram(
    model: Annotated[str, typer.Argument(metavar="MODEL", help=MODEL_HELP)],
    parameters: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME=VALUE...", help=PARAMETERS_HELP),
    ] = None,
    *,
    over: Annotated[
        str,
        typer.Option(metavar="NAME=A:B:N", help="Parameter, first and last value, how many."),
    ],
    start: Annotated[
        str, typer.Option(help="restart, follow up or follow down: where each column begins.")
    ] = "restart",
    initial: Annotated[
        list[str] | None,
        typer.Option(metavar="x=0.1,v=0", help="States at the start; may be given several times."),
    ] = None,
    transient: Annotated[int, typer.Option(help="Periods to drop first.")] = 200,
    record: Annotated[int, typer.Option(help="Periods to look at.")] = 100,
    at: Annotated[
        str, typer.Option(help="strobe, or the name of an event at which states are taken.")
    ] = "strobe",
    section: Annotated[
        str | None,
        typer.Option(
            metavar="EXPRESSION", help="Points where it vanishes, or at this event, not strobes."
        ),
    ] = None,
    direction: Annotated[
        int | None, typer.Option(help="Of the section: 1 where it grows, -1 falls, 0 both.")
    ] = None,
    side: Annotated[str, typer.Option(help="States just before or just after events.")] = "before",
    threads: Annotated[int | None, typer.Option(help="Threads; all processors by default.")] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the diagram: .png or .pdf.")
    ] = None,
    variable: Annotated[
        str | None, typer.Option(metavar="x", help="What to draw; the first state by default.")
    ] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the diagram as netCDF: .nc.")
    ] = None,
    store: Annotated[Path | None, typer.Option(metavar="FOLDER", help=STORE_HELP)] = None,
) -> None:
    """Settled motions for many values of a parameter, by brute force."""
    from nonsmooth.analysis.bifurcation_diagram import bifurcation_diagram

    check_files(plot, save)
    if plot is None and variable is not None:
        raise OptionError("--variable is drawn into a file: name it, such as --plot picture.png")
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    parameter, values = value_range(over)
    drawn = _variable(system, variable)
    starts = [constants(settings(names(text), "--initial"), "--initial") for text in initial or []]
    target = _target(system, section, direction, side)
    result = bifurcation_diagram(
        target,
        parameter,
        values,
        initial=starts or None,
        start=start,
        transient=transient,
        record=record,
        at=at,
        side=side if target is system else "before",
        threads=threads,
        store=store,
    )
    from nonsmooth.system.columns import harmless

    typer.echo(harmless(_summary(result)))
    if save is not None:
        save_dataset(result, save)
    if plot is not None:
        _plot(result, drawn, plot)
    if result.attrs["status"] == "interrupted":
        raise typer.Exit(INTERRUPTED)
    if not result.attrs["message"].startswith("completed"):
        raise typer.Exit(ENDED_EARLY)


def _target(
    system: System, section: str | None, direction: int | None, side: str
) -> System | PoincareMap:
    """The system, or its map from one point of a section to the next."""
    from nonsmooth.runs.poincare_map import PoincareMap

    if section is not None:
        return PoincareMap(system, section, direction=direction, side=side)
    if direction is not None:
        raise OptionError("--direction is that of a section: name it with --section")
    return system


def _variable(system: System, variable: str | None) -> str:
    if variable is None:
        return system.states[0]
    once = ("period", "events", "impacts")
    drifts = [f"{name}_per_{unit}" for name in system.drift_states for unit in ("period", "time")]
    known = [*system.states, *system.outputs, *once, *drifts]
    if variable not in known:
        raise OptionError(f"--variable: {unknown_name('variable', variable, known)}")
    return variable


def _summary(result: xr.Dataset) -> str:
    """How many columns there are, and of which period."""
    import numpy as np

    status, period = result["status"].values.ravel(), result["period"].values.ravel()
    counts = {word: int(np.count_nonzero(status == word)) for word in sorted(set(status))}
    lines = [
        f"{result.attrs['system_name']}: {result.sizes['parameter']} values of"
        f" {result.attrs['parameter']}, {result.sizes['lane']} initial state(s)",
        "status   " + ", ".join(f"{count} {word}" for word, count in counts.items()),
    ]
    settled = period[status == "completed"]
    found = sorted(set(settled[settled > 0]))
    texts = [f"{int(np.count_nonzero(settled == p))} of period {p}" for p in found[:8]]
    others = settled.size - sum(int(np.count_nonzero(settled == p)) for p in found[:8])
    if others:
        texts.append(f"{others} of longer period or none")
    lines.append("motions  " + ", ".join(texts or ["none settled"]))
    lines.append(f"certified  {certified_runs(result)}")
    _, _, doubt = result.attrs["message"].partition("; ")
    return "\n".join([*lines, f"message  {doubt}"] if others and doubt else lines)


def _plot(result: xr.Dataset, variable: str, path: Path) -> None:
    from nonsmooth.plot import bifurcation, print_figure, save_figure

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    bifurcation(result, variable, ax=ax)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
