"""Spectra below each other as an xarray dataset."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.spectra.spectrum_dataset import HARMONIC, spectrum_labels
from nonsmooth.errors import OptionError, unknown_name

__all__ = ["Rows", "check_plane", "plane_label", "waterfall_dataset"]

Floats = npt.NDArray[np.float64]


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
            f"variable = {variable!r:.60}: give the name of a state or output, or two for a motion"
            " in a plane"
        )
    for name in names:
        if name not in known:
            raise OptionError(f"variable: {unknown_name('variable', str(name), known)}")
    units = [attributes(name).get("units", "") for name in names]
    if len(set(units)) == 2:
        raise OptionError(
            f"{names[0]!r} is in {units[0] or 'no units'} and {names[1]!r} in"
            f" {units[1] or 'no units'}; a motion in a plane has one unit"
        )
    return tuple(str(name) for name in names)


def plane_label(names: Sequence[str], label: str) -> str:
    """What a spectrum is of: the label of one variable, or the names of two."""
    return f"the {label}" if len(names) == 1 else f"{names[0]} + i {names[1]}"


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
