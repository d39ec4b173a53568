"""Strobe times: one phase of every period, of the forcing or of a chosen length."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.options import finite_number
from nonsmooth.system.system import System

__all__ = ["check_phase", "require_period", "strobes"]


def require_period(system: System, verb: str) -> float:
    """Period of a system; refused where it has none."""
    period = system.period_value
    if period is None:
        raise OptionError(
            f"{verb}: {system.name!r} has no period to strobe at; give period= a length of time, or"
            " the system one, or take a section of it (poincare_section, PoincareMap)"
        )
    return float(period)


def check_phase(phase: Any) -> float:
    """Part of a period at which strobes are taken, from 0 up to 1."""
    number = finite_number("phase", phase)
    if not 0.0 <= number < 1.0:
        raise OptionError(f"phase = {number:g} is a part of the period, from 0 to less than 1")
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
