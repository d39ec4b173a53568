"""Commands for attractors, their basins, and how predictable the outcomes are."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.cli.arguments import names, need_period, settings, value_limits, value_range
from nonsmooth.cli.command import Task
from nonsmooth.cli.report import Column, Report
from nonsmooth.cli.saved import saved_dataset
from nonsmooth.cli.variables import chosen
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.system.columns import with_error

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from nonsmooth.runs.poincare_map import PoincareMap
    from nonsmooth.runs.stroboscopic_map import StroboscopicMap
    from nonsmooth.system.system import System

__all__ = [
    "MOST", "add_status", "attractors", "basins", "coordinates_of", "grid_of", "map_of_task",
    "measures", "or_blank", "region_of",
]  # fmt: skip

_MOST_CELLS = 100_000_000  # of a grid
MOST = 40  # attractors that are printed
_MOST_STATES = 3  # of a point
_ROUNDING = 1e-12  # of the largest coordinate
_LONGEST = 28  # letters of a word; those of long cycles are in the file
_FEWEST_FOR_WADA = 3


def attractors(task: Task) -> None:
    """``nonsmooth attractors``."""
    from nonsmooth.analysis.attractors import attractors as find

    coordinates = coordinates_of(task)
    region = region_of(task.system, task["over"])
    result = find(map_of_task(task), region, **_options(task, "attractors"))

    task.picture("attractors", result, *coordinates)
    attrs = result.attrs
    report = Report(str(attrs["system_name"]))
    add_status(report, result)
    samples, drawn = attrs["samples"], attrs["drawn_starts"]
    text = (
        f"{samples}" if drawn == samples else f"{samples} of {drawn} drawn, the others inadmissible"
    )
    report.add("starts", text, starts=samples, drawn_starts=drawn)
    told = {
        "unsettled_starts": "unsettled",
        "ended_starts": "ended early",
        "unreturned_starts": "of these never back at the section",
    }
    for key, label in told.items():
        if attrs[key]:
            report.add(label, f"{attrs[key]} starts", **{key: attrs[key]})
    _add_attractors(report, result)
    complete = str(attrs["message"]).startswith("completed")
    task.finish(result, report, code=task.by_message(result, complete))


def coordinates_of(task: Task) -> list[str]:
    """Two states to draw, or none, so that the picture chooses."""
    text = task["draw"]
    if text is None:
        return []
    if len(names(text, "--draw")) != 2:
        raise OptionError(f"--draw: {text!r} is not two states, such as x,v")
    return chosen(text, task.system.states, kind="state")


def basins(task: Task) -> None:
    """``nonsmooth basins``."""
    from nonsmooth.analysis.basins_of_attraction import basins_of_attraction

    region = grid_of(task.system, task["over"])
    if task.plot is not None and len(region) != 2:
        raise OptionError(f"--plot draws basins over two states, and --over has {len(region)}")
    result = basins_of_attraction(
        map_of_task(task), region, **_options(task, "basins_of_attraction")
    )

    task.picture("basins", result, colour=task["colour"])
    attrs, label = result.attrs, result["label"]
    report = Report(str(attrs["system_name"]))
    add_status(report, result)
    text = f"{label.size} ({' x '.join(str(n) for n in reversed(label.shape))})"
    report.add("cells", text, cells={str(name): label.sizes[name] for name in label.dims})
    kinds = ("unsettled", "ended early", "inadmissible", "not computed")
    keys = ("unsettled_cells", "ended_cells", "inadmissible_cells", "cells_left_out")
    for kind, key in zip(kinds, keys, strict=True):
        if attrs[key]:
            report.add(kind, f"{attrs[key]} cells", **{key: attrs[key]})
    _add_attractors(report, result)
    complete = str(attrs["message"]).startswith("completed")
    task.finish(result, report, code=task.by_message(result, complete))


def _options(task: Task, verb: str) -> dict[str, Any]:
    """Options of a search for attractors."""
    options = task.options(verb, "completion")
    return options | {"completion": dict(settings(task["complete"], "--complete", "q=max(0,p-g)"))}


def region_of(system: System, over: tuple[str, ...]) -> dict[str, tuple[float, float]]:
    """Ranges of states from texts such as ``x=-1:1``."""
    settings(over, "--over")  # refuses a state that is given twice
    region = dict(map(value_limits, over))
    for name in region:
        _check_state(system, name)
    return region


def grid_of(system: System, over: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Values of states from texts such as ``x=-1:1:200``, two states at least."""
    region: dict[str, np.ndarray] = {}
    cells = 1
    for text in over:
        name, values = value_range(text)
        if name in region:
            raise OptionError(f"--over: {name!r} is given twice")
        _check_state(system, name)
        if values.size < 2 or not values[0] < values[-1]:
            raise OptionError(
                f"--over: {text!r} is no row of cells; the first value must be less than the last"
                " one, and the count 2 or more"
            )
        region[name] = values
        cells *= values.size
    if len(region) < 2:
        raise OptionError("--over: basins need two states or more, such as x=-1:1:200")
    if cells > _MOST_CELLS:
        raise OptionError(f"--over: {cells} cells are too many; {_MOST_CELLS} are the most")
    return region


