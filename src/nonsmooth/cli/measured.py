"""``nonsmooth measured``: a measured motion, its section, or a diagram of several."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nonsmooth.cli import options
from nonsmooth.cli.arguments import constants, names, settings
from nonsmooth.cli.output import check_files, save_dataset, table
from nonsmooth.errors import OptionError, ResultWarning, unknown_name

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["measured"]

_WIDTH, _HEIGHT = 10.0, 8.0  # centimetres
_READING = "acceleration_"  # before the name of a displacement: what it is integrated from


def measured(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="CSV, one per speed.")],
    *,
    columns: Annotated[
        str, typer.Option(metavar="x=CH1,y=CH2", help="Displacements: names and columns.")
    ],
    mark: Annotated[
        str | None,
        typer.Option(metavar="COLUMN", help="One pulse per revolution; without it no section."),
    ] = None,
    time: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="Times; 'time' or 't' by default.")
    ] = None,
    sample_rate: Annotated[
        float | None, typer.Option(help="Samples per s, in place of times.")
    ] = None,
    edge: Annotated[str, typer.Option(help="Of a pulse: rising or falling.")] = "rising",
    threshold: Annotated[
        float | None, typer.Option(help="Level of an edge; midway by default.")
    ] = None,
    bad_marks: Annotated[
        str, typer.Option(help="Double or missing ones: refuse or repair.")
    ] = "refuse",
    sensitivity: Annotated[
        float | None, typer.Option(help="Reading per unit of displacement, of all columns.")
    ] = None,
    offset: Annotated[float, typer.Option(help="Reading at zero displacement.")] = 0.0,
    units: Annotated[str, typer.Option(help="Of displacements; as in headers by default.")] = "",
    length: Annotated[
        float | None, typer.Option(help="Unit of length, such as the gap, for no dimensions.")
    ] = None,
    natural_frequency: Annotated[
        str | None, typer.Option(metavar="2*pi*14.4", help="In rad/s, with --length.")
    ] = None,
    highest: Annotated[
        float | None,
        typer.Option(help="Highest frequency of velocities, in cycles; 10 per revolution without."),
    ] = None,
    bias: Annotated[float, typer.Option(help="Relative error allowed there.")] = 0.01,
    low_pass: Annotated[
        float | None,
        typer.Option(help="Cut-off frequency of a filter without delay, before all else."),
    ] = None,
    lowest: Annotated[
        float | None,
        typer.Option(
            help="Columns are accelerations; integrate twice what is above this frequency."
        ),
    ] = None,
    transient: Annotated[int, typer.Option(help="Marks to drop first.")] = 0,
    phase: options.Phase = None,
    unit: Annotated[str | None, typer.Option(help="Speed in a diagram: rad/s, Hz or rpm.")] = None,
    variables: Annotated[
        str | None,
        typer.Option(metavar="x,vx", help="To draw; one of a diagram, one or two of a record."),
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw record, section or diagram: .png or .pdf."),
    ] = None,
    save: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Save record, section or diagram as netCDF: .nc."),
    ] = None,
) -> None:
    """Section of a measured motion with one mark per revolution; a diagram of several.

    Without marks: the motion itself, filtered, integrated or differentiated.
    """
    check_files(plot, save)
    if plot is None and variables is not None:
        raise OptionError("--variables are drawn into a file: name it, such as --plot picture.png")
    if unit is not None and len(files) == 1:
        raise OptionError("--unit is that of a diagram, which several files give")
    if mark is None:
        _check_unmarked(files, {"--transient": transient, "--phase": phase})
    from nonsmooth.measured import Channel, diagram, section
    from nonsmooth.system.columns import harmless

    before = "" if lowest is None else _READING
    channels = {
        before + name: Channel(_column(column), sensitivity=sensitivity, offset=offset, units=units)
        for name, column in _columns(columns).items()
    }
    reading: dict[str, Any] = {
        "time": _column(time), "sample_rate": sample_rate, "mark": _column(mark), "edge": edge,
        "threshold": threshold, "bad_marks": bad_marks,
    }  # fmt: skip
    scale = _scale(length, natural_frequency)
    treatment = {"low_pass": low_pass, "lowest": lowest, "highest": highest, "bias": bias}
    if lowest is not None and highest is not None:
        raise OptionError("--highest is of velocities, which --lowest integrates; use --low-pass")
    records = [_record(file, channels, reading, scale, treatment) for file in files]
    at: dict[str, Any] = {"transient": transient, "phase": phase or 0.0}
    if mark is None:
        result = records[0]
        shown = _shown(result, variables, 1, 2)
        text = table(result.attrs["system_name"], list(_rows(result)))
    elif len(records) == 1:
        result = section(records[0], **at)
        shown = _shown(result, variables, 2, 2)
        text = table(records[0].attrs["system_name"], list(_rows(records[0], result)))
    else:
        result = diagram(records, unit=unit, **at)
        shown = _shown(result, variables, 1, 1)
        text = table(f"{len(records)} records", list(_columns_of(result)))
    typer.echo(harmless(text))
    if save is not None:
        save_dataset(result, save)
    if plot is not None:
        _plot(result, shown, plot)


def _check_unmarked(files: list[Path], sections: dict[str, Any]) -> None:
    """Refuse what only marks give."""
    if len(files) > 1:
        raise OptionError("several files make a diagram of sections: name the column of --mark")
    for name, value in sections.items():
        if value:
            raise OptionError(f"{name} is that of a section: name the column of --mark")


def _columns(text: str) -> dict[str, str]:
    """Names with their columns; a name alone is that of its column."""
    return settings(
        [part if "=" in part else f"{part}={part}" for part in names(text)], "--columns"
    )


def _column(text: str | None) -> Any:
    """Column by its header or, where a whole number is given, by that."""
    return int(text) if text is not None and text.isdecimal() else text


def _scale(length: float | None, frequency: str | None) -> dict[str, Any] | None:
    if (length is None) != (frequency is None):
        raise OptionError("give --length and --natural-frequency together, or neither")
    if length is None or frequency is None:
        return None
    rate = constants({"natural_frequency": frequency}, "--natural-frequency")
    return {"length": length, **rate}


def _record(
    file: Path,
    channels: dict[str, Any],
    reading: dict[str, Any],
    scale: dict[str, Any] | None,
    treatment: dict[str, Any],
) -> xr.Dataset:
    """Record with velocities, where their band is known; warnings as lines of text."""
    from nonsmooth import measured as rig

    with warnings.catch_warnings(record=True) as raised:
        warnings.simplefilter("always", ResultWarning)
        record = rig.read_csv(file, channels, **reading)
    for warning in raised:
        typer.echo(f"nonsmooth: {warning.message}", err=True)
    bias, lowest = treatment["bias"], treatment["lowest"]
    if treatment["low_pass"] is not None:
        record = rig.low_pass(record, treatment["low_pass"])
    if lowest is not None:
        names = {name: name.removeprefix(_READING) for name in channels}
        record = rig.displacements(record, names, lowest=lowest, bias=bias)
    if scale is not None:
        record = rig.dimensionless(record, **scale)
    unmarked = "speed" not in record.attrs and treatment["highest"] is None
    if lowest is not None or unmarked:
        return record
    return rig.velocities(record, highest=treatment["highest"], bias=bias)


def _rows(record: xr.Dataset, points: xr.Dataset | None = None) -> Iterator[tuple[str, str]]:
    """What a user wants to know of a record before believing it, or its section."""
    if points is None:
        rate = record.attrs["sample_rate"]
        yield "samples", f"{record.sizes['time']}, {rate:.6g} per unit time; no marks"
    else:
        yield from _mark_rows(record, points)
    yield from _variable_rows(record)


def _mark_rows(record: xr.Dataset, points: xr.Dataset) -> Iterator[tuple[str, str]]:
    attrs, unit = points.attrs, points["speed"].attrs.get("units", "")
    if "speed" in attrs:
        yield "speed", f"{attrs['speed']:.7g} {unit} +- {attrs['speed_spread']:.2g}"
    yield "points", f"{points.sizes['point']} of {record.sizes['mark']} marks"
    if attrs["n_repaired"]:
        yield "repaired", f"{attrs['n_repaired']} marks"
    yield "mark error", f"by sampling at most {attrs['mark_error']:.3g} {_unit(record['time'])}"


def _variable_rows(record: xr.Dataset) -> Iterator[tuple[str, str]]:
    for name in map(str, record.data_vars):
        words = record[name].attrs
        if "noise" not in words:  # neither filtered, integrated nor differentiated
            yield name, str(words["long_name"])
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
        yield name, text


def _columns_of(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """A line per record of a diagram."""
    unit = _unit(result["speed"])
    for k, source in enumerate(result.attrs["sources"].split(", ")):
        speed, spread = (float(result[name][k, 0]) for name in ("speed", "speed_spread"))
        count = int(result["n_points"][k, 0])
        yield source, f"speed {speed:.6g} {unit} +- {spread:.2g}, {count} points".replace("  ", " ")


def _unit(values: xr.DataArray) -> str:
    return str(values.attrs.get("units", ""))


def _shown(result: xr.Dataset, text: str | None, fewest: int, most: int) -> list[str]:
    """Variables to draw: by default the first displacement, with its velocity but in a diagram."""
    known = [str(n) for n, v in result.data_vars.items() if {"point", "time"} & set(v.dims)]
    velocity = [n for n in known if result[n].attrs.get("derivative_of") == known[0]]
    chosen = names(text) if text is not None else [known[0], *velocity][:most]
    if not fewest <= len(chosen) <= most:
        count = most if fewest == most else f"{fewest} or {most}"
        raise OptionError(f"--variables: {text!r} must name {count} of {', '.join(known)}")
    for name in chosen:
        if name not in known:
            raise OptionError(f"--variables: {unknown_name('variable', name, known)}")
    return chosen


def _plot(result: xr.Dataset, shown: list[str], path: Path) -> None:
    from nonsmooth.plot import bifurcation, phase_portrait, print_figure, save_figure, time_history
    from nonsmooth.plot import section as draw

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    if "time" in result.dims:
        draw_motion = time_history if len(shown) == 1 else phase_portrait
        draw_motion(result, *shown, ax=ax)
    elif len(shown) == 1:
        bifurcation(result, shown[0], ax=ax)
    else:
        draw(result, *shown, ax=ax)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
