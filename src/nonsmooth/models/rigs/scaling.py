"""The dataset of a rig in SI units: every variable, coordinate and attribute of it."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.models.rigs.units import DERIVATIVES, OF_STATES, Unit, Units, unit_of
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["changed_parameters", "in_si"]

_RESTART = ("guard_rate", "anchor_state")
_TIME_ATTRIBUTES = ("period", "window", "strobe_period", "step", "duration", "end_time",
                    "t_start", "t_end")  # fmt: skip
_LENGTH_ATTRIBUTES = ("extent",)
# texts with numbers of the dimensionless system in them
_TEXTS = ("system", "initial", "completion", "section", "between")


def in_si(data: xr.Dataset, units: Units) -> xr.Dataset:
    """Dataset with all that has a unit in it, labels and attributes included."""
    # nothing can go on from a result in other units, so what serves that alone is left out
    kept = [*_RESTART, *(["end_state"] if "anchor_state" in data else [])]
    data = data.drop_vars(kept, errors="ignore")
    result = data.copy()
    for name in map(str, data.variables):
        if name in OF_STATES or name in DERIVATIVES:
            result[name] = _over_states(data, name, units)
        elif (found := unit_of(data, name, units)) is not None:
            result = _scaled(result, name, *found)
    if "state" in data.coords and data["state"].ndim == 1:
        result = result.assign_coords(_state_words(data, units))
    result.attrs = _attributes(data, units)
    return result


def _scaled(data: xr.Dataset, name: str, unit: Unit, label: str | None) -> xr.Dataset:
    variable = data[name]
    attrs = {key: value for key, value in variable.attrs.items() if key != "units"}
    attrs |= {"units": unit.name} if unit.name else {}
    if label is not None:
        attrs["long_name"] = label
    scaled = (variable.dims, variable.values * unit.factor, attrs)
    return (
        data.assign_coords({name: scaled}) if name in data.coords else data.assign({name: scaled})
    )


def _over_states(data: xr.Dataset, name: str, units: Units) -> xr.DataArray:
    """States in their units, or derivatives in theirs over those of what they are by."""
    factors = data["state"].copy(data=_factors(units.states(np.atleast_1d(data["state"])), data))
    scaled = data[name] * factors.drop_vars("state")
    text = units.states_text
    if name in DERIVATIVES:
        by = DERIVATIVES[name]
        names = [str(each) for each in np.atleast_1d(data[by])]
        found = (
            units.states(names) if by == "state_0" else [units.parameters[each] for each in names]
        )
        below = data[by].copy(data=np.reshape([unit.factor for unit in found], data[by].shape))
        scaled = scaled / below.drop_vars(by)
        text = f"unit of the state over that of {by}"
    scaled.attrs = dict(data[name].attrs) | {"units": text}
    return scaled.transpose(*data[name].dims)


def _factors(found: list[Unit], data: xr.Dataset) -> np.ndarray[Any, Any]:
    return np.reshape([unit.factor for unit in found], data["state"].shape)


def _state_words(data: xr.Dataset, units: Units) -> dict[str, Any]:
    """Coordinates that say what the states are, for pictures of points."""
    from nonsmooth.runs.labels import labels_of

    names = [str(name) for name in data["state"].values]
    found: dict[str, Any] = {
        "state_units": ("state", [unit.name for unit in units.states(names)]),
    }
    if "system" in data.attrs:
        labels = labels_of(System.from_toml(data.attrs["system"]))
        texts = [labels.attributes(name)["long_name"] for name in names]
        found["state_long_name"] = ("state", texts)
    return found


def changed_parameters(data: xr.Dataset) -> dict[str, float]:
    """Parameters that a verb was told to change, dimensionless."""
    text = str(data.attrs.get("changed_parameters", ""))
    try:
        found = ast.literal_eval(text) if text else {}
    except (SyntaxError, ValueError):  # numbers of other types are written with their names
        return {}
    return {str(k): float(v) for k, v in found.items() if isinstance(v, int | float)}


def _attributes(data: xr.Dataset, units: Units) -> dict[str, Any]:
    attrs = dict(data.attrs)
    if "end_number" in attrs and "end_time" not in attrs:
        attrs["end_time"] = float(attrs["end_number"] * attrs["window"] + attrs["end_phase"])
    for name in list(attrs):
        # verbs and plots would read it as if it went with the numbers
        if name in _TEXTS or str(name).startswith("region_"):
            attrs[f"dimensionless_{name}"] = attrs.pop(name)
    for names, factor in (
        (_TIME_ATTRIBUTES, units.time),
        (_LENGTH_ATTRIBUTES, units.length),
        (("resolution",), 1.0 / units.time),
    ):
        for name in names:
            if isinstance(attrs.get(name), float):
                attrs[name] = float(attrs[name]) * factor
    for name, unit in units.parameters.items():
        if name in attrs:
            attrs[name] = float(attrs[name]) * unit.factor
    if changed := changed_parameters(data):
        attrs["changed_parameters"] = ", ".join(
            f"{name} = {value * units.parameters[name].factor:.6g}"
            f" {units.parameters[name].name}".rstrip()
            for name, value in changed.items()
        )
    return {
        name: value
        for name, value in attrs.items()
        if not str(name).startswith(("end_n", "end_p", "anchor_", "slow_"))
    }
