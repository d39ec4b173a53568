"""Curves of a manifold as a dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nonsmooth.analysis.manifolds.curve import Curve
from nonsmooth.analysis.manifolds.first_segment import FirstSegment
from nonsmooth.analysis.manifolds.saddle import Saddle
from nonsmooth.analysis.options import result_attributes
from nonsmooth.runs.labels import labels_of

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["CurveOfSide", "manifold_dataset"]

_ENDS = {
    "points": "has as many points as steps= allows",
    "images": "is longest= images of its first piece long",
    "attractor": "has come to its end at an attractor",
    "no_image": "ends, as motions from there come to no further point of the map",
    "no_preimage": "ends, as no start within largest_step= of its last point has an image on it",
    "not_located": "ends, as further points could not be put onto the manifold",
    "interrupted": "was interrupted",
}


class CurveOfSide(NamedTuple):
    """One side of the manifold at one point of the orbit."""

    number: int  # of the point of the orbit
    first: FirstSegment
    curve: Curve


def manifold_dataset(
    saddle: Saddle, branches: list[CurveOfSide], options: dict[str, Any], *, complete: bool
) -> xr.Dataset:
    """Dataset of all curves, one after the other."""
    import xarray as xr

    system = saddle.chosen.system
    message = _message(branches, complete)
    status = "completed" if complete else "interrupted"
    variables, coords = _over_points(saddle, branches)
    variables |= _over_borders(branches) | _over_curves(saddle, branches)
    for name in system.angles:
        turned = float(saddle.turns[system.states.index(name)]) / saddle.period
        words = {"long_name": f"{name}, per iterate of the orbit"}
        variables[f"{name}_per_iterate"] = ((), turned, words)
    words = {"long_name": "multipliers of the orbit, the largest first"}
    variables["multipliers"] = ("multiplier", saddle.multipliers, words)
    attrs = {
        "period": saddle.period,
        "sides_alternate": int(saddle.flips),
        "multiplier": float(saddle.multiplier),
        "residual": saddle.residual,
        **options,
    }
    return xr.Dataset(variables, coords, result_attributes(system, status, message, attrs))


def _over_points(
    saddle: Saddle, branches: list[CurveOfSide]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables over ``point``."""
    system = saddle.chosen.system
    labels = labels_of(system)
    counts = [len(branch.curve.points) for branch in branches]
    frames = [saddle.points[branch.number].here.coordinates for branch in branches]
    states = [
        frame.states(branch.curve.points) for frame, branch in zip(frames, branches, strict=True)
    ]
    whole = np.concatenate(states) if states else np.zeros((0, len(system.states)))
    marks = [_marks(branch.curve) for branch in branches]
    active = saddle.points[0].here.coordinates.active

    def joined(parts: list[Any], kind: Any) -> Any:
        return np.concatenate(parts) if parts else np.zeros(0, kind)

    variables: dict[str, Any] = {
        system.states[i]: ("point", whole[:, i], labels.attributes(system.states[i]))
        for i in active
    }
    variables |= {
        "arclength": ("point", joined([b.curve.arclength for b in branches], float), {
            "long_name": "length of the curve from the orbit, in scaled states"}),
        "image": ("point", joined([b.curve.images for b in branches], int), {
            "long_name": "applications of the map between the point and the first piece"}),
        "word": ("point", joined([b.curve.words for b in branches], str), {
            "long_name": "modes on the way to or from the point"}),
        "border": ("point", joined(marks, str), {
            "long_name": "kind of the border at which the point lies"}),
    }  # fmt: skip
    sides = np.repeat([int(branch.first.side) for branch in branches], counts)
    numbers = np.repeat([branch.number for branch in branches], counts)
    curves = np.repeat(np.arange(len(branches)), counts)
    coords = {
        "curve_of_point": ("point", curves.astype(int), {"long_name": "number of the curve"}),
        "side": ("point", sides.astype(int), {"long_name": "side of the orbit"}),
        "orbit_point": ("point", numbers.astype(int), {
            "long_name": "iterate of the orbit from which the curve comes"}),
    }  # fmt: skip
    return variables, coords


def _marks(curve: Curve) -> Any:
    marks = np.full(len(curve.points), "", dtype="<U10")
    for border in curve.borders:
        marks[border.place : border.place + 2] = border.kind
    return marks


def _over_borders(branches: list[CurveOfSide]) -> dict[str, Any]:
    """Variables over ``at_border``."""
    begins = np.cumsum([0, *(len(branch.curve.points) for branch in branches)])
    rows = [
        (int(begin) + border.place, border.kind, border.turn, border.gap)
        for begin, branch in zip(begins, branches, strict=False)
        for border in branch.curve.borders
    ]
    points, kinds, turns, gaps = zip(*rows, strict=True) if rows else ((), (), (), ())
    dim = "at_border"
    return {
        "border_point": (dim, np.array(points, int), {
            "long_name": "number of the first of the two points at the border"}),
        "border_kind": (dim, np.array(kinds, str), {"long_name": "what happens at the border"}),
        "border_turn": (dim, np.array(turns, float), {
            "long_name": "angle by which the curve turns", "units": "rad"}),
        "border_gap": (dim, np.array(gaps, float), {
            "long_name": "distance of the two points at the border, in scaled states"}),
    }  # fmt: skip


def _over_curves(saddle: Saddle, branches: list[CurveOfSide]) -> dict[str, Any]:
    """Variables over ``curve``."""
    system = saddle.chosen.system
    names = np.array([system.states[i] for i in saddle.points[0].here.coordinates.active])
    origins, directions = np.zeros((2, len(branches), names.size))
    for k, branch in enumerate(branches):
        point = saddle.points[branch.number]
        frame = point.here.coordinates
        origins[k] = frame.origin[frame.active]
        directions[k] = branch.first.side * (frame.basis @ point.direction) * frame.scales
    return {
        "state": ("state", names, {"long_name": "state"}),
        "curve_side": ("curve", np.array([int(b.first.side) for b in branches]), {
            "long_name": "side of the orbit"}),
        "curve_orbit_point": ("curve", np.array([b.number for b in branches]), {
            "long_name": "iterate of the orbit from which the curve comes"}),
        "curve_end": ("curve", np.array([b.curve.ended for b in branches], str), {
            "long_name": "why the curve ends"}),
        "first_length": ("curve", np.array([b.first.length for b in branches]), {
            "long_name": "length of the straight first piece, in scaled states"}),
        "first_deviation": ("curve", np.array([b.first.deviation for b in branches]), {
            "long_name": "deviation of the manifold from the first piece, in scaled states"}),
        "saddle": (("curve", "state"), origins, {"long_name": "point of the orbit"}),
        "saddle_direction": (("curve", "state"), directions, {
            "long_name": "direction in which the curve begins"}),
    }  # fmt: skip


def _message(branches: list[CurveOfSide], complete: bool) -> str:
    told = []
    if not complete:
        told.append("interrupted by the user; the curves found until then are kept")
    for k, branch in enumerate(branches):
        if branch.curve.ended in _ENDS and branch.curve.ended != "interrupted":
            told.append(f"curve {k} {_ENDS[branch.curve.ended]}")
    borders = [border.kind for branch in branches for border in branch.curve.borders]
    if borders.count("unresolved"):
        told.append(f"{borders.count('unresolved')} borders were not located to rounding")
    return "; ".join(told) or "completed"
