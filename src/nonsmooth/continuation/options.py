"""The options of `follow`, checked."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral
from typing import Any

import numpy as np

from nonsmooth.continuation.point import Array
from nonsmooth.errors import OptionError, quote
from nonsmooth.real_numbers import finite_real

__all__ = [
    "OWN_NAMES",
    "Options",
    "checked_bounds",
    "checked_options",
    "number",
    "sizes_of",
    "start_of",
]

OWN_NAMES = ("fold", "branch_point", "bound", "closed", "cusp")


@dataclass(frozen=True, slots=True)
class Options:
    """What holds for a whole branch."""

    step: float
    smallest: float
    largest: float
    bounds: tuple[float, float]
    steps: int
    tests: Callable[[Any], Mapping[str, float]] | None
    tolerance: float
    max_newton: int
    unknown_bounds: tuple[float, float] = (-math.inf, math.inf)  # of the last unknown
    # slope of the last unknown by the arclength that is none: a fold that has it is a cusp
    cusps: float = 0.0
    # asked whether a step is taken, by its points in order
    accept: Callable[[Sequence[Any]], bool] | None = None


def checked_options(
    p: float, step: Any, smallest_step: Any, largest_step: Any, bounds: Any, steps: Any,
    tests: Any, tolerance: Any, max_newton: Any, accept: Any = None,
) -> Options:  # fmt: skip
    """Options, or an `OptionError` that names the one that cannot be right."""
    lengths = {"smallest_step": smallest_step, "step": step, "largest_step": largest_step}
    smallest, first, largest = (_positive(name, value) for name, value in lengths.items())
    if not smallest <= first <= largest:
        raise OptionError(
            f"smallest_step = {smallest:g}, step = {first:g}, largest_step = {largest:g}: each must"
            " be at most the next; give all three when you change one by much"
        )
    if tests is not None and not callable(tests):
        raise OptionError(
            f"tests = {quote(tests)} is no function; give tests(point) that returns a mapping of"
            " names to numbers, such as lambda point: {'zero': point.u[0]}"
        )
    if accept is not None and not callable(accept):
        raise OptionError(
            f"accept = {quote(accept)} is no function; give accept(points) that returns whether the"
            " step through these points is taken"
        )
    goal = _positive("tolerance", tolerance)
    if not 1e-15 <= goal <= 1e-3:
        raise OptionError(f"tolerance = {goal:g}: from 1e-15 to 1e-3, relative to the unknowns")
    return Options(
        first, smallest, largest, checked_bounds(p, bounds), _count("steps", steps, 0), tests, goal,
        _count("max_newton", max_newton, 2), accept=accept,
    )  # fmt: skip


def start_of(u: Any, p: Any) -> tuple[Array, float]:
    """Unknowns as an array of one dimension, parameter as a float."""
    try:
        unknowns = np.asarray(u)
        if unknowns.dtype.kind not in "fiu":
            raise TypeError
        unknowns = np.atleast_1d(unknowns.astype(float))
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"u = {quote(u)} must be real numbers: one for each unknown") from None
    if unknowns.ndim != 1 or not unknowns.size:
        raise OptionError(
            f"u has the shape {unknowns.shape}; give the unknowns in one row, such as u.ravel(),"
            " and shape them again inside the residual"
        )
    if not np.isfinite(unknowns).all():
        place = int(np.flatnonzero(~np.isfinite(unknowns))[0])
        raise OptionError(f"u[{place}] = {unknowns[place]} is not finite")
    return unknowns, number("p", p)


def sizes_of(
    u: Array, p: float, scale: Any, parameter_scale: Any, bounds: tuple[float, float]
) -> Array:
    """Sizes of the unknowns and, last, of the parameter."""
    sizes = np.empty(u.size + 1)
    if scale is None:
        sizes[:-1] = max(1.0, float(np.abs(u).max()))
    else:
        given = np.asarray(scale, dtype=float)
        if given.shape not in ((), u.shape) or not (np.isfinite(given) & (given > 0.0)).all():
            raise OptionError(
                f"scale = {quote(scale)}: one positive number, or one for each of the {u.size}"
                " unknowns, their usual sizes"
            )
        sizes[:-1] = given
    width = bounds[1] - bounds[0]
    usual = width if math.isfinite(width) and width > 0.0 else max(1.0, abs(p))
    sizes[-1] = usual if parameter_scale is None else _positive("parameter_scale", parameter_scale)
    return sizes


def checked_bounds(p: float, bounds: Any) -> tuple[float, float]:
    """Bounds that are in order, with the start inside them."""
    try:
        low, high = (float(bound) for bound in bounds)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"bounds = {quote(bounds)}: two numbers (low, high)") from None
    if not low < high:
        raise OptionError(f"bounds = ({low:g}, {high:g}): the first must be below the second")
    if not low <= p <= high:
        raise OptionError(
            f"the start {p:g} is outside of bounds = ({low:g}, {high:g}): start inside them"
        )
    return low, high


def number(name: str, value: Any) -> float:
    """A finite number."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.item()
    return finite_real(name, value)


def _positive(name: str, value: Any) -> float:
    found = number(name, value)
    if found <= 0.0:
        raise OptionError(f"{name} = {found:g} must be positive")
    return found


def _count(name: str, value: Any, least: int) -> int:
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise OptionError(f"{name} = {quote(value)}: a whole number, {least} or more")
    return int(value)
