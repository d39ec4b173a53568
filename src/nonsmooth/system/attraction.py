"""Whether both sides of a surface can point at it, for any state and any parameters.

A field may jump where motion only changes its speed: a spring that meets a second damper. There
the rates of the switching function on both sides have one sign, so their zeros are the same.
Where one rate has a zero that the other does not share, both signs come beside it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.system.evaluate import evaluate_shared
from nonsmooth.system.expressions import Call, Expression, Name
from nonsmooth.system.identities import random_point

__all__ = ["may_attract"]

_SEEDS = 2
_STEPS = 30  # of the secant method
_ROOT = 1e-11  # of the size of a rate
_ZERO = 1e-6  # of it: what is no zero of the other rate

_Array = npt.NDArray[np.float64]


def may_attract(up: Expression, down: Expression) -> bool:
    """Whether rates on both sides of a surface may have different signs; yes where in doubt.

    The surface is put into the rates: any values of what stands in them are a point of it.
    """
    names = sorted(_names([up, down]))
    points = [random_point(seed) for seed in range(_SEEDS)]
    start = {name: np.array([point[name] for point in points]) for name in names}
    rates = _values(up, down, start, _SEEDS)
    if not (rates[0] * rates[1] > 0.0).all():
        return True
    if not names:
        return False
    size = np.abs(rates).max(axis=0)
    # one search for each point, coordinate and rate, side by side
    searches = [(s, n, r) for s in range(_SEEDS) for n in range(len(names)) for r in (0, 1)]
    which, coordinate, side = (np.array(part) for part in zip(*searches, strict=True))
    begin = {name: start[name][which] for name in names}
    others = _at_roots(up, down, begin, coordinate, side, size[which])
    found = ~np.isnan(others)
    return not found.any() or bool((others[found] > _ZERO * size[which][found]).any())


def _names(nodes: list[Expression]) -> set[str]:
    """Names in some graphs, each node met once."""
    found, seen, open_ = set(), set(), list(nodes)
    while open_:
        node = open_.pop()
        if id(node) in seen:
            continue
        seen.add(id(node))
        if isinstance(node, Name) and node.name != "pi":
            found.add(node.name)
        elif isinstance(node, Call):
            open_ += node.arguments
    return found


def _values(up: Expression, down: Expression, point: dict[str, _Array], count: int) -> _Array:
    """Both rates at some points."""
    known: dict[int, Any] = {}
    try:
        rows = [evaluate_shared(node, point, known, lambda _: None) for node in (up, down)]
    except (ArithmeticError, KeyError, TypeError, ValueError):
        return np.full((2, count), np.nan)
    return np.array([np.broadcast_to(np.asarray(row, float), count) for row in rows])


def _at_roots(
    up: Expression,
    down: Expression,
    point: dict[str, _Array],
    coordinate: npt.NDArray[np.int64],
    side: npt.NDArray[np.int64],
    size: _Array,
) -> _Array:
    """Size of one rate where the other is zero by a change of one coordinate; nan where it is not.

    By the secant method, for many coordinates at once.
    """
    names, every = list(point), np.arange(len(side))
    others = np.full(len(side), np.nan)
    x = np.array([point[names[n]][k] for k, n in enumerate(coordinate)])
    step = 0.1 * x + 0.01
    value = _values(up, down, point, len(side))[side, every]
    going = np.isfinite(value)
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            for n, name in enumerate(names):
                point[name] = np.where(coordinate == n, x + step, point[name])
            both = _values(up, down, point, len(side))
            new = both[side, every]
            there = going & (np.abs(new) <= _ROOT * size)
            others[there] = np.abs(both[1 - side, every])[there]
            change = new - value
            going &= ~there & (np.abs(change) > 0.0)  # no number: no change either
            if not going.any():
                break
            x = x + step
            step = np.where(going, -step * new / np.where(going, change, 1.0), 0.0)
            value = new
    return others
