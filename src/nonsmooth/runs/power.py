"""How often a map is applied that is a power of another one."""

from __future__ import annotations

from typing import Any

from nonsmooth.errors import OptionError
from nonsmooth.runs.options import whole_number

__all__ = ["raised"]


def raised(every: int, power: Any) -> int:
    """Times that a map is applied, raised to a power."""
    if power == 0 or (isinstance(power, int) and power < 0):
        raise OptionError(
            f"power {power} of a map: give a whole number of at least 1; maps go forward in time"
        )
    return every * whole_number("power", power)
