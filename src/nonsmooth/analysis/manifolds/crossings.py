"""Where an unstable manifold crosses a stable one: found on the curves, refined by the map."""

from __future__ import annotations

from collections import defaultdict
from itertools import product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.manifolds.curve import Curve
from nonsmooth.analysis.manifolds.manifold_dataset import CurveOfSide
from nonsmooth.analysis.manifolds.passage import Passage
from nonsmooth.analysis.manifolds.saddle import Saddle
from nonsmooth.runs.whole_turns import periods_of_states

__all__ = ["Curves", "ManifoldCrossing", "find_crossings"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

_AT_ONCE = 256  # pieces of one curve that are compared with all of the other
_SAMPLES = 33  # places at which a sign is looked for beside a crossing of pieces
_APART = ("jump", "end", "unresolved")  # borders over which a curve does not go on
_SAME = 1e-9  # of a place: crossings that are one
_ROUND = 1e-9  # of a turn, which rounding may put a curve beyond its end
_SHARP = 3.0  # largest steps that a refined crossing lies from that of the pieces, at most


class Curves(NamedTuple):
    """Curves of one manifold of a saddle."""

    saddle: Saddle
    branches: list[CurveOfSide]
    step: float  # largest distance of neighbours


class ManifoldCrossing(NamedTuple):
    """A point of both manifolds."""

    passage: Passage
    out: int  # number of the unstable curve
    into: int  # number of the stable curve
    place: float  # on the first piece of the unstable one
    state: Floats
    angle: float
    sense: float  # 1 or -1: in which direction the stable one is crossed
    error: float  # along the curve, in scaled states
    length: float  # of the first piece of the unstable one
    reach: float  # of that of the stable one, with the sign of its side


class _Met(NamedTuple):
    """Pieces that cross: numbers of their first points, and where on the unstable one."""

    out: Integers
    into: Integers
    part: Floats


def find_crossings(unstable: Curves, stable: Curves) -> tuple[list[ManifoldCrossing], int]:
    """All crossings in the order of the unstable curves, and how many could not be refined."""
    found: list[ManifoldCrossing] = []
    lost = 0
    for i, out in enumerate(unstable.branches):
        for j, into in enumerate(stable.branches):
            for shift in _shifts(unstable, stable, out, into):
                some, failed = _of_curves(unstable, stable, (i, j), (out, into), shift)
                found += some
                lost += failed
    return sorted(found, key=lambda each: (each.out, each.passage.images, each.place)), lost


def _shifts(unstable: Curves, stable: Curves, out: CurveOfSide, into: CurveOfSide) -> list[Floats]:
    """Whole turns of angles by which one curve lies, in part, beyond the other; (n,) each.

    The stable manifold comes to each copy of its orbit, whole turns apart.
    """
    periods = periods_of_states(stable.saddle.chosen.system)
    at = np.flatnonzero(periods)
    if not at.size:
        return [np.zeros(periods.size)]
    own = unstable.saddle.points[out.number].here.coordinates.states(out.curve.points)[:, at]
    other = stable.saddle.points[into.number].here.coordinates.states(into.curve.points)[:, at]
    first = np.ceil((own.min(axis=0) - other.max(axis=0)) / periods[at] - _ROUND)
    last = np.floor((own.max(axis=0) - other.min(axis=0)) / periods[at] + _ROUND)
    found = []
    for turns in product(*(np.arange(a, b + 1.0) for a, b in zip(first, last, strict=True))):
        found.append(np.zeros(periods.size))
        found[-1][at] = np.array(turns) * periods[at]
    return found


def _of_curves(
    unstable: Curves, stable: Curves, numbers: tuple[int, int],
    curves: tuple[CurveOfSide, CurveOfSide], shift: Floats,
) -> tuple[list[ManifoldCrossing], int]:  # fmt: skip
    """Crossings of one curve with another, as far as that lies whole turns beside it."""
    out, into = curves
    frame = stable.saddle.points[into.number].here.coordinates
    own = unstable.saddle.points[out.number].here.coordinates
    points = frame.points(own.states(out.curve.points) - shift)
    met = _meet(points, _cuts(out.curve), into.curve.points, _cuts(into.curve))
    # both begin at the saddle
    first = (out.curve.images[met.out + 1] == 0) & (into.curve.images[met.into + 1] == 0)
    met = _Met(*(column[~first] for column in met))
    groups: dict[tuple[int, int], list[int]] = defaultdict(list)
    aheads = np.maximum(into.curve.images[met.into], into.curve.images[met.into + 1])
    images = out.curve.images[met.out + 1]
    for k, key in enumerate(zip(images.tolist(), aheads.tolist(), strict=True)):
        groups[key].append(k)
    found: list[ManifoldCrossing] = []
    lost = 0
    for (count, ahead), members in groups.items():
        passage = Passage(
            unstable.saddle.points[out.number], out.first.side,
            stable.saddle.points[into.number], count, ahead, shift,
        )  # fmt: skip
        chosen = np.array(members)
        low, high, expected = _brackets(out, unstable.saddle.multiplier, met, chosen)
        near = points[met.out[chosen]]
        some = _refined(passage, low, high, expected)
        for place, width, close in zip(*some, near, strict=True):
            ends = out.first.length, into.first.side * into.first.length
            one = _crossing(passage, numbers, place, width, ends)
            here = None if one is None else frame.points(one.state[None] - shift)[0]
            if one is None or np.linalg.norm(here - close) > _SHARP * unstable.step:
                lost += 1
            elif not any(_is_same(one, other) for other in found):
                found.append(one)
    return found, lost


def _is_same(one: ManifoldCrossing, other: ManifoldCrossing) -> bool:
    return one.passage.images == other.passage.images and bool(
        abs(one.place - other.place) <= _SAME * one.place
    )


def _cuts(curve: Curve) -> Bools:
    """Pieces that are none, as the curve goes on elsewhere."""
    cut = np.zeros(max(len(curve.points) - 1, 0), bool)
    places = [b.place for b in curve.borders if b.kind in _APART and b.place < cut.size]
    cut[places] = True
    return cut


def _meet(out: Floats, out_cut: Bools, into: Floats, into_cut: Bools) -> _Met:
    """Pieces of two broken lines in the plane that cross; shapes: (P, 2) and (Q, 2)."""
    step = np.diff(into, axis=0)
    low, high = np.minimum(into[:-1], into[1:]), np.maximum(into[:-1], into[1:])
    rows: list[Integers] = []
    columns: list[Integers] = []
    parts: list[Floats] = []
    for begin in range(0, len(out) - 1, _AT_ONCE):
        a = out[begin : begin + _AT_ONCE + 1]
        arc = np.diff(a, axis=0)
        near = np.ones((len(arc), len(step)), bool)
        for axis in range(2):
            ends = np.sort(np.stack([a[:-1, axis], a[1:, axis]]), axis=0)
            near &= (ends[0][:, None] <= high[None, :, axis]) & (
                ends[1][:, None] >= low[None, :, axis]
            )
        near &= ~out_cut[begin : begin + len(arc), None] & ~into_cut[None]
        i, k = np.nonzero(near)
        gap = into[k] - a[i]
        with np.errstate(invalid="ignore", divide="ignore"):
            area = arc[i, 0] * step[k, 1] - arc[i, 1] * step[k, 0]
            on_out = (gap[:, 0] * step[k, 1] - gap[:, 1] * step[k, 0]) / area
            on_into = (gap[:, 0] * arc[i, 1] - gap[:, 1] * arc[i, 0]) / area
        hit = (on_out >= 0.0) & (on_out <= 1.0) & (on_into >= 0.0) & (on_into <= 1.0)
        rows.append(begin + i[hit])
        columns.append(k[hit])
        parts.append(on_out[hit])
    if not rows:
        return _Met(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))
    return _Met(np.concatenate(rows), np.concatenate(columns), np.concatenate(parts))


