"""Flaws of the time itself: samples that are missing, uneven times, marks too many or too few."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.measured.clock import lost_samples, usual_step
from nonsmooth.measured.marking import faulty_marks
from nonsmooth.measured.quality.flaw import Flaw, Readings, stretches

__all__ = ["mark_findings", "missing_findings", "time_findings"]

Floats = npt.NDArray[np.float64]

_EVEN = 0.1  # of a step, that a time may be off: that which reading a record allows


def missing_findings(data: Readings) -> Iterator[Flaw]:
    """Stretches of samples that are not finite."""
    bad = ~np.isfinite(data.values)
    for first, last in stretches(bad):
        begin, end = float(data.times[first]), float(data.times[last - 1])
        count = last - first
        yield Flaw(
            data.name, "missing", begin, end, count, float(count),
            f"{data.name} has no reading from t = {begin:.7g} to {end:.7g}, {count} samples",
            np.arange(first, last),
        )  # fmt: skip


def time_findings(times: Floats) -> Iterator[Flaw]:
    """Gaps of the time, times that do not increase, and times off an even grid."""
    steps = np.diff(times)
    usual = usual_step(times)
    for k in np.flatnonzero(steps <= 0.0):
        yield Flaw(
            "time", "uneven", float(times[k]), float(times[k + 1]), 1, float(steps[k]),
            f"time does not increase: {times[k + 1]:.9g} follows {times[k]:.9g}",
        )  # fmt: skip
    # times that jitter have long steps, too: a gap moves all times behind it
    lost_at = lost_samples(times, usual)
    gaps = lost_at > 0
    for k in np.flatnonzero(gaps):
        lost = int(lost_at[k])
        yield Flaw(
            "time", "gap", float(times[k]), float(times[k + 1]), lost, float(steps[k]),
            f"about {lost} {'sample is' if lost == 1 else 'samples are'} missing between"
            f" t = {times[k]:.7g} and {times[k + 1]:.7g}",
        )  # fmt: skip
    inside = ~gaps & (steps > 0.0)
    off = np.abs(steps[inside] / usual - 1.0)
    if off.size and off.max() > 2.0 * _EVEN:  # a step has two ends
        count = int((off > 2.0 * _EVEN).sum())
        yield Flaw(
            "time", "uneven", float(times[0]), float(times[-1]), count, float(off.max()),
            f"{count} steps of the time are more than {2 * _EVEN:g} usual ones off, up to"
            f" {off.max():.3g}",
        )  # fmt: skip


def mark_findings(record: xr.Dataset) -> Iterator[Flaw]:
    """Marks that are one too many or missing, and those that were repaired."""
    if "mark_time" not in record.coords or record.sizes["mark"] < 3:
        return
    marks = record["mark_time"].values.astype(float)
    doubled, missed = faulty_marks(marks)
    for k in doubled:
        at = float(marks[k])
        yield Flaw("mark", "marks", at, at, 1, 1.0, f"a double mark at t = {at:.7g}")
    for k, count in missed:
        begin, end = float(marks[k]), float(marks[k + 1])
        yield Flaw(
            "mark", "marks", begin, end, count, -float(count),
            f"{count} marks are missing between t = {begin:.7g} and {end:.7g}",
        )  # fmt: skip
    repaired = int(record.attrs.get("n_repaired", 0))
    if repaired:
        yield Flaw(
            "mark", "marks", float(marks[0]), float(marks[-1]), repaired, float(repaired),
            f"{repaired} marks were repaired when the record was read",
            doubtful=False,
        )  # fmt: skip