def _check_state(system: System, name: str) -> None:
    if name not in system.states:
        raise OptionError(f"--over: {unknown_name('state', name, system.states)}")


def map_of_task(task: Task) -> PoincareMap | StroboscopicMap:
    """The map from strobe to strobe, or from one point of a section to the next."""
    from nonsmooth.runs.poincare_map import PoincareMap
    from nonsmooth.runs.stroboscopic_map import StroboscopicMap

    system, section, every = task.system, task["section"], task["every"]
    strobes = task.options("StroboscopicMap")
    if section is None:
        if task["direction"] is not None or task.is_given("side"):
            raise OptionError("--direction and --side are those of a section: name it: --section")
        if task["period"] is None:
            need_period(
                system, f"name a section, such as --section {system.states[-1]}, or give --period"
            )
        strobed = StroboscopicMap(system, **strobes)
        strobed.check_whole_periods()
        return strobed
    if task.is_given("phase") or task["period"] is not None:
        raise OptionError("--phase and --period are those of strobes: leave out --section, or them")
    found = PoincareMap(system, every=every, **task.options("PoincareMap"))
    if found.reads_time:
        raise OptionError(
            f"--section: the motion of {system.name} depends on time, so that it also matters when"
            " it comes to the section; leave out --section, for points once per period"
        )
    return found


def add_status(report: Report, result: xr.Dataset) -> None:
    """Add the message of a result."""
    message = str(result.attrs["message"])
    report.add("status", message, status=result.attrs["status"], message=message)


def _add_attractors(report: Report, result: xr.Dataset) -> None:
    """Add how many attractors there are, and one line for each."""
    import numpy as np

    report.lines.append(("attractors", f"{result.sizes['attractor']}"))
    rows = []
    # the sum of all increments since a start says nothing of the attractor
    states = [n for n in map(str, result["state"].values) if f"{n}_per_iterate" not in result]
    for i in range(result.sizes["attractor"]):
        one = result.isel(attractor=i)
        period = int(one["period"])
        sizes = np.hypot(one["multiplier_real"].values, one["multiplier_imag"].values)
        share = float(one["fraction"]), float(one["fraction_error"])
        exponent = float(one["exponent"]), float(one["exponent_error"])
        point = {name: float(one["points"].sel(state=name)[0]) for name in states}
        rows.append(
            (
                int(one["attractor"]), (str(one["kind"].item()), int(one["chaotic_for"])),
                period or None, point, share,
                float(sizes.max(initial=0.0)) if period else None,
                None if period else exponent, str(one["word"].item()),
            )
        )  # fmt: skip
    if any(not period for period in result["period"].values):
        report.add("exponents", "per iterate", exponents_are="per iterate")
    columns: list[Column] = [
        ("", "attractor", str),
        ("kind", "kind and chaotic_for", lambda pair: pair[0]),  # the message tells for how long
        ("period", "period", or_blank(str)),
        (f"point {_bracketed(states)}", "point", _point_text),
        ("share", "share and share_error", _pair_text),
        ("multiplier", "multiplier", or_blank("{:.4g}".format)),
        ("exponent", "exponent and exponent_error", or_blank(_pair_text)),
        ("word", "word", lambda w: w if len(w) <= _LONGEST else w[: _LONGEST - 4] + " ..."),
    ]
    report.table("attractors", columns, rows, MOST)


