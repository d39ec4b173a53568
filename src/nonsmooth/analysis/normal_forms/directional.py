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
_EPS = 4.0 * float(np.finfo(float).eps)  # of derivatives of the image: their rounding
_PATTERNS = 4  # of signs, by which rounding is tried out
ROUNDING = 1e-11  # of the terms: orbit and eigenvectors are known to about that


class Narrow(ArithmeticError):
    """The itinerary changes too close to the orbit; ``within`` is where it was last seen to."""

    def __init__(self, within: float) -> None:
        super().__init__(f"the itinerary changes within {within:.1e} of the size of the orbit")


class Quotients(NamedTuple):
    """Differences over falling steps, and what rounding may be in each of their entries."""

    values: Floats  # (K, ...)
    rounding: Floats  # (K,), or (K, m + 1) of each column


class Differences(NamedTuple):
    """Differences of the derivatives of the image along a line, for each of its steps.

    Values are (K, m, m + 1); the last column is the derivative by the parameter.
    """

    first: Quotients
    second: Quotients
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


def differences(
    near: WordMap, along: Floats, by_parameter: float, width: float, levels: int = _LEVELS
) -> Differences:
    """Differences along a line through the orbit; `Narrow` where the word changes at once.

    width: what counts as large for the parameter; levels: number of steps
    """
    size = max(np.abs(along).max(initial=0.0), abs(by_parameter) / width)
    step = largest = _LARGEST / size
    for _ in range(_HALVINGS):
        if _keeps_word(near, step * along, step * by_parameter):
            break
        step *= 0.5
    else:
        raise Narrow(step * size)
    centre = _derivatives(_image(near, 0.0 * along, 0.0))
    first, second = [], []
    steps = _steps(step, levels)
    for h in steps:
        ahead, behind = (
            _derivatives(_image(near, way * along, way * by_parameter)) for way in (h, -h)
        )
        first.append((ahead - behind) / (2.0 * h))
        second.append((ahead - 2.0 * centre + behind) / h**2)
    # the parameter has a unit of its own
    largest_of = np.abs(centre).max(axis=0)
    rounding = _EPS * np.append(np.full(along.size, largest_of[:-1].max()), largest_of[-1])
    return Differences(
        Quotients(np.array(first), rounding / steps[:, None]),
        Quotients(np.array(second), 2.0 * rounding / steps[:, None] ** 2), step, step < largest,
    )  # fmt: skip


def derivative(function: Callable[[float], npt.ArrayLike], longest: float) -> list[Estimate]:
    """Derivative at zero of each entry of a function, by steps up to a longest one."""
    steps = _steps(longest)
    ahead, behind = (
        np.array([np.atleast_1d(function(way * h)) for h in steps]) for way in (1.0, -1.0)
    )
    slopes = (ahead - behind) / (2.0 * steps[:, None])
    rounding = _EPS * np.abs(ahead).max(axis=0)
    return [
        extrapolate(lambda d: d[0], [Quotients(column[:, None], size / steps)])
        for column, size in zip(slopes.T, rounding, strict=True)
    ]


def _steps(longest: float, levels: int = _LEVELS) -> Floats:
    return np.asarray(longest / _RATIO ** np.arange(levels))


def _image(near: WordMap, away: Floats, by_parameter: float) -> Image:
    found = near.image(near.start + away, near.value + by_parameter)
    if found is None:
        raise Narrow(float(np.abs(away).max(initial=0.0)))
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


def extrapolate(
    terms: Callable[[Sequence[Floats]], Floats], made_of: Sequence[Quotients]
) -> Estimate:
    """A sum of terms that are made of differences, at no step.

    made_of: differences; ``terms`` takes one row of each
    """
    rows = list(made_of)
    table = [_sums(terms, rows)]
    best = Estimate(float(table[0][-1, 0]), np.inf)
    for order in range(1, len(rows[0].values)):
        rows = [_next_order(each, 1.0 / (_RATIO ** (2 * order) - 1.0)) for each in rows]
        table.append(_sums(terms, rows))
        (here, doubt), before = table[order].T, table[order - 1][:, 0]
        for k in range(1, here.size):
            # three neighbours: two may agree by chance
            apart = (here[k] - here[k - 1], here[k] - before[k + 1], here[k] - before[k])
            error = _SAFETY * float(np.max(np.abs(apart))) + float(doubt[k])
            if error < best.error:
                best = Estimate(float(here[k]), error)
    return best


def _next_order(rows: Quotients, share: float) -> Quotients:
    """The next column of the extrapolation."""
    values, rounding = rows
    return Quotients(
        values[1:] + share * (values[1:] - values[:-1]),
        (1.0 + share) * rounding[1:] + share * rounding[:-1],
    )


def _sums(terms: Callable[[Sequence[Floats]], Floats], rows: list[Quotients]) -> Floats:
    """Sums of terms, and what rounding may be in them, (K, 2).

    Rounding of the differences is tried out by adding it with some patterns of signs.
    """
    signs = np.random.default_rng(0)
    patterns = [
        [signs.choice([-1.0, 1.0], each.values.shape[1:]) for each in rows]
        for _ in range(_PATTERNS)
    ]
    found = []
    for k in range(len(rows[0].values)):
        parts = terms([each.values[k] for each in rows])
        total, size = float(parts.sum()), float(np.abs(parts).sum())
        moved = [
            terms([e.values[k] + e.rounding[k] * s for e, s in zip(rows, pattern, strict=True)])
            for pattern in patterns
        ]
        doubt = max(abs(float(each.sum()) - total) for each in moved)
        found.append((total, 2.0 * doubt + ROUNDING * size))
    return np.array(found)
