"""Where two manifolds touch: a bump of one over a parameter, until its top is on the other.

Between two crossings in opposite senses the unstable manifold makes a bump across the stable one.
How far its top is across tells whether they cross, touch or stay apart, and its zero over the
parameter is the tangency. The top of a smooth bump is smooth; in a piecewise-smooth system it may
be a corner.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.manifolds.crossings import ManifoldCrossing
from nonsmooth.analysis.manifolds.passage import Passage
from nonsmooth.analysis.manifolds.saddle import Saddle
from nonsmooth.runs.whole_turns import periods_of_states

__all__ = ["Both", "Bump", "Tangency", "bumps_of", "touch"]

Floats = npt.NDArray[np.float64]

_STEPS = 16  # of the parameter, in which a bump is followed
_MORE = 3  # applications of the map that are tried, to see which line is the manifold
_ENDS = 1e-6  # of the first piece, by which a top may be beyond its ends
_MOVES = 8  # times that the window follows a top that has come to its end
_NEAR_END = 0.02  # of the window
_SAMPLES = 65  # places at which it is seen how wide a bump is
_LEAST = 1e-9  # of a place: the least one, and the least width of a window
_BENDS = 0.1  # of the way of a top between two values, by which it may be off a straight one
_ROUNDS = 80  # of the search for a zero
_JUMP = 1e-6  # of the heights at which that begins: what may be left of them in the end
_BESIDE = 1e-6  # of the place, where slopes on both sides of a top are taken
_SMOOTH = 2.0  # times the change of slopes twice as near


class Both(NamedTuple):
    """The saddle of each manifold, at one value of the parameter; sides are those of all values."""

    out: Saddle
    into: Saddle


class Bump(NamedTuple):
    """Two crossings in a row along the unstable manifold, in opposite senses."""

    out: int  # number of the point of the orbit
    side: float
    into: int
    images: int
    ahead: int
    turns: Floats  # whole turns of angles by which it lies beyond the stable curve, (n,)
    low: float  # places of the crossings, as of these images
    high: float
    way: float  # sign across the stable manifold between them
    length: float  # of the first piece of the unstable manifold
    reach: float  # of that of the stable one, with the sign of its side


class Tangency(NamedTuple):
    """A tangency."""

    value: float
    error: float  # of the parameter: what height is left, by the slope
    place: float
    state: Floats
    bump: Bump
    kind: str  # corner or smooth
    is_there: bool  # whether the top is on the first piece, and not on the line beyond


def bumps_of(found: list[ManifoldCrossing], both: Both) -> list[Bump]:
    """Pairs of crossings that may vanish together, those of few applications first.

    One application more is taken, so that there is room on the first piece beside both. Of the
    points of one orbit the first pair alone is taken.
    """
    bumps: list[Bump] = []
    for one, other in _pairs(found, both):
        if one.sense * other.sense >= 0.0:
            continue
        images = max(one.passage.images, other.passage.images) + 1
        ahead = max(one.passage.ahead, other.passage.ahead)
        passage = one.passage.later(images - one.passage.images, ahead)
        low, high = (
            each.place / both.out.multiplier ** (images - each.passage.images)
            for each in (one, other)
        )
        middle = passage.across(np.array([0.5 * (low + high)]))[0]
        if not np.isfinite(middle) or middle == 0.0:
            continue
        out = both.out.points.index(passage.out)
        into = both.into.points.index(passage.into)
        bump = Bump(
            out, passage.side, into, images, ahead, _counted(both, passage.shift), low, high,
            float(np.sign(middle)), other.length, other.reach,
        )  # fmt: skip
        bumps.append(bump)
    return sorted(bumps, key=lambda each: (each.images + each.ahead, each.images))


def _pairs(
    found: list[ManifoldCrossing], both: Both
) -> Iterator[tuple[ManifoldCrossing, ManifoldCrossing]]:
    """Crossings in a row of one curve with another, and with one copy of it.

    Copies of a stable curve that are whole turns of an angle apart are curves of their own.
    """
    last = max((each.passage.images for each in found), default=0)
    before: dict[tuple[int, int, tuple[float, ...]], ManifoldCrossing] = {}
    for each in found:
        shift = each.passage.later(last - each.passage.images, each.passage.ahead).shift
        key = each.out, each.into, tuple(_counted(both, shift).tolist())
        if key in before:
            yield before[key], each
        before[key] = each


def _counted(both: Both, shift: Floats) -> Floats:
    """How many periods of each angle a shift is; the periods may depend on the parameter."""
    periods = periods_of_states(both.into.chosen.system)
    return np.rint(shift / np.where(periods > 0.0, periods, 1.0))


class _Top(NamedTuple):
    """The top of a bump at one value of the parameter, and how wide the bump is."""

    value: float
    height: float  # across, positive where the manifolds cross
    place: float
    width: float  # of the places at which they are crossed; 0 where they are not
    passage: Passage


def touch(
    bump: Bump, begin: float, end: float, at: Callable[[float], Both | None]
) -> Tangency | None:
    """The tangency in which a bump vanishes on the way from one value to another.

    None where it does not, or where a saddle is lost before. Lines of the first pieces go on where
    the manifolds do not; a top that has come to such a place is sought again with one application
    of the map more.
    """
    for more in range(_MORE):
        found = _vanishes(bump._replace(ahead=bump.ahead + more), begin, end, at)
        if found is None or found.is_there:
            return found
    return None


def _vanishes(
    bump: Bump, begin: float, end: float, at: Callable[[float], Both | None]
) -> Tangency | None:
    """Where the top of a bump comes to the line of the first piece of the stable manifold."""
    tops: list[_Top] = []
    middle, width = 0.5 * (bump.low + bump.high), bump.high - bump.low
    for value in np.linspace(begin, end, _STEPS + 1).tolist():
        both = at(value)
        if tops:
            middle, width = _expected(tops, value), tops[-1].width
        top = None if both is None else _top(bump, both, value, middle, width)
        if top is None:
            return None
        if top.height <= 0.0:
            return _zero(bump, tops[-1], top, at) if tops else None
        tops.append(top)
    return None


def _expected(tops: list[_Top], value: float) -> float:
    """Where the top will be at a value behind the last one, on the line through the last two."""
    last = tops[-1]
    if len(tops) == 1:
        return last.place
    slope = (last.place - tops[-2].place) / (last.value - tops[-2].value)
    return max(last.place + slope * (value - last.value), 0.5 * last.place)


def _between(above: _Top, below: _Top, value: float) -> tuple[float, float]:
    """Where the top will be at a value between two, and in which window it is looked for."""
    part = (value - above.value) / (below.value - above.value)
    way = below.place - above.place
    width = max(above.width, _BENDS * abs(way), _LEAST * above.place)
    return above.place + part * way, width


def _top(bump: Bump, both: Both, value: float, middle: float, width: float) -> _Top | None:
    """The top of a bump near a place; the window follows it, and becomes wider where it is low.

    While the manifolds cross there may be higher tops beside this one. Places grow by the
    multiplier from image to image, so the window ends at half the place: far below, starts stay at
    the saddle and are across by next to nothing.
    """
    out, into = both.out.points[bump.out], both.into.points[bump.into]
    shift = bump.turns * periods_of_states(both.into.chosen.system)
    passage = Passage(out, bump.side, into, bump.images, bump.ahead, shift)
    place, height, first = middle, -np.inf, width
    for _ in range(_MOVES):
        middle = min(middle, bump.length)
        low, high = max(middle - width, 0.5 * middle), min(middle + width, bump.length)
        place, height = passage.largest(low, high, bump.way)
        if min(place - low, high - place) > _NEAR_END * width:
            break
        middle, width = place, width if height > 0.0 else 2.0 * width
    if not np.isfinite(height):
        return None
    across = _extent(passage, bump.way, place, first) if height > 0.0 else 0.0
    return _Top(value, height, place, across, passage)


def _extent(passage: Passage, way: float, place: float, width: float) -> float:
    """Twice the way from a top to the farther of the two places at which it is crossed."""
    reach = width
    for _ in range(_MOVES):
        away = reach * np.linspace(0.0, 1.0, _SAMPLES)[1:]
        sides = []
        for sign in (-1.0, 1.0):
            places = place + sign * away
            outside = ~(way * passage.across(np.maximum(places, 0.0)) > 0.0)
            sides.append(float(away[np.argmax(outside)]) if outside.any() else np.inf)
        if np.isfinite(sides).all():
            return 2.0 * max(sides)
        reach *= 2.0
    return 2.0 * reach


def _zero(
    bump: Bump, above: _Top, below: _Top, at: Callable[[float], Both | None]
) -> Tangency | None:
    """The value between two at which the top is on the stable manifold; None where it jumps there.

    By the Illinois method, or halves where that is slow: heights far from the manifold are no
    longer in proportion to distances.
    """
    weights = [1.0, 1.0]  # of the heights above and below
    kept, slow, size = 0, 0, abs(below.value - above.value)
    jump = _JUMP * (above.height - below.height)
    for _ in range(_ROUNDS):
        up, down = weights[0] * above.height, weights[1] * below.height
        part = 0.5 if slow > 1 else up / (up - down)
        value = above.value + part * (below.value - above.value)
        if not min(above.value, below.value) < value < max(above.value, below.value):
            break
        both = at(value)
        top = None if both is None else _top(bump, both, value, *_between(above, below, value))
        if top is None:
            return None
        if top.height > 0.0:
            above = top
            weights = [1.0, 0.5 * weights[1] if kept == 1 else 1.0]
            kept = 1
        else:
            below, weights = top, [0.5 * weights[0] if kept == -1 else 1.0, 1.0]
            kept = -1
        slow = slow + 1 if abs(below.value - above.value) > 0.5 * size else 0
        size = abs(below.value - above.value)
    if min(above.height, -below.height) > jump:
        return None
    best = above if above.height < -below.height else below
    slope = (above.height - below.height) / size
    error = min(size, abs(best.height) / slope + float(np.spacing(abs(best.value))))
    state = best.passage.states(np.array([best.place]))[0]
    along = best.passage.along(best.place) / bump.reach
    there = -_ENDS < along < 1.0 + _ENDS and best.place < bump.length * (1.0 - _ENDS)
    return Tangency(best.value, error, best.place, state, bump, _kind(best), there)


def _kind(top: _Top) -> str:
    """Whether a top is a corner: beside it the slopes do not become less."""
    width = _BESIDE * top.place
    values = top.passage.across(top.place + width * np.array([-2.0, -1.0, 0.0, 1.0, 2.0]))
    slopes = np.diff(values)
    # of a smooth top, whose slopes grow with the distance, this is three; of a corner it is one
    ratio = abs(slopes[3] - slopes[0]) / max(abs(slopes[2] - slopes[1]), 1e-300)
    return "corner" if ratio < _SMOOTH else "smooth"
