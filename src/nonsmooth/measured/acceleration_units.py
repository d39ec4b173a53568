"""Units of accelerations, and of what their integrals are in."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

from nonsmooth.errors import OptionError

__all__ = ["IntegralUnits", "integral_units"]

_G = 9.80665  # m/s^2, standard gravity, exactly
_GRAVITY = ("g", "gn", "g_n")
# such as m/s^2, m/s2, m/s**2, m/s², m/s/s, m s^-2, m s⁻², m·s⁻²
_PER_SQUARE = re.compile(
    r"(?P<length>[^/]+?)\s*(?:/\s*\(?(?P<a>[^\s/^*²)]*[^\s/^*²)\d])\s*(?:\^\s*2|\*\*\s*2|2|²)\)?"
    r"|/\s*(?P<b>[^\s/^*²]+)\s*/\s*(?P=b)"
    r"|[\s·*](?P<c>[^\s/^*²⁻-]+)\s*(?:\^\s*-2|\*\*\s*-2|-2|⁻²))"
)
_RATE_SQUARED = re.compile(r"(.+) (\S+)\^2")  # such as A_b omega^2


class IntegralUnits(NamedTuple):
    """What readings are multiplied by, and the units of displacements and velocities."""

    factor: float = 1.0
    displacement: str = ""
    velocity: str = ""


def integral_units(name: str, unit: Any, time: Any) -> IntegralUnits:
    """Units of the integrals over a time: the length in the unit of the acceleration, m for g.

    Nothing is known of the integrals of what has no unit.
    """
    unit, time = str(unit or "").strip(), str(time or "").strip()
    if unit in ("", "1"):
        return IntegralUnits()
    if unit in _GRAVITY:
        _check_time(name, unit, time, "s")
        return IntegralUnits(_G, "m", "m/s")
    found = _PER_SQUARE.fullmatch(unit)
    if found:
        second = found["a"] or found["b"] or found["c"]
        _check_time(name, unit, time, second)
        return IntegralUnits(1.0, found["length"], f"{found['length']}/{second}")
    scaled = _RATE_SQUARED.fullmatch(unit)
    if scaled and scaled[2] not in (time, "s", "ms"):  # not a length times a time squared
        return IntegralUnits(1.0, scaled[1], f"{scaled[1]} {scaled[2]}")
    raise OptionError(
        f"accelerations: {name} is in {unit!r:.40}, which is no unit of an acceleration; known are"
        " g, lengths over a time squared such as m/s^2 or mm/s^2, and lengths times a rate squared"
        " such as A_b omega^2. Name the right one by units= when it is read (of a Channel, with"
        " its sensitivity), or leave units out"
    )


def _check_time(name: str, unit: str, time: str, second: str) -> None:
    if time not in ("", second):
        raise OptionError(
            f"accelerations: {name} is in {unit!r:.40} and the time in {time!r:.40}; give the time"
            f" in {second}"
        )
