"""The command that reads measured motions, takes their section or draws a diagram of several."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.cli.arguments import names
from nonsmooth.cli.command import Task
from nonsmooth.cli.records import add_flaws, channels, checked, code_of_flaws, refuse_repeated
from nonsmooth.cli.report import Report
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.measured.quality.masks import quality_of

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["measured"]

_READING = "acceleration_"  # before the name of a displacement: what it is integrated from


def measured(task: Task) -> None:
    """``nonsmooth measured``."""
    _check(task)
    from nonsmooth import measured as rig

    columns = channels(task, "" if task["lowest"] is None else _READING)
    read = [_read(file, columns, task) for file in task["files"]]
    flaws = [found for _, found in read]
    records = [_processed(one, columns, task) for one, _ in read]
    if task["mark"] is None:
        result = records[0]
        shown = _shown(result, task["draw"], 1, 2)
        report = _record_report(result)
    elif len(records) == 1:
        result = rig.section(records[0], **task.options("measured.section"))
        shown = _shown(result, task["draw"], 2, 2)
        cut_off = _marks_within(read[0][0]) - _marks_within(records[0])
        report = _section_report(records[0], result, cut_off)
    else:
        options = task.options("measured.section") | task.options("measured.diagram")
        result = rig.diagram(records, **options)
        shown = _shown(result, task["draw"], 1, 1)
        report = _diagram_report(result, len(records))

    if "time" in result.dims:
        task.picture("time_history" if len(shown) == 1 else "phase_portrait", result, *shown)
    else:
        task.picture("bifurcation" if len(shown) == 1 else "section", result, *shown)
    add_flaws(report, *flaws)
    task.finish(result, report, code=code_of_flaws(task, *flaws))


def _check(task: Task) -> None:
    """Refuse options that do not go together."""
    files = task["files"]
    refuse_repeated(files, "records")
    if task["speed_unit"] is not None and len(files) == 1:
        raise OptionError("--speed-unit is that of a diagram, which several files give")
    if task["mark"] is None:
        if len(files) > 1:
            raise OptionError("several files make a diagram of sections: name the column of --mark")
        for name in ("transient", "phase"):
            if task[name]:
                raise OptionError(f"--{name} is that of a section: name the column of --mark")
    if (task["length"] is None) != (task["natural_frequency"] is None):
        raise OptionError("give --length and --natural-frequency together, or neither")
    if task["lowest"] is not None and task["highest"] is not None:
        raise OptionError("--highest is of velocities, which --lowest integrates; use --low-pass")


def _read(file: str, columns: dict[str, Any], task: Task) -> tuple[xr.Dataset, xr.Dataset]:
    """Record as it was measured, and what is wrong with it."""
    from nonsmooth import measured as rig

    record = rig.read_csv(file, columns, **task.options("measured.read_csv"))
    # integration from a lowest frequency on takes a drift off
    return checked(record, task, *(() if task["lowest"] is None else ("drift",)))


def _processed(record: xr.Dataset, columns: dict[str, Any], task: Task) -> xr.Dataset:
    """Record behind its filters, with velocities where their band is known."""
    from nonsmooth import measured as rig

    if task["low_pass"] is not None:
        record = rig.low_pass(record, task["low_pass"])
    if task["lowest"] is not None:
        displacements = {name: name.removeprefix(_READING) for name in columns}
        limits = {"lowest": task["lowest"], "bias": task["bias"]}
        record = rig.displacements(record, displacements, **limits)
    if task["length"] is not None:
        record = rig.dimensionless(record, **task.options("measured.dimensionless"))
    unmarked = "speed" not in record.attrs and task["highest"] is None
    if task["lowest"] is not None or unmarked:
        return record
    return rig.velocities(record, **task.options("measured.velocities"))


def _marks_within(record: xr.Dataset) -> int:
    """Number of marks between the first and the last sample of a record."""
    times, marks = record["time"].values, record["mark_time"].values
    return int(((marks >= times[0]) & (marks <= times[-1])).sum())


def _record_report(record: xr.Dataset) -> Report:
    """What a user wants to know of a record without marks before believing it."""
    report = Report(record.attrs["system_name"])
    rate, count = record.attrs["sample_rate"], record.sizes["time"]
    text = f"{count}, {rate:.6g} per unit time; no marks"
    report.add("samples", text, samples=count, sample_rate=rate)
    _add_variables(report, record)
    return report


def _section_report(record: xr.Dataset, points: xr.Dataset, cut_off: int) -> Report:
    """What a user wants to know of a section before believing it.

    cut_off: marks among the samples that the filters took as they need both of their sides
    """
    report, attrs = Report(record.attrs["system_name"]), points.attrs
    unit = points["speed"].attrs.get("units", "")
    if "speed" in attrs:
        speed, spread = attrs["speed"], attrs["speed_spread"]
        text = f"{speed:.7g} {unit} +- {spread:.2g}"
        report.add("speed", text, speed=speed, speed_spread=spread, speed_unit=unit)
    count, marks = points.sizes["point"], record.sizes["mark"]
    text = f"{count} of {marks} marks"
    text += f"; {cut_off} lie in the ends that the filter cuts off" if cut_off else ""
    report.add("points", text, points=count, marks=marks, marks_cut_off=cut_off)
    flagged = int(_flagged(points).sum())
    report.data["points_flagged"] = flagged
    if flagged:
        report.lines.append(("flagged", f"{flagged} of {count} points are made of flagged samples"))
    if attrs["n_repaired"]:
        report.add("repaired", f"{attrs['n_repaired']} marks", n_repaired=attrs["n_repaired"])
    error = attrs["mark_error"]
    text = f"by sampling at most {error:.3g} {_unit(record['time'])}"
    report.add("mark error", text, mark_error=error)
    _add_variables(report, record)
    return report


def _flagged(points: xr.Dataset) -> np.ndarray:
    """Whether points are made of flagged samples, in one of their variables at least."""
    flagged = np.zeros(1, bool)
    for name in map(str, points.data_vars):
        mask = quality_of(points, name)
        if mask is not None:
            flagged = flagged | (mask > 0)
    return flagged


def _add_variables(report: Report, record: xr.Dataset) -> None:
    """Add the noise of each variable, and up to which frequency it is right."""
    told: dict[str, dict[str, Any]] = {}
    for name in map(str, record.data_vars):
        words = record[name].attrs
        keys = (
            "long_name",
            "units",
            "noise",
            "noise_gain",
            "lowest",
            "highest",
            "bandwidth",
            "bias",
        )
        told[name] = {key: words[key] for key in keys if key in words}
        if "noise" not in words:  # neither filtered, integrated nor differentiated
            report.add(name, str(words["long_name"]), variables=told)
            continue
        text = f"noise {words['noise']:.3g} {words.get('units', '')}".rstrip()
        if "lowest" in words:
            text += (
                f" (gain {words['noise_gain']:.4g}); integrated, right to {words['bias']:g} from"
                f" the frequency {words['lowest']:.4g} on"
            )
        if "bandwidth" in words:
            text += (
                f" (gain {words['noise_gain']:.4g}); right to {words['bias']:g} up to the"
                f" frequency {words['highest']:.4g}, -3 dB at {words['bandwidth']:.4g}"
            )
        report.add(name, text, variables=told)


def _diagram_report(result: xr.Dataset, records: int) -> Report:
    """A line for each record of a diagram."""
    report, unit = Report(f"{records} records"), _unit(result["speed"])
    found = []
    for k, source in enumerate(result.attrs["sources"].split(", ")):
        speed, spread = (float(result[name][k, 0]) for name in ("speed", "speed_spread"))
        count = int(result["n_points"][k, 0])
        flagged = int(_flagged(result.isel(parameter=k)).sum())
        told = {"source": source, "speed": speed, "speed_spread": spread, "points": count}
        found.append(told | {"points_flagged": flagged})
        text = f"speed {speed:.6g} {unit} +- {spread:.2g}, {count} points".replace("  ", " ")
        text += f", {flagged} of flagged samples" if flagged else ""
        report.add(source, text, speed_unit=unit, records=found)
    return report


def _unit(values: xr.DataArray) -> str:
    return str(values.attrs.get("units", ""))


def _shown(result: xr.Dataset, text: str | None, fewest: int, most: int) -> list[str]:
    """Variables to draw: by default the first displacement, with its velocity but in a diagram."""
    known = [str(n) for n, v in result.data_vars.items() if {"point", "time"} & set(v.dims)]
    velocity = [n for n in known if result[n].attrs.get("derivative_of") == known[0]]
    found = names(text, "--draw") if text is not None else [known[0], *velocity][:most]
    if not fewest <= len(found) <= most:
        count = most if fewest == most else f"{fewest} or {most}"
        raise OptionError(f"--draw: {text!r} must name {count} of {', '.join(known)}")
    for name in found:
        if name not in known:
            sentence = f"--draw: {unknown_name('variable', name, known)}"
            if name[:1] == "v" and name[1:] in known:
                sentence += f"; --highest gives {name}, the velocity of {name[1:]}"
            raise OptionError(sentence)
    return found
