"""Spectra as xarray datasets."""

from __future__ import annotations

from typing import Any

import xarray as xr

from nonsmooth.analysis.spectra.transforms import Lines

__all__ = ["FREQUENCY", "HARMONIC", "spectrum_dataset", "spectrum_labels"]

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
) -> xr.Dataset:
    """Dataset of the spectrum of a record; ``attrs`` has its ``resolution``."""
    texts = spectrum_labels(what, unit, time_unit)
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
