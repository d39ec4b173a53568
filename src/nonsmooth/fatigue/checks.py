"""Checks of numbers that are handed to fracture mechanics, of specimens, and of records."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, OptionError, quote
from nonsmooth.real_numbers import check_size, finite_real

__all__ = [
    "Array",
    "check_times",
    "crack_lengths",
    "finite",
    "finite_array",
    "finite_number",
    "flag",
    "like",
    "listed",
    "number_array",
    "positive",
    "real_numbers",
    "record_values",
    "same_shape",
    "set_numbers",
]

Array = npt.NDArray[np.float64]


def set_numbers(thing: Any, positive: Mapping[str, str]) -> None:
    """Turn the fields of a frozen dataclass into finite numbers, some of which are positive.

    ``positive`` has the reason for each field that must be.
    """
    for item in fields(thing):
        object.__setattr__(thing, item.name, finite_number(item.name, getattr(thing, item.name)))
    for name, reason in positive.items():
        if getattr(thing, name) <= 0.0:
            raise ModelError(f"{name} = {getattr(thing, name):g} must be positive: {reason}")
        check_size(name, getattr(thing, name), ModelError, positive=True)


def finite_number(name: str, value: Any) -> float:
    """One number of a specimen or curve, or an error that names it."""
    return finite_real(name, value, ModelError)


def finite(name: str, value: Any) -> float:
    """A finite number."""
    return finite_real(name, value)


def positive(name: str, value: Any, unit: str = "") -> float:
    """A finite number above zero."""
    number = finite(name, value)
    if number <= 0.0:
        raise OptionError(f"{name} = {number:g}{unit and ' ' + unit}: it must be above zero")
    check_size(name, number, positive=True)
    return number


def listed(name: str, values: Any, what: str) -> list[Any]:
    """The entries of a list, or an error that says ``what`` they are to be."""
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        raise OptionError(f"{name} = {quote(values)}: give a list of {what}")
    return list(values)


def flag(name: str, value: Any) -> bool:
    """True or false."""
    if not isinstance(value, bool | np.bool_):
        raise OptionError(f"{name} = {quote(value)}: give True or False")
    return bool(value)


def number_array(name: str, values: Any) -> Array:
    """Values as numbers, which may be nan."""
    try:
        return real_numbers(values)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"{name} = {quote(values)} is no number, nor are its parts") from None


def finite_array(name: str, values: Any) -> Array:
    """Values as numbers that are all finite, or an error that shows the first one that is not."""
    numbers = number_array(name, values)
    if not np.all(np.isfinite(numbers)):
        place = int(np.flatnonzero(~np.isfinite(numbers))[0])
        where = f"{name}[{place}]" if numbers.ndim else name
        raise OptionError(f"{where} = {numbers.flat[place]:g} is not finite")
    return numbers


def real_numbers(values: Any) -> Array:
    """Values as an array of real numbers; a TypeError for texts, truth values and complex ones."""
    found = np.asarray(values)
    if found.dtype.kind not in "iufO":
        raise TypeError("not real numbers")
    if found.dtype.kind == "O":  # of which numpy would take texts, and None as no number
        if any(isinstance(v, str | bytes | bool) for v in found.flat):
            raise TypeError("not numbers alone")
        return np.array([float(v) for v in found.flat]).reshape(found.shape)
    return found.astype(float)


def same_shape(**arrays: Array) -> None:
    """Refuse arrays that do not broadcast."""
    try:
        np.broadcast_shapes(*(np.shape(array) for array in arrays.values()))
    except ValueError:
        shapes = " and ".join(str(np.shape(array)) for array in arrays.values())
        raise OptionError(
            f"{' and '.join(arrays)} have the shapes {shapes}, which do not go together; give as"
            " many of each, one of either, or one of them as a column: values[:, None]"
        ) from None


def crack_lengths(crack: Any, width: float, *, through: bool = False) -> Array:
    """Lengths of cracks that fit into a beam; one ``through`` all of it only where that is said."""
    lengths = finite_array("crack", crack)
    if np.any(lengths < 0.0):
        worst = float(lengths.min())
        raise OptionError(
            f"crack = {worst:g} mm is negative; a crack in a beam of width = {width:g} mm has a"
            " length from 0 on"
        )
    worst = float(lengths.max(initial=0.0))
    if worst > width or (worst == width and not through):
        kind = "is longer than" if worst > width else "is as long as"
        raise OptionError(
            f"crack = {worst:g} mm {kind} the specimen's width = {width:g} mm, so there is no"
            " ligament left; give a crack shorter than the width"
        )
    return lengths


def like(values: Any, given: Any) -> Any:
    """Numbers as they were given: a float for a float, an array for an array."""
    return values if np.ndim(given) else float(values)


def record_values(name: str, values: Any) -> Array:
    """Samples of a record: one dimension, two at least, all finite."""
    try:
        found = real_numbers(values)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"{name}: give samples as numbers, not {quote(values)}") from None
    if found.ndim != 1:
        raise OptionError(f"{name} has {found.ndim} dimensions; give one series of samples")
    if found.size < 2:
        raise OptionError(f"{name} has {found.size} samples; a record needs two at least")
    bad = np.flatnonzero(~np.isfinite(found))
    if bad.size:
        raise OptionError(
            f"{name}: {bad.size} samples are not finite, the first at index {bad[0]}; repair them"
            " or cut them off"
        )
    return found


def check_times(times: Any, size: int) -> Array:
    """Times of samples: as many, increasing."""
    found = record_values("times", times)
    if found.size != size:
        raise OptionError(f"times: {found.size} came for {size} samples; give one for each")
    back = np.flatnonzero(np.diff(found) <= 0.0)
    if back.size:
        raise OptionError(
            f"times must increase, and they do not after index {back[0]}: {found[back[0]]:.9g},"
            f" {found[back[0] + 1]:.9g}"
        )
    return found
