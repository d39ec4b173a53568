"""``nonsmooth continue``: a periodic orbit followed over a parameter."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli import options
from nonsmooth.cli.arguments import build_system, constants, names, settings
from nonsmooth.cli.console import ENDED_EARLY, print_table
from nonsmooth.cli.orbit import complex_text, exists, orbit_rows
from nonsmooth.cli.orbit_options import OrbitPeriod, OrbitTransient, Word, modes_of_word
from nonsmooth.cli.output import check_files, exit_by_status, save_dataset, table
from nonsmooth.errors import OptionError, unknown_name

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["continue_"]

_WIDTH, _HEIGHT = 12.0, 9.0  # centimetres
_MOST = 60  # special points that are printed


def continue_(
    model: options.Model,
    parameters: options.Parameters = None,
    *,
    over: Annotated[
        str, typer.Option(metavar="NAME=A:B", help="Parameter and where it may go, at most.")
    ],
    start: options.Start = None,
    period: OrbitPeriod = 1,
    word: Word = None,
    transient: OrbitTransient = None,
    mode: options.StartMode = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the branch: .png or .pdf.")
    ] = None,
    variable: Annotated[
        str | None,
        typer.Option(metavar="x", help="What to draw; a drift, or else the first state."),
    ] = None,
    diagram: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw over this, saved by: nonsmooth diagram --save."),
    ] = None,
    multipliers: Annotated[
        bool, typer.Option("--multipliers", help="Draw the paths of the multipliers instead.")
    ] = False,
    inadmissible: Annotated[
        bool,
        typer.Option("--inadmissible", help="Follow the word also where its orbit is no motion."),
    ] = False,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the branch as netCDF: .nc.")
    ] = None,
) -> None:
    """Follow a periodic orbit over a parameter, stable or not, through folds and grazing.

    It is found first at the value that the parameter has.
    """
    import nonsmooth as ns

    check_files(plot, save)
    _check_pictures(plot, variable, diagram, multipliers)
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    parameter, between = _range(system, over)
    drawn = _variable(system, variable)
    behind = _read_diagram(diagram, parameter, drawn)
    first = ns.find_orbit(
        system,
        constants(settings(names(start), "--start"), "--start") or None,
        period=period,
        word=modes_of_word(word),
        transient=transient,
        mode=mode,
    )
    from nonsmooth.system.columns import harmless

    if not exists(first):
        typer.echo(harmless(table(first.attrs["system_name"], list(orbit_rows(first)))))
        typer.echo("there is no orbit to start from; see: nonsmooth orbit --help", err=True)
        raise typer.Exit(ENDED_EARLY)
    branch = ns.continue_orbit(system, parameter, between, initial=first, inadmissible=inadmissible)
    typer.echo(harmless(table(branch.attrs["system_name"], list(_rows(branch)))))
    _print_special_points(branch)
    if save is not None:
        save_dataset(branch, save)
    if plot is not None:
        _plot(branch, plot, drawn, behind, multipliers)
    exit_by_status(branch.attrs["status"])


def _check_pictures(
    plot: Path | None, variable: str | None, diagram: Path | None, multipliers: bool
) -> None:
    if plot is None and (variable is not None or diagram is not None or multipliers):
        raise OptionError(
            "--variable, --diagram and --multipliers are drawn into a file: name it, such as"
            " --plot picture.png"
        )
    if multipliers and (variable is not None or diagram is not None):
        raise OptionError("--multipliers is a picture of its own: leave out the other two")


def _range(system: System, over: str) -> tuple[str, tuple[float, float]]:
    """Parameter and its ends; its own value lies between."""
    ((name, value),) = settings([over], "--over").items()
    parts = [part.strip() for part in value.split(":")]
    if len(parts) != 2 or not all(parts):
        raise OptionError(f"--over: {over!r} is not of the form name=low:high")
    if name not in system.parameters:
        raise OptionError(f"--over: {unknown_name('parameter', name, system.parameters)}")
    ends = constants(dict(zip(("low", "high"), parts, strict=True)), "--over")
    low, high = sorted(ends.values())
    value_here = system.parameters[name]
    if isinstance(value_here, int | float) and not low <= value_here <= high:
        raise OptionError(
            f"--over: the orbit is found at {name} = {value_here:g}, which is not between {low:g}"
            f" and {high:g}; give another value of {name}, or another range"
        )
    return name, (low, high)


def _variable(system: System, variable: str | None) -> str:
    """What to draw: by default how fast the system drifts, or its first state."""
    drifts = [f"{name}_per_{unit}" for name in system.drift_states for unit in ("time", "period")]
    if variable is None:
        return drifts[0] if drifts else system.states[0]
    known = [*system.states, *drifts, "length", "residual", "multipliers"]
    if variable not in known:
        raise OptionError(f"--variable: {unknown_name('variable', variable, known)}")
    return variable


def _read_diagram(path: Path | None, parameter: str, drawn: str) -> xr.Dataset | None:
    """The diagram to draw behind, which fits the branch that is followed only after this."""
    if path is None:
        return None
    import xarray as xr

    from nonsmooth.plot.branches import check_diagram

    if not path.is_file():
        raise OptionError(
            f"--diagram: there is no file {str(path)!r}; make it with nonsmooth diagram --save"
        )
    try:
        with xr.open_dataset(path, engine="h5netcdf") as data:
            found = data.load()
    except (OSError, ValueError) as error:
        raise OptionError(f"--diagram: {str(path)!r} is no netCDF file: {error!s:.120}") from None
    try:
        check_diagram(found, parameter, drawn)
    except OptionError as fault:
        raise OptionError(
            f"--diagram: {str(path)!r} does not go with {drawn} over {parameter}: {fault}; make"
            " another one with nonsmooth diagram --save"
        ) from None
    return found


def _rows(branch: xr.Dataset) -> Iterator[tuple[str, str]]:
    """How far the branch goes, why no further, and of what kind its orbits are."""
    import numpy as np

    attrs = branch.attrs
    yield "status", str(attrs["message"])
    values = branch[attrs["parameter"]].values
    yield "points", f"{values.size}"
    if not values.size:
        return
    yield str(attrs["parameter"]), f"{values.min():.10g} to {values.max():.10g}"
    for end, label, place in (("end_first", "first end", 0), ("end_last", "last end", -1)):
        yield label, f"{attrs[end]}, at {attrs['parameter']} = {values[place]:.10g}"
    stable, admissible = (branch[name].values.astype(bool) for name in ("stable", "admissible"))
    counts = {
        "stable": stable & admissible,
        "unstable": ~stable & admissible,
        "inadmissible": ~admissible,
    }
    parts = [f"{np.count_nonzero(here)} {name}" for name, here in counts.items() if here.any()]
    yield "orbits", ", ".join(parts)


def _print_special_points(branch: xr.Dataset) -> None:
    """One line for each special point, in order along the branch."""
    from nonsmooth.system.columns import harmless  # details name guards of files

    count = int(branch.sizes.get("special", 0))
    rows = []
    for k in range(min(count, _MOST)):
        one = branch.isel(special=k)
        multiplier = complex(one["special_multiplier"].item())
        rows.append(
            (
                str(one["special_kind"].item()).replace("_", " "),
                f"{float(one['special_value']):.12g}",
                complex_text(multiplier) if multiplier == multiplier else "",
                harmless(str(one["special_detail"].item())),
            )
        )
    if rows:
        print_table(("special point", str(branch.attrs["parameter"]), "multiplier", ""), rows)
    if count > _MOST:
        typer.echo(f"and {count - _MOST} more special points")


def _plot(
    branch: xr.Dataset, path: Path, variable: str, diagram: xr.Dataset | None, multipliers: bool
) -> None:
    from nonsmooth import plot

    if not branch.sizes["point"]:
        typer.echo("there is no branch to draw", err=True)
        return
    figure, (ax,) = plot.print_figure(width=_WIDTH, height=_HEIGHT)
    if multipliers:
        plot.multipliers(branch, ax=ax)
    else:
        plot.branch(branch, variable, diagram=diagram, ax=ax)
    plot.save_figure(figure, path)
    typer.echo(f"drawn {path}")
