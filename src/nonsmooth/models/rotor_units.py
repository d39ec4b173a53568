"""Units of what the rotor's datasets hold: variables, coordinates and attributes by their names."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

__all__ = ["PARAMETERS", "Unit", "Units", "in_si"]

_LENGTHS = ("x", "y", "sx", "sy", "gap")
_VELOCITIES = ("vx", "vy", "ring_vx", "ring_vy")
_FORCES = ("force_x", "force_y", "force", "normal_force")
_TIMES = ("time", "phase", "event_time", "event_phase")
_TIME_ATTRIBUTES = ("period", "window", "strobe_period", "phase_of_period", "step")
_RATES = (  # per unit time
    "exponent", "exponent_error", "lyapunov_exponent", "running_exponent", "exponent_sum"
)  # fmt: skip

# what each parameter of the model stands for in a machine
PARAMETERS = {
    "eta": "speed of the rotor",
    "nu1": "damping of the rotor",
    "nu2": "damping of the ring",
    "K": "stiffness of the ring",
    "eta_m": "unbalance mass",
    "rho": "radius of the unbalance mass",
    "eps_x": "eccentricity in x",
    "eps_y": "eccentricity in y",
    "delta_x": "preload in x",
    "delta_y": "preload in y",
    "phi0": "phase of the unbalance",
}


@dataclass(frozen=True)
class Unit:
    """What one in a dimensionless quantity is worth."""

    factor: float
    name: str


@dataclass(frozen=True)
class Units:
    """Units of one machine: length in mm, time in s, force in N."""

    length: float
    time: float
    force: float
    parameters: dict[str, Unit]

    def of(self, variable: str) -> Unit | None:
        """Unit of a variable of a result, none for counts, words and ratios."""
        kinds = (
            (_LENGTHS, Unit(self.length, "mm")),
            (_VELOCITIES, Unit(self.length / self.time, "mm/s")),
            (_FORCES, Unit(self.force, "N")),
            (_TIMES, Unit(self.time, "s")),
            (_RATES, Unit(1.0 / self.time, "1/s")),
            (("energy",), Unit(self.force * self.length, "mJ")),
            (("contact_angle",), Unit(1.0, "rad")),
            (("frequency",), Unit(1.0 / self.time, "Hz")),
        )
        return next((unit for names, unit in kinds if variable in names), None)


def in_si(data: xr.Dataset, units: Units) -> xr.Dataset:
    """Dataset with all that has a unit in it, labels and attributes included."""
    result = data.copy()
    for name in data.variables:
        unit, label = _unit_of(data, str(name), units)
        if unit is not None and (label is not None or data[name].dtype.kind == "f"):
            result = _scaled(result, name, unit, label)
    for name in ("state_before", "state_after"):
        if name in data:
            result[name] = _states(data, name, units)
    result.attrs = _attributes(data, units)
    return result


def _unit_of(data: xr.Dataset, name: str, units: Units) -> tuple[Unit | None, str | None]:
    """Unit of a variable, and its label where that becomes another one."""
    swept = str(data.attrs.get("parameter", "")) if name == "parameter" else name
    # as an axis, or varying slowly in a run
    if swept in units.parameters and (name in data.dims or "time" in data[name].dims):
        return units.parameters[swept], PARAMETERS[swept]
    if name == "standard_error" and "lyapunov_exponent" in data:
        return units.of("lyapunov_exponent"), None
    if name in ("amplitude", "power_density") and "variable" in data.attrs:
        unit = units.of(str(data.attrs["variable"]))
        if unit is None or name == "amplitude":
            return unit, None
        square = f"({unit.name})^2" if "/" in unit.name else f"{unit.name}^2"
        return Unit(unit.factor**2 * units.time, f"{square}/Hz"), None
    if name == "frequency":
        return units.of(name), "frequency"  # no longer in cycles per unit of time
    return units.of(name), None


def _scaled(data: xr.Dataset, name: Hashable, unit: Unit, label: str | None) -> xr.Dataset:
    variable = data[name]
    attrs = dict(variable.attrs) | {"units": unit.name}
    if label is not None:
        attrs["long_name"] = label
    if np.issubdtype(variable.dtype, np.datetime64) or variable.dtype.kind not in "iuf":
        return data
    scaled = (variable.dims, variable.values * unit.factor, attrs)
    return (
        data.assign_coords({name: scaled}) if name in data.coords else data.assign({name: scaled})
    )


def _states(data: xr.Dataset, name: str, units: Units) -> xr.DataArray:
    found = [units.of(str(state)) for state in data["state"].values]
    factors = np.array([1.0 if unit is None else unit.factor for unit in found])
    scaled = data[name] * xr.DataArray(factors, dims="state")
    scaled.attrs = dict(data[name].attrs) | {"units": "mm; mm/s for velocities; 1 for mu"}
    return scaled.transpose(*data[name].dims)


def _attributes(data: xr.Dataset, units: Units) -> dict[str, Any]:
    attrs = dict(data.attrs)
    # verbs and plots would read it as if it went with the numbers
    if "system" in attrs:
        attrs["dimensionless_system"] = attrs.pop("system")
    for name in _TIME_ATTRIBUTES:
        if isinstance(attrs.get(name), float | int | np.number):
            attrs[name] = float(attrs[name]) * units.time
    if "resolution" in attrs:
        attrs["resolution"] = float(attrs["resolution"]) / units.time
    for name in ("delta_x", "delta_y", "eps_x", "eps_y", "extent"):
        if name in attrs:
            attrs[name] = float(attrs[name]) * units.length
    return {
        name: value
        for name, value in attrs.items()
        if not str(name).startswith(("end_", "anchor_", "slow_"))  # nothing can go on from here
    }
