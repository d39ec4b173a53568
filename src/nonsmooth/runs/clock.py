"""Times as window number and phase, and the sample times of a run.

A time is kept as (number of whole windows, phase within the window). The window is the
period of the forcing where there is one. So a run of a million periods ends at a phase
that is as exact as that of the first one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.library import constant
from nonsmooth.errors import OptionError
from nonsmooth.runs.options import check_count, finite_number, time_grid, whole_number

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "Instant", "Plan", "check_one_end", "instants", "plan_run", "rounding_of_events",
    "rounding_of_logged", "since_strobe",
]  # fmt: skip

_UNIT = float(np.finfo(float).eps)
_ROUNDING = 0.5 ** constant("ROUNDING_BITS")
_LEAST, _MOST = constant("LEAST_DRIFTING"), constant("MOST_DRIFTING")
DEFAULT_SAMPLES = 1000  # intervals of a run given by t_end of a system without a period


class Instant(NamedTuple):
    """A time as window number and phase."""

    number: int
    phase: float

    def time(self, window: float) -> float:
        """Time as a single number."""
        return self.number * window + self.phase


class Plan(NamedTuple):
    """Where a run ends and when it is sampled."""

    end: Instant
    sample_number: npt.NDArray[np.int64]
    sample_phase: npt.NDArray[np.float64]
    times: npt.NDArray[np.float64] | None = None  # of the samples, where they were asked for


def instants(
    times: npt.ArrayLike, window: float | npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Window numbers and phases; a time within rounding of a window's end begins the next."""
    times = np.asarray(times, dtype=float)
    nearest = np.rint(times / window)
    on_boundary = np.abs(times - nearest * window) <= 4.0 * _UNIT * np.abs(times)
    number = np.where(on_boundary, nearest, np.floor(times / window))
    phase = np.where(on_boundary, 0.0, np.clip(times - number * window, 0.0, window))
    return number.astype(np.int64), phase


def rounding_of_events(
    numbers: npt.NDArray[np.int64], phases: npt.NDArray[np.float64], windows: npt.ArrayLike
) -> npt.NDArray[np.float64]:
    """Time by which samples may lie on either side of events and still be at them.

    A clock that is reset once per period comes to its reset a rounding before a strobe or behind
    it. The engine takes the sample before the reset in both cases, by the same bound.
    """
    passed = _LEAST + np.minimum(np.abs(numbers), _MOST)
    length = np.where(numbers == 0, np.minimum(windows, np.abs(phases)), windows)
    return np.asarray(_ROUNDING * passed * length)


def rounding_of_logged(run: xr.Dataset) -> npt.NDArray[np.float64]:
    """The same for the event log of a run, as a dataset; zero where its clock is not told.

    Times that were converted to other units have the window of no clock.
    """
    if "window" not in run.attrs:
        return np.zeros(run.sizes["event"])
    number, phase = run["event_period_number"].values, run["event_phase"].values
    return rounding_of_events(number, phase, run.attrs["window"])


def since_strobe(
    numbers: npt.NDArray[np.int64], phases: npt.NDArray[np.float64], first: Instant, window: float
) -> npt.NDArray[np.float64]:
    """Times of events since a strobe; those at a strobe by rounding are put there exactly."""
    windows, phase = numbers - first.number, phases - first.phase
    nearest = windows + np.rint(phase / window)
    apart = (windows - nearest) * window + phase
    at_strobe = np.abs(apart) <= rounding_of_events(numbers, phases, window)
    return np.asarray(np.where(at_strobe, nearest * window, windows * window + phase))


def check_one_end(**ends: object) -> None:
    """Exactly one of the options that end a run is given."""
    given = [name for name, value in ends.items() if value is not None]
    if len(given) != 1:
        what = "none is" if not given else " and ".join(given) + " are"
        raise OptionError(f"give exactly one of periods=, t_end= and times=; {what} given")


def plan_run(
    window: float,
    periodic: bool,
    start: Instant,
    *,
    periods: float | None,
    t_end: float | None,
    times: npt.ArrayLike | None,
    samples_per_period: int,
    sample_bytes: int = 0,
) -> Plan:
    """End and sample times of a run from exactly one of ``periods``, ``t_end``, ``times``."""
    check_one_end(periods=periods, t_end=t_end, times=times)
    per_window = whole_number("samples_per_period", samples_per_period)
    if times is not None:
        return _plan_times(window, start, time_grid(times))
    t_start = start.number * window + start.phase
    if periods is not None:
        if not periodic:
            raise OptionError(
                "periods= needs a system with a period; declare period= in the system, or give"
                " t_end= or times="
            )
        if not finite_number("periods", periods) > 0:
            raise OptionError(f"periods = {periods} must be positive")
        whole = int(np.floor(periods))
        end = _after(start, whole, (periods - whole) * window, window)
        count = check_count(np.floor(periods * per_window + 1e-9), sample_bytes)
        return _plan_grid(window, start, end, count, per_window)
    if not finite_number("t_end", t_end) > t_start:
        raise OptionError(f"t_end = {t_end} must be later than the start, t = {t_start:g}")
    assert t_end is not None
    number, phase = instants([t_end], window)
    end = Instant(int(number[0]), float(phase[0]))
    if periodic:
        count = check_count(np.floor((t_end - t_start) / window * per_window + 1e-9), sample_bytes)
        return _plan_grid(window, start, end, count, per_window)
    grid = np.linspace(t_start, t_end, DEFAULT_SAMPLES + 1)
    return _grid_of_times(window, start, end, grid)


def _after(start: Instant, windows: int, phase: float, window: float) -> Instant:
    number, phase = start.number + windows, start.phase + phase
    if phase >= window * (1.0 - 4.0 * _UNIT):  # a sum of phases meets the boundary up to rounding
        return Instant(number + 1, max(0.0, phase - window))
    return Instant(number, phase)


def _plan_grid(window: float, start: Instant, end: Instant, count: int, per_window: int) -> Plan:
    # the phases of one window repeat in all
    pattern = start.phase + np.arange(min(per_window, count + 1)) * (window / per_window)
    over = pattern >= window * (1.0 - 4.0 * _UNIT)
    pattern = np.maximum(pattern - window * over, 0.0)
    windows = start.number + np.arange(count // per_window + 1, dtype=np.int64)
    number = np.add.outer(windows, over).ravel()[: count + 1]
    phase = np.tile(pattern, windows.size)[: count + 1]
    beyond = (int(number[-1]) - end.number) * window + (float(phase[-1]) - end.phase)
    if abs(beyond) <= 1e-9 * window / per_window:
        end = Instant(int(number[-1]), float(phase[-1]))  # equal up to rounding
    return Plan(end, number, phase)


def _plan_times(window: float, start: Instant, grid: npt.NDArray[np.float64]) -> Plan:
    t_start = start.number * window + start.phase
    if grid[0] < t_start - 4.0 * _UNIT * abs(t_start):
        raise OptionError(
            f"times[0] = {grid[0]:g} lies before the start, t = {t_start:g}; runs go forward only"
        )
    number, phase = instants(grid[-1:], window)
    plan = _grid_of_times(window, start, Instant(int(number[0]), float(phase[0])), grid)
    return plan._replace(times=grid)


def _grid_of_times(
    window: float, start: Instant, end: Instant, grid: npt.NDArray[np.float64]
) -> Plan:
    number, phase = instants(grid, window)
    # a first time equal to the start up to rounding is the start
    early = (number < start.number) | ((number == start.number) & (phase < start.phase))
    number[early], phase[early] = start.number, start.phase
    return Plan(end, number, phase)
