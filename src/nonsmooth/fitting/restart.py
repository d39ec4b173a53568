"""The equations of a fit and its minimum, made again from the result.

A result has its system as a text, the data that were measured, and how each channel shows them. So
what goes on from a fit needs no other argument, also where the result comes from a file.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import ANY
from nonsmooth.errors import ModelError, OptionError
from nonsmooth.fitting.channels import ObservedChannel, Range
from nonsmooth.fitting.record_equations import RecordEquations
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.system.system import System

__all__ = ["fitted_shooting", "restart_text"]

Floats = npt.NDArray[np.float64]
Entry = dict[str, Any]

_NEEDED = ("estimate", "noise", "measured", "segment_record", "segment_time", "segment_state")
_SENSOR = (
    *("name", "text", "gain", "offset", "delay", "noise"),
    *("shows_events", "extent", "jump"),
)


def restart_text(shooting: Shooting) -> str:
    """What a result must tell beside its variables, as JSON."""
    common = shooting.system.parameter_values
    records = [
        {
            "label": label,
            "values": {
                name: value
                for name, value in record.system.parameter_values.items()
                if value != common[name]
            },
            "end": float(record.bounds[-1]),
            "is_cycle": record.is_cycle,
            "first_mode": record.first_mode,
            "shift": record.shift,
            "channels": [
                {key: getattr(channel, key) for key in _SENSOR} for channel in record.channels
            ],
        }
        for label, record in zip(shooting.labels, shooting.records, strict=True)
    ]
    free = dict(zip(shooting.records[0].free, shooting.free, strict=True))
    return json.dumps({"free": free, "private": shooting.private, "records": records})


def fitted_shooting(found: Any) -> tuple[Shooting, Floats, Floats]:
    """Equations of a fit, with the unknowns and the noise that it found."""
    if not hasattr(found, "data_vars") or not (
        "restart" in found.attrs and set(_NEEDED) <= set(found.variables)
    ):
        raise OptionError("found: give a result of fit")
    if found.attrs["status"] != "completed":
        raise OptionError(f"found: the fit did not converge: {found.attrs['message']}")
    told = json.loads(found.attrs["restart"])
    try:
        system = System.from_toml(found.attrs["system"])
    except ModelError as fault:
        raise OptionError(f"found: its system cannot be read: {fault}") from None
    free = {name: Range(*each) for name, each in told["free"].items()}
    records, first = [], 0
    for r, entry in enumerate(told["records"]):
        records.append(_record(found, system, free, r, entry, first))
        first += len(entry["channels"])
    labels = [entry["label"] for entry in told["records"]]
    shooting = Shooting(records, list(free.values()), labels, told["private"])
    states = np.array(found["segment_state"].values, float)
    sizes = np.abs(states).max(axis=0)
    shooting.scale_states(np.where(sizes > 0.0, sizes, 1.0))
    u = shooting.join(shooting.head_of(found["estimate"].values), states)
    return shooting, u, np.array(found["noise"].values, float)


def _record(
    found: Any, system: System, free: dict[str, Range], r: int, entry: Entry, first: int
) -> RecordEquations:
    """Equations of one record, whose channels begin with number ``first`` of all."""
    sensors = entry["channels"]
    places = range(first, first + len(sensors))
    sampled = [c for c, each in zip(places, sensors, strict=True) if not each["shows_events"]]
    measured = found["measured"].values
    here = np.flatnonzero(np.isfinite(measured[sampled]).any(axis=0))
    kept = np.where(found["held_back"].values, np.nan, measured)[:, here]
    channels = []
    for c, sensor in zip(places, sensors, strict=True):
        values = _picked(found, c) if sensor["shows_events"] else kept[c]
        ranges = {key: Range(*sensor[key]) for key in ("gain", "offset", "delay", "noise")}
        channels.append(ObservedChannel(**(sensor | ranges), values=values))
    begins = found["segment_time"].values[found["segment_record"].values == r]
    record = RecordEquations(
        system.with_parameters(**entry["values"]) if entry["values"] else system,
        tuple(free), channels, found["time"].values[here], np.append(begins, entry["end"]),
        float(found.attrs["tolerance"]), Range(*entry["shift"]), is_cycle=entry["is_cycle"],
    )  # fmt: skip
    record.first_mode = entry.get("first_mode", ANY)  # results of old files tell none
    return record


def _picked(found: Any, c: int) -> Floats:
    """Events of a channel that were fitted."""
    own = found["picked_channel"].values == c
    held = found["picked_held_back"].values[own]
    return np.where(held, np.nan, found["picked_measured"].values[own])
