"""A return map as a dataset."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.coordinate import Coordinate
from nonsmooth.analysis.returns.images import Imaging
from nonsmooth.analysis.returns.reduced_map import Branch
from nonsmooth.engine.status import Status
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.maps import Map
from nonsmooth.version import __version__

__all__ = [
    "BorderTable",
    "Reduction",
    "common_attributes",
    "over_borders",
    "over_fixed",
    "over_starts",
]

Floats = npt.NDArray[np.float64]


class BorderTable(NamedTuple):
    """Borders with the map on both sides."""

    low: Branch
    high: Branch
    kinds: list[str]


class Reduction(NamedTuple):
    """How one-dimensional the map is."""

    deviations: Floats
    median: float
    largest: float


def over_starts(
    imaging: Imaging, coordinate: Coordinate, branch: Branch, piece: Any, reduction: Reduction
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables and coordinates over ``start``."""
    images, starts, system = branch.images, branch.starts, imaging.chosen.system
    words, label = dict(coordinate.words), coordinate.words["long_name"]
    time = labels_of(system).attributes("time")
    length = (images.number - starts.number) * imaging.window + (images.phase - starts.phase)
    statuses = [Status(int(code)).word for code in images.status]
    variables: dict[str, Any] = {
        "image": ("start", branch.image, {**words, "long_name": f"{label}, at the image"}),
        "slope": ("start", branch.slope, {"long_name": "derivative of the image by the start"}),
        "deviation": ("start", reduction.deviations, {
            **words, "long_name": "what the coordinate alone does not tell of an image"}),
        "return_time": ("start", np.where(images.there, length, np.nan), {
            **time, "long_name": "time from the start to the image"}),
        "word": ("start", images.words, {"long_name": "modes on the way"}),
        "exits": ("start", images.exits, {"long_name": "exits passed on the way"}),
        "n_events": ("start", images.n_events, {"long_name": "events on the way"}),
        "certified": ("start", images.certified & images.there, {
            "long_name": "whether rounding leaves no doubt about the events"}),
        "status": ("start", np.array(statuses), {"long_name": "how the way to the image ended"}),
        "piece": ("start", piece, {
            "long_name": "part of the map without a border, from 0; -1 without an image"}),
        "start_state": (("start", "state"), images.begun, {
            "long_name": "states at the start"}),
        "image_state": (("start", "state"), images.states, {"long_name": "states at the image"}),
        "spread": ((), reduction.median, {
            "long_name": "median of the deviations over the range of the images"}),
        "largest_spread": ((), reduction.largest, {
            "long_name": "largest deviation over the range of the images"}),
    }  # fmt: skip
    if coordinate.turn is not None:
        turn = {**words, "long_name": "length after which the coordinate begins anew"}
        variables["turn"] = ((), coordinate.turn, turn)
    coords = {
        "start": ("start", branch.values, words),
        "state": ("state", np.array(system.states), {"long_name": "state"}),
    }
    return variables, coords


def over_borders(coordinate: Coordinate, table: BorderTable) -> dict[str, Any]:
    """Variables over ``border``."""
    words, label = dict(coordinate.words), coordinate.words["long_name"]
    low, high = table.low, table.high
    return {
        "border_start": ("border", 0.5 * (low.values + high.values), {
            **words, "long_name": f"{label}, at a border"}),
        "border_kind": ("border", np.array(table.kinds, dtype=str), {
            "long_name": "what the map does at a border"}),
        "image_before": ("border", low.image, {
            **words, "long_name": f"{label}, at the image of a start just below"}),
        "image_after": ("border", high.image, {
            **words, "long_name": f"{label}, at the image of a start just above"}),
        "exits_before": ("border", low.images.exits, {"long_name": "exits passed just below"}),
        "exits_after": ("border", high.images.exits, {"long_name": "exits passed just above"}),
    }  # fmt: skip


def over_fixed(coordinate: Coordinate, fixed: Branch, deviations: Floats) -> dict[str, Any]:
    """Variables over ``fixed_point``."""
    words, label = dict(coordinate.words), coordinate.words["long_name"]
    return {
        "fixed_start": ("fixed_point", fixed.values, {
            **words, "long_name": f"{label}, at a fixed point"}),
        "fixed_slope": ("fixed_point", fixed.slope, {"long_name": "derivative at a fixed point"}),
        "fixed_stable": ("fixed_point", np.abs(fixed.slope) < 1.0, {
            "long_name": "whether the map of one coordinate is stable there"}),
        "fixed_deviation": ("fixed_point", deviations, {
            **words, "long_name": "what the coordinate alone does not tell at a fixed point"}),
        "fixed_word": ("fixed_point", fixed.images.words, {"long_name": "modes on the way"}),
        "fixed_state": (("fixed_point", "state"), fixed.images.begun, {
            "long_name": "states at a fixed point"}),
    }  # fmt: skip


def common_attributes(
    chosen: Map, coordinate: Coordinate, branch: Branch, options: dict[str, Any]
) -> dict[str, Any]:
    """Attributes of a result, with how it ended."""
    system = chosen.system
    attrs = {
        "system_name": system.name,
        "system": labels_of(system).system,
        "nonsmooth_version": __version__,
        "status": "completed",
        "variable": coordinate.name,
        **chosen.protocol,
        **options,
    }
    if system.period_value is not None:
        attrs["period"] = system.period_value
    lost = branch.images.status[~branch.images.there]
    counts = {Status(int(code)).word: int(np.sum(lost == code)) for code in np.unique(lost)}
    attrs["message"] = "completed"
    if counts:
        told = ", ".join(f"{count} {word}" for word, count in counts.items())
        attrs["message"] = f"starts without an image, see status: {told}"
    return attrs
