"""From options that are checked to a branch with its first point."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nonsmooth.continuation.arrays import Array
from nonsmooth.continuation.branch import Branch
from nonsmooth.continuation.corrector import Corrector
from nonsmooth.continuation.equations import Equations
from nonsmooth.continuation.options import Options
from nonsmooth.continuation.start import first_node, scaled_direction

__all__ = ["begin"]


def begin(
    residual: Callable[[Array, float], Any],
    u: Array,
    p: float,
    direction: Any,
    sizes: Array,
    options: Options,
) -> Branch:
    """The branch through a start, which is corrected here."""
    equations = Equations(residual, sizes, options.bounds)
    corrector = Corrector(equations, options.tolerance, options.max_newton)
    ahead, given = scaled_direction(direction, u.size, equations.scale)
    return Branch(corrector, options, first_node(corrector, u, p, ahead, given))
