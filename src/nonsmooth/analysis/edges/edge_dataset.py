"""The motion on a border of basins as a dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor_search import ENDED
from nonsmooth.analysis.edges.straddle import Straddle
from nonsmooth.analysis.edges.track import Edge
from nonsmooth.analysis.options import result_attributes
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.maps import Map
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.whole_turns import whole_turns

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["edge_dataset"]

# least unit of a distance, beside the spread of the states: what is smaller is rounding
_UNIT = 1e-6

Floats = npt.NDArray[np.float64]


def edge_dataset(
    chosen: Map,
    straddle: Straddle,
    found: Edge,
    ends: Floats,
    options: dict[str, Any],
    tolerance: float,
) -> xr.Dataset:
    """Dataset of a track, and of the saddle or the set to which it has come."""
    import xarray as xr

    system = chosen.system
    labels = labels_of(system)
    track = found.track
    points, modes = _set_of(found, len(system.states))
    known = [mode if mode >= 0 else -1 for mode in modes]
    variables: dict[str, Any] = {
        name: ("point", points[:, k], labels.attributes(name))
        for k, name in enumerate(system.states)
    }
    variables["mode"] = (
        "point", np.array(known, labels.mode_type), labels.mode_flags("mode at the point"),
    )  # fmt: skip
    variables |= _of_set(chosen, straddle, found, points, tolerance)
    variables |= _drift_of_set(chosen, found)
    variables |= {
        "track": (("iterate", "state"), track.points.reshape(-1, len(system.states)), {
            "long_name": "states along the border"}),
        "width": ("iterate", np.array(track.widths), {
            "long_name": "distance of the pair that straddles the border, beside the spread"}),
        "crossing": ((), _place(straddle, ends, found.first.states[0]), {
            "long_name": "part of the way from start a to start b at which the border lies"}),
        "start": (("side", "state"), ends, {"long_name": "start"}),
        **_of_sides(straddle, found, points),
    }  # fmt: skip
    coords: dict[str, Any] = {
        "state": ("state", labels.states),
        "side": ("side", ["a", "b"], {"long_name": "side of the border"}),
        "iterate": ("iterate", np.arange(len(track.widths)), {"long_name": "iterate of the map"}),
    }
    if isinstance(chosen, StroboscopicMap):
        length = system.period_value if chosen.length is None else chosen.length
        coords["time"] = ((), chosen.phase * (length or 0.0), labels.attributes("time"))
    status = "completed" if found.complete else "interrupted"
    attrs = {"levels": straddle.levels, "starts_settled": straddle.starts, **options}
    message = _message(straddle, found, options)
    return xr.Dataset(variables, coords, result_attributes(system, status, message, attrs))


def _set_of(found: Edge, count: int) -> tuple[Floats, list[int]]:
    """Points of the saddle, or those of the later half of a track, with their modes."""
    if found.cycle is not None:
        return found.cycle.points, found.cycle.modes.tolist()
    half = len(found.track.states) // 2
    return found.track.points.reshape(-1, count)[half:], found.track.modes[half:]


def _of_set(
    chosen: Map, straddle: Straddle, found: Edge, points: Floats, tolerance: float
) -> dict[str, Any]:
    """What is known of the saddle, or of the set."""
    cycle, free = found.cycle, int(straddle.search.known.measure.columns.size)
    multipliers, word, residual = np.full(free, np.nan + 0j), "", np.nan
    if cycle is not None:
        assert cycle.multipliers is not None  # every refined cycle has them
        multipliers, residual = cycle.multipliers, cycle.residual
        word = str(
            chosen.runner(tolerance).word(cycle.points[0], int(cycle.modes[0]), cycle.period)
        )
    empty = np.full(points.shape[1], np.nan)
    return {
        "kind": ((), found.kind, {"long_name": "kind of motion on the border"}),
        "period": ((), found.period, {"long_name": "points of the saddle, 0 where none repeats"}),
        "word": ((), word, {"long_name": "modes of one turn of the saddle"}),
        "residual": ((), residual, {"long_name": "distance of the saddle from its image, scaled"}),
        "multipliers": ("multiplier", multipliers, {
            "long_name": "multipliers of the saddle, the largest first"}),
        "exponent": ("exponent_number", found.exponents, {
            "long_name": "largest exponents per iterate, of no saddle"}),
        "exponent_error": ("exponent_number", found.errors, {
            "long_name": "standard error of the exponent"}),
        "mean": ("state", points.mean(axis=0) if len(points) else empty, {
            "long_name": "mean over the points"}),
        "deviation": ("state", points.std(axis=0) if len(points) else empty, {
            "long_name": "standard deviation over the points"}),
    }  # fmt: skip


def _drift_of_set(chosen: Map, found: Edge) -> dict[str, Any]:
    """How far drifts and angles of the saddle go in one iterate; nan of other sets."""
    system = chosen.system
    labels = labels_of(system)
    variables = {}
    for name in system.drift:
        gone = np.nan if found.cycle is None else found.cycle.drift[system.states.index(name)]
        label = labels.attributes(name)["long_name"]
        variables[f"{name}_per_iterate"] = ((), gone, {"long_name": f"{label}, per iterate"})
    return variables


def _of_sides(straddle: Straddle, found: Edge, points: Floats) -> dict[str, Any]:
    """Variables over ``side``: where motions go from there, and how far that is."""
    known = straddle.search.known
    attractors = [
        None if label == ENDED else known.attractors[label - 1]
        for label in found.last.labels.tolist()
    ]
    distances, nearest = np.full(2, np.nan), np.full((2, points.shape[1]), np.nan)
    there = {side: one for side, one in enumerate(attractors) if one is not None and len(points)}
    apart = {}
    for side, one in there.items():
        away = points[:, None] - one.points[None]
        apart[side] = away - whole_turns(away, straddle.periods)
    columns, unit = known.measure.columns, _UNIT * known.measure.scale
    for away in apart.values():
        unit = np.maximum(unit, np.abs(away).max(axis=(0, 1)))
    for side, one in there.items():
        far = np.linalg.norm((apart[side] / unit)[..., columns], axis=2)
        distances[side] = far.min()
        nearest[side] = one.points[int(far.min(axis=0).argmin())]
    kinds = ["ended early" if one is None else one.kind for one in attractors]
    periods = [0 if one is None else one.period for one in attractors]
    return {
        "outcome": ("side", np.array(kinds), {"long_name": "motion on this side"}),
        "outcome_period": ("side", np.array(periods), {
            "long_name": "points of that motion, 0 where none repeats"}),
        "distance": ("side", distances, {
            "long_name": "least distance from that motion, beside the largest along each state"}),
        "nearest": (("side", "state"), nearest, {
            "long_name": "point of that motion that is nearest"}),
    }  # fmt: skip


def _place(straddle: Straddle, ends: Floats, state: Floats) -> float:
    """Part of the way along the segment, measured in scaled states."""
    scaled = straddle.search.known.measure.scaled
    way = (scaled(ends[1:]) - scaled(ends[:1]))[0]
    return float((scaled(state[None]) - scaled(ends[:1]))[0] @ way / (way @ way))


def _message(straddle: Straddle, found: Edge, options: dict[str, Any]) -> str:
    told = []
    if not found.complete:
        told.append("interrupted by the user; the track until then is kept")
    if found.kind == "unresolved":
        told.append(
            f"the track repeats after {found.period} iterates, and Newton's method finds no saddle"
            " there: motions leave a border at once where two flows point away from it, and the"
            " map has no derivative"
        )
    if found.ended:
        told.append(
            "the track stops early: even from next to the border motions end within one iterate"
        )
    if found.track.widths and max(found.track.widths) > options["wide"]:
        told.append(
            f"pairs straddle the border at distances up to {max(found.track.widths):.2g}: no mode"
            " admits starts between them, or the border is not reached by a straight line; give"
            " completion= or other starts"
        )
    if found.complete and found.kind in ("aperiodic", "quasi-periodic", "chaotic"):
        told.append(
            f"the track has not come to a saddle in {len(found.track.widths)} iterates: its points"
            " after the first half are kept as the set on the border"
        )
    return "; ".join(told) or "completed"
