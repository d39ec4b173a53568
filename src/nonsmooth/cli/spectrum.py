"""``nonsmooth spectrum``: amplitudes of a variable over frequency."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli.arguments import build_system, constants, names, settings
from nonsmooth.cli.console import MODEL_HELP, PARAMETERS_HELP
from nonsmooth.cli.output import check_files, save_dataset, table
from nonsmooth.errors import OptionError, RunError, RunWarning

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["spectrum"]

_WIDTH, _HEIGHT = 12.0, 7.5  # centimetres
_SHOWN = 8  # amplitudes in the summary


def spectrum(
    model: Annotated[str, typer.Argument(metavar="MODEL", help=MODEL_HELP)],
    parameters: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME=VALUE...", help=PARAMETERS_HELP),
    ] = None,
    *,
    variable: Annotated[
        str | None, typer.Option(metavar="x", help="State or output; the first state by default.")
    ] = None,
    second: Annotated[
        str | None,
        typer.Option(metavar="y", help="Second coordinate: forward and backward whirl apart."),
    ] = None,
    transient: Annotated[
        float, typer.Option(help="Dropped first: periods, or time without a period.")
    ] = 200.0,
    record: Annotated[
        float, typer.Option(help="Length of the record: periods, or time without a period.")
    ] = 200.0,
    samples: Annotated[
        int, typer.Option(help="Samples per period, or per unit of time without one.")
    ] = 64,
    window: Annotated[str, typer.Option(help="Such as hann; boxcar is none.")] = "boxcar",
    segments: Annotated[int, typer.Option(help="Parts whose power is averaged.")] = 1,
    start: Annotated[
        str | None, typer.Option(metavar="p=0.1,y=0", help="States at the start.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the amplitudes: .png or .pdf.")
    ] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save the result as netCDF: .nc.")
    ] = None,
) -> None:
    """Spectrum of a variable of a ready-made system, or of one in a file."""
    check_files(plot, save)
    system = build_system(model, settings(parameters or [], "NAME=VALUE"))
    initial = constants(settings(names(start), "--start"), "--start")
    run = _run(system, initial, transient, record, samples)
    if run.attrs["status"] != "completed":
        raise RunError(f"{system.name}: {run.attrs['message']}")
    from nonsmooth.system.columns import harmless

    shown = variable or system.states[0]
    result = _spectrum(run, shown, second, transient, window, segments)
    typer.echo(harmless(_summary(result)))
    if save is not None:
        save_dataset(result, save)
    if plot is not None:
        _plot(result, plot)


def _run(
    system: System, initial: dict[str, float], transient: float, record: float, samples: int
) -> xr.Dataset:
    import numpy as np

    from nonsmooth.runs.simulate import simulate

    if not (transient >= 0.0 and record > 0.0 and samples >= 2):
        raise OptionError("--record must be positive, --transient not negative, --samples >= 2")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)  # told as an error
        if system.period is not None:
            periods = transient + record
            return simulate(
                system, initial, periods=periods, samples_per_period=samples, events=False
            )
        count = int((transient + record) * samples)
        return simulate(system, initial, times=np.arange(count + 1) / samples, events=False)


def _spectrum(
    run: xr.Dataset, x: str, y: str | None, transient: float, window: str, segments: int
) -> xr.Dataset:
    from nonsmooth.analysis.full_spectrum import full_spectrum
    from nonsmooth.analysis.power_spectrum import power_spectrum

    if y is None:
        return power_spectrum(run, x, transient=transient, window=window, segments=segments)
    return full_spectrum(run, x, y, transient=transient, window=window, segments=segments)


def _summary(result: xr.Dataset) -> str:
    """The largest amplitudes, by frequency and harmonic."""
    import numpy as np

    attrs, amplitude = result.attrs, result["amplitude"].values
    rows = [
        ("variable", str(attrs["variable"])),
        ("record", f"{attrs['segments']} x {attrs['n_samples']} samples, window {attrs['window']}"),
        ("mean", f"{amplitude[result['frequency'].values == 0.0].item():.6g}"),
    ]
    amplitude = np.where(result["frequency"].values == 0.0, 0.0, amplitude)
    rising = np.concatenate([[False], amplitude[1:] > amplitude[:-1]])
    falling = np.concatenate([amplitude[:-1] >= amplitude[1:], [True]])
    peaks = np.flatnonzero(rising & falling & (amplitude > 1e-9 * amplitude.max()))
    largest = peaks[np.argsort(-amplitude[peaks], kind="stable")][:_SHOWN]
    for k in sorted(largest):
        text = f"amplitude {amplitude[k]:.6g}"
        if "harmonic" in result.coords:
            text += f", harmonic {float(result['harmonic'][k]):.6g}"
        rows.append((f"frequency {float(result['frequency'][k]):.6g}", text))
    return table(str(attrs["system_name"]), rows)


def _plot(result: xr.Dataset, path: Path) -> None:
    from nonsmooth.plot import print_figure, save_figure
    from nonsmooth.plot import spectrum as draw

    figure, (ax,) = print_figure(width=_WIDTH, height=_HEIGHT)
    draw(result, ax=ax)
    save_figure(figure, path)
    typer.echo(f"drawn {path}")
