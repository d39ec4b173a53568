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

__all__ = [
    "check_phase", "hides_phase", "is_driven", "require_period", "require_repeats", "strobes",
    "strobes_of_motions",
]  # fmt: skip


Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_TURN = 1e-9  # of a forcing between strobes, beside their number, within which it is a whole one


def is_driven(tables: Tables) -> bool:
    """Whether time stands in a system: as harmonics, as powers, or as signals."""
    return bool(tables.harmonics.shape[1] or tables.sizes.powers or tables.signals.shape[0])


def hides_phase(frequencies: Floats, lengths: Floats) -> npt.NDArray[np.bool_]:
    """Whether strobes see the forcing at different phases, for lack of a common period, (K,).

    Those phases neither grow nor die away, and are no states.

    shapes: frequencies (K, F) of each of K motions, lengths (K,) between strobes
    """
    turns = frequencies * lengths[:, None] / (2.0 * np.pi)
    away = np.abs(turns - np.rint(turns)) > _TURN * np.maximum(1.0, turns)
    return np.asarray(np.any(away, axis=1))


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


def require_repeats(system: System, verb: str) -> None:
    """Refuse equations that do not repeat: of maps, of what settles, and of what has a period.

    Strobes of a single motion are there all the same.
    """
    if system.unrepeated:
        raise OptionError(
            f"{verb}: {system.name!r} has {system.unrepeated}, which does not repeat, so no motion"
            " repeats or settles, and a state at a strobe does not say what follows; leave it out,"
            " or look at runs from one time with simulate or ensemble"
        )


def check_phase(phase: Any) -> float:
    """Part of a period at which strobes are taken, from 0 up to 1."""
    number = finite_number("phase", phase)
    if not 0.0 <= number < 1.0:
        raise OptionError(f"phase = {number:g}: give a part of the period, from 0 to less than 1")
    return number


def strobes(
    window: float, begin: Instant, period: float | None, phase: float, first: int, count: int
) -> tuple[Integers, Floats]:
    """Window numbers and phases of strobes first ... first + count - 1 after the beginning.

    The strobes of a period of the system keep their phase exactly; others are rounded once each.
    """
    numbers, phases = strobes_of_motions(
        np.array([window]), (np.array([begin.number]), np.array([begin.phase])),
        np.array([np.nan if period is None else period]), phase, np.array([first]), count,
    )  # fmt: skip
    return numbers[0], phases[0]


def strobes_of_motions(
    windows: Floats,
    begins: tuple[Integers, Floats],
    periods: Floats,
    phase: float,
    firsts: Integers,
    count: int,
) -> tuple[Integers, Floats]:
    """The same of K motions; a period is nan where it is that of the clock.

    shapes: windows, begins, periods and firsts (K,); returns (K, count) each
    """
    number, since = begins
    places = np.arange(count, dtype=np.int64)
    # strobe 0 is the first one that is not before the beginning
    first = number + (since > phase * windows) + firsts
    numbers, phases = first[:, None] + places, np.tile((phase * windows)[:, None], count)
    other = ~(np.isnan(periods) | (periods == windows))
    if np.any(other):
        start, own = (number * windows + since)[other], periods[other]
        first = np.ceil(start / own - phase - 1e-12).astype(np.int64) + firsts[other]
        times = (first[:, None] + places + phase) * own[:, None]
        numbers[other], phases[other] = instants(times, windows[other, None])
    return numbers, phases
