"""The command that fits parameters of a system to a record."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.cli.arguments import number, settings, value_limits
from nonsmooth.cli.command import Task
from nonsmooth.cli.options import flag
from nonsmooth.cli.records import (
    add_flaws,
    checked,
    code_of_flaws,
    columns_of,
    places_of,
    refuse_repeated,
)
from nonsmooth.cli.report import Report
from nonsmooth.cli.saved import saved_dataset
from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["fit"]

# options of the shell by the names of the arguments; --offset is one number in other commands
_SENSOR = {"gain": "gain", "offset": "channel_offset", "delay": "delay", "noise": "noise"}
_BY_RECORD = "record.name=value"
# pictures of one channel, by what --draw calls them
_OF_CHANNELS = {"fit": "fit", "spectra": "fit_spectra"}
# no flaws of what is fitted: the mean of a transient moves by itself
_OF_TRANSIENTS = ("drift", "runaway")


def fit(task: Task) -> None:
    """``nonsmooth fit``."""
    from nonsmooth.fitting.channels import check_free
    from nonsmooth.fitting.fit import fit as verb

    _check(task)
    system = task.system
    task.refuse_fixed(settings(task["free"], "--free", "name=low:high"), "--free")
    ranges = dict(value_limits(text, "--free") for text in task["free"])
    check_free(system, ranges)  # before anything is said of the record
    flaws: list[xr.Dataset] = []
    records, observe = _records(task, flaws)
    sensor: dict[str, Any] = {
        name: _by_channel(flag(own), task[own]) for name, own in _SENSOR.items()
    }
    found = verb(
        system, records, ranges, observe or None, by_record=_by_record(task), **sensor,
        **task.options("fit"),
    )  # fmt: skip
    report = Report(str(found.attrs["system_name"]))
    # the table of the shell has no such column
    report.add("message", str(found.attrs["message"]).replace(" (interval_open)", ""))
    add_flaws(report, *flaws)
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
    task.finish(found, report, code=code or code_of_flaws(task, *flaws))


def _check(task: Task) -> None:
    """Refuse options that do not go together, and what the posterior would refuse after the fit."""
    from nonsmooth.fitting.posterior import check_chain

    if task["private"] and not task["more"]:
        raise OptionError("--private: there is one record; name further ones by --more")
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
    if found.attrs["status"] != "completed":
        report.add("posterior", "not drawn, since the fit has not converged")
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


def _records(task: Task, flaws: list[xr.Dataset]) -> tuple[Any, dict[str, str]]:
    """The record of the command, or all by their names where there are more; and what they show.

    flaws: what is found to be wrong with the records is added to it
    """
    first = Path(task["record"])
    further = settings(task["more"], "--more", "name=file")
    more = {name: Path(text) for name, text in further.items()}
    events = settings(task["events"], "--events", "name=file")
    columns = columns_of(task["columns"]) if task["columns"] is not None else {}
    observe = _observed(task, columns, events)
    columns |= {name: name for name in observe if name not in (*columns, *events)}
    if more and events:
        raise OptionError("--events: with --more the instants must stand in netCDF files")
    if first.stem in more:
        raise OptionError(f"--more: {first.stem} is the name of RECORD; give another one")
    refuse_repeated([first, *more.values()], "--more")
    if events and not columns and first.suffix.lower() != ".nc":
        _check_alone(first, events)
        import xarray as xr

        return xr.Dataset(_instants(task, events)), observe
    files = {first.stem: first, **more}
    records = {name: _record(task, file, columns, flaws) for name, file in files.items()}
    if more:
        return records, observe
    return records[first.stem].assign(_instants(task, events)), observe


def _observed(task: Task, columns: dict[str, str], events: dict[str, str]) -> dict[str, str]:
    """What each channel shows; one without a word shows what has its name."""
    from nonsmooth.runs.section_search import event_names

    found = settings(task["observe"], "--observe", "name=expression")
    system = task.system
    shown: dict[str, Any] = dict.fromkeys(columns, (*system.states, *system.outputs))
    shown |= dict.fromkeys(events, event_names(system) if events else ())
    for name, known in shown.items():
        if name in found:
            continue
        if name not in known:
            what = "instants" if name in events else "column"
            raise OptionError(
                f"--observe does not say what the {what} {name} shows: give one of"
                f" {', '.join(known)}, such as --observe {name}={next(iter(known), 'x')}"
            )
        found[name] = name
    for name in found:
        if name not in shown and not name.isidentifier():
            raise OptionError(
                f"--observe: {name!r} cannot be the name of a channel; give the column a name, as"
                f" in --columns 'a1={name}' --observe a1={found[name]}"
            )
    return found


def _check_alone(file: Path, events: dict[str, str]) -> None:
    """Refuse a record of which nothing is fitted; with instants alone RECORD is their file."""
    if all(file.absolute() != Path(text).absolute() for text in events.values()):
        raise OptionError(
            f"--observe says nothing of the columns of {file}: name one, such as --observe x=x; to"
            " fit the instants of --events alone, give their file as RECORD too"
        )


def _instants(task: Task, events: dict[str, str]) -> dict[str, tuple[str, np.ndarray]]:
    """Instants of events in s, within the range of time that is kept, with a dimension for each."""
    from nonsmooth import measured
    from nonsmooth.measured.csv_text import read_table
    from nonsmooth.measured.reading import seconds_of, unit_of_times

    reading = task.options("measured.read_csv", "time", "sample_rate", "time_range")
    low, high = (-np.inf, np.inf) if task["time_range"] is None else task["time_range"]
    found = {}
    for name, text in events.items():
        column = measured.read_columns(text, {"instant": 0}, **reading)["instant"]
        units = column.attrs["units"] or unit_of_times(read_table(text, None, None).header(0))
        instants = column.values * seconds_of(units, text, "give them in s")
        found[name] = name, instants[(instants >= low) & (instants <= high)]
    return found


def _record(task: Task, file: Path, columns: dict[str, str], flaws: list[xr.Dataset]) -> xr.Dataset:
    """Record of a file, netCDF or CSV, in which flawed samples are flagged."""
    from nonsmooth import measured

    if file.suffix.lower() == ".nc":
        record = _saved_record(task, file)
        if "time" not in record.dims:  # instants alone
            return record
        names = [name for name in columns if name in record and record[name].dims == ("time",)]
    elif not columns:
        raise OptionError("--observe: name the columns of a CSV file, such as --observe a1=rate(v)")
    else:
        options = task.options("measured.read_csv") | {"bad_samples": "keep"}
        record = measured.read_csv(file, places_of(columns), **options)
        names = list(columns)
    record, found = checked(record, task, *_OF_TRANSIENTS, channels=names or None)
    flaws.append(found)
    return record


def _saved_record(task: Task, file: Path) -> xr.Dataset:
    """Record of a netCDF file."""
    if task["columns"] is not None:
        raise OptionError(f"--columns is that of CSV files; in {file} channels have their names")
    record = saved_dataset(file)
    return record.assign_attrs({"system_name": file.stem} | record.attrs)


def _by_record(task: Task) -> dict[str, dict[str, float]] | None:
    """Values such as ``slow.omega=0.8``, by record."""
    found: dict[str, dict[str, float]] = {}
    for name, text in settings(task["by_record"], "--by-record", _BY_RECORD).items():
        label, dot, parameter = name.rpartition(".")
        if not (dot and label and parameter):
            raise OptionError(f"--by-record: {name!r} is not of the form {_BY_RECORD}")
        found.setdefault(label, {})[parameter] = number(text, f"--by-record: {name}")
    if found and not task["more"]:
        raise OptionError("--by-record: there is one record; name further ones by --more")
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
            found[name] = number(text, f"{option}: {name}")
    return found or None
