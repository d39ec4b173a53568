"""Second and third derivatives of a return map along lines, from its exact first derivatives.

Central differences at steps that fall in a geometric sequence, extrapolated to no step at all
(L. F. Richardson, 1911). The step and the order of the extrapolation are those at which numbers
that are made of the derivatives agree best with their neighbours (C. J. F. Ridders, Accurate
computation of F'(x) and F'(x)F''(x), Advances in Engineering Software 4, 1982).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.word_map import Image, WordMap

__all__ = [
    "ROUNDING",
    "Differences",
    "Estimate",
    "Narrow",
    "derivative",
    "differences",
    "extrapolate",
]

Floats = npt.NDArray[np.float64]

_LEVELS = 11  # steps along a line
_RATIO = 1.5  # of one step to the next
_LARGEST = 0.1  # of the sizes of the states, and of the parameter
_HALVINGS = 30  # of the largest step, until the word is the same at both ends
_SAFETY = 4.0  # times the difference of neighbours in the extrapolation
ROUNDING = 1e-11  # of the terms: orbit and eigenvectors are known to about that


class Narrow(ArithmeticError):
    """The itinerary changes too close to the orbit; ``within`` is where it was last seen to."""

    def __init__(self, within: float) -> None:
        super().__init__(f"the itinerary changes within {within:.1e} of the size of the orbit")


class Differences(NamedTuple):
    """Differences of the derivatives of the image along a line, for each of its steps.

    The last column is the derivative by the parameter.
    """

    first: Floats  # (K, m, m + 1)
    second: Floats  # (K, m, m + 1)
    reach: float  # largest step, in lengths of the direction, with one itinerary on both sides
    narrow: bool  # whether another itinerary lies closer than orbits are displaced


class Estimate(NamedTuple):
    """A number with how far it may be wrong."""

    value: float
    error: float

    @property
    def decided(self) -> bool:
        """Whether its sign is beyond doubt."""
        return bool(abs(self.value) > self.error)


def differences(near: WordMap, along: Floats, by_parameter: float, width: float) -> Differences:
    """Differences along a line through the orbit; `Narrow` where the word changes at once.

    width: what counts as large for the parameter
    """
    size = max(np.abs(along / near.sizes).max(initial=0.0), abs(by_parameter) / width)
    step = largest = _LARGEST / size
    for _ in range(_HALVINGS):
        if _keeps_word(near, step * along, step * by_parameter):
            break
        step *= 0.5
    else:
        raise Narrow(step * size)
    centre = _derivatives(_image(near, 0.0 * along, 0.0))
    first, second = [], []
    for h in _steps(step):
        ahead, behind = (
            _derivatives(_image(near, way * along, way * by_parameter)) for way in (h, -h)
        )
        first.append((ahead - behind) / (2.0 * h))
        second.append((ahead - 2.0 * centre + behind) / h**2)
    return Differences(np.array(first), np.array(second), step, step < largest)


def derivative(function: Callable[[float], npt.ArrayLike], longest: float) -> list[Estimate]:
    """Derivative at zero of each entry of a function, by steps up to a longest one."""
    pairs = [(np.atleast_1d(function(h)), np.atleast_1d(function(-h))) for h in _steps(longest)]
    slopes = [
        (ahead - behind) / (2.0 * h)
        for h, (ahead, behind) in zip(_steps(longest), pairs, strict=True)
    ]
    return [extrapolate(lambda d: d[0], [column[:, None]]) for column in np.array(slopes).T]


def _steps(longest: float) -> Floats:
    return np.asarray(longest / _RATIO ** np.arange(_LEVELS))


def _image(near: WordMap, away: Floats, by_parameter: float) -> Image:
    found = near.image(near.start + away, near.value + by_parameter)
    if found is None:
        raise Narrow(float(np.abs(away / near.sizes).max(initial=0.0)))
    return found


def _derivatives(image: Image) -> Floats:
    return np.column_stack([image.by_start, image.by_parameter])


def _keeps_word(near: WordMap, away: Floats, by_parameter: float) -> bool:
    """Whether a motion from either end of a step has the word of the orbit."""
    for way in (1.0, -1.0):
        value = near.value + way * by_parameter
        found = near.image(near.start + way * away, value)
        if found is None or not near.margin(found, value) > 0.0:
            return False
    return True


def extrapolate(terms: Callable[[Sequence[Floats]], Floats], made_of: Sequence[Floats]) -> Estimate:
    """A sum of terms that are made of differences, at no step.

    made_of: differences, each (K, ...) over falling steps; ``terms`` takes one of each
    """
    rows = [list(each) for each in made_of]
    table = [_sums(terms, rows)]
    best = Estimate(float(table[0][-1, 0]), np.inf)
    for order in range(1, _LEVELS):
        share = 1.0 / (_RATIO ** (2 * order) - 1.0)
        rows = [
            [row[k + 1] + share * (row[k + 1] - row[k]) for k in range(len(row) - 1)]
            for row in rows
        ]
        table.append(_sums(terms, rows))
        (here, sizes), before = table[order].T, table[order - 1][:, 0]
        for k in range(1, here.size):
            # three neighbours: two may agree by chance
            apart = (here[k] - here[k - 1], here[k] - before[k + 1], here[k] - before[k])
            error = _SAFETY * float(np.max(np.abs(apart))) + ROUNDING * float(sizes[k])
            if error < best.error:
                best = Estimate(float(here[k]), error)
    return best


def _sums(terms: Callable[[Sequence[Floats]], Floats], rows: list[list[Floats]]) -> Floats:
    """Sums of terms and of their sizes, (K, 2)."""
    found = [terms([row[k] for row in rows]) for k in range(len(rows[0]))]
    return np.array([(each.sum(), np.abs(each).sum()) for each in found])
