"""``nonsmooth regime``: what one motion settles to."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli.arguments import build_system, constants, names, settings
from nonsmooth.cli.console import MODEL_HELP, PARAMETERS_HELP
from nonsmooth.cli.output import certified, check_files, save_dataset, table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["regime"]


def regime(
    model: Annotated[str, typer.Argument(metavar="MODEL", help=MODEL_HELP)],
    parameters: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME=VALUE...", help=PARAMETERS_HELP),
    ] = None,
    *,
    start: Annotated[
        str | None, typer.Option(metavar="x=0.1,v=0", help="States at the start.")
    ] = None,
    transient: Annotated[int, typer.Option(help="Periods to drop first, at least.")] = 200,
    record: Annotated[int, typer.Option(help="Periods in which strobes may repeat.")] = 100,
    evidence: Annotated[int, typer.Option(help="Periods for exponent and 0-1 test.")] = 500,
    longest: Annotated[
        int | None, typer.Option(help="Largest transient; 16 times the first by default.")
    ] = None,
    confirm: Annotated[
        int, typer.Option(help="Periods for which a chaotic motion is run on, to see it stay so.")
    ] = 10_000,
    period: Annotated[
        str | None, typer.Option(help="Time between strobes, for systems without a period.")
    ] = None,
    mode: Annotated[str | None, typer.Option(help="Mode to start in.")] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the result as netCDF: .nc.")
    ] = None,
) -> None:
    """What a motion settles to, and the evidence for it."""
    from nonsmooth.analysis.regime import regime as judge
    from nonsmooth.system.columns import harmless

    check_files(None, save)
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    found = judge(
        system,
        constants(settings(names(start), "--start"), "--start"),
        transient=transient,
        record=record,
        evidence=evidence,
        longest=longest,
        confirm=confirm,
        period=period,
        mode=mode,
    )
    typer.echo(harmless(table(found.attrs["system_name"], list(_rows(found)))))
    if save is not None:
        save_dataset(found, save)


def _rows(found: xr.Dataset) -> Iterator[tuple[str, str]]:
    """The label and what is known beside it."""
    yield "regime", str(found.attrs["message"])
    period = found["period"].item()
    if period:
        yield "period", f"{period} of {found.attrs['strobe_period']:.7g}"
        yield "word", found["word"].item()
    for name in ("events", "impacts"):
        if found[name].item() == found[name].item():
            yield name, f"{found[name].item():.6g} per period"
    for variable in map(str, found.data_vars):
        if variable.endswith("_per_period"):
            drift = variable.removesuffix("_per_period")
            yield f"drift of {drift}", f"{found[variable].item():.7g} per period"
    moduli = [value for value in found["multiplier_modulus"].values if value == value]
    if moduli:
        yield "multipliers", ", ".join(f"{value:.6g}" for value in moduli)
    exponent, error = found["exponent"].item(), found["exponent_error"].item()
    if exponent == exponent:
        yield "exponent", f"{exponent:.6g}" + (f" +- {error:.2g}" if error == error else "")
    yield "certified", certified(found["n_uncertain"].item(), found["n_estimated"].item())
    yield "transient", f"{found['transient_used'].item()} periods"
