"""A return map of the points of a motion: where each comes to, and along which direction."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.family import Coordinate, SectionStarts
from nonsmooth.analysis.returns.images import Imaging
from nonsmooth.analysis.returns.reduced_map import MappedStarts, Tangents, joined
from nonsmooth.engine.lanes import ANY
from nonsmooth.errors import OptionError
from nonsmooth.runs.clock import instants
from nonsmooth.runs.strobe_times import is_driven

__all__ = ["MappedMotion", "map_of_points"]

Floats = npt.NDArray[np.float64]

_TOGETHER = 512  # points at once
_SAME = 1e-6  # of the spread of each coordinate, within which the next point is the image
_ALIGNED = 1e-9  # angle of two directions that have become one


class MappedMotion(NamedTuple):
    """The map along a motion."""

    branch: MappedStarts
    exponents: Floats  # (2,) per return, nan where points do not follow each other


def map_of_points(
    imaging: Imaging, coordinate: Coordinate, points: Any, report: Any
) -> MappedMotion:
    """The map at points of a motion."""
    starts = _starts(imaging, points)
    tangents = Tangents(imaging)
    parts, matrices = [], []
    for first in range(0, len(starts.states), _TOGETHER):
        some = starts.some(slice(first, first + _TOGETHER))
        images = imaging.images(some)
        matrices.append(tangents.of(some, images))
        image = coordinate.of(images.states, images.phase)
        nothing = np.full(image.size, np.nan)
        parts.append(
            MappedStarts(coordinate.of(some.states, some.phase), some, images, image, nothing)
        )
        report(image.size)
    branch = joined(parts)
    slopes, exponents = _along(imaging, coordinate, branch, np.concatenate(matrices))
    return MappedMotion(branch._replace(slope=slopes), exponents)


def _starts(imaging: Imaging, points: Any) -> SectionStarts:
    """Starts at the points of a dataset."""
    system = imaging.chosen.system
    missing = [name for name in system.states if name not in getattr(points, "data_vars", ())]
    if missing or points[system.states[0]].ndim != 1:
        raise OptionError(
            f"points = {type(points).__name__}: give a dataset of points of one motion, with the"
            f" states {', '.join(system.states)} over one dimension, as poincare_section or"
            " stroboscopic_map give it"
        )
    states = np.column_stack([points[name].values.astype(float) for name in system.states])
    if not len(states) or not np.all(np.isfinite(states)):
        raise OptionError("points: there are none, or some are not finite; drop those first")
    modes = np.full((len(states), 1), ANY, np.int64)
    names = points["mode"].attrs.get("flag_meanings", "").split() if "mode" in points else []
    if names == list(system.mode_names):
        modes = np.column_stack([points["mode"].values.astype(np.int64), modes[:, 0]])
    number = np.full(len(states), imaging.begin.number)
    phase = np.full(len(states), imaging.begin.phase)
    if imaging.at_rows and {"period_number", "phase"} <= set(points.coords):
        number, phase = points["period_number"].values, points["phase"].values
    elif imaging.at_rows and "time" in points.coords:
        number, phase = instants(points["time"].values, imaging.window)
    return SectionStarts(states, number.astype(np.int64), phase.astype(float), modes)


def _along(
    imaging: Imaging, coordinate: Coordinate, branch: MappedStarts, matrices: Floats
) -> tuple[Floats, Floats]:
    """Slopes along the motion's own direction, and its two largest exponents per return.

    Whatever direction one begins with, it turns into that in which neighbours separate fastest.
    """
    system, count = imaging.chosen.system, branch.values.size
    kept = [i for i, name in enumerate(system.states) if name not in system.drift_states]
    kept += [] if coordinate.place in kept or coordinate.is_phase else [coordinate.place]
    if imaging.at_rows and is_driven(imaging.engine.tables):  # else nothing depends on time
        kept.append(len(system.states))
    place = kept.index(coordinate.place)
    matrices = matrices[:, kept][:, :, kept]
    begin = _two_directions(len(kept))
    frame, other = begin, begin[:, ::-1] @ np.array([0.8, 0.6])
    slopes, growth, settled = np.full(count, np.nan), np.full((count, 2), np.nan), False
    follows = _follows(imaging, branch)
    for i in range(count):
        if not np.all(np.isfinite(matrices[i])) or (i and not follows[i - 1]):
            frame, other = begin, begin[:, ::-1] @ np.array([0.8, 0.6])
        if not np.all(np.isfinite(matrices[i])):
            continue
        leading = frame[:, 0]
        aligned = np.linalg.norm(other - (leading @ other) * leading) <= _ALIGNED
        moved = matrices[i] @ frame
        if aligned and leading[place] != 0.0:
            slopes[i] = moved[place, 0] / leading[place]
        frame, sizes = np.linalg.qr(moved)
        other = matrices[i] @ other
        size = float(np.linalg.norm(other))
        other = other / size if size > 0.0 else begin[:, 1]
        if aligned and not settled:  # what came before belongs to the directions at the beginning
            growth[:i], settled = np.nan, True
        if aligned or not settled:
            with np.errstate(divide="ignore"):
                growth[i] = np.log(np.abs(np.diag(sizes)))
    counted = growth[~np.isnan(growth[:, 0])]
    return slopes, counted.mean(axis=0) if len(counted) else np.full(2, np.nan)


def _two_directions(n: int) -> Floats:
    """Two directions at right angles that no equation knows."""
    rng = np.random.default_rng(0)
    frame: Floats = np.linalg.qr(rng.normal(size=(n, 2)))[0]
    return frame


def _follows(imaging: Imaging, branch: MappedStarts) -> npt.NDArray[np.bool_]:
    """Whether the next point is the image of a point, up to the drift; (L - 1,)."""
    system = imaging.chosen.system
    kept = [i for i, name in enumerate(system.states) if name not in system.drift_states]
    states, images = branch.starts.states[:, kept], branch.images.states[:, kept]
    spread = np.ptp(states, axis=0) + np.abs(states).max(axis=0) * 1e-9
    apart = np.abs(images[:-1] - states[1:])
    found: npt.NDArray[np.bool_] = np.all(apart <= _SAME * spread + 1e-12, axis=1)
    return found
