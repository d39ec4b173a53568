"""``nonsmooth regimes``: what motions settle to over two parameters."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli.arguments import build_system, constants, names, settings, value_range
from nonsmooth.cli.console import MODEL_HELP, PARAMETERS_HELP, STORE_HELP
from nonsmooth.cli.output import certified_runs, check_files, exit_by_status, save_dataset, table
from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

__all__ = ["regimes"]

_WIDTH, _HEIGHT = 12.0, 8.0  # centimetres, between one column and two


def regimes(
    model: Annotated[str, typer.Argument(metavar="MODEL", help=MODEL_HELP)],
    parameters: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME=VALUE...", help=PARAMETERS_HELP),
    ] = None,
    *,
    over: Annotated[
        list[str],
        typer.Option(
            metavar="NAME=A:B:N", help="Parameter, first and last value, how many; given twice."
        ),
    ],
    refine: Annotated[int, typer.Option(help="Halve cells at borders so often.")] = 0,
    fill: Annotated[
        str, typer.Option(help="Refined cells: labels, or motions so that no number is missing.")
    ] = "labels",
    start: Annotated[
        str | None, typer.Option(metavar="x=0.1,v=0", help="States at the start.")
    ] = None,
    follow: Annotated[
        str | None,
        typer.Option(metavar="up|down", help="Begin where the neighbour below or above settled."),
    ] = None,
    transient: Annotated[int, typer.Option(help="Periods to drop first, at least.")] = 200,
    record: Annotated[int, typer.Option(help="Periods in which strobes may repeat.")] = 100,
    evidence: Annotated[
        int, typer.Option(help="Periods for exponent and 0-1 test; below 200 a survey.")
    ] = 500,
    longest: Annotated[
        int | None, typer.Option(help="Largest transient; 16 times the first by default.")
    ] = None,
    confirm: Annotated[
        int, typer.Option(help="Periods for which a chaotic motion is run on, to see it stay so.")
    ] = 10_000,
    period: Annotated[
        str | None, typer.Option(help="Time between strobes, for systems without a period.")
    ] = None,
    threads: Annotated[int | None, typer.Option(help="Threads; all processors by default.")] = None,
    store: Annotated[Path | None, typer.Option(metavar="FOLDER", help=STORE_HELP)] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the map: .png or .pdf.")
    ] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the map as netCDF: .nc.")
    ] = None,
) -> None:
    """What motions settle to for many values of two parameters."""
    from nonsmooth.analysis.regime_map import regime_map
    from nonsmooth.system.columns import harmless

    check_files(plot, save)
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    result = regime_map(
        system,
        _grid(over),
        initial=constants(settings(names(start), "--start"), "--start"),
        refine=refine,
        fill=fill,
        start="restart" if follow is None else f"follow {follow}",
        transient=transient,
        record=record,
        evidence=evidence,
        longest=longest,
        confirm=confirm,
        period=period,
        threads=threads,
        store=store,
    )
    typer.echo(harmless(_summary(result)))
    if save is not None:
        save_dataset(result, save)
    if plot is not None:
        _plot(result, plot)
    exit_by_status(result.attrs["status"])


def _grid(over: list[str]) -> dict[str, np.ndarray]:
    """Both parameters with their values."""
    pairs = [value_range(text) for text in over]
    if len(pairs) != 2 or pairs[0][0] == pairs[1][0]:
        given = ", ".join(name for name, _ in pairs)
        raise OptionError(
            f"--over: {given} given; give it twice, for two different parameters, such as --over"
            " omega=0.5:1:40 --over zeta=0.01:0.1:20"
        )
    return dict(pairs)


def _summary(result: xr.Dataset) -> str:
    """How large the map is, and how many points have each label."""
    import numpy as np

    second, first = result["regime"].dims
    words = result["regime"].attrs["flag_meanings"].split()
    computed = int(result["computed"].sum())
    rows = [
        ("points", f"{result.sizes[first]} of {first} times {result.sizes[second]} of {second}"),
        ("computed", f"{computed} of {result['regime'].size}"),
    ]
    codes, counts = np.unique(result["regime"].values, return_counts=True)
    rows += [(words[code], f"{count}") for code, count in zip(codes, counts, strict=True)]
    rows.append(("certified", certified_runs(result)))
    return table(result.attrs["system_name"], rows)


def _plot(result: xr.Dataset, path: Path) -> None:
    from nonsmooth.plot import print_figure, regime_map, save_figure

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    regime_map(result, ax=ax)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
