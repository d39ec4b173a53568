"""``nonsmooth measures``: what saved basins say about the predictability of outcomes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli.arguments import names
from nonsmooth.cli.attractor_table import with_error
from nonsmooth.cli.console import print_table
from nonsmooth.cli.output import check_files, table
from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["measures"]

_WIDTH, _HEIGHT = 10.0, 8.0  # centimetres
_FEWEST_FOR_WADA = 3


def measures(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE.nc", help="Saved by: nonsmooth basins --save basins.nc."),
    ],
    *,
    box: Annotated[int, typer.Option(help="Cells along a side of a box of the entropy.")] = 5,
    between: Annotated[
        str | None, typer.Option(metavar="1,2", help="Exponent of this boundary alone.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the uncertain part: .png or .pdf.")
    ] = None,
) -> None:
    """Fractions, uncertainty exponent and entropy of saved basins."""
    from nonsmooth.analysis.basin_fractions import basin_fractions
    from nonsmooth.analysis.uncertainty_exponent import uncertainty_exponent
    from nonsmooth.system.columns import harmless

    check_files(plot, None)
    pair = _pair(between)
    basins = _basins(file)
    fractions = basin_fractions(basins)
    exponent = uncertainty_exponent(basins, between=pair)
    rows = [*_exponent_rows(exponent), *_entropy_rows(basins, box), *_wada_rows(basins, fractions)]
    typer.echo(harmless(table(str(basins.attrs.get("system_name", file)), rows)))
    print_table(("outcome", "share", "starts"), [
        (
            str(one["outcome"].item()),
            with_error(float(one["fraction"]), float(one["fraction_error"])),
            str(int(one["starts"])),
        )
        for one in (fractions.isel(label=i) for i in range(fractions.sizes["label"]))
    ])  # fmt: skip
    if plot is not None:
        _plot(exponent, plot)


def _pair(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    parts = names(text)
    try:
        first, second = (int(part) for part in parts)
    except ValueError:
        raise OptionError(f"--between: {text!r} is not two labels, such as 1,2") from None
    return first, second


def _basins(file: Path) -> xr.Dataset:
    import xarray as xr

    if not file.is_file():
        raise OptionError(f"{file} is no file; nonsmooth basins --save {file} would write it")
    try:
        basins = xr.load_dataset(file, engine="h5netcdf")
    except (OSError, ValueError, KeyError) as fault:
        reason = str(fault).splitlines()[0] if str(fault) else type(fault).__name__
        raise OptionError(f"{file} cannot be read as netCDF: {reason}") from None
    if "label" not in basins:
        raise OptionError(
            f"{file} holds no basins; give a file that nonsmooth basins --save has written"
        )
    return basins


def _exponent_rows(found: xr.Dataset) -> Iterator[tuple[str, str]]:
    value, error = float(found["uncertainty_exponent"]), float(found["standard_error"])
    yield "uncertainty exponent", with_error(value, error)
    yield "boundary dimension", with_error(float(found["boundary_dimension"]), error)
    if found.attrs["message"]:
        yield "", str(found.attrs["message"])


def _entropy_rows(basins: xr.Dataset, box: int) -> Iterator[tuple[str, str]]:
    from nonsmooth.analysis.basin_entropy import basin_entropy

    found = basin_entropy(basins, box=box)
    for name in ("basin_entropy", "boundary_basin_entropy"):
        text = with_error(float(found[name]), float(found[f"{name}_error"]))
        yield name.replace("_", " "), text
    if bool(found["fractal"]):
        yield "", "the boundary is fractal: its entropy is above log 2"


def _wada_rows(basins: xr.Dataset, fractions: xr.Dataset) -> Iterator[tuple[str, str]]:
    from nonsmooth.analysis.wada_test import wada_test

    counted = (fractions["starts"].values > 0) & (fractions["label"].values != 0)
    if int(counted.sum()) >= _FEWEST_FOR_WADA:
        found = wada_test(basins)
        told = "yes" if bool(found["wada"]) else "no"
        cells = float(found["largest_distance"])
        yield "Wada property", f"{told}, boundaries are up to {cells:g} cells apart"


def _plot(found: xr.Dataset, path: Path) -> None:
    from nonsmooth.plot import print_figure, save_figure, uncertainty

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    uncertainty(found, ax=ax)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
