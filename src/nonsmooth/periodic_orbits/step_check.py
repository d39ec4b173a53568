"""Whether the points of a step of a branch of orbits agree with one another.

A search for changes of sign misses two of them within one step, and one of a number that begins to
exist within it. What it has found is therefore checked: every orbit has to be a motion up to the
change of the word, and multipliers may leave the unit circle, and the parameter may turn back, only
as the special points say. A step that does not agree is halved until it does.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth.continuation.point import Point
from nonsmooth.periodic_orbits.branch_part import is_critical
from nonsmooth.periodic_orbits.branch_tests import Looked, broken_tests, is_of_word
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.multipliers import UNBOUNDED, Floquet
from nonsmooth.periodic_orbits.stretch import MODULUS, BranchStart, BranchStretch

__all__ = ["VERTICAL", "StepCheck"]

_SHORTEST = 1e-6  # arclength of a step that is taken as it is
_FIRST = 0.1  # the same as part of the first step, until an orbit behind a change is a motion
_NEAR = 1e-6  # distance from the unit circle within which a multiplier is on neither side
_NEAR_AT_START = 1e-3  # the same where the branch begins, perhaps at a special point
_STILL = 1e-6  # part of a slope of the parameter by the arclength that is none
VERTICAL = 1e-10  # of the range by the arclength: slopes that rounding makes along a family
_AT_ONCE = 1e-6  # arclength between changes of the word that are one
# product of rates over kicks, of which rounding leaves more where only one of them is zero
_SEVERAL_POLES = 1e-20
_FOLDS = ("fold", "branch_point")


class StepCheck:
    """Asked by the continuation whether it takes a step of a stretch."""

    def __init__(self, stretch: BranchStretch, start: BranchStart, *, behind_change: bool) -> None:
        # values of the parameter at steps over which no special point explains the multipliers
        self.unexplained: list[float] = []
        self._stretch, self._start = stretch, start
        self._new = behind_change  # no orbit has been a motion yet
        self._closely = 0

    def __call__(self, points: Sequence[Point]) -> bool:
        """Whether the step is taken."""
        try:
            looked = [self._stretch.look(point) for point in points]
        except LegError:
            return True  # such points are left out
        length = points[-1].arclength - points[0].arclength
        end = _change_of_word(points, looked)
        if len(self._stretch.tests.closely) > self._closely:
            # numbers that were found before are told anew: they are looked for in a new step
            self._closely = len(self._stretch.tests.closely)
            return False
        least = max(_SHORTEST, 2.0 * self._stretch.options.smallest_step)
        if not self._stand(points, looked, end):
            return length <= (_FIRST * self._stretch.options.step if self._new else least)
        self._new = False
        if length > least and self._stretch.changes_too_much(points[0], points[end]):
            return False
        word, trail = self._stretch.equations.word, self._stretch.trail
        if length > least and trail.leads_back(word, [points[0], points[end]]):
            return False  # a long step has come to a part of the branch that was passed before
        low, high = self._stretch.options.bounds
        if not is_explained(points[: end + 1], looked[: end + 1], high - low):
            if not self._stretch.each_multiplier and _several_cross(looked[0], looked[end]):
                self._stretch.each_multiplier = True
                return False
            if length > least:
                return False
            self.unexplained.append(points[end].p)
        return True

    def _stand(self, points: Sequence[Point], looked: Sequence[Looked], end: int) -> bool:
        """Whether the orbits are motions up to the change of the word, or to the end."""
        if self._stretch.options.inadmissible:
            return True
        at_once = {
            point.special
            for point in points[end:]
            if point.arclength - points[end].arclength <= _AT_ONCE
        }
        if "motion" in at_once:
            end -= 1
        return all(
            each.admissibility.admissible
            or self._is_before(each)
            or (k == end and broken_tests(each, -each.rounding) <= at_once)
            for k, each in enumerate(looked[: end + 1])
            if k
        )

    def _is_before(self, looked: Looked) -> bool:
        """Whether an orbit lies on the other side of the graze behind which the stretch begins."""
        return self._start.located and looked.tests.get(self._start.grows, 1.0) <= 0.0


def _change_of_word(points: Sequence[Point], looked: Sequence[Looked]) -> int:
    """Number of the point at which the word changes, or of the last one."""
    for k, point in enumerate(points):
        name = point.special
        if k and is_of_word(name) and looked[0].tests.get(name, 1.0) >= 0.0:
            return k
    return len(points) - 1


def is_explained(points: Sequence[Point], looked: Sequence[Looked], width: float) -> bool:
    """Whether the multipliers at both ends differ as the special points in between say.

    And whether the parameter turns back as they say; ``width`` is its range.
    """
    first, last = looked[0].multipliers, looked[-1].multipliers
    near = _NEAR if points[0].arclength > 0.0 else _NEAR_AT_START
    inner = list(zip(points[1:], looked[1:], strict=True))
    count = {
        kind: sum(p.special == kind and is_critical(each, kind) for p, each in inner)
        for kind in (*_FOLDS, "flip", "torus")
    }
    if not _turns_are_told(points, width):
        return False
    for critical, kinds in ((1.0, _FOLDS), (-1.0, ("flip",))):
        sides = _side(first, critical, near) * _side(last, critical, _NEAR)
        passed = sum(count[kind] for kind in kinds)
        if sides != 0.0 and (sides < 0.0) != (passed % 2 == 1):
            return False
    before, after = _outside(first, near), _outside(last, _NEAR)
    if before is None or after is None:
        return True
    alone = sum(point.special.startswith(MODULUS) for point in points[1:])
    return abs(after - before) <= sum(count.values()) + count["torus"] + alone


def _several_cross(first: Looked, last: Looked) -> bool:
    """Whether an even number of multipliers more are outside the unit circle at one of the ends."""
    before, after = _outside(first.multipliers, _NEAR), _outside(last.multipliers, _NEAR)
    return before is not None and after is not None and (after - before) % 2 == 0 != after - before


def _turns_are_told(points: Sequence[Point], width: float) -> bool:
    """Whether the parameter turns back as often as there are folds, or as rounding may say.

    Along a family of cycles of all sizes it stays where it is.
    """
    slopes = [points[0].tangent_p, points[-1].tangent_p]
    largest = max(map(abs, slopes))
    still = min(map(abs, slopes)) <= _STILL * largest or largest <= VERTICAL * width
    at_fold = still or points[-1].special in _FOLDS
    turns = sum(point.special == "fold" for point in points[1:])
    return at_fold or (slopes[0] * slopes[1] < 0.0) == (turns % 2 == 1)


def _side(multipliers: Floquet, critical: float, near: float) -> float:
    """Sign of the determinant that vanishes with a multiplier of that value; 0 if it is at it.

    And 0 where several guards are only touched at one instant, as by equal machines.
    """
    values = multipliers.multipliers
    apart = values - critical
    if not values.size or not np.all(np.isfinite(values)) or np.abs(apart).min() <= near:
        return 0.0
    if abs(multipliers.poles.determinant) <= _SEVERAL_POLES:
        return 0.0
    # of directions: the product of many large numbers may overflow
    product = float(np.prod(apart / np.abs(apart)).real)
    return float(np.sign(product) * np.sign(multipliers.poles.determinant))


def _outside(multipliers: Floquet, near: float) -> int | None:
    """Multipliers outside the unit circle; None where one is on it, or has no bound."""
    sizes = np.abs(multipliers.multipliers)
    if not np.all(sizes <= UNBOUNDED) or np.any(np.abs(sizes - 1.0) <= near):
        return None
    return int(np.count_nonzero(sizes > 1.0))
