"""What is computed aside: each task turns a view into pieces, ready to be drawn.

A piece is a dictionary of plain values and arrays. Tasks that take long give coarse pieces first,
so that there is something to see after a moment.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.explorer import calls
from nonsmooth.explorer.limits import label_and_unit, sliders
from nonsmooth.explorer.reasons import certificate, event_reasons
from nonsmooth.explorer.view import View, system_of
from nonsmooth.runs.start import GOES_ON

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["TASKS", "Piece"]

Piece = dict[str, Any]

_LONGEST_RUN = 4.0  # seconds of a motion that is shown; more would keep a slider waiting
_MOST_EVENTS = 100_000
_EVENTS = 2_000  # rows that go to the page
_FRAMES = 400  # of the drawing
_COARSE_COLUMNS = 8  # every so many columns come first
_COARSE_CELLS = 25
_LONG_COARSE = 4.0  # seconds of coarse basins, beyond which fine ones would take minutes
_AROUND = 0.25  # of the extent of a motion, by which a region reaches beyond it
_LONGEST_TURN = 16  # periods of an orbit that is looked for
_SETTLING = 200  # periods until the period of a motion is read


def _run(view: View) -> xr.Dataset:
    """The motion shown; where its part that is left out ends early, that part is shown instead."""
    limits = {"max_seconds": _LONGEST_RUN, "max_events": _MOST_EVENTS}
    *before, shown = calls.motion(view)
    results = calls.computed(before, {"system": view.system}, **limits)
    if before and results["settled"].attrs["status"] not in GOES_ON:
        (shown,) = calls.motion(replace(view, leave_out=0.0, length=view.leave_out))
    return calls.computed([shown], results, **limits)["run"]


def motion(view: View) -> Iterator[Piece]:
    """Curves of the motion by mode, and its events."""
    from nonsmooth.plot.style import mode_colours

    run = _run(view)
    drawn, portrait = list(view.drawn), list(view.portrait)
    attrs = run.attrs
    yield {
        "status": attrs["status"],
        "message": attrs["message"],
        "certified": bool(attrs["certified"]),
        "n_events": int(attrs["n_events"]),
        "n_uncertain": int(attrs["n_uncertain"]) + int(attrs["n_estimated"]),
        "word": attrs["phase_word"],
        "period": attrs.get("period"),
        "time": run["time"].values,
        "values": {name: run[name].values for name in dict.fromkeys([*drawn, *portrait])},
        "labels": {name: _label(run, name) for name in dict.fromkeys([*drawn, *portrait, "time"])},
        "colours": mode_colours(run),
        "history": [_by_mode(run, [name], over_time=True) for name in drawn],
        "portrait": _by_mode(run, portrait),
        "extent": {name: _extent(run[name].values) for name in view.system.states},
        "end": dict(zip(view.system.states, run["end_state"].values.tolist(), strict=True)),
        "events": _events(view, run, [*drawn[:1], *portrait]),
    }


def _label(data: xr.Dataset, name: str) -> tuple[str, str]:
    attrs = data[name].attrs
    return str(attrs.get("long_name", name)), str(attrs.get("units", ""))


def _extent(values: np.ndarray) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)


def _by_mode(run: xr.Dataset, names: list[str], *, over_time: bool = False) -> dict[str, Any]:
    """Points of a curve for each mode, with gaps where the motion is in another one."""
    from nonsmooth.plot.style import modes_visited
    from nonsmooth.plot.trace import broken, curve

    trace = curve(run, names)
    points = np.vstack([trace.time, trace.values]) if over_time else trace.values
    points = np.vstack([points, points]) if len(points) == 1 else points
    found = {
        name: broken(points, here & ~trace.jumps)
        for name, here in modes_visited(run, trace.mode).items()
    }
    moved = np.append(np.any(np.diff(points, axis=1) != 0.0, axis=0), False)
    found[""] = broken(points, trace.jumps & moved)
    return {name: line for name, line in found.items() if line.size}


def _events(view: View, run: xr.Dataset, names: list[str]) -> list[dict[str, Any]]:
    """The event log as rows, with where the events lie in the curves."""
    log = run.isel(event=slice(0, _EVENTS))
    modes = log["mode"].attrs["flag_meanings"].split()
    columns = {key: log[f"event_{key}"].values.tolist() for key in ("time", "name", "kind")}
    columns |= {key: [modes[i] for i in log[f"event_{key}"].values] for key in ("from", "to")}
    columns |= {side: log[f"state_{side}"].values.tolist() for side in ("before", "after")}
    columns |= {"rate": log["guard_rate"].values.tolist()}
    columns |= {key: log[key].values.astype(bool).tolist() for key in ("certified", "estimated")}
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    states = list(view.system.states)
    when = np.array([row["time"] for row in rows])
    for name in names:
        place = states.index(name) if name in states else -1
        at = np.interp(when, run["time"].values, run[name].values) if place < 0 else ()
        for k, row in enumerate(rows):
            row.setdefault("at", {})[name] = row["before"][place] if place >= 0 else float(at[k])
    for row, reason in zip(rows, event_reasons(view.system, rows), strict=True):
        row |= {"reason": reason, "certificate": certificate(row)}
    return rows


def ranges(view: View) -> Iterator[Piece]:
    """How far each slider may go, beside the present values of all others."""
    yield {"sliders": sliders(view.system, system_of(view.model, view.text))}


def drawing(view: View) -> Iterator[Piece]:
    """The machine in all its places, as outlines over frames."""
    from nonsmooth.drawings import ROLES, drawing_of

    run = _run(view)
    step = max(1, -(-run.sizes["time"] // _FRAMES))
    run = run.isel(time=slice(None, None, step))
    frames = drawing_of(view.system).frames(run)
    modes = run["mode"].attrs["flag_meanings"].split()
    yield {
        "time": run["time"].values,
        "mode": [modes[k] for k in run["mode"].values],
        "note": frames.note,
        "x_range": frames.x_range,
        "y_range": frames.y_range,
        "shapes": [
            {
                "kind": shape.kind,
                "x": shape.x.astype(np.float32),
                "y": shape.y.astype(np.float32),
                "visible": shape.visible,
                "text": shape.text,
                "fill": ROLES[shape.role].fill,
                "edge": ROLES[shape.role].edge,
                "width": ROLES[shape.role].width,
                "dashed": ROLES[shape.role].dashed,
            }
            for shape in frames.shapes
        ],
    }


def diagram(view: View) -> Iterator[Piece]:
    """Columns of the bifurcation diagram, some of them first."""
    if not view.over:
        raise OptionError("the system has no parameter for a diagram")
    if view.start != "restart":  # each column begins where the one before has ended
        coarse = max(2, view.columns // _COARSE_COLUMNS)
        for columns in (coarse, view.columns):
            done = calls.computed(calls.diagram(view, columns), {"system": view.system})["diagram"]
            yield _columns(view, done, np.arange(columns), columns, done)
        return
    made, system = calls.diagram(view), view.system
    values = made[-1].arguments[2].values()
    results = calls.computed(made[:-1], {"system": system})
    parts: list[xr.Dataset] = []
    for chosen in _coarse_to_fine(len(values)):
        if not chosen.size:  # of few columns
            continue
        call = replace(made[-1], arguments=(*made[-1].arguments[:2], values[chosen]))
        parts.append(calls.computed([call], results)["diagram"])
        whole = _joined(parts)
        yield _columns(view, parts[-1], chosen, len(values), whole)


def _joined(parts: list[xr.Dataset]) -> xr.Dataset:
    """Columns of some parts as one diagram; where motions ended early, points are missing."""
    import xarray as xr

    most = max(part.sizes["point"] for part in parts)
    even = []
    for part in parts:
        over_points = [name for name, each in part.variables.items() if "point" in each.dims]
        nothing = {name: np.nan if part[name].dtype.kind == "f" else -1 for name in over_points}
        missing = most - part.sizes["point"]
        even.append(part.pad(point=(0, missing), constant_values=nothing) if missing else part)
    return xr.concat(even, "parameter", combine_attrs="override").sortby("parameter")


def _coarse_to_fine(count: int) -> Iterator[np.ndarray]:
    """Numbers below a count: every eighth, then those half way, and so on."""
    step = _COARSE_COLUMNS
    yield np.arange(0, count, step)
    while step > 1:
        yield np.arange(step // 2, count, step)
        step //= 2


def _columns(
    view: View, part: xr.Dataset, numbers: np.ndarray, count: int, whole: xr.Dataset
) -> Piece:
    """Points of some columns with the period of each; and what is said of all so far."""
    came = whole["status"].values == "completed"
    shown = part[view.shown]
    values = shown.values.reshape(len(numbers), -1)
    period = part["period"].values[:, 0]
    # a motion of period p has p points: the others lie on them
    kept = np.isfinite(values)
    short = (period > 0) & (period < values.shape[1])
    kept[short] &= np.arange(values.shape[1]) < period[short, None]
    column, _ = np.nonzero(kept)
    return {
        "label": _label(part, view.shown),
        "parameter": part["parameter"].values[column],
        "value": values[kept],
        "period": period[column],
        "numbers": numbers,
        "done": whole.sizes["parameter"],
        "count": count,
        "unsettled": int((came & (whole["period"].values == 0)).sum()),
        "ended": sorted(set(whole["status"].values[~came].tolist())),
        "n_ended": int((~came).sum()),
        "result": {"diagram": whole},
    }


def plane(view: View, every: bool = False) -> Iterator[Piece]:
    """Basins of attraction, coarse first; or points of a section.

    Where coarse ones take long, all cells are computed only when ``every`` asks for them.
    """
    if not view.plane:
        raise OptionError("the system has fewer than two states for a plane")
    if view.picture == "section":
        yield _points(view)
        return
    if view.system.period is None and not view.section:
        raise OptionError(
            "nothing drives this system: give a section, such as one of its velocities, by which"
            " basins are counted"
        )
    view = replace(view, region=view.region or _region(view))
    coarse = min(_COARSE_CELLS, view.cells)
    for cells in [view.cells] if every else sorted({coarse, view.cells}):
        began = time.perf_counter()
        found = calls.computed(calls.basins(view, cells), {"system": view.system})["basins"]
        seconds = time.perf_counter() - began
        waits = cells < view.cells and seconds > _LONG_COARSE
        yield _cells(view, found) | {"seconds": seconds, "waits": waits}
        if waits:
            return


def _region(view: View) -> tuple[float, ...]:
    """Ranges a little wider than the motion."""
    run = _run(view)
    ends: list[float] = []
    for name in view.plane:
        low, high = _extent(run[name].values)
        reach = _AROUND * (high - low) or 1.0
        ends += [float(f"{low - reach:.3g}"), float(f"{high + reach:.3g}")]
    return tuple(ends)


def _cells(view: View, found: xr.Dataset) -> Piece:
    from nonsmooth.plot.attractor_style import attractor_points, attractor_styles

    across, up = view.plane
    numbers = [int(k) for k in found["attractor"].values]
    styles = attractor_styles(found, numbers)
    return {
        "label": found["label"].transpose(up, across).values,
        "region": view.region,
        "labels": {name: _name_and_unit(view, name) for name in view.plane},
        "attractors": [
            {
                "number": k,
                "basin": styles[k].basin,
                "colour": styles[k].points,
                "text": _kind(found, k),
                "share": float((found["label"] == k).mean()),
                "points": attractor_points(found, k, across, up),
            }
            for k in numbers
        ],
        "others": {
            name: found.attrs[key] / found["label"].size
            for name, key in (
                ("unsettled", "unsettled_cells"),
                ("ended early", "ended_cells"),
                ("inadmissible", "inadmissible_cells"),
                ("not computed", "cells_left_out"),
            )
            if found.attrs[key]
        },
        "cells": int(found["label"].size),
        "message": str(found.attrs["message"]),
        "result": {"basins": found},
    }


def _kind(found: xr.Dataset, number: int) -> str:
    """What an attractor is, in a word or two."""
    one = found.sel(attractor=number)
    period = int(one["period"]) if "period" in one else 0
    return f"period {period}" if period > 0 else str(one["kind"].item())


def _points(view: View) -> Piece:
    from nonsmooth.plot.style import mode_colours

    points = calls.computed(calls.points(view), {"system": view.system})["points"]
    across, up = view.plane
    modes = points["mode"].attrs["flag_meanings"].split()
    colours = mode_colours(points)
    return {
        "x": points[across].values,
        "y": points[up].values,
        "mode": [modes[k] for k in points["mode"].values],
        "colour": [colours[modes[k]] for k in points["mode"].values],
        "labels": {name: _name_and_unit(view, name) for name in view.plane},
        "message": str(points.attrs.get("message", "")),
        "result": {"points": points},
    }


def _name_and_unit(view: View, name: str) -> tuple[str, str]:
    label, unit = label_and_unit(view.system.describe.get(name, name))
    return label or name, unit


def orbit(view: View) -> Iterator[Piece]:
    """The periodic orbit near the end of the motion; then its branch, where it is asked for."""
    from nonsmooth.analysis.orbit_samples import orbit_samples

    system = view.system
    run = _run(view)
    if run.attrs["status"] not in GOES_ON:
        yield {"turn": 0, "message": "the motion ends early, so there is no orbit near its end"}
        return
    if view.turn < 0:
        view = replace(view, turn=_period(view))
    results = calls.computed(calls.orbit(view), {"system": system, "run": run})
    found = results["orbit"]
    if found.attrs["status"] not in ("completed", "inadmissible"):
        yield {"turn": 0, "message": found.attrs["message"]}
        return
    samples = orbit_samples(found)
    yield {
        "turn": view.turn,
        "message": found.attrs["message"],
        "admissible": bool(found["admissible"]),
        "stable": bool(found["stable"]),
        "word": str(found["word"].item()),
        "residual": float(found["residual"]),
        "length": float(found["length"]),
        "multipliers": found["multipliers"].values.tolist(),
        "curve": tuple(samples[name].values for name in view.portrait),
        "state": {name: float(found[name]) for name in system.states},
    }
    if view.branch and view.over and bool(found["admissible"]):
        (follow,) = calls.branch(view)
        yield _branch(view, follow.run(results))


def _period(view: View) -> int:
    """Period to which the motion repeats, 1 where it does not: an orbit is near all the same."""
    if view.system.period is None:
        return 1
    call = calls.diagram(replace(view, section="", start="restart", initial=()))[-1]
    value = np.array([view.system.parameter_values[view.over]]) if view.over else None
    if value is None:
        return 1
    call = replace(call, arguments=(*call.arguments[:2], value))
    options = {"transient": _SETTLING, "record": 4 * _LONGEST_TURN, "initial": _run(view)}
    settled = call.run({"system": view.system}, **options)
    return int(settled["period"].values.ravel()[0]) or 1


def _branch(view: View, branch: xr.Dataset) -> Piece:
    shown = view.shown if view.shown in branch else ""
    special = [
        {
            "kind": str(kind),
            "value": float(value),
            "height": float(branch[shown].values[int(point)]) if shown else float("nan"),
        }
        for kind, value, point in zip(
            branch["special_kind"].values,
            branch["special_value"].values,
            branch["special_point"].values,
            strict=True,
        )
    ]
    return {
        "parameter": branch[view.over].values,
        "value": branch[shown].values if shown else np.full(branch.sizes["point"], np.nan),
        "stable": branch["stable"].values.astype(bool),
        "special": special,
        "ends": (branch.attrs["end_first"], branch.attrs["end_last"]),
        "result": {"branch": branch},
    }


def picture(
    view: View,
    which: str = "portrait",
    suffix: str = ".png",
    known: Mapping[str, Any] | None = None,
) -> Iterator[Piece]:
    """A picture for print, drawn by `nonsmooth.plot` from known results, or of the same calls."""
    from nonsmooth.explorer.printing import printed

    results = dict(known or {})
    if which in ("history", "portrait"):
        results["run"] = _run(view)
    yield {"file": printed(view, which, suffix, results), "name": f"{which}{suffix}"}


TASKS: dict[str, Callable[..., Iterator[Piece]]] = {
    "motion": motion,
    "ranges": ranges,
    "drawing": drawing,
    "diagram": diagram,
    "plane": plane,
    "orbit": orbit,
    "picture": picture,
}
