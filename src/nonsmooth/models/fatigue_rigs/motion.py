"""Settled motion of a forced system, and where the fatigue rig loses contact in a run."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nonsmooth.errors import OptionError, RunError
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Loss", "SettledMotion", "first_loss", "settled_motion", "swing"]

_CHUNK = 32  # periods between two looks
_MOST = 2048  # periods until a motion counts as one that does not repeat
_LONGEST = 8  # periods of a motion that repeats
_APERIODIC = 64  # periods kept of one that does not


class SettledMotion(NamedTuple):
    """The last periods of a motion; ``period`` is 0 where it does not repeat."""

    run: xr.Dataset
    period: int


class Loss(NamedTuple):
    """The first phase without full contact in a run, and when it began."""

    phase: str
    time: float


def settled_motion(
    system: System, *, tolerance: float = 1e-9, samples_per_period: int = 400
) -> SettledMotion:
    """Run from rest until the strobed states repeat, then the periods of one repetition."""
    from nonsmooth.runs.simulate import simulate

    start = None
    for _ in range(_MOST // _CHUNK):
        start = simulate(system, start, periods=_CHUNK, samples_per_period=1)
        _completed(start)
        points = np.stack([start[name].values for name in system.states], axis=1)
        scale = tolerance * np.abs(points).max()
        period = next(
            (
                n
                for n in range(1, _LONGEST + 1)
                if np.abs(points[-1] - points[-1 - n]).max() < scale
            ),
            0,
        )
        if period:
            break
    periods = period or _APERIODIC
    run = simulate(system, start, periods=periods, samples_per_period=samples_per_period)
    return SettledMotion(_completed(run), period)


def _completed(run: xr.Dataset) -> xr.Dataset:
    if run.attrs["status"] != "completed":
        raise RunError(
            f"the motion ended as {run.attrs['status']}: {run.attrs.get('message', '')}",
            status=run.attrs["status"],
            partial=run,
        )
    return run


def first_loss(run: xr.Dataset) -> Loss | None:
    """The first phase other than i of a run of the rig, from its event log; none in full contact.

    Phases that last no time, at a start or where a contact force touches zero, are none. The log
    is that of the whole run, of which the samples may be a part.
    """
    if "event_to" not in run or "event_time" not in run:
        raise OptionError("the run has no event log; simulate it without events=False")
    rows = run.sizes["event"]
    if rows == 0 or rows != run.attrs.get("n_rows", rows):
        raise OptionError(
            f"the run has {rows} of the {run.attrs.get('n_rows', 'at least 1')} rows of its event"
            " log; give all of it"
        )
    names = run["event_to"].attrs["flag_meanings"].split()
    # the first row is the start
    times = [float(time) for time in run["event_time"].values]
    ends = [*times[1:], _end(run)]
    for begin, end, mode in zip(times, ends, run["event_to"].values, strict=True):
        if names[int(mode)] != "i" and end > begin:
            return Loss(names[int(mode)], begin)
    return None


def _end(run: xr.Dataset) -> float:
    """Time at which a run ended, which may be after its last sample."""
    attrs = run.attrs
    if "end_time" in attrs:
        return float(attrs["end_time"])
    try:
        return float(attrs["end_number"] * attrs["window"] + attrs["end_phase"])
    except KeyError:
        return float("inf")  # not told: the last phase then counts as one that lasts


def swing(run: xr.Dataset, name: str) -> tuple[float, float]:
    """Least and largest value of a quantity, by a parabola through the extreme samples."""
    values = run[name].values
    return -_peak(-values), _peak(values)


def _peak(values: np.ndarray) -> float:
    i = int(np.argmax(values))
    if not 0 < i < len(values) - 1:
        return float(values[i])
    before, top, after = values[i - 1 : i + 2]
    bend = before - 2.0 * top + after
    # at a kink the parabola would stand above the motion
    return float(top - (after - before) ** 2 / (8.0 * bend)) if bend < 0.0 else float(top)