def _brackets(
    out: CurveOfSide, multiplier: float, met: _Met, chosen: Integers
) -> tuple[Floats, Floats, Floats]:
    """Places a piece before and behind those that cross, and where the crossing is expected."""
    places, images = out.curve.places, out.curve.images
    assert places is not None  # every unstable curve has them
    last = len(places) - 1

    def at(number: Integers, image: Integers) -> Floats:
        """Places of points, as of the given image: those of the one before are larger."""
        behind = image - images[number]
        return places[number] / multiplier ** behind.astype(float)

    i = met.out[chosen]
    image = images[i + 1]
    low, high = at(i, image), at(i + 1, image)
    expected = low + met.part[chosen] * (high - low)
    before = at(np.maximum(i - 1, 0), image)
    behind = np.minimum(i + 2, last)
    after = np.where(images[behind] == image, places[behind], high)
    return before, after, expected


def _refined(
    passage: Passage, low: Floats, high: Floats, expected: Floats
) -> tuple[Floats, Floats]:
    """Places of crossings nearest to those expected, and their brackets; nan where none is."""
    places = low[:, None] + np.linspace(0.0, 1.0, _SAMPLES) * (high - low)[:, None]
    signs = np.sign(passage.across(places.ravel())).reshape(places.shape)
    changes = (signs[:, 1:] != signs[:, :-1]) & np.isfinite(signs[:, 1:] + signs[:, :-1])
    middle = 0.5 * (places[:, 1:] + places[:, :-1])
    away = np.where(changes, np.abs(middle - expected[:, None]), np.inf)
    best, there = np.argmin(away, axis=1), changes.any(axis=1)
    rows = np.arange(low.size)
    found, widths = np.full(low.size, np.nan), np.full(low.size, np.nan)
    if there.any():
        root = passage.roots(places[rows, best][there], places[rows, best + 1][there])
        found[there], widths[there] = root
    return found, widths


def _crossing(
    passage: Passage, curves: tuple[int, int], place: float, width: float,
    ends: tuple[float, float],
) -> ManifoldCrossing | None:  # fmt: skip
    if not np.isfinite(place):
        return None
    states = passage.states(np.array([place, place + width]))
    if not np.isfinite(states).all():
        return None
    frame = passage.into.here.coordinates
    error = float(np.linalg.norm(np.diff(frame.points(states), axis=0)))
    angle, sense = passage.angle(place)
    return ManifoldCrossing(passage, *curves, float(place), states[0], angle, sense, error, *ends)
