"""``nonsmooth attractors``: where motions from a region come to."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli import options
from nonsmooth.cli.arguments import build_system, names, settings
from nonsmooth.cli.attractor_table import exit_code, print_attractors
from nonsmooth.cli.output import check_files, save_dataset, table
from nonsmooth.cli.regions import build_map, completion_rules, range_region
from nonsmooth.errors import OptionError, unknown_name

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["attractors"]

_WIDTH, _HEIGHT = 12.0, 9.0  # centimetres


def attractors(
    model: options.Model,
    parameters: options.Parameters = None,
    *,
    over: Annotated[
        list[str],
        typer.Option(
            metavar="x=A:B", help="State with the range of its starts; for each such state."
        ),
    ],
    complete: options.Complete = None,
    samples: options.Samples = 1000,
    seed: options.Seed = 0,
    cells: options.SearchCells = 64,
    longest: options.Longest = 10_000,
    record: options.Record = 20_000,
    match: options.Match = 1e-6,
    section: options.SectionText = None,
    direction: options.Direction = None,
    side: options.Side = None,
    phase: options.Phase = None,
    period: options.Period = None,
    every: options.Every = 1,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the points: .png or .pdf.")
    ] = None,
    variables: Annotated[
        str | None, typer.Option(metavar="x,v", help="Draw the second state over the first.")
    ] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the result as netCDF: .nc.")
    ] = None,
) -> None:
    """Find the attractors of a region from random starts."""
    from nonsmooth.analysis.attractors import attractors as find

    check_files(plot, save)
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    pair = _pair(system, variables, plot)
    region = range_region(system, over)
    rules = completion_rules(complete or [])
    chosen = build_map(
        system, section=section, direction=direction, side=side, phase=phase, period=period,
        every=every,
    )  # fmt: skip
    result = find(
        chosen,
        region,
        completion=rules,
        samples=samples,
        seed=seed,
        cells=cells,
        longest=longest,
        record=record,
        match=match,
    )
    from nonsmooth.system.columns import harmless

    typer.echo(harmless(_summary(result)))
    print_attractors(result)
    if save is not None:
        save_dataset(result, save)
    if plot is not None:
        _plot(result, pair, plot)
    raise typer.Exit(exit_code(result))


def _pair(system: System, text: str | None, plot: Path | None) -> tuple[str, str] | None:
    """Two states to draw, or those that the picture chooses."""
    if text is None:
        return None
    if plot is None:
        raise OptionError("--variables are drawn into a file: name it, such as --plot picture.png")
    pair = names(text)
    if len(pair) != 2:
        raise OptionError(f"--variables: {text!r} is not two states, such as x,v")
    for name in pair:
        if name not in system.states:
            raise OptionError(f"--variables: {unknown_name('state', name, system.states)}")
    return pair[0], pair[1]


def _summary(result: xr.Dataset) -> str:
    attrs = result.attrs
    rows = [
        ("status", str(attrs["message"])),
        ("starts", f"{attrs['samples']} of {attrs['drawn_starts']} drawn, the others inadmissible"),
    ]
    if attrs["drawn_starts"] == attrs["samples"]:
        rows[-1] = ("starts", f"{attrs['samples']}")
    for key, label in (("unsettled_starts", "unsettled"), ("ended_starts", "ended early")):
        if attrs[key]:
            rows.append((label, f"{attrs[key]} starts"))
    rows.append(("attractors", f"{result.sizes['attractor']}"))
    return table(str(attrs["system_name"]), rows)


def _plot(result: xr.Dataset, pair: tuple[str, str] | None, path: Path) -> None:
    from nonsmooth.plot import attractors as draw
    from nonsmooth.plot import print_figure, save_figure

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    draw(result, *(pair or ()), ax=ax)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
