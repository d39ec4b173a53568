"""Points of a section as an xarray dataset."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from nonsmooth.engine.status import CURES, Status
from nonsmooth.engine.tables import Tables
from nonsmooth.runs.certificate import with_doubts
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.outputs import Clock, output_values
from nonsmooth.runs.section_search import PATIENCE, Search, joined_points
from nonsmooth.system.system import System
from nonsmooth.version import __version__

__all__ = ["section_dataset"]

_WAYS = {1: "upward", -1: "downward", 0: "in either direction"}


def section_dataset(
    system: System, tables: Tables, found: Search, protocol: dict[str, Any]
) -> xr.Dataset:
    """Dataset over ``point`` from what a search has found."""
    labels = labels_of(system)
    points = joined_points(found.parts, len(system.states))
    side = 0 if protocol["side"] == "before" else 1
    states, modes = points.states[side].T.copy(), points.modes[side]
    clock = Clock(points.number, points.phase, tables)
    columns = dict(zip(system.states, states, strict=True))
    columns |= output_values(system, clock, states, modes)
    variables: dict[str, Any] = {
        name: ("point", values, labels.attributes(name)) for name, values in columns.items()
    }
    words = labels.mode_flags(f"mode just {protocol['side']}")
    variables["mode"] = ("point", modes.astype(labels.mode_type), words)
    if protocol["section_kind"] == "crossing":
        words = {"long_name": "1 where the section grows, -1 where it falls"}
        variables["direction"] = ("point", points.direction.astype("int8"), words)
    words = {"long_name": "whether neither rounding nor an estimate leaves a doubt about the point"}
    variables["certified"] = ("point", points.certified, words)
    coords: dict[str, Any] = {"time": ("point", clock.time, labels.attributes("time"))}
    if system.period_value is not None:
        words = {"long_name": "whole periods before the point"}
        coords["period_number"] = ("point", points.number, words)
        words = {"long_name": "time since the period began"}
        coords["phase"] = ("point", points.phase, words)
    return xr.Dataset(variables, coords, _attributes(system, tables, found, protocol))


def _attributes(
    system: System, tables: Tables, found: Search, protocol: dict[str, Any]
) -> dict[str, Any]:
    end = found.instant.time(tables.window)
    attrs = {
        "system_name": system.name,
        "system": labels_of(system).system,
        "nonsmooth_version": __version__,
        "status": _status(found),
        "message": _message(found, protocol, end),
        "certified": int(found.n_uncertain == found.n_estimated == 0),
        "n_points": found.n_points,
        "n_uncertain": found.n_uncertain,
        "n_estimated": found.n_estimated,
        "n_grazes": found.n_grazes,
        "end_time": end,
    }
    if system.period_value is not None:
        attrs["period"] = system.period_value
    return attrs | protocol


def _status(found: Search) -> str:
    if found.at_rest:
        return "at_rest"
    return "time_limit" if found.gave_up else found.status.word


def _message(found: Search, protocol: dict[str, Any], end: float) -> str:
    """What became of the search, and what to do where it found less than was asked for."""
    status, count, record = found.status, found.n_points, protocol["record"]
    few = f"{count} of {record} points until t = {end:.9g}"
    if found.at_rest:
        return (
            f"{few}; there the motion comes to rest on the section, as far as rounding tells: the"
            " points that are not certified mean nothing"
        )
    if status != Status.COMPLETED:
        return f"{status.word} at t = {end:.9g}, {count} of {record} points: {CURES[status]}"
    if count == record or (count and protocol["t_end"] < np.inf):
        return with_doubts(status.word, found.n_uncertain, found.n_estimated)
    reason = f"; none came in the last {PATIENCE} periods or windows" if found.gave_up else ""
    if count:
        return f"{few}{reason}; does the motion come to rest, or leave the section?"
    name = protocol["section"]
    if protocol["section_kind"] == "event":
        return f"{few}{reason}; no event {name!r} came: draw the motion, or give a later t_end="
    if found.n_grazes:
        return (
            f"{few}; the motion touches section = {name!r} {found.n_grazes} times, within rounding"
            " of crossing it: move the section a little into the motion"
        )
    way = _WAYS[protocol["direction"]]
    return (
        f"{few}{reason}; nothing crosses section = {name!r} {way}: draw the motion"
        " with simulate, move the section into it, or give direction=0 or a later t_end="
    )
