"""The map of one coordinate: images, slopes, jumps between starts, and how much it leaves open."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.family import Coordinate, SectionStarts, StartFamily
from nonsmooth.analysis.returns.images import Images, Imaging, settle
from nonsmooth.engine.lanes import ANY, GOES_ON, Anchor, allocate_columns, allocate_records, run
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.outputs import StateRates
from nonsmooth.runs.runner import build_derivatives

__all__ = [
    "JUMP",
    "MappedStarts",
    "ReducedMap",
    "Tangents",
    "deviations_of_family",
    "deviations_of_points",
    "extent_of",
    "hidden_jumps",
    "joined",
    "relative",
    "some_values",
]

Floats = npt.NDArray[np.float64]

Integers = npt.NDArray[np.int64]

_TOGETHER = 512  # starts at once, which bounds the memory of their event logs

JUMP = 1e-6  # of the range of images; within rounding of a place only a jump moves them so far
_STRANGE = 8.0  # how much more than most pairs of starts one may differ from its slopes
_LEAST = 1e-6  # of the range, which slopes leave open in any case
_MOST = 64  # pairs that are looked at
_HALVINGS = 60
_CONSTANT = 1e-6  # beside images; a smaller range is not told from none
_WIDTH = 8.0 * float(np.finfo(float).eps)


class Tangents:
    """Derivatives of the images of starts.

    A start a little later is a point a little later, so that time is a coordinate of points of a
    section: a shift along the motion changes nothing. Points of a stroboscopic map are all at one
    time, and have zeros there.
    """

    def __init__(self, imaging: Imaging) -> None:
        self.imaging = imaging
        engine = imaging.engine
        self.derivatives = build_derivatives(engine.system, engine.tables, ())
        self.rates = StateRates(imaging.chosen.system, engine.tables, imaging.origin)
        self.knots = bool(imaging.chosen.system.signals)

    def of(self, starts: SectionStarts, images: Images) -> Floats:
        """Derivatives at starts, nan where there is no image.

        shapes: returns (L, n + 1, n + 1), time last
        """
        count, n = starts.states.shape
        found = np.full((count, n + 1, n + 1), np.nan)
        there = np.flatnonzero(images.there)
        if not there.size:
            return found
        some = self.imaging.prepared(starts.some(there))
        engine, tolerance = self.imaging.engine, self.imaging.tolerance
        begun = settle(engine, some, tolerance, self.derivatives)
        entry = np.tile(np.eye(n), (there.size, 1, 1))
        through = np.flatnonzero(begun.passed)
        if through.size:  # begin again behind what was passed at the start
            entry[through] = begun.columns[through, :, :n].transpose(0, 2, 1)
            anchors = begun.anchors
            behind = SectionStarts(
                anchors.state[through], anchors.place["number"][through],
                anchors.place["phase"][through], anchors.place["mode"][through, None],
            )  # fmt: skip
            again = settle(engine, behind, tolerance, self.derivatives)
            anchors.put(through, again.anchors)
            begun.columns[through] = again.columns
        anchors = begun.anchors
        first = self.rates.of_many(
            anchors.place["number"], anchors.place["phase"], anchors.place["mode"], anchors.state
        )
        with np.errstate(invalid="ignore"):  # slopes without bound where a motion just touches
            for k, i in enumerate(there):
                whole = self._to_image(begun.anchor(k), begun.columns[k], images, int(i))
                found[i, :, :n] = whole @ entry[k]
                # the motion from a later start is that from a start as much behind on the way
                found[i, :, n] = -whole @ first[k] if self.imaging.at_rows else 0.0
        return found

    def _to_image(self, anchor: Anchor, columns: Floats, images: Images, i: int) -> Floats:
        """States and time of an image by the states behind the start; (n + 1, n)."""
        engine, at_rows = self.imaging.engine, self.imaging.at_rows
        n, rows = anchor.state.size, int(images.n_rows[i])
        tangent = allocate_columns(engine.sizes, n, 1)
        tangent.columns[:] = columns
        end = Instant(int(images.number[i]), float(images.phase[i]))
        # a log that is full behind the image
        records = allocate_records(
            engine.sizes, np.array([end.number]), np.array([end.phase]), rows + 1 if at_rows else 0
        )
        far = Instant(end.number + 1, 0.0) if at_rows else end
        rates, scratch = self.derivatives.rates, self.derivatives.scratch
        lane = (engine.tables, rates, scratch, anchor, engine.segment, tangent)
        status = run(lane, records, GOES_ON, far, self.imaging.tolerance)
        if not at_rows:
            return np.vstack([tangent.samples[0].T, np.zeros(n)])
        if status != Status.BUFFER_FULL:
            return np.full((n + 1, n), np.nan)
        side = self.imaging.side
        row, state = records.events[rows - 1], records.event_states[rows - 1, side]
        now = (tangent.now, tangent.columns)[side][:, :n].T
        # the moment of a knot of a signal is known, so nothing shifts it
        at_knot = self.knots and row["guard_rate"] == 0.0
        shift = np.zeros(n) if at_knot else -tangent.shifts[0]
        rate = self.rates.at(end, int(row[("from_mode", "to_mode")[side]]), state)
        return np.vstack([now + np.outer(rate, shift), shift])


class MappedStarts(NamedTuple):
    """The map at some values."""

    values: Floats  # (L,)
    starts: SectionStarts
    images: Images
    image: Floats  # (L,) coordinate of the images
    slope: Floats  # (L,) nan where it was not asked for


class ReducedMap:
    """The map of a family of starts."""

    def __init__(
        self,
        coordinate: Coordinate,
        family: StartFamily,
        imaging: Imaging,
        report: Callable[[int], None] = lambda _: None,
    ) -> None:
        """``report`` is told of how many values the map was taken since it was told last."""
        self.coordinate, self.family, self.imaging = coordinate, family, imaging
        self.tangents = Tangents(imaging)
        self.report = report

    def at(self, values: Floats, *, slopes: bool = True) -> MappedStarts:
        """The map at some values of the coordinate."""
        parts = []
        for first in range(0, max(values.size, 1), _TOGETHER):
            parts.append(self._at(values[first : first + _TOGETHER], slopes=slopes))
            self.report(parts[-1].values.size)
        return parts[0] if len(parts) == 1 else joined(parts)

    def _at(self, values: Floats, *, slopes: bool) -> MappedStarts:
        starts = self.family.starts(values)
        images = self.imaging.images(starts)
        image = self.coordinate.of(images.states, images.phase)
        slope = np.full(values.size, np.nan)
        if slopes:
            whole = self.tangents.of(starts, images)
            direction = self.family.directions(values)
            slope = np.einsum("lj,lj->l", whole[:, self.coordinate.place], direction)
            if self.coordinate.is_phase:
                # a reset at the start may itself depend on time
                slope[images.jumped] = np.nan
        return MappedStarts(values, starts, images, image, slope)

    def second_images(self, branch: MappedStarts) -> tuple[Floats, Floats]:
        """Coordinates two images on: by the motion, and by the map of the coordinate; (L,) each."""
        onward = np.full(branch.values.size, np.nan)
        again = onward.copy()
        all_there = np.flatnonzero(branch.images.there)
        for first in range(0, all_there.size, _TOGETHER):
            there = all_there[first : first + _TOGETHER]
            images = self.imaging.images(starts_of_images(branch.images, there, self.imaging))
            onward[there] = self.coordinate.of(images.states, images.phase)
            again[there] = self.at(branch.image[there], slopes=False).image
        return onward, again


def joined(parts: list[MappedStarts]) -> MappedStarts:
    """Parts of a map, one after the other."""
    starts = [np.concatenate(each) for each in zip(*(part.starts for part in parts), strict=True)]
    images = [np.concatenate(each) for each in zip(*(part.images for part in parts), strict=True)]
    single = ("values", "image", "slope")
    values, image, slope = (np.concatenate([getattr(p, n) for p in parts]) for n in single)
    return MappedStarts(values, SectionStarts(*starts), Images(*images), image, slope)


def some_values(branch: MappedStarts, chosen: npt.NDArray[Any]) -> MappedStarts:
    """The map at some of its values."""
    return MappedStarts(
        branch.values[chosen],
        branch.starts.some(chosen),
        Images(*(part[chosen] for part in branch.images)),
        branch.image[chosen],
        branch.slope[chosen],
    )


def starts_of_images(images: Images, chosen: Integers, imaging: Imaging) -> SectionStarts:
    """Starts at some of the images."""
    number, phase = images.number[chosen], images.phase[chosen]
    if not imaging.at_rows:  # the motion is the same from any period on
        number = np.full(chosen.size, imaging.begin.number)
        phase = np.full(chosen.size, imaging.begin.phase)
    modes = images.modes[chosen, None]
    return SectionStarts(
        images.states[chosen], number, phase, np.hstack([modes, np.full_like(modes, ANY)])
    )


def extent_of(image: Floats) -> float:
    """Range of images; of those that are all one but for rounding, something above that."""
    finite = image[np.isfinite(image)]
    if not finite.size:
        return 1.0
    size = float(np.abs(finite).max())
    return max(float(np.ptp(finite)), _CONSTANT * size) or 1.0


def hidden_jumps(
    reduced: ReducedMap, branch: MappedStarts, same: npt.NDArray[np.bool_]
) -> tuple[Floats, Floats]:
    """Pairs of values between which the map jumps; ``same`` are pairs in one piece so far.

    Where images differ from what slopes on both sides tell, the half with more of the change is
    kept, until it is gone or the interval is.
    """
    change = reduced.coordinate.change
    values, image, slope = branch.values, branch.image, branch.slope
    there = branch.images.there
    extent, span = extent_of(image), float(np.ptp(values))
    rise = change(np.diff(image))
    told = 0.5 * np.diff(values) * (slope[1:] + slope[:-1])
    off = np.where(np.isfinite(told), np.abs(rise - told), np.abs(rise))
    inner = same & there[1:] & there[:-1] & np.isfinite(off)
    usual = float(np.median(off[inner])) if inner.any() else 0.0
    pairs = np.flatnonzero(inner & (off > max(_STRANGE * usual, _LEAST * extent)))
    pairs = pairs[np.argsort(-off[pairs], kind="stable")][:_MOST]
    low, high = values[pairs], values[pairs + 1]
    left, right = image[pairs], image[pairs + 1]
    for _ in range(_HALVINGS):
        wide = high - low > _WIDTH * (np.abs(low) + span)
        kept = np.isfinite(left + right) & (np.abs(change(right - left)) > JUMP * extent)
        low, high, left, right = (part[kept] for part in (low, high, left, right))
        wide = wide[kept]
        if not wide.any():
            break
        middle = 0.5 * (low + high)
        found = reduced.at(middle, slopes=False).image
        first = np.abs(change(found - left)) > np.abs(change(right - found))
        high, right = np.where(wide & first, middle, high), np.where(wide & first, found, right)
        low, left = np.where(wide & ~first, middle, low), np.where(wide & ~first, found, left)
    order = np.argsort(low)
    return low[order], high[order]


def deviations_of_family(reduced: ReducedMap, branch: MappedStarts) -> Floats:
    """By how much the second image of the motion is off that which the map itself gives; (L,).

    The first image does not lie on the family. What the map makes of it is the image of the start
    that has its coordinate.
    """
    onward, again = reduced.second_images(branch)
    return reduced.coordinate.change(onward - again)


def deviations_of_points(coordinate: Coordinate, branch: MappedStarts) -> Floats:
    """By how much each image is off the line between those of the two neighbours in the coordinate.

    On a curve that is little and grows less with more points.
    """
    found = np.full(branch.values.size, np.nan)
    here = np.flatnonzero(branch.images.there)
    here = here[np.argsort(branch.values[here], kind="stable")]
    if here.size < 3:
        return found
    x, image = branch.values[here], branch.image[here]
    left, right = (
        coordinate.change(image[:-2] - image[1:-1]),
        coordinate.change(image[2:] - image[1:-1]),
    )
    width = x[2:] - x[:-2]
    share = np.divide(x[1:-1] - x[:-2], width, out=np.full(width.size, 0.5), where=width > 0.0)
    found[here[1:-1]] = -(left + share * (right - left))
    return found


def relative(
    coordinate: Coordinate, branch: MappedStarts, deviations: Floats
) -> tuple[float, float]:
    """Median and largest deviation beside the range of the images; nan where there is none."""
    finite = np.abs(deviations[np.isfinite(deviations)])
    if not finite.size:
        return np.nan, np.nan
    extent = extent_of(branch.image)
    if coordinate.turn is not None:
        extent = min(extent, 0.5 * coordinate.turn)
    return float(np.median(finite)) / extent, float(finite.max()) / extent
