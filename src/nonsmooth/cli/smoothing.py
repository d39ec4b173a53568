"""The command that compares a system with the same one smoothed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from nonsmooth.cli.arguments import value_limits
from nonsmooth.cli.basins import region_of
from nonsmooth.cli.command import Task
from nonsmooth.cli.report import Column, Report
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.system.columns import with_error

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["smoothing"]

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


def smoothing(task: Task) -> None:
    """``nonsmooth smoothing``."""
    system, widths = task.system, task["epsilons"]
    if task["toml"]:
        if task.plot is not None or task.save is not None or task["json"]:
            raise OptionError(
                "--toml prints a system and compares nothing: leave out the files, and --json"
            )
        _print_smoothed(system, widths, task["kind"])
        return
    if isinstance(widths, str):
        raise OptionError(
            f"--epsilons: {widths} uses {widths!r}; give a number or a constant expression"
        )
    from nonsmooth.analysis.smoothing_report import smoothing_report

    options = task.options("smoothing_report", "epsilons")
    options |= _length(system, task["periods"], task["t_end"])
    found = smoothing_report(system, widths, **options, **_compared(system, task["over"]))
    report = Report(str(found.attrs["system_name"]))
    _add_exponents(report, found)
    _add_widths(report, found)

    task.picture("smoothing", found, task["draw"])
    task.finish(found, report)


def _print_smoothed(system: System, widths: list[float] | str, kind: str) -> None:
    """Print the smoothed system as TOML, with a number or the name of a parameter as width."""
    from nonsmooth.system.smoothed import smoothed

    if not isinstance(widths, str) and len(widths) != 1:
        given = ",".join(f"{width:g}" for width in widths)
        raise OptionError(f"--epsilons: {given!r} is not one width, which --toml needs")
    width = widths if isinstance(widths, str) else widths[0]
    click.echo(smoothed(system, width, kind=kind).to_toml(), nl=False)


def _length(system: System, periods: float | None, t_end: float | None) -> dict[str, Any]:
    """How long the motion is, in the words of the library."""
    if periods is not None and t_end is not None:
        raise OptionError("give either --periods or --t-end, the length of the motion")
    if t_end is None and system.period is None:
        raise OptionError(f"{system.name} has no period; give the length of the motion by --t-end")
    if t_end is None and periods is None:
        periods = _PERIODS
    return {"periods": periods, "t_end": t_end}


def _compared(system: System, over: tuple[str, ...]) -> dict[str, Any]:
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
        found["region"] = region_of(system, tuple(of_states))
    if len(of_parameters) > 1:
        raise OptionError("--over: an orbit is followed over one parameter; leave out the others")
    for text in of_parameters:
        found["parameter"], found["between"] = value_limits(text)
    return found


def _add_exponents(report: Report, found: xr.Dataset) -> None:
    """Add the exponents of the width by which everything goes to zero."""
    report.add("smooth sign", str(found.attrs["kind"]))
    exponents = {}
    for name, label, column in _columns(found):
        exponent, error = (
            float(found[f"{name}_{what}"].values.ravel()[column])
            for what in ("exponent", "exponent_error")
        )
        shown = with_error(exponent, error) if exponent == exponent else "unknown"
        exponents[label] = {"exponent": exponent, "exponent_error": error}
        report.add(label, f"exponent {shown}", exponents=exponents)
    if "attractors_exact" in found:
        report.number("attractors, exact", int(found["attractors_exact"]))


def _columns(found: xr.Dataset) -> Iterator[tuple[str, str, int]]:
    """Quantities with an exponent, each for every state, surface or special point."""
    for name, label in _LABELS.items():
        if f"{name}_exponent" not in found:
            continue
        over = next((str(d) for d in found[name].dims if d != "epsilon"), None)
        for k in range(1 if over is None else found.sizes[over]):
            yield name, label.format(_name(found, over, k)), k


def _name(found: xr.Dataset, over: str | None, k: int) -> str:
    if over == "special":
        place = float(found["special_value_exact"][k])
        return f"{found['special_kind'].values[k]} at {place:.6g}"
    return "" if over is None else str(found[over].values[k])


def _add_widths(report: Report, found: xr.Dataset) -> None:
    """Add one line for each width; numbers stand below the labels of the exponents."""
    quantities = list(_columns(found))
    counts = [name for name in _COUNTS if name in found]
    columns: list[Column] = [("epsilon", "epsilon", "{:g}".format)]
    columns += [(label, label, "{:.4g}".format) for _, label, _ in quantities]
    columns += [(_COUNTS[name], name, "{:g}".format) for name in counts]
    rows = []
    for i in range(found.sizes["epsilon"]):
        one = found.isel(epsilon=i)
        row: list[Any] = [float(one["epsilon"])]
        row += [float(one[name].values.ravel()[k]) for name, _, k in quantities]
        rows.append([*row, *(float(one[name]) for name in counts), str(one["status"].item())])
    if any(row[-1] != "completed" for row in rows):
        columns.append(("status", "status", lambda word: "" if word == "completed" else word))
    else:
        rows = [row[:-1] for row in rows]
    report.table("widths", columns, map(tuple, rows))
