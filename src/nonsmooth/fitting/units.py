"""Labels of the records of a fit: units on its variables and beside those of the model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.fitting.channels import ObservedChannel, Range
from nonsmooth.fitting.cuts import GivenRecord
from nonsmooth.runs.labels import labels_of

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["units_of_times", "with_units"]

_SAMPLED = ("measured", "fitted", "residual")
_INSTANTS = (
    *("time", "mark_time", "segment_time"),
    *("picked_measured", "picked_fitted", "picked_residual"),
)
_AS_IT_IS = Range(1.0, 1.0, 1.0)  # a gain that turns no unit into another
_NONE = ("", "1", "-", "dimensionless")
_MICRO = str.maketrans("\N{MICRO SIGN}\N{GREEK SMALL LETTER MU}", "uu")


def with_units(
    found: xr.Dataset, records: Sequence[GivenRecord], datasets: Sequence[Any]
) -> xr.Dataset:
    """A fit with the labels of its records; its message says where units of the model differ.

    Nothing is converted: that a probe reads um says nothing of what the equations are written in.
    """
    channels = [
        (channel, _units(data, channel))
        for record, data in zip(records, datasets, strict=True)
        for channel in record.channels
    ]
    about = {"long_name": "units of the channel"}
    units = np.array([each for _, each in channels], str)
    words = np.array([
        _quantity(record, data, channel)
        for record, data in zip(records, datasets, strict=True)
        for channel in record.channels
    ], str)  # fmt: skip
    quantities = "channel", words, {"long_name": "quantity that the channel shows"}
    found = found.assign(channel_units=("channel", units, about), channel_quantity=quantities)
    _name(found, _SAMPLED, {each for channel, each in channels if not channel.shows_events})
    _name(found, _INSTANTS, {units_of_times(data) for data in datasets})
    told = dict.fromkeys(
        words for record, data in zip(records, datasets, strict=True)
        for words in _differences(record, data)
    )  # fmt: skip
    return found.assign_attrs(message="; ".join([str(found.attrs["message"]), *told]))


def _units(data: Any, channel: ObservedChannel) -> str:
    if channel.shows_events and "units" not in data[channel.name].attrs:
        return units_of_times(data)
    return str(data[channel.name].attrs.get("units", ""))


def _quantity(record: GivenRecord, data: Any, channel: ObservedChannel) -> str:
    """What the record calls a channel, else what the model calls that which it observes."""
    said = str(data[channel.name].attrs.get("long_name", ""))
    if said not in ("", channel.name) or channel.shows_events:
        return said
    system = record.system
    if channel.text not in (*system.states, *system.outputs):
        return ""
    named = labels_of(system).attributes(channel.text).get("long_name", "")
    return "" if named == channel.text else named


def units_of_times(data: Any) -> str:
    """Units of the times of a record; empty where they are not told."""
    return str(data["time"].attrs.get("units", "")) if "time" in data.coords else ""


def _name(found: xr.Dataset, variables: Sequence[str], units: set[str]) -> None:
    """Give variables their units, where these are the same in all of them."""
    if len(units) == 1 and "" not in units:
        for name in variables:
            if name in found.variables:
                found[name].attrs["units"] = next(iter(units))


def _differences(record: GivenRecord, data: Any) -> list[str]:
    """Sentences on units that a record and its model have, and that are not the same."""
    system = record.system
    labels = labels_of(system)
    told = []
    for channel in record.channels:
        if channel.shows_events or channel.text not in (*system.states, *system.outputs):
            continue
        ours, theirs = _units(data, channel), labels.attributes(channel.text).get("units", "")
        if channel.gain == _AS_IT_IS and _differ(ours, theirs):
            told.append(
                f"{channel.name} is in {ours} and {channel.text} of the model in {theirs}, with a"
                " gain of 1: give gain=, or both in one unit"
            )
    ours, theirs = units_of_times(data), labels.attributes("time").get("units", "")
    if _differ(ours, theirs):
        told.append(
            f"times of the record are in {ours} and those of the model in {theirs}: give both in"
            " one unit"
        )
    return told


def _differ(one: str, other: str) -> bool:
    """Whether two units are told and differ; the sign of a millionth may be written as u."""
    one, other = (each.translate(_MICRO).strip() for each in (one, other))
    return one != other and not {one, other} & set(_NONE)
