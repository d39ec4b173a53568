"""Checks that the data of every rig in SI units pass, and datasets of its motions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, OptionError, quote
from nonsmooth.real_numbers import check_size, finite_real

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Positive", "check_contents", "check_data", "finite_values", "one_number"]

Positive: TypeAlias = Annotated[float, "a positive number"]
_NEVER_EMPTY = ("time", "state")  # of a run


def one_number(name: str, value: Any, *, positive: bool = False, most: float = math.inf) -> float:
    """One finite number, positive if it must be, or an error that names the argument."""
    kind = "positive number" if positive else "finite number"
    limit = f" of at most {most:g}" if math.isfinite(most) else ""
    number = finite_real(name, value, wanted=f"a {kind}{limit}")
    if (positive and number <= 0.0) or number > most:
        raise OptionError(f"{name} = {quote(value)} must be a {kind}{limit}")
    check_size(name, number, positive=positive)
    return number


def finite_values(name: str, values: Any) -> npt.NDArray[np.float64]:
    """Finite numbers of any shape, or an error that names the argument."""
    try:
        given = np.asarray(values)
        # text and truth values would be turned into numbers
        numbers = given.astype(float) if given.dtype.kind in "iufO" else None
    except (TypeError, ValueError, OverflowError):
        numbers = None
    if numbers is None:
        raise OptionError(f"{name} = {quote(values)} is no number, nor are its parts")
    if not np.all(np.isfinite(numbers)):
        raise OptionError(f"{name} = {quote(values)} must be finite")
    return numbers


def check_data(rig: Any, positive: Mapping[str, str], not_negative: Mapping[str, str]) -> None:
    """Turn the fields of a frozen dataclass into finite numbers, some of which have a sign.

    A field whose default is None may be left out.
    The mappings give the reason for each field that must be positive, or must not be negative.
    """
    for item in fields(rig):
        value = getattr(rig, item.name)
        if value is None and item.default is None:
            continue  # left out
        number = finite_real(item.name, value, ModelError)
        check_size(item.name, number, ModelError)
        object.__setattr__(rig, item.name, number)
    for name, reason in positive.items():
        if getattr(rig, name) is not None and getattr(rig, name) <= 0.0:
            raise ModelError(f"{name} = {getattr(rig, name):g} must be positive: {reason}")
        if getattr(rig, name) is not None:
            check_size(name, getattr(rig, name), ModelError, positive=True)
    for name, reason in not_negative.items():
        if getattr(rig, name) < 0.0:
            raise ModelError(f"{name} = {getattr(rig, name):g} must not be negative: {reason}")


def check_contents(
    name: str, data: xr.Dataset, variables: Iterable[str], attributes: Iterable[str] = ()
) -> None:
    """Refuse a dataset from which something that is needed was taken out."""
    missing = [repr(each) for each in variables if each not in data.variables]
    missing += [f"attribute {each!r}" for each in attributes if each not in data.attrs]
    if missing:
        raise OptionError(
            f"{name} has no {', '.join(missing)}; give the dataset as it was computed"
        )
    if empty := [str(dim) for dim, size in data.sizes.items() if dim in _NEVER_EMPTY and not size]:
        raise OptionError(f"{name} has nothing over {empty[0]!r}; choose a part that is not empty")
