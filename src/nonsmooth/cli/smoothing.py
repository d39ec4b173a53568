"""``nonsmooth smoothing``: what smooth functions in place of switches do to a motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nonsmooth.cli import options
from nonsmooth.cli.arguments import build_system, constants, names, settings
from nonsmooth.cli.attractor_table import with_error
from nonsmooth.cli.console import print_table
from nonsmooth.cli.output import check_files, save_dataset, table
from nonsmooth.cli.regions import range_region
from nonsmooth.errors import OptionError, unknown_name

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["smoothing"]

_WIDTH, _HEIGHT = 10.0, 8.0  # centimetres
_PERIODS = 20.0
_LABELS = {
    "error": "error of {}",
    "stick_time_error": "time on {}, error",
    "creep": "creep at {}",
    "special_shift": "shift of {}",
    "extra_width": "extra special points, range",
}
_COUNTS = {
    "attractors": "attractors",
    "only_smoothed": "attractors, only smoothed",
    "only_exact": "attractors, only exact",
    "extra_specials": "extra special points",
}


def smoothing(
    model: options.Model,
    parameters: options.Parameters = None,
    *,
    epsilons: Annotated[
        str,
        typer.Option(metavar="0.1,0.01", help="Widths of the smooth switches, two or more."),
    ],
    kind: Annotated[
        str, typer.Option(help="The smooth sign: tanh, arctan, logistic or sqrt.")
    ] = "tanh",
    toml: Annotated[
        bool,
        typer.Option("--toml", help="Print the system smoothed by one width, or a name of it."),
    ] = False,
    start: options.Start = None,
    periods: Annotated[
        float | None, typer.Option(help="Length of the motion in periods; 20 by default.")
    ] = None,
    t_end: Annotated[
        float | None, typer.Option(help="Time at which it ends, in place of periods.")
    ] = None,
    transient: Annotated[
        float, typer.Option(help="Left out of it first: periods, or time with --t-end.")
    ] = 0.0,
    samples: Annotated[
        int, typer.Option(help="Instants that are compared: per period, or in all with --t-end.")
    ] = 2000,
    band: Annotated[
        float, typer.Option(help="Width beside a surface that counts as on it, in epsilons.")
    ] = 10.0,
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=A:B",
            help="Of a parameter: follow the orbit. Of states: look for attractors there.",
        ),
    ] = None,
    starts: Annotated[int, typer.Option(help="Starts by which attractors are found.")] = 20,
    period: Annotated[int, typer.Option(help="Periods of the orbit that is followed.")] = 1,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw a quantity: .png or .pdf.")
    ] = None,
    quantity: Annotated[
        str, typer.Option(help="What to draw, such as creep or stick_time_error.")
    ] = "error",
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the report as netCDF: .nc.")
    ] = None,
) -> None:
    """Compare a system with the same smoothed, over a ladder of widths."""
    check_files(plot, save)
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    if toml:
        if plot is not None or save is not None:
            raise OptionError("--toml prints a system and compares nothing: leave out the files")
        _print_smoothed(system, epsilons, kind)
        return
    from nonsmooth.analysis.smoothing_report import smoothing_report
    from nonsmooth.system.columns import harmless

    _check_quantity(quantity, plot)
    report = smoothing_report(
        system,
        _widths(epsilons),
        kind=kind,
        initial=constants(settings(names(start), "--start"), "--start") or None,
        transient=transient,
        samples=samples,
        band=band,
        starts=starts,
        period=period,
        **_length(system, periods, t_end),
        **_compared(system, over or []),
    )
    typer.echo(harmless(table(str(report.attrs["system_name"]), list(_rows(report)))))
    _print_widths(report)
    if save is not None:
        save_dataset(report, save)
    if plot is not None:
        _plot(report, quantity, plot)


def _print_smoothed(system: System, epsilon: str, kind: str) -> None:
    """The smoothed system as a file, with a number or the name of a new parameter as width."""
    from nonsmooth.system.smoothed import smoothed
    from nonsmooth.system.text.grammar import is_name

    parts = names(epsilon)
    if len(parts) != 1:
        raise OptionError(f"--epsilons: {epsilon!r} is not one width, which --toml needs")
    width = parts[0] if is_name(parts[0]) else _widths(epsilon)[0]
    typer.echo(smoothed(system, width, kind=kind).to_toml(), nl=False)


def _widths(text: str) -> list[float]:
    """Widths that may be written as expressions."""
    parts = names(text)
    if not parts:
        raise OptionError("--epsilons: give widths such as 0.1,0.01,0.001")
    numbered = {str(k): part for k, part in enumerate(parts, 1)}
    return list(constants(numbered, "--epsilons").values())


def _length(system: System, periods: float | None, t_end: float | None) -> dict[str, Any]:
    """How long the motion is, in the words of the library."""
    if periods is not None and t_end is not None:
        raise OptionError("give either --periods or --t-end, the length of the motion")
    if t_end is not None:
        return {"t_end": t_end}
    if system.period is None:
        raise OptionError(f"{system.name} has no period; give the length of the motion by --t-end")
    return {"periods": _PERIODS if periods is None else periods}


def _compared(system: System, over: Sequence[str]) -> dict[str, Any]:
    """Region of the states that are named, and the parameter to follow an orbit over."""
    of_states: list[str] = []
    of_parameters: list[str] = []
    for text in over:
        name = text.partition("=")[0].strip()
        if name and name not in (*system.states, *system.parameters):
            known = (*system.states, *system.parameters)
            raise OptionError(f"--over: {unknown_name('state or parameter', name, known)}")
        (of_parameters if name in system.parameters else of_states).append(text)
    found: dict[str, Any] = {}
    if of_states:
        found["region"] = range_region(system, of_states)
    if len(of_parameters) > 1:
        raise OptionError("--over: an orbit is followed over one parameter; leave out the others")
    for text in of_parameters:
        found["parameter"], found["between"] = _range(text)
    return found


def _range(text: str) -> tuple[str, tuple[float, float]]:
    """Name and ends of ``omega=0.7:0.85``."""
    ((name, value),) = settings([text], "--over").items()
    parts = [part.strip() for part in value.split(":")]
    if len(parts) != 2 or not all(parts):
        raise OptionError(f"--over: {text!r} is not of the form name=low:high")
    ends = constants(dict(zip(("low", "high"), parts, strict=True)), "--over")
    return name, (ends["low"], ends["high"])


def _check_quantity(quantity: str, plot: Path | None) -> None:
    """Refuse what no report has, before it is made."""
    if quantity not in _LABELS:
        raise OptionError(f"--quantity: {quantity!r} is not one of {', '.join(_LABELS)}")
    if plot is None and quantity != "error":
        raise OptionError("--quantity is drawn into a file: name it, such as --plot picture.png")


def _rows(report: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Exponents of the width by which everything goes to zero."""
    yield "smooth sign", str(report.attrs["kind"])
    for name, label, column in _columns(report):
        exponent, error = (
            float(report[f"{name}_{what}"].values.ravel()[column])
            for what in ("exponent", "exponent_error")
        )
        shown = with_error(exponent, error) if exponent == exponent else "unknown"
        yield label, f"exponent {shown}"
    if "attractors_exact" in report:
        yield "attractors, exact", f"{int(report['attractors_exact'])}"


