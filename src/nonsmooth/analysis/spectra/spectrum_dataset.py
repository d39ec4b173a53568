"""Spectra as xarray datasets: one, or several below each other over a parameter."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.spectra.transforms import Lines
from nonsmooth.errors import OptionError, quote, unknown_name

__all__ = [
    "FREQUENCY",
    "HARMONIC",
    "Rows",
    "check_plane",
    "plane_label",
    "spectrum_dataset",
    "spectrum_labels",
    "waterfall_dataset",
]

Floats = npt.NDArray[np.float64]

FREQUENCY = "frequency in cycles per unit time"
HARMONIC = "frequency over that of the forcing"


def spectrum_labels(
    what: str, unit: str, time_unit: str
) -> tuple[dict[str, str], dict[str, str], dict[str, str]]:
    """Attributes of amplitude, power density and frequency of something with a unit."""
    per_density = {"units": f"({unit})^2 {time_unit}".strip()} if unit else {}
    frequency = {"long_name": FREQUENCY}
    if time_unit:
        frequency = {"long_name": "frequency in cycles", "units": f"1/{time_unit}"}
    if time_unit == "s":
        square = f"({unit})^2" if "/" in unit else f"{unit}^2"
        per_density = {"units": f"{square}/Hz"} if unit else {}
        frequency = {"long_name": "frequency", "units": "Hz"}
    return (
        {"long_name": f"amplitude of {what}"} | ({"units": unit} if unit else {}),
        {"long_name": f"power density of {what}"} | per_density,
        frequency,
    )


def spectrum_dataset(
    lines: Lines,
    periods: int,
    what: str,
    unit: str,
    time_unit: str,
    attrs: dict[str, Any],
    *,
    by_angle: bool = False,
) -> xr.Dataset:
    """Dataset of the spectrum of a record; ``attrs`` has its ``resolution``.

    Of samples that are even in the angle of a shaft, lines are orders, and have a frequency at the
    mean speed only.
    """
    texts = spectrum_labels(what, unit, time_unit)
    if by_angle:
        texts[2]["long_name"] = f"{texts[2]['long_name']} at the mean speed"
    coords: dict[str, Any] = {
        "frequency": ("frequency", lines.number * attrs["resolution"], texts[2])
    }
    if periods:
        coords["harmonic"] = ("frequency", lines.number / periods, {"long_name": HARMONIC})
    variables = {
        "amplitude": ("frequency", lines.amplitude, texts[0]),
        "power_density": ("frequency", lines.density, texts[1]),
    }
    return xr.Dataset(variables, coords, attrs)


class Rows(NamedTuple):
    """One spectrum for each value of a parameter, line by line."""

    harmonic: Floats  # (line,)
    amplitude: Floats  # (value, line)
    density: Floats
    period: Floats  # (value,) of the forcing, in time
    phase: Floats | None  # (value, line); None for averages, which have none


def check_plane(
    variable: Any, known: Sequence[str], attributes: Callable[[str], Mapping[str, str]]
) -> tuple[str, ...]:
    """One name, or two of the same unit, out of those that are known."""
    names: tuple[Any, ...] = (variable,) if isinstance(variable, str) else ()
    if isinstance(variable, Sequence) and not isinstance(variable, str):
        names = tuple(variable)
    if len(names) not in (1, 2):
        raise OptionError(
            f"variable = {quote(variable)}: give the name of a state or output, or two for a motion"
            " in a plane"
        )
    for name in names:
        if name not in known:
            raise OptionError(f"variable: {unknown_name('variable', name, known)}")
    if len(set(names)) < len(names):
        raise OptionError(
            f"variable: {names[0]!r} is given twice; a motion in a plane has two coordinates"
        )
    units = [attributes(name).get("units", "") for name in names]
    if len(set(units)) == 2:
        raise OptionError(
            f"{names[0]!r} is in {units[0] or 'no units'} and {names[1]!r} in"
            f" {units[1] or 'no units'}; a motion in a plane has one unit"
        )
    return tuple(str(name) for name in names)


def plane_label(names: Sequence[str], label: str) -> str:
    """What a spectrum is of: the label of one variable, or the names of two."""
    return (
        (label if label == names[0] else f"the {label}")
        if len(names) == 1
        else f"{names[0]} + i {names[1]}"
    )


def waterfall_dataset(
    rows: Rows,
    names: Sequence[str],
    labels: Sequence[Mapping[str, str]],
    parameter: Any,
    time_unit: str,
    attrs: dict[str, Any],
) -> xr.Dataset:
    """Dataset of spectra; ``parameter`` is a coordinate as xarray takes it."""
    what = plane_label(names, labels[0].get("long_name", names[0]))
    amplitude, density, frequency = spectrum_labels(what, labels[0].get("units", ""), time_unit)
    dims = ("parameter", "harmonic")
    time = {"units": time_unit} if time_unit else {}
    variables: dict[str, Any] = {
        "amplitude": (dims, rows.amplitude, amplitude),
        "power_density": (dims, rows.density, density),
    }
    if rows.phase is not None:
        label = {"long_name": "phase", "units": "rad"}
        variables["phase"] = (dims, rows.phase, label)
    return xr.Dataset(
        variables,
        {
            "parameter": parameter,
            "harmonic": (("harmonic",), rows.harmonic, {"long_name": HARMONIC}),
            "frequency": (dims, rows.harmonic / rows.period[:, None], frequency),
            "period": (
                ("parameter",), rows.period, {"long_name": "period of the forcing"} | time,
            ),
        },
        attrs,
    )  # fmt: skip
