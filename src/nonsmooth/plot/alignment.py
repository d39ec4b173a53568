"""Times of two motions brought together: by their marks, or by the phase between them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, unknown_choice

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["WAYS", "folded", "marks_of", "shift_to_marks", "turns_of", "way_to_align"]

Floats = npt.NDArray[np.float64]

_INSTANT = 1e-9  # part of a motion that is no time
WAYS = ("mark", "phase", "time")


def way_to_align(align: Any, x: str, computed: xr.Dataset, measured: xr.Dataset) -> str:
    """How histories over time are aligned; by marks, where both have them, if nothing is given."""
    if align is None:
        both = x == "time" and all(marks_of(each).size for each in (computed, measured))
        return "mark" if both else "time"
    if align not in WAYS:
        raise OptionError(unknown_choice("align", align, WAYS))
    if x != "time":
        raise OptionError(
            f"align = {align!r}: histories over time are aligned; give x='time', or leave align="
            " out"
        )
    for data, which in ((computed, "computed"), (measured, "measured")):
        if align != "time" and not marks_of(data).size:
            raise OptionError(
                f"align = {align!r}: what was {which} has no marks and no period; give"
                " align='time', or a record with marks and a run of a system with a period"
            )
    return str(align)


def marks_of(data: xr.Dataset) -> Floats:
    """Times of the marks of a record, or at which periods of the forcing begin; none of others."""
    if "mark_time" in data.coords and data.sizes.get("mark"):
        return np.asarray(data["mark_time"].values, float)
    if "period" not in data.attrs or not {"phase", "period_number"} <= set(data.coords):
        return np.zeros(0)
    _, first = np.unique(data["period_number"].values, return_index=True)
    begins = data["time"].values[first] - data["phase"].values[first]
    return np.asarray(begins, float)


def shift_to_marks(computed: xr.Dataset, measured: xr.Dataset) -> float:
    """What is added to the time of the computed motion, so that its last mark is the last one."""
    last = []
    for data in (computed, measured):
        marks = marks_of(data)
        first, end = (float(data["time"][k]) for k in (0, -1))
        within = marks[marks < end - _INSTANT * (end - first)]  # with something behind it
        last.append(float((within if within.size else marks)[-1]))
    return last[1] - last[0]


def folded(
    time: Floats, values: Floats, data: xr.Dataset, periods: int = 1
) -> tuple[Floats, Floats]:
    """Phase of a history, from 0 at a mark to the number of periods, with a gap in between."""
    turns = turns_of(time, data)
    number = np.floor(turns / periods)
    ends = np.flatnonzero(np.diff(number) > 0)  # the last point before each return
    at_end = number[ends + 1] * periods
    share = (at_end - turns[ends]) / (turns[ends + 1] - turns[ends])
    between = values[ends] + share * (values[ends + 1] - values[ends])
    places = np.repeat(ends + 1, 3)
    gap = np.full(ends.size, np.nan)
    phases = np.stack([np.full(ends.size, float(periods)), gap, np.zeros(ends.size)], axis=1)
    joined = np.stack([between, gap, between], axis=1).ravel()
    return (
        np.insert(turns - number * periods, places, phases.ravel()),
        np.insert(values, places, joined),
    )


def turns_of(time: Floats, data: xr.Dataset) -> Floats:
    """Number of marks that have passed, and parts between them."""
    marks = marks_of(data)
    step = float(data.attrs["period"]) if marks.size < 2 else 0.0
    before, behind = (step, step) if step else (marks[1] - marks[0], marks[-1] - marks[-2])
    # a mark more on either side, as far from the last as those before: samples may go beyond
    n_before = int(np.ceil(max(0.0, marks[0] - time[0]) / before)) + 1
    n_behind = int(np.ceil(max(0.0, time[-1] - marks[-1]) / behind)) + 1
    marks = np.concatenate(
        [
            marks[0] - before * np.arange(n_before, 0, -1),
            marks,
            marks[-1] + behind * np.arange(1, n_behind + 1),
        ]
    )
    return np.interp(time, marks, np.arange(marks.size, dtype=float) - n_before)
