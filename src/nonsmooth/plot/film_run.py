"""The run that a film shows: its motion at the instants of the frames, and the pace of the film."""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nonsmooth.errors import OptionError, RunWarning
from nonsmooth.plot.trace import check_range
from nonsmooth.runs.options import positive_number
from nonsmooth.runs.simulate import simulate
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["MOST_FRAMES", "Pace", "film_run", "pace_of"]

MOST_FRAMES = 2_000  # 80 s at 25 frames per second
_USUAL, _LONGEST = 4.0, 20.0  # seconds of film for a period, and for all of them
_WITHOUT_PERIOD = 12.0  # seconds of film for a run that has none
_FEWEST = 2
_PER_PERIOD = 200  # samples of the curves, which frames are too few for
_WHOLE = 2000  # samples of the curves, where there is no period
_BY_SAMPLE = 1e-9  # of the run, within which an instant is the end of the run


class Pace(NamedTuple):
    """Instants of the frames, and what a second of the film is.

    The curves have ``fine`` samples for each frame.
    """

    start: float
    step: float
    frames: int
    fine: int
    text: str

    @property
    def times(self) -> np.ndarray:
        """Times of the samples, of which every ``fine``-th one is a frame."""
        return self.start + self.step / self.fine * np.arange((self.frames - 1) * self.fine + 1)


def pace_of(
    run: xr.Dataset,
    time_range: tuple[float, float] | None,
    slow_down: float | None,
    frames_per_second: float,
) -> Pace:
    """Instants of the frames of a film of a run."""
    positive_number("frames_per_second", frames_per_second)
    if slow_down is not None:
        positive_number("slow_down", slow_down)
    time_range = check_range(run, time_range)
    first, last = float(run["time"][0]), float(run["time"][-1])
    low, high = (first, last) if time_range is None else time_range
    low, high = max(low, first), min(high, last)
    if not low < high:
        raise OptionError("the run takes no time; simulate some periods to animate them")
    period = run.attrs.get("period")
    unit = float(period) if period else 1.0
    length = (high - low) / unit
    if slow_down is None:
        seconds = min(_USUAL * length, _LONGEST) if period else _WITHOUT_PERIOD
        slow_down = seconds / length
    frames = slow_down * length * frames_per_second
    if frames >= MOST_FRAMES:
        raise OptionError(
            f"the film would have {frames:.0f} frames, at most {MOST_FRAMES} are drawn: give a"
            " shorter time_range, a smaller slow_down or fewer frames_per_second"
        )
    count = math.floor(frames * (1.0 + _BY_SAMPLE)) + 1
    if count < _FEWEST:
        raise OptionError(
            f"the film would have one frame: give a larger slow_down than {slow_down:g}, or more"
            f" frames_per_second than {frames_per_second:g}"
        )
    step = unit / (slow_down * frames_per_second)
    fine = math.ceil(_PER_PERIOD * step / unit if period else _WHOLE / count)
    return Pace(low, step, count, fine, _said(run, slow_down, period))


def _said(run: xr.Dataset, slow_down: float, period: float | None) -> str:
    """What a second of the film is."""
    amount = f"{1.0 / slow_down:.3g}"
    if period:
        return f"1 s of the film is {amount} period" + ("" if amount == "1" else "s")
    units = str(run["time"].attrs.get("units", ""))
    return f"1 s of the film is {amount} {units or 'units of time'}"


def film_run(run: xr.Dataset, system: System, times: np.ndarray) -> xr.Dataset:
    """The motion at some instants, run anew from the last sample before them.

    Between two samples of a run there may be events, so that no interpolation would be right. The
    system and a sample determine the motion, and a run from there is exact.
    """
    samples = run["time"].values
    place = int(np.searchsorted(samples, times[0], side="right")) - 1
    # the end of the last step may lie behind the end of the run by rounding
    times = np.minimum(times, max(float(samples[-1]), float(times[-2])))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)
        again = simulate(system, run.isel(time=max(place, 0)), times=times)
    if again.sizes["time"] < times.size:
        raise OptionError(
            f"the motion does not come to the end of the film when it is run from t ="
            f" {samples[place]:g}: {again.attrs['message']}; give a time_range that ends earlier"
        )
    return again