def _bracketed(states: Sequence[str]) -> str:
    """States as coordinates of a point."""
    return f"({', '.join(states[:_MOST_STATES])}{', ...' if len(states) > _MOST_STATES else ''})"


def _point_text(point: Mapping[str, float]) -> str:
    """Coordinates of a point, with zero for what is zero but for rounding."""
    rounding = _ROUNDING * max(map(abs, point.values()), default=0.0)
    shown = list(point.values())[:_MOST_STATES]
    return ", ".join(f"{value if abs(value) > rounding else 0.0:.3g}" for value in shown)


def _pair_text(pair: tuple[float, float]) -> str:
    return with_error(*pair)


def or_blank(text: Any) -> Any:
    """What writes a value as ``text`` does, and nothing for one that is not known."""
    return lambda value: "" if value is None else text(value)


def measures(task: Task) -> None:
    """``nonsmooth measures``."""
    from nonsmooth.analysis.basin_entropy import basin_entropy
    from nonsmooth.analysis.basin_fractions import basin_fractions
    from nonsmooth.analysis.uncertainty_exponent import uncertainty_exponent

    saved = _saved(Path(task["file"]))
    fractions = basin_fractions(saved)
    found = uncertainty_exponent(saved, **task.options("uncertainty_exponent"))
    report = Report(str(saved.attrs.get("system_name", task["file"])))
    error = float(found["standard_error"])
    for label in ("uncertainty exponent", "boundary dimension"):
        _add_with_error(report, label, float(found[label.replace(" ", "_")]), error)
    if found.attrs["message"]:
        report.add("", str(found.attrs["message"]), message=str(found.attrs["message"]))
    entropy = basin_entropy(saved, **task.options("basin_entropy"))
    for name in ("basin_entropy", "boundary_basin_entropy"):
        values = float(entropy[name]), float(entropy[f"{name}_error"])
        _add_with_error(report, name.replace("_", " "), *values)
    report.data["fractal"] = bool(entropy["fractal"])
    if report.data["fractal"]:
        report.lines.append(("", "the boundary is fractal: its entropy is above log 2"))
    _add_wada(report, saved, fractions, task)
    outcomes = [fractions.isel(label=i) for i in range(fractions.sizes["label"])]
    rows = [
        (
            str(one["outcome"].item()),
            (float(one["fraction"]), float(one["fraction_error"])),
            int(one["starts"]),
        )
        for one in outcomes
    ]
    columns: list[Column] = [
        ("outcome", "outcome", str),
        ("share", "share and share_error", _pair_text),
        ("starts", "starts", str),
    ]
    report.table("outcomes", columns, rows, sys.maxsize)

    task.picture("uncertainty", found)
    task.finish(None, report)


def _add_with_error(report: Report, label: str, value: float, error: float) -> None:
    key = label.replace(" ", "_")
    report.add(label, with_error(value, error), **{key: value, f"{key}_error": error})


def _add_wada(report: Report, saved: xr.Dataset, fractions: xr.Dataset, task: Task) -> None:
    """Add whether basins share one boundary, where there are three or more."""
    from nonsmooth.analysis.wada_test import wada_test

    counted = (fractions["starts"].values > 0) & (fractions["label"].values != 0)
    if int(counted.sum()) >= _FEWEST_FOR_WADA:
        found = wada_test(saved, **task.options("wada_test"))
        wada, cells = bool(found["wada"]), float(found["largest_distance"])
        text = f"{'yes' if wada else 'no'}, boundaries are up to {cells:g} cells apart"
        report.add("Wada property", text, wada=wada, largest_distance=cells)


def _saved(file: Path) -> xr.Dataset:
    """Basins of a file."""
    saved = saved_dataset(file, cure="nonsmooth basins --save writes one")
    if "label" not in saved:
        raise OptionError(
            f"{file} holds no basins; give a file that nonsmooth basins --save has written"
        )
    return saved
