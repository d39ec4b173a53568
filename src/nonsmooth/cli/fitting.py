"""The command that fits parameters of a system to a record."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.cli.arguments import number, settings, value_limits
from nonsmooth.cli.command import Task
from nonsmooth.cli.options import flag
from nonsmooth.cli.report import Report
from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["fit"]

# options of the shell by the names of the arguments; --offset is one number in other commands
_SENSOR = {"gain": "gain", "offset": "channel_offset", "delay": "delay", "noise": "noise"}


def fit(task: Task) -> None:
    """``nonsmooth fit``."""
    from nonsmooth.fitting.fit import fit as verb

    system = task.system
    ranges = (value_limits(text, "--free") for text in task["free"])
    observe = settings(task["observe"], "--observe")
    record = _record(task, observe)
    sensor: dict[str, Any] = {
        name: _by_channel(flag(own), task[own]) for name, own in _SENSOR.items()
    }
    found = verb(system, record, dict(ranges), observe or None, **sensor, **task.options("fit"))
    report = Report(str(found.attrs["system_name"]))
    report.add("message", str(found.attrs["message"]))
    columns: list[Any] = [
        ("parameter", "parameter", str),
        ("estimate", "estimate", "{:.6g}".format),
        ("from", "interval_low", "{:.6g}".format),
        ("to (95 %)", "interval_high", "{:.6g}".format),
        ("determined", "identified", lambda known: "" if known else "no"),
    ]
    names = [name for _, name, _ in columns]
    report.table("parameters", columns, zip(*(found[name].values for name in names), strict=True))
    channels: list[Any] = [
        ("channel", "channel", str),
        ("noise", "noise", "{:.4g}".format),
        ("whiteness", "whiteness", "{:.2g}".format),
        ("prediction", "prediction_error", lambda x: "" if np.isnan(x) else f"{x:.3g} noise"),
    ]
    names = [name for _, name, _ in channels]
    report.table("channels", channels, zip(*(found[name].values for name in names), strict=True))
    task.picture("fit", found, task["draw"])
    task.finish(found, report, code=task.by_status(found))


def _record(task: Task, observe: dict[str, str]) -> xr.Dataset:
    """Record of a file: CSV with a column for each channel, or netCDF."""
    file = Path(task["record"])
    if file.suffix.lower() == ".nc":
        import xarray as xr

        if not file.is_file():
            raise OptionError(f"{file} is no file")
        return xr.load_dataset(file, engine="h5netcdf")
    from nonsmooth import measured

    if not observe:
        raise OptionError("--observe: name the columns of a CSV file, such as --observe a1=rate(v)")
    return measured.read_csv(file, list(observe), **task.options("measured.read_csv"))


def _by_channel(option: str, texts: tuple[str, ...]) -> dict[str, Any] | None:
    """Numbers, ranges and the word ``free`` by channel."""
    found: dict[str, Any] = {}
    for name, text in settings(texts, option).items():
        if text == "free":
            found[name] = text
        elif ":" in text:
            found[name] = value_limits(f"{name}={text}", option)[1]
        else:
            found[name] = number(text, option)
    return found or None
