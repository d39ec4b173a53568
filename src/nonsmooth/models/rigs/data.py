"""Checks that the data of every rig in SI units pass."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from nonsmooth.errors import ModelError, OptionError

__all__ = ["check_data", "one_number"]


def one_number(name: str, value: Any, *, positive: bool = False) -> float:
    """One finite number, positive if it must be, or an error that names the argument."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number) or (positive and number <= 0.0):
        kind = "positive number" if positive else "finite number"
        raise OptionError(f"{name} = {value!r:.60} must be a {kind}")
    return number


def check_data(rig: Any, positive: Mapping[str, str], not_negative: Mapping[str, str]) -> None:
    """Turn the fields of a frozen dataclass into finite numbers, some of which have a sign.

    A field whose default is None may be left out.
    The mappings give the reason for each field that must be positive, or must not be negative.
    """
    for item in fields(rig):
        value = getattr(rig, item.name)
        if value is None and item.default is None:
            continue  # left out
        try:
            number = float(value)
        except (TypeError, ValueError):
            number = math.nan
        if not math.isfinite(number):
            raise ModelError(f"{item.name} = {value!r:.60} is not a finite number")
        object.__setattr__(rig, item.name, number)
    for name, reason in positive.items():
        if getattr(rig, name) is not None and getattr(rig, name) <= 0.0:
            raise ModelError(f"{name} = {getattr(rig, name):g} must be positive: {reason}")
    for name, reason in not_negative.items():
        if getattr(rig, name) < 0.0:
            raise ModelError(f"{name} = {getattr(rig, name):g} must not be negative: {reason}")