def _columns(report: xr.Dataset) -> Iterator[tuple[str, str, int]]:
    """Quantities with an exponent, each for every state, surface or special point."""
    for name, label in _LABELS.items():
        if f"{name}_exponent" not in report:
            continue
        over = next((str(d) for d in report[name].dims if d != "epsilon"), None)
        for k in range(1 if over is None else report.sizes[over]):
            yield name, label.format(_name(report, over, k)), k


def _name(report: xr.Dataset, over: str | None, k: int) -> str:
    if over == "special":
        place = float(report["special_value_exact"][k])
        return f"{report['special_kind'].values[k]} at {place:.6g}"
    return "" if over is None else str(report[over].values[k])


def _print_widths(report: xr.Dataset) -> None:
    """One line for each width; numbers stand below the labels of the exponents."""
    from nonsmooth.system.columns import harmless

    columns = list(_columns(report))
    counts = [name for name in _COUNTS if name in report]
    heads = ["epsilon", *(harmless(label) for _, label, _ in columns)]
    heads += [_COUNTS[name] for name in counts]
    rows = []
    for i in range(report.sizes["epsilon"]):
        one = report.isel(epsilon=i)
        row = [f"{float(one['epsilon']):g}"]
        row += [f"{float(one[name].values.ravel()[k]):.4g}" for name, _, k in columns]
        row += [f"{float(one[name]):g}" for name in counts]
        status = str(one["status"].item())
        rows.append([*row, "" if status == "completed" else status])
    shown = any(row[-1] for row in rows)
    print_table([*heads, "status"] if shown else heads, [r if shown else r[:-1] for r in rows])


def _plot(report: xr.Dataset, quantity: str, path: Path) -> None:
    from nonsmooth.plot import print_figure, save_figure
    from nonsmooth.plot import smoothing as draw

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    draw(report, quantity, ax=ax)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
