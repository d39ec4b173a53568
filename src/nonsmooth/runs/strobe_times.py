"""Strobe times, one phase of every period, and whether strobes see all that drives a system."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import Tables
from nonsmooth.errors import OptionError
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.options import finite_number
from nonsmooth.system.system import System

__all__ = ["check_phase", "hides_phase", "is_driven", "require_period", "strobes"]


_TURN = 1e-9  # of a forcing between strobes, beside their number, within which it is a whole one


def is_driven(tables: Tables) -> bool:
    """Whether time stands in a system: as harmonics, as powers, or as signals."""
    return bool(tables.harmonics.shape[1] or tables.sizes.powers or tables.signals.shape[0])


def hides_phase(tables: Tables, length: float) -> bool:
    """Whether strobes see the forcing at different phases, for lack of a common period.

    Those phases neither grow nor die away, and are no states.
    """
    turns = tables.harmonics[0] * length / (2.0 * np.pi)
    return bool(np.any(np.abs(turns - np.rint(turns)) > _TURN * np.maximum(1.0, turns)))


_CURE = (
    "give period= a length of time, or the system one, or take a section of it (poincare_section,"
    " PoincareMap)"
)


def require_period(system: System, verb: str, cure: str = _CURE) -> float:
    """Period of a system; refused where it has none, with what can be done about it."""
    period = system.period_value
    if period is None:
        raise OptionError(f"{verb}: {system.name!r} has no period to strobe at; {cure}")
    return float(period)


def check_phase(phase: Any) -> float:
    """Part of a period at which strobes are taken, from 0 up to 1."""
    number = finite_number("phase", phase)
    if not 0.0 <= number < 1.0:
        raise OptionError(f"phase = {number:g}: give a part of the period, from 0 to less than 1")
    return number


def strobes(
    window: float, begin: Instant, period: float | None, phase: float, first: int, count: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Window numbers and phases of strobes first ... first + count - 1 after the beginning.

    The strobes of a period of the system keep their phase exactly; others are rounded once each.
    """
    if period is None or period == window:
        # strobe 0 is the first one that is not before the beginning
        number = begin.number + (1 if begin.phase > phase * window else 0)
        numbers = np.arange(number + first, number + first + count, dtype=np.int64)
        return numbers, np.full(count, phase * window)
    start = begin.time(window)
    number = int(np.ceil(start / period - phase - 1e-12))
    times = (np.arange(number + first, number + first + count) + phase) * period
    return instants(times, window)
