"""Curves through points that a continuation has placed far apart, without corners of their own.

Between two points the curve is a cubic whose tangents at both are those of parabolas through three
neighbours, over the length of the chords as a picture shows them. At places where a branch may have
a corner, as where its orbits graze, the tangents of the sides are not the same.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["rounded"]

Floats = npt.NDArray[np.float64]

_PARTS = 8  # of each way between two points
_SEEN = 5e-4  # of the picture, by which a curve is seen to leave its chord
_SHARP = 0.5  # cosine of the bend at a point from which on it is a corner
_STEEPEST = 3.0  # times the slope of a way: up to there it is monotone
_EVEN = 6.0  # ratio of chords side by side, from which on a parabola says nothing of the longer one


def rounded(
    x: Floats, y: Floats, corner: npt.NDArray[np.bool_], apart: npt.NDArray[np.bool_]
) -> tuple[Floats, Floats, npt.NDArray[np.int64]]:
    """Places of K points, and seven between two of them where the curve is seen to leave the chord.

    ``corner`` (K,) says where the curve may bend sharply, ``apart`` (K - 1,) where no curve leads
    from one point to the next.

    returns: x and y of all places, and the number of the point at or before each
    """
    given = np.stack([x, y], axis=1)
    points = np.where(np.isfinite(given), given, np.nan)
    known = points[np.all(np.isfinite(points), axis=1)]
    size = np.ptp(known, axis=0) if len(known) else np.ones(2)
    unit = np.where(size > 0.0, size, 1.0)
    steps = np.diff(points / unit, axis=0)
    chords = np.linalg.norm(steps, axis=1)
    curved = np.isfinite(chords) & (chords > 0.0) & ~apart
    slopes = steps / np.where(curved, chords, 1.0)[:, None]
    begin, end = _tangents(slopes, chords, curved, corner)
    onward = _goes_on(slopes[:, 0], curved)
    begin, end = (_without_hooks(each, slopes, onward) for each in (begin, end))
    t = np.arange(_PARTS)[:, None, None] / _PARTS
    length = np.where(curved, chords, 0.0)[:, None]
    away = t * (1.0 - t) ** 2 * length * (begin - slopes) - t**2 * (1.0 - t) * length * (
        end - slopes
    )
    between = points[:-1] + t * steps * unit + away * unit
    bent = np.linalg.norm(away, axis=2).max(axis=0) > _SEEN
    kept = (np.arange(_PARTS)[:, None] == 0) | bent
    places = np.append(np.repeat(np.arange(chords.size), kept.sum(axis=0)), chords.size)
    whole = np.concatenate([between.transpose(1, 0, 2)[kept.T], given[-1:]])
    whole[np.searchsorted(places, np.arange(len(points)))] = given  # not rounded
    return whole[:, 0], whole[:, 1], places


def _tangents(
    slopes: Floats, chords: Floats, curved: npt.NDArray[np.bool_], corner: npt.NDArray[np.bool_]
) -> tuple[Floats, Floats]:
    """Tangents at the begin and at the end of each way, (K - 1, 2) each."""
    begin, end = slopes.copy(), slopes.copy()
    if len(slopes) < 2:
        return begin, end
    before, behind = chords[:-1], chords[1:]
    smooth = curved[:-1] & curved[1:] & ~corner[1:-1]
    with np.errstate(invalid="ignore", divide="ignore"):
        smooth &= np.sum(slopes[:-1] * slopes[1:], axis=1) > _SHARP
        smooth &= np.maximum(before / behind, behind / before) < _EVEN
        weight = np.where(smooth, behind / (before + behind), 0.5)[:, None]
    middle = weight * slopes[:-1] + (1.0 - weight) * slopes[1:]
    end[:-1] = np.where(smooth[:, None], middle, end[:-1])
    begin[1:] = np.where(smooth[:, None], middle, begin[1:])
    # where one side alone is known, the way is a parabola
    left = np.append(False, smooth) & ~np.append(smooth, False)
    right = np.append(smooth, False) & ~np.append(False, smooth)
    end[left] = 2.0 * slopes[left] - begin[left]
    begin[right] = 2.0 * slopes[right] - end[right]
    return begin, end


def _goes_on(across: Floats, curved: npt.NDArray[np.bool_]) -> Floats:
    """The sense, -1 or 1, in which a way and those beside it lead across the picture; else 0."""
    sense = np.where(curved, np.sign(across), 0.0)
    before, behind = np.append(0.0, sense[:-1]), np.append(sense[1:], 0.0)
    alone = (sense * before >= 0.0) & (sense * behind >= 0.0)
    onward: Floats = np.where(alone, sense, 0.0)
    return onward


def _without_hooks(tangents: Floats, slopes: Floats, onward: Floats) -> Floats:
    """Tangents with which no way turns back across the picture where its points go on.

    A cubic does not turn back if both tangents are at most three times its slope (F. N. Fritsch and
    R. E. Carlson, Monotone piecewise cubic interpolation, 1980). Tangents that are shortened keep
    their direction, so that the curve gets no corners.
    """
    along, most = onward * tangents[:, 0], _STEEPEST * np.abs(slopes[:, 0])
    with np.errstate(invalid="ignore", divide="ignore"):
        part = np.where((onward != 0.0) & (along > most), most / along, 1.0)
    found: Floats = np.where(((onward != 0.0) & (along < 0.0))[:, None], slopes, tangents)
    return found * part[:, None]
