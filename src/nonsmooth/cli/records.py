"""Records as commands read them: their columns, and what is wrong with them; `check`."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from nonsmooth.cli.arguments import names, settings
from nonsmooth.cli.command import Task
from nonsmooth.cli.console import DOUBTFUL
from nonsmooth.cli.report import Report
from nonsmooth.errors import OptionError, unknown_name

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "add_flaws",
    "channels",
    "check",
    "checked",
    "code_of_flaws",
    "columns_of",
    "places_of",
    "refuse_repeated",
]

_MOST_TOLD = 20  # findings of a record
_CALIBRATION: dict[str, Any] = {"sensitivity": None, "offset": 0.0, "units": ""}


def columns_of(text: str) -> dict[str, str]:
    """Names with their columns; a name alone is that of its column."""
    parts = [part if "=" in part else f"{part}={part}" for part in names(text, "--columns")]
    return settings(parts, "--columns")


def places_of(columns: dict[str, str]) -> dict[str, str | int]:
    """Columns as reading takes them: a number is the place of a column, from 0."""
    return {name: int(column) if column.isdecimal() else column for name, column in columns.items()}


def refuse_repeated(files: Iterable[str | Path], where: str) -> None:
    """Refuse a record that is given twice, since its samples would count twice."""
    seen = set()
    for file in files:
        place = Path(file).resolve()
        if place in seen:
            raise OptionError(f"{where}: '{file}' is given twice; give each record once")
        seen.add(place)


def channels(task: Task, before: str = "") -> dict[str, Any]:
    """Channels of the columns, each with its own calibration where it has one.

    before: what is put in front of the name of each
    """
    from nonsmooth.measured import Channel

    columns = columns_of(task["columns"])
    given = task.options("measured.Channel")
    for key, value in given.items():
        for name in value if isinstance(value, dict) else ():
            if name not in columns:
                raise OptionError(f"--{key}: {unknown_name('name', name, columns)}")
    return {
        before + name: Channel(
            column,
            **{
                key: value.get(name, _CALIBRATION[key]) if isinstance(value, dict) else value
                for key, value in given.items()
            },
        )
        for name, column in places_of(columns).items()
    }


def checked(
    record: xr.Dataset, task: Task, *more: str, channels: list[str] | None = None
) -> tuple[xr.Dataset, xr.Dataset]:
    """A record with its mask, and what was found; each finding is told in a line.

    more: kinds that are not looked for, because what follows does not mind them; channels: what is
    looked at, all by default
    """
    from nonsmooth import measured

    options = task.options("measured.check")
    options["leave_out"] = [*(options["leave_out"] or ()), *more]
    given = {key: each for key, each in options.items() if each is not None}
    found = measured.check(record, channels=channels, **given)
    _tell(record, found)
    bad = any(
        found[name].values.any() for name in found.data_vars if str(name).endswith("_quality")
    )
    return measured.flagged(record, found) if bad else record, found


def _tell(record: xr.Dataset, found: xr.Dataset) -> None:
    """Print each finding; that a channel is constant the reading has told."""
    from nonsmooth.system.columns import harmless

    told = [
        str(sentence)
        for sentence, kind in zip(found["sentence"].values, found["kind"].values, strict=True)
        if kind != "constant"
    ]
    title = record.attrs["system_name"]
    for sentence in told[:_MOST_TOLD]:
        click.echo(f"nonsmooth: {harmless(f'{title}: {sentence}')}", err=True)
    if len(told) > _MOST_TOLD:
        more = f"nonsmooth: {title}: and {len(told) - _MOST_TOLD} more; nonsmooth check --json"
        click.echo(harmless(f"{more} lists all"), err=True)


def add_flaws(report: Report, *found: xr.Dataset) -> None:
    """Add how many flaws some records have, if any."""
    told = sum(one.attrs["n_findings"] for one in found)
    if told:
        report.number("flaws", told)


def code_of_flaws(task: Task, *found: xr.Dataset) -> int:
    """Exit code of what was made of some records, by what was found in them."""
    doubtful = any(one.attrs["n_doubtful"] for one in found)
    return DOUBTFUL if doubtful and not task["accept_flaws"] else 0


def check(task: Task) -> None:
    """``nonsmooth check``."""
    from nonsmooth import measured as rig

    options = task.options("measured.read_csv") | {"bad_samples": "keep"}
    if task["mark"] is not None:
        options["bad_marks"] = "keep"
    record = rig.read_csv(task["record"], channels(task), **options)
    record, found = checked(record, task)
    channel = _drawn(record, found, task["draw"])
    report = Report(record.attrs["system_name"])
    count, rate = record.sizes["time"], record.attrs["sample_rate"]
    report.add("samples", f"{count}, {rate:.6g} per s", samples=count, sample_rate=rate)
    if "mark_time" in record.coords:
        report.number("marks", record.sizes["mark"])
    for name in map(str, record.data_vars):
        words = found[f"{name}_quality"].attrs
        bad = int((found[f"{name}_quality"] > 0).sum())
        shown = f"noise {words['noise']:.3g}" if words["noise_visible"] else "no noise to be seen"
        report.add(name, f"{bad} bad samples; {shown}, least step {words['step']:.3g}")
    report.data["channels"] = {
        name: {"bad_samples": int((found[f"{name}_quality"] > 0).sum())}
        | {key: found[f"{name}_quality"].attrs[key] for key in ("noise", "step", "noise_visible")}
        for name in map(str, record.data_vars)
    }
    text = f"{found.attrs['n_findings']}, {found.attrs['n_doubtful']} of them doubtful"
    report.add("flaws", text, flaws=found.attrs["n_findings"], doubtful=found.attrs["n_doubtful"])
    columns = [(key, key, str if key in ("channel", "kind") else "{:.6g}".format) for key in _SHOWN]
    rows = zip(*(found[key].values.tolist() for key in _SHOWN), strict=True)
    report.table("findings", columns, rows, _MOST_TOLD)
    for row, sentence in zip(report.data["findings"], found["sentence"].values, strict=True):
        row["sentence"] = str(sentence)
    task.picture("quality", record, found, channel)
    task.finish(found, report, code=code_of_flaws(task, found))


_SHOWN = ("channel", "kind", "begin", "end", "n_samples", "size")


def _drawn(record: xr.Dataset, found: xr.Dataset, wanted: str | None) -> str:
    """Channel to draw: the first one with a flaw without a wish."""
    known = [str(name) for name in record.data_vars]
    if wanted is None:
        flawed = [str(name) for name in found["channel"].values]
        return next((name for name in flawed if name in known), known[0])
    if wanted not in known:
        raise OptionError(f"--draw: {unknown_name('variable', wanted, known)}")
    return wanted
