"""``nonsmooth basins``: which starts lead to which attractor."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli import options
from nonsmooth.cli.arguments import build_system, settings
from nonsmooth.cli.attractor_table import exit_code, print_attractors
from nonsmooth.cli.console import STORE_HELP
from nonsmooth.cli.output import check_files, save_dataset, table
from nonsmooth.cli.regions import build_map, completion_rules, grid_region
from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["basins"]

_WIDTH, _HEIGHT = 12.0, 10.0  # centimetres


def basins(
    model: options.Model,
    parameters: options.Parameters = None,
    *,
    over: Annotated[
        list[str],
        typer.Option(
            metavar="x=A:B:N",
            help="State, first and last value, how many; for two states or more.",
        ),
    ],
    complete: options.Complete = None,
    method: Annotated[
        str,
        typer.Option(
            help="recurrences: follow each start; 'cell mapping' or 'generalised cell mapping'."
        ),
    ] = "recurrences",
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
    threads: Annotated[int | None, typer.Option(help="Threads; all processors by default.")] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the basins: .png or .pdf.")
    ] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the result as netCDF: .nc.")
    ] = None,
    store: Annotated[Path | None, typer.Option(metavar="FOLDER", help=STORE_HELP)] = None,
) -> None:
    """Basins of attraction on a grid of starts."""
    from nonsmooth.analysis.basins_of_attraction import basins_of_attraction

    check_files(plot, save)
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    region = grid_region(system, over)
    if plot is not None and len(region) != 2:
        raise OptionError(f"--plot draws basins over two states, and --over has {len(region)}")
    rules = completion_rules(complete or [])
    chosen = build_map(
        system, section=section, direction=direction, side=side, phase=phase, period=period,
        every=every,
    )  # fmt: skip
    result = basins_of_attraction(
        chosen,
        region,
        method=method.replace("-", " "),
        completion=rules,
        samples=samples,
        seed=seed,
        cells=cells,
        longest=longest,
        record=record,
        match=match,
        threads=threads,
        store=store,
    )
    from nonsmooth.system.columns import harmless

    typer.echo(harmless(_summary(result)))
    print_attractors(result)
    if save is not None:
        save_dataset(result, save)
    if plot is not None:
        _plot(result, plot)
    raise typer.Exit(exit_code(result))


def _summary(result: xr.Dataset) -> str:
    attrs, shape = result.attrs, result["label"].shape
    rows = [
        ("status", str(attrs["message"])),
        ("cells", f"{result['label'].size} ({' x '.join(str(n) for n in reversed(shape))})"),
    ]
    kinds = ("unsettled", "ended early", "inadmissible", "not computed")
    keys = ("unsettled_cells", "ended_cells", "inadmissible_cells", "cells_left_out")
    rows += [
        (kind, f"{attrs[key]} cells") for kind, key in zip(kinds, keys, strict=True) if attrs[key]
    ]
    rows.append(("attractors", f"{result.sizes['attractor']}"))
    return table(str(attrs["system_name"]), rows)


def _plot(result: xr.Dataset, path: Path) -> None:
    from nonsmooth.plot import basins as draw
    from nonsmooth.plot import print_figure, save_figure

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    draw(result, ax=ax)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
