"""Whether both sides of a surface can point at it, for any state and any parameters.

A field may jump where motion only changes its speed: a spring that meets a second damper. There
the rates of the switching function on both sides have one sign, so their zeros are the same.
Where one rate has a zero that the other does not share, both signs come beside it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nonsmooth.system.expressions import Call, Expression, Name
from nonsmooth.system.identities import random_point, value_at

__all__ = ["may_attract"]

_SEEDS = 3
_STEPS = 40  # of the secant method
_ROOT = 1e-11  # of the size of a rate
_ZERO = 1e-6  # of it: what is no zero of the other rate

_Place = Callable[[Any], bool]


def may_attract(up: Expression, down: Expression, place: _Place) -> bool:
    """Whether rates above and below a surface may have different signs; yes where it is not known.

    ``place`` moves a point onto the surface.
    """
    names = sorted(_names([up, down]))
    shared = not names
    for seed in range(_SEEDS):
        point = random_point(seed)
        placed = place(point)
        above, below = value_at(up, point), value_at(down, point)
        if not placed or not above * below > 0.0:
            return True
        size = max(abs(above), abs(below))
        for name in names:
            for rate, other in ((up, down), (down, up)):
                root = _root(rate, place, point, name, _ROOT * size)
                if root is None:
                    continue
                if not abs(value_at(other, root)) <= _ZERO * size:
                    return True
                shared = True
    return not shared


def _names(nodes: list[Expression]) -> set[str]:
    """Names in some graphs, each node met once."""
    found, seen, open_ = set(), set(), list(nodes)
    while open_:
        node = open_.pop()
        if id(node) in seen:
            continue
        seen.add(id(node))
        if isinstance(node, Name):
            found.add(node.name)
        elif isinstance(node, Call):
            open_ += node.arguments
    return found


def _root(rate: Expression, place: _Place, point: Any, name: str, small: float) -> Any:
    """Point on the surface where a rate is zero, found by changing one coordinate, or None."""

    def moved(to: float) -> Any:
        changed = random_point(0)
        changed.update(point)
        changed[name] = to
        return changed if place(changed) else None

    x, step = point[name], 0.1 * point[name] + 0.01
    value = value_at(rate, point)
    for _ in range(_STEPS):
        beside = moved(x + step)
        if beside is None:
            return None
        new = value_at(rate, beside)
        if abs(new) <= small:
            return beside
        if not abs(new - value) > 0.0:  # no number, or the rate does not depend on it
            return None
        x, step, value = x + step, -step * new / (new - value), new
    return None
