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
# pictures of one channel, by what --draw calls them
_OF_CHANNELS = {"fit": "fit", "spectra": "fit_spectra"}


def fit(task: Task) -> None:
    """``nonsmooth fit``."""
    from nonsmooth.fitting.fit import fit as verb

    _check(task)
    system = task.system
    ranges = (value_limits(text, "--free") for text in task["free"])
    observe = settings(task["observe"], "--observe")
    records = _records(task, observe)
    sensor: dict[str, Any] = {
        name: _by_channel(flag(own), task[own]) for name, own in _SENSOR.items()
    }
    found = verb(
        system, records, dict(ranges), observe or None, by_record=_by_record(task), **sensor,
        **task.options("fit"),
    )  # fmt: skip
    report = Report(str(found.attrs["system_name"]))
    report.add("message", str(found.attrs["message"]))
    columns: list[Any] = [
        ("parameter", "parameter", str),
        ("estimate", "estimate", "{:.6g}".format),
        ("from", "interval_low", "{:.6g}".format),
        ("to (95 %)", "interval_high", "{:.6g}".format),
        ("determined", "identified", lambda known: "" if known else "no"),
    ]
    _add_table(report, "parameters", columns, found)
    channels: list[Any] = [
        ("channel", "channel", str),
        ("noise", "noise", "{:.4g}".format),
        ("whiteness", "whiteness", "{:.2g}".format),
        ("prediction", "prediction_error", lambda x: "" if np.isnan(x) else f"{x:.3g} noise"),
    ]
    _add_table(report, "channels", channels, found)
    drawn = _posterior(task, found, report)
    _choose_picture(task, found, drawn)
    code = task.by_status(found) or (0 if drawn is None else task.by_status(drawn))
    task.finish(found, report, code=code)


def _check(task: Task) -> None:
    """Refuse options that do not go together, and what the posterior would refuse after the fit."""
    from nonsmooth.fitting.posterior import check_chain

    if task["posterior"] is None and task["store"] is not None:
        raise OptionError("--store keeps draws of a posterior: give --posterior")
    if task["posterior"] is not None:
        check_chain(**task.options("posterior"))
    if task["channel"] is not None and task["draw"] not in _OF_CHANNELS:
        raise OptionError(f"--channel is that of samples or spectra, not of --draw {task['draw']}")


def _posterior(task: Task, found: xr.Dataset, report: Report) -> xr.Dataset | None:
    """Draw the posterior, where that was asked for, and add it to the report."""
    if task["posterior"] is None:
        return None
    from nonsmooth.fitting.posterior import posterior as verb

    drawn = verb(found, **task.options("posterior"))
    report.add("posterior", str(drawn.attrs["message"]))
    columns: list[Any] = [
        ("parameter", "parameter", str),
        ("mean", "mean", "{:.6g}".format),
        ("from", "interval_low", "{:.6g}".format),
        ("to (95 %)", "interval_high", "{:.6g}".format),
        ("independent draws", "effective_number", "{:.0f}".format),
        ("split R-hat", "split_r_hat", "{:.3f}".format),
    ]
    if "mean" in drawn:
        _add_table(report, "posterior_parameters", columns, drawn)
    return drawn


def _choose_picture(task: Task, found: xr.Dataset, drawn: xr.Dataset | None) -> None:
    """Choose what --plot draws."""
    if task["draw"] in _OF_CHANNELS:
        task.picture(_OF_CHANNELS[task["draw"]], found, task["channel"])
    elif task["draw"] == "corner":
        task.picture("corner", found, posterior=drawn)
    else:
        task.picture("profiles", found)


def _add_table(report: Report, name: str, columns: list[Any], data: xr.Dataset) -> None:
    """Add a table of variables over one dimension."""
    values = (data[variable].values for _, variable, _ in columns)
    report.table(name, columns, zip(*values, strict=True))


def _records(task: Task, observe: dict[str, str]) -> Any:
    """The record of the command, or all by their names where there are more."""
    first = Path(task["record"])
    more = {name: Path(text) for name, text in settings(task["more"], "--more").items()}
    events = settings(task["events"], "--events")
    if not more:
        return _record(task, first, observe, events)
    if events:
        raise OptionError("--events: with --more the instants must stand in netCDF files")
    if first.stem in more:
        raise OptionError(f"--more: {first.stem} is the name of RECORD; give another one")
    files = {first.stem: first, **more}
    return {name: _record(task, file, observe, {}) for name, file in files.items()}


def _record(task: Task, file: Path, observe: dict[str, str], events: dict[str, str]) -> xr.Dataset:
    """Record of a file: CSV with a column for each channel, or netCDF; with instants of events."""
    from nonsmooth import measured

    instants = {
        name: (name, measured.read_columns(text, {"instant": 0})["instant"].values)
        for name, text in events.items()
    }
    if file.suffix.lower() == ".nc":
        import xarray as xr

        if not file.is_file():
            raise OptionError(f"{file} is no file")
        return xr.load_dataset(file, engine="h5netcdf").assign(instants)
    columns = [name for name in observe if name not in events]
    if instants and not columns:  # RECORD is then the file of the instants
        import xarray as xr

        return xr.Dataset(instants)
    if not columns:
        raise OptionError("--observe: name the columns of a CSV file, such as --observe a1=rate(v)")
    options = task.options("measured.read_csv")
    return measured.read_csv(file, columns, **options).assign(instants)


def _by_record(task: Task) -> dict[str, dict[str, float]] | None:
    """Values such as ``slow.omega=0.8``, by record."""
    found: dict[str, dict[str, float]] = {}
    for name, text in settings(task["by_record"], "--by-record").items():
        label, dot, parameter = name.rpartition(".")
        if not (dot and label and parameter):
            raise OptionError(f"--by-record: {name!r} is not of the form record.parameter")
        found.setdefault(label, {})[parameter] = number(text, "--by-record")
    return found or None


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
