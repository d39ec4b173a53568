"""Numbers that users pass, as floating-point numbers, or an error that says what is wrong.

Whatever is an argument somewhere comes through here: a whole number too large for a double, an
infinity or a text is refused with the name of the argument, never with a bare OverflowError.
"""

from __future__ import annotations

import math
from numbers import Real
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import NonsmoothError, OptionError, quote

__all__ = ["check_size", "finite_numbers", "finite_real", "whole_number"]

_REACH = 1e60  # largest size, and the inverse of the least
_MOST = 1e15  # of a count: doubles hold each whole number up to here


def finite_real(
    where: str,
    value: Any,
    error: type[NonsmoothError] = OptionError,
    wanted: str = "a finite real number",
) -> float:
    """A finite real number as a float; ``where`` names the argument, ``wanted`` what it may be.

    Booleans, texts and complex numbers are none; an array without axes stands for its element.
    """
    given = value
    if not isinstance(value, Real) and getattr(value, "ndim", None) == 0:
        value = value.item()
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real):
        kind = "a complex number" if isinstance(value, complex) else "not a finite number"
        raise error(f"{where} = {quote(given)} is {kind}; give {wanted}")
    try:
        number = float(value)
    except OverflowError:
        raise error(
            f"{where} = {quote(given)} is too large for a double, which reaches 1.8e308; give"
            f" {wanted}"
        ) from None
    if not math.isfinite(number):
        raise error(f"{where} = {number} is not a finite number; give {wanted}")
    return number


def finite_numbers(
    where: str, value: Any, error: type[NonsmoothError] = OptionError
) -> npt.NDArray[np.float64]:
    """An array of finite real numbers; what is not one is refused as in `finite_real`."""
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        raise error(f"{where} = {quote(value)}: give a list of numbers") from None
    if array.dtype.kind not in "iuf":
        found = [finite_real(where, each, error) for each in array.ravel().tolist()]
        return np.array(found, dtype=float).reshape(array.shape)
    numbers = array.astype(float)
    wrong = numbers[~np.isfinite(numbers)]
    if wrong.size:
        raise error(f"{where} = {wrong[0]} is not a finite number; give numbers that are")
    return numbers


def check_size(
    where: str,
    number: float,
    error: type[NonsmoothError] = OptionError,
    *,
    positive: bool = False,
) -> None:
    """Refuse sizes whose powers no double holds, or whose inverse has none if positive."""
    if abs(number) > _REACH or (positive and number < 1.0 / _REACH):
        raise error(f"{where} = {number:g} is no size of anything; check its unit")


def whole_number(name: str, value: Any, least: int = 1) -> int:
    """Value that must be a whole number, not less than the least one allowed."""
    number = finite_real(name, value)
    if abs(number) > _MOST:
        raise OptionError(f"{name} = {number:g} must be at most {_MOST:g} in size")
    if number != int(number) or number < least:
        raise OptionError(f"{name} = {number:g} must be a whole number of at least {least}")
    return int(number)
