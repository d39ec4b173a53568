"""Commands for the borders of basins: the saddle on one, and how basins shrink."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.cli.arguments import settings, value_range
from nonsmooth.cli.basins import (
    MOST,
    add_status,
    coordinates_of,
    grid_of,
    map_of_task,
    or_blank,
)
from nonsmooth.cli.command import Task
from nonsmooth.cli.report import Column, Report, complex_text
from nonsmooth.errors import OptionError
from nonsmooth.system.columns import with_error

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["edge", "erosion"]

_MEASURES = ("local_integrity", "global_integrity", "integrity_factor")


def edge(task: Task) -> None:
    """``nonsmooth edge``."""
    from nonsmooth.analysis.edge_state import edge_state

    coordinates = coordinates_of(task)
    result = edge_state(map_of_task(task), **task.options("edge_state"))

    task.picture("edge_state", result, *coordinates)
    report = Report(str(result.attrs["system_name"]))
    add_status(report, result)
    report.add("kind", str(result["kind"].item()), kind=str(result["kind"].item()))
    report.number("crossing", float(result["crossing"]), ".10g")
    if result["kind"].item() == "periodic":
        _add_saddle(report, result)
    elif bool((result["exponent"] == result["exponent"]).any()):
        pairs = zip(result["exponent"].values, result["exponent_error"].values, strict=True)
        exponents = [(float(value), float(error)) for value, error in pairs]
        text = ", ".join(with_error(*pair) for pair in exponents if pair[0] == pair[0])
        report.add("exponents per iterate", text, exponents=exponents)
    rows = [
        (str(one["side"].item()), str(one["outcome"].item()), int(one["outcome_period"]) or None,
         float(one["distance"]))
        for one in (result.isel(side=k) for k in range(2))
    ]  # fmt: skip
    columns: list[Column] = [
        ("side", "side", str),
        ("leads to", "outcome", str),
        ("period", "period", or_blank(str)),
        ("distance", "distance", lambda far: "" if far != far else f"{far:.4g}"),
    ]
    report.table("sides", columns, rows, len(rows))
    task.finish(result, report, code=task.by_message(result))


def _add_saddle(report: Report, result: xr.Dataset) -> None:
    """Add the saddle on a border: its period, multipliers and points."""
    report.add("period", f"{int(result['period'])}", period=int(result["period"]))
    multipliers = result["multipliers"].values
    report.add("multipliers", ", ".join(map(complex_text, multipliers)), multipliers=multipliers)
    report.number("residual", float(result["residual"]), ".2g")
    states = [str(name) for name in result["state"].values]
    rows = [
        (k, {name: float(result[name][k]) for name in states}) for k in range(result.sizes["point"])
    ]
    columns: list[Column] = [
        ("point", "number", str),
        (
            f"({', '.join(states)})",
            "states",
            lambda point: ", ".join(f"{value:.10g}" for value in point.values()),
        ),
    ]
    report.table("points", columns, rows, MOST)


def erosion(task: Task) -> None:
    """``nonsmooth erosion``."""
    from nonsmooth.analysis.erosion_profile import erosion_profile

    names = [text.partition("=")[0].strip() for text in task["over"]]
    varied = [k for k, name in enumerate(names) if name in task.system.parameters]
    if len(varied) != 1:
        raise OptionError(
            "--over: give the values of one parameter, such as --over omega=0.6:0.9:10, and those"
            f" of two states, such as --over {task.system.states[0]}=-1:1:60"
        )
    parameter, values = value_range(task["over"][varied[0]])
    task.refuse_fixed([parameter], "--over")
    over = tuple(text for k, text in enumerate(task["over"]) if k not in varied)
    options = task.options("erosion_profile", "completion")
    options["completion"] = dict(settings(task["complete"], "--complete", "q=max(0,p-g)"))
    region = grid_of(task.system, over)
    result = erosion_profile(map_of_task(task), parameter, values, region, **options)

    task.picture("erosion_profile", result, task["draw"], relative=task["relative"])
    report = Report(str(result.attrs["system_name"]))
    add_status(report, result)
    half = float(result.attrs["half_diagonal"])
    report.add("half diagonal of a cell", f"{half:.4g}", half_diagonal=half)
    rows = []
    table = result.stack(row=("parameter", "attractor"))
    for one in (table.isel(row=k) for k in range(table.sizes["row"])):
        if one["kind"].item():
            measured = [float(one[name]) for name in _MEASURES]
            rows.append((float(one["parameter"]), int(one["attractor"]), *measured))
    columns: list[Column] = [
        (parameter, "value", "{:.6g}".format),
        ("attractor", "attractor", str),
        ("distance", "local_integrity", _or_unknown),
        ("share", "global_integrity", "{:.4g}".format),
        ("ball", "integrity_factor", "{:.4g}".format),
    ]
    report.table("integrity", columns, rows, 4 * MOST)
    task.finish(result, report, code=task.by_message(result))


def _or_unknown(value: float) -> str:
    return "" if value != value else f"{value:.4g}"
