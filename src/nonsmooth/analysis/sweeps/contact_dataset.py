"""Contact statistics over a parameter as an xarray dataset."""

from __future__ import annotations

from typing import Any

import xarray as xr

from nonsmooth.analysis.sweeps.contact_numbers import Asked
from nonsmooth.analysis.sweeps.sweep import SweepProtocol, Swept
from nonsmooth.analysis.sweeps.sweep_dataset import (
    parameter_coordinate,
    stacked,
    statuses,
    sweep_attributes,
)
from nonsmooth.runs.labels import labels_of

__all__ = ["contact_dataset"]

_TEXTS = {
    "mean": "mean of the {}",
    "rms": "root mean square of the {}",
    "in_contact": "mean of the {} in contact",
    "min": "least {}",
    "min_error": "error of the least {}",
    "max": "largest {}",
    "max_error": "error of the largest {}",
    "percentile": "{} not exceeded for a part of the time",
}


def contact_dataset(sweep: SweepProtocol, parameter: str, swept: Swept, asked: Asked) -> xr.Dataset:
    """Dataset of what was found at each value."""
    labels = labels_of(sweep.system)
    time = {key: text for key, text in labels.attributes("time").items() if key == "units"}
    texts: dict[str, dict[str, str]] = {
        "contacts": {"long_name": "contacts per period"},
        "contact_share": {"long_name": "part of the time in contact"},
        "contact_duration": {"long_name": "mean duration of a contact"} | time,
        "shortest_contact": {"long_name": "shortest contact"} | time,
        "longest_contact": {"long_name": "longest contact"} | time,
    }
    for name in asked.variables:
        own = labels.attributes(name)
        for key, text in _TEXTS.items():
            texts[f"{name}_{key}"] = own | {"long_name": text.format(own["long_name"])}
    variables: dict[str, Any] = {}
    for name, attributes in texts.items():
        over = name.endswith("_percentile")
        dims = ("parameter", "percentile") if over else ("parameter",)
        shape = asked.percentiles.shape if over else ()
        variables[name] = (dims, stacked(swept.found, name, shape), attributes)
    variables["status"] = statuses(swept.found)
    coords = {
        "parameter": parameter_coordinate(sweep.system, parameter, swept.values),
        "percentile": (("percentile",), asked.percentiles, {"long_name": "part of the time in %"}),
    }
    options = {"parameter": parameter} | sweep.options | asked.options
    attributes = sweep_attributes(sweep.system, swept.found, swept.complete, options)
    return xr.Dataset(variables, coords, attributes)
