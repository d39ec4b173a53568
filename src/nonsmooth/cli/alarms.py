"""The command that sets an alarm by healthy records and judges watched ones by it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.cli.arguments import number, settings
from nonsmooth.cli.command import Task
from nonsmooth.cli.records import channels, checked, code_of_flaws, refuse_repeated
from nonsmooth.cli.report import Report
from nonsmooth.cli.saved import saved_dataset
from nonsmooth.errors import OptionError, unknown_name

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["alarm"]

_MOST_TOLD = 20  # windows with an alarm


def alarm(task: Task) -> None:
    """``nonsmooth alarm``."""
    from nonsmooth import measured

    _check(task)
    if task.plot is not None and not task["watched"]:
        raise OptionError("--plot draws watched windows: name their records by --watched")
    flaws: list[xr.Dataset] = []
    healthy = [_windows(file, task, flaws) for file in task["healthy"]]
    watched = [_windows(file, task, flaws) for file in task["watched"]]
    # a list of one record would be a record among several
    sets: Any = healthy[0] if len(healthy) == 1 else healthy
    found = measured.alarm(sets, watched or None, **task.options("measured.alarm"))
    report = Report(f"{len(healthy)} healthy records")
    count = sum(one.sizes["window"] for one in healthy)
    worth = float(found["n_effective"])
    report.add("healthy windows", f"{count}, worth {worth:.0f} independent ones for the threshold",
               healthy_windows=count, n_effective=worth)  # fmt: skip
    report.number("indicators", ", ".join(map(str, healthy[0].data_vars)))
    report.number("threshold", float(found["threshold"]), ".4g")
    _add_rate(report, "rate above it", found, "rate_expected rate_low rate_high")
    if found.attrs["among"] > 1:
        _add_rate(report, "rate of alarms", found, "alarm_rate alarm_rate_low alarm_rate_high")
    if watched:
        _add_watched(report, found, list(task["watched"]))
        task.picture("alarm", found)
    task.finish(found, report, code=code_of_flaws(task, *flaws))


def _check(task: Task) -> None:
    """Refuse what is given twice."""
    settings(task["contact_range"], "--contact-range", "name=low:high")
    refuse_repeated(task["healthy"], "healthy records")
    refuse_repeated(task["watched"], "--watched")


def _windows(file: str, task: Task, flaws: list[xr.Dataset]) -> xr.Dataset:
    """Indicators of a record; or those that a netCDF file holds already."""
    from nonsmooth import measured

    if Path(file).suffix.lower() == ".nc":
        found = saved_dataset(file)
    else:
        if task["columns"] is None:
            raise OptionError("--columns: name the columns of a CSV file, such as x=CH1")
        record = measured.read_csv(file, channels(task), **task.options("measured.read_csv"))
        record, own = checked(record, task)
        flaws.append(own)
        ranges = dict(_range(text) for text in task["contact_range"])
        options = task.options("measured.indicators")
        found = measured.indicators(record, contact=ranges or None, **options)
    if task["indicators"] is None:
        return found
    known = [str(name) for name in found.data_vars]
    for name in task["indicators"]:
        if name not in known:
            raise OptionError(f"--indicators: {unknown_name('indicator', name, known)}")
    return found[task["indicators"]]


def _range(text: str) -> tuple[str, tuple[float, float]]:
    """Name and ends of ``name=low:high``; an end that is left out is infinite."""
    ((name, value),) = settings([text], "--contact-range", "name=low:high").items()
    low, colon, high = (part.strip() for part in value.partition(":"))
    if not colon or not (low or high):
        raise OptionError(f"--contact-range: {text!r} is not of the form name=low:high")
    return name, (
        number(low, "--contact-range") if low else -np.inf,
        number(high, "--contact-range") if high else np.inf,
    )


def _add_rate(report: Report, label: str, found: xr.Dataset, names: str) -> None:
    """Add an expected rate with its interval."""
    rate, low, high = (float(found[name]) for name in names.split())
    data = dict(zip(names.split(), (rate, low, high), strict=True))
    report.add(label, f"{rate:.3g} of healthy windows ({low:.2g} to {high:.2g})", **data)


def _add_watched(report: Report, found: xr.Dataset, files: list[str]) -> None:
    """Add what was found in watched windows, and a table of those with an alarm."""
    above, alarmed = found["exceeded"].values, found["alarmed"].values
    report.add(
        "watched windows", f"{above.size}, {above.sum()} above the threshold",
        watched_windows=above.size, exceeded=int(above.sum()), alarms=int(alarmed.sum()),
    )  # fmt: skip
    zeros = np.zeros(above.size, dtype=int)
    records = found["record"].values if "record" in found.coords else zeros
    times = found["time"].values if "time" in found.coords else np.full(above.size, np.nan)
    first = int(found["first_alarm"])
    text = "none"
    if first >= 0:
        text = f"window {first + 1} of {above.size}, in {files[records[first]]}"
        text += f" at t = {times[first]:.6g}" if np.isfinite(times[first]) else ""
        text += f", {found['leading'].values[first]} leads"
    report.add("first alarm", text, first_alarm=None if first < 0 else first)
    columns: list[Any] = [
        ("window", "window", lambda k: str(k + 1)),  # people count from 1, programs from 0
        ("file", "file", str),
        ("time", "time", lambda t: "" if np.isnan(t) else f"{t:.6g}"),
        ("score", "score", "{:.4g}".format),
        ("leading", "leading", str),
    ]
    rows = (
        (int(k), files[records[k]], float(times[k]), float(found["score"][k]),
         str(found["leading"].values[k]))
        for k in np.flatnonzero(alarmed)
    )  # fmt: skip
    report.table("windows with an alarm", columns, rows, _MOST_TOLD)
