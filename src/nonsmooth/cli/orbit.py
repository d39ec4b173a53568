"""``nonsmooth orbit``: one periodic orbit, stable or not."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli import options
from nonsmooth.cli.arguments import build_system, constants, names, settings
from nonsmooth.cli.console import print_table
from nonsmooth.cli.orbit_options import OrbitPeriod, OrbitTransient, Word, modes_of_word
from nonsmooth.cli.output import check_files, exit_by_status, save_dataset, table
from nonsmooth.cli.points import pair_of_variables
from nonsmooth.errors import OptionError, unknown_name

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["orbit"]

_WIDTH, _HEIGHT = 10.0, 8.0  # centimetres
_MOST_LEGS = 40  # that are printed
_MOST_MODES = 12  # of a word


def orbit(
    model: options.Model,
    parameters: options.Parameters = None,
    *,
    start: options.Start = None,
    period: OrbitPeriod = 1,
    word: Word = None,
    transient: OrbitTransient = None,
    mode: options.StartMode = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the orbit: .png or .pdf.")
    ] = None,
    variables: Annotated[
        str | None,
        typer.Option(metavar="x,v", help="Draw the second over the first; the first two states."),
    ] = None,
    history: Annotated[
        str | None, typer.Option(metavar="x,v", help="Draw these over time instead.")
    ] = None,
    multipliers: Annotated[
        bool, typer.Option("--multipliers", help="Draw the multipliers instead.")
    ] = False,
    less_drift: Annotated[
        bool, typer.Option("--less-drift", help="Draw what drifts less its mean motion.")
    ] = False,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the result as netCDF: .nc.")
    ] = None,
) -> None:
    """Find a periodic orbit near a start, with its stability; it may be unstable."""
    import nonsmooth as ns

    check_files(plot, save)
    _check_pictures(plot, [variables, history, multipliers or None, less_drift or None])
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    pair = pair_of_variables(system, variables)
    shown = _history(system, history)
    found = ns.find_orbit(
        system,
        constants(settings(names(start), "--start"), "--start") or None,
        period=period,
        word=modes_of_word(word),
        transient=transient,
        mode=mode,
    )
    from nonsmooth.system.columns import harmless

    typer.echo(harmless(table(found.attrs["system_name"], list(orbit_rows(found)))))
    _print_legs(found)
    if save is not None:
        save_dataset(found, save)
    if plot is not None:
        _plot(found, plot, pair, shown, multipliers=multipliers, drift=not less_drift)
    exit_by_status(found.attrs["status"])


def _check_pictures(plot: Path | None, chosen: list[str | bool | None]) -> None:
    if plot is None and any(option is not None for option in chosen):
        raise OptionError(
            "--variables, --history, --multipliers and --less-drift are drawn into a file: name it,"
            " such as --plot picture.png"
        )
    if sum(option is not None for option in chosen[:3]) > 1:
        raise OptionError("give one of --variables, --history and --multipliers: it is one picture")


def _history(system: System, text: str | None) -> list[str]:
    known = [*system.states, *system.outputs]
    for name in names(text):
        if name not in known:
            raise OptionError(f"--history: {unknown_name('variable', name, known)}")
    return names(text)


def orbit_rows(found: xr.Dataset) -> Iterator[tuple[str, str]]:
    """What is known of an orbit; of none only why."""
    attrs = found.attrs
    yield "status", str(attrs["message"])
    if not exists(found):
        return
    yield "word", word_text(str(found["word"].item()))
    length = f"{found['length'].item():.9g}"
    yield "length", f"{length}, period {attrs['period']}" if "period" in attrs else length
    states = (f"{name} = {found[name].item():.10g}" for name in found["state"].values)
    yield "section point", ", ".join(states)
    yield "at time", f"{found['time'].item():.7g}"
    for name in found["drift_state"].values if "drift_state" in found else ():
        per = (
            f"{found[f'{name}_per_{unit}'].item():.9g} per {unit}" for unit in ("period", "time")
        )
        yield f"drift of {name}", ", ".join(per)
    if found["multipliers"].size:
        yield "multipliers", ", ".join(complex_text(mu) for mu in found["multipliers"].values)
    yield "stable", "yes" if found["stable"].item() else "no"
    if "symmetric" in found:
        yield "symmetric", "yes" if found["symmetric"].item() else "no, its mirror image is another"
    if int(found["primitive_parts"]) > 1:
        yield "repeats", f"a shorter orbit {int(found['primitive_parts'])} times"
    yield "admissible", "yes" if found["admissible"].item() else "no, no motion follows it"
    yield "residual", f"{found['residual'].item():.2g}"


def exists(found: xr.Dataset) -> bool:
    """Whether there is an orbit, be it inadmissible."""
    length = float(found["length"].item())
    return length == length


def word_text(word: str) -> str:
    """A word as it is read; of a long one the first modes and the number of legs."""
    modes = word.split()
    if len(modes) <= _MOST_MODES:
        return word
    return f"{' '.join(modes[:_MOST_MODES])} ... ({len(modes)} legs)"


def complex_text(number: complex) -> str:
    """A multiplier as it is read; of a real one the real part alone."""
    if number.imag == 0.0:
        return f"{number.real:.6g}"
    return f"{number.real:.6g} {'-' if number.imag < 0 else '+'} {abs(number.imag):.6g}i"


def _print_legs(found: xr.Dataset) -> None:
    """One line for each leg: its mode, when it begins, how long it takes and what ends it."""
    if not exists(found):
        return
    from nonsmooth.system.columns import harmless  # names come from files

    modes = found["leg_mode"].attrs.get("flag_meanings", "").split()
    rows = []
    for k in range(min(found.sizes["leg"], _MOST_LEGS)):
        leg = found.isel(leg=k)
        name = modes[int(leg["leg_mode"])] if modes else str(int(leg["leg_mode"]))
        rows.append(
            (
                str(k), harmless(name), f"{float(leg['leg_time']):.9g}",
                f"{float(leg['durations']):.9g}",
                harmless(str(leg["leg_exit"].item())) or "section",
            )
        )  # fmt: skip
    print_table(("leg", "mode", "from", "duration", "until"), rows)
    if found.sizes["leg"] > _MOST_LEGS:
        typer.echo(f"and {found.sizes['leg'] - _MOST_LEGS} more legs")


def _plot(
    found: xr.Dataset,
    path: Path,
    pair: tuple[str, str],
    shown: list[str],
    *,
    multipliers: bool,
    drift: bool,
) -> None:
    import nonsmooth as ns

    if not exists(found):
        typer.echo("there is no orbit to draw", err=True)
        return
    figure, (ax,) = ns.plot.print_figure(width=_WIDTH, height=_HEIGHT)
    if multipliers:
        ns.plot.multipliers(found, ax=ax)
    else:
        samples = ns.orbit_samples(found)
        if shown or "time" in pair:
            ns.plot.orbit_history(samples, shown or pair[1], ax=ax, drift=drift)
        else:
            ns.plot.periodic_orbit(samples, *pair, ax=ax, drift=drift)
    ns.plot.save_figure(figure, path)
    typer.echo(f"drawn {path}")
