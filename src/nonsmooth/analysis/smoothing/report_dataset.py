"""The report on smoothing as an xarray dataset, with the exponents of what goes to zero."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.smoothing.ladder import Ladder
from nonsmooth.analysis.statistics.power_law import fit_power_law
from nonsmooth.runs.labels import labels_of
from nonsmooth.version import __version__

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["report_dataset"]

Floats = npt.NDArray[np.float64]

_MEANING = {
    "epsilon": "width of the smooth switches",
    "state": "state",
    "surface": "surface on which the exact motion slides",
    "status": "how the smoothed motion ended",
    "error": "largest distance from the exact motion",
    "stick_time_exact": "time that the exact motion is on the surface",
    "stick_time": "time that the smoothed motion is beside the surface",
    "stick_time_error": "error of the time on the surface",
    "creep": "mean size of the switching function in stick",
    "attractors_exact": "attractors of the exact system",
    "attractors": "attractors of the smoothed system",
    "only_smoothed": "attractors that exist only smoothed",
    "only_exact": "attractors that smoothing has lost",
    "special_kind": "kind of the special point",
    "special_value_exact": "value of the parameter there",
    "special_value": "value of the parameter there, smoothed",
    "special_shift": "shift of the special point by smoothing",
    "extra_specials": "special points of the smoothed branch only",
    "extra_width": "range of the parameter that these span",
}
_FITTED = ("error", "stick_time_error", "creep", "special_shift", "extra_width")


def report_dataset(
    ladder: Ladder, variables: dict[str, Any], options: dict[str, Any]
) -> xr.Dataset:
    """Dataset of the report."""
    import xarray as xr

    named: dict[str, Any] = {
        name: (*given, {"long_name": _MEANING[name]}) for name, given in variables.items()
    }
    for name in _FITTED:
        if name in variables:
            over, values = variables[name]
            named |= _exponents(name, over, ladder.epsilons, values)
    coords = {name: named.pop(name) for name in ("state", "surface")}
    coords["epsilon"] = ("epsilon", ladder.epsilons, {"long_name": _MEANING["epsilon"]})
    attrs = {
        "system_name": ladder.exact.name,
        "system": labels_of(ladder.exact).system,
        "nonsmooth_version": __version__,
    }
    return xr.Dataset(named, coords, attrs | options)


def _exponents(name: str, over: Any, widths: Floats, values: Floats) -> dict[str, Any]:
    """Exponent of a power of the width for each column of a variable, with its error."""
    rest = () if isinstance(over, str) else tuple(over[1:])
    columns = np.abs(values).reshape(widths.size, -1)
    laws = [fit_power_law(widths, column) for column in columns.T]
    shape = values.shape[1:]
    what = _MEANING[name]
    exponents = np.array([law.exponent for law in laws]).reshape(shape)
    errors = np.array([np.hypot(law.scatter, law.bend) for law in laws]).reshape(shape)
    return {
        f"{name}_exponent": (rest, exponents, {"long_name": f"exponent of the {what}"}),
        f"{name}_exponent_error": (
            rest, errors, {"long_name": f"standard error of the exponent of the {what}"},
        ),
    }  # fmt: skip
