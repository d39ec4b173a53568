"""Units of what the datasets of a rig hold, by the names that the verbs give."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["DERIVATIVES", "OF_STATES", "Unit", "Units", "unit_of"]

_TIMES = (
    "time", "phase", "event_time", "event_phase", "begin", "end_time",
    "contact_duration", "shortest_contact", "longest_contact", "from_time", "to_time",
    "return_time", "length", "durations", "leg_time",
)  # fmt: skip
_RATES = ("lyapunov_exponent", "running_exponent", "exponent_sum")  # per unit time
_STATISTICS = (
    "mean", "rms", "in_contact", "min", "min_error", "max", "max_error", "amplitude", "percentile"
)  # fmt: skip

# over ``state``, each in the unit of its state, and derivatives by ``state_0``, ``parameter_0``
OF_STATES = (
    "state_before", "state_after", "points", "initial_state", "end_state", "start_state",
    "image_state", "fixed_state", "leg_states",
)  # fmt: skip
# of a return map, in the unit of its coordinate
_OF_COORDINATE = (
    "start", "image", "deviation", "border_start", "image_before", "image_after", "fixed_start",
    "fixed_deviation", "turn",
)  # fmt: skip
DERIVATIVES = {"tangent": "state_0", "sensitivity": "parameter_0"}

# shares, ratios, counts and numbers of tests and of dimensions
_NUMBERS = {
    "harmonic", "percentile", "contacts", "contact_share", "events", "impacts",
    "residual", "K", "K_of_motion", "K_low", "K_high", "K_of_c", "c", "multiplier",
    "multiplier_real", "multiplier_imag", "multiplier_modulus", "kaplan_yorke_dimension",
    "fraction", "fraction_error", "probability", "basin_entropy", "basin_entropy_error",
    "boundary_basin_entropy", "boundary_basin_entropy_error", "uncertainty_exponent",
    "digits", "boundary_dimension", "uncertain_fraction", "largest_distance", "fraction_within",
    "box_dimension", "correlation_dimension", "correlation_sum", "fit", "distance",
    "standard_error", "drift", "net_drift", "slope", "fixed_slope", "spread", "largest_spread",
    "exponent_per_return", "log_determinant", "arclength",
}  # fmt: skip


@dataclass(frozen=True)
class Unit:
    """What one in a dimensionless quantity is worth; without a name what has no unit."""

    factor: float = 1.0
    name: str = ""


@dataclass(frozen=True)
class Units:
    """Units of one machine: length in mm, time in s, force in N; labels of parameters."""

    length: float
    time: float
    force: float
    parameters: dict[str, Unit]
    labels: dict[str, str]
    quantities: dict[str, Unit]  # of states and outputs
    states_text: str  # what the numbers over ``state`` are in
    symbols: tuple[str, ...] = ()  # what units of the dimensionless model are written with

    def of(self, quantity: str) -> Unit | None:
        """Unit of a state or output, or of a time or rate among results; none for others."""
        if quantity in self.quantities:
            return self.quantities[quantity]
        kinds = (
            (_TIMES, Unit(self.time, "s")),
            (_RATES, Unit(1.0 / self.time, "1/s")),
            (("frequency",), Unit(1.0 / self.time, "Hz")),
        )
        return next((unit for names, unit in kinds if quantity in names), None)

    def is_foreign(self, text: str) -> bool:
        """Whether units are none of the dimensionless model, such as those of an angle."""
        known = text in ("", "1", "dimensionless")
        return not known and not any(symbol in text for symbol in self.symbols)

    def states(self, names: Iterable[str]) -> list[Unit]:
        """Units of states, in order."""
        return [self.of(str(name)) or Unit() for name in names]


def unit_of(data: xr.Dataset, name: str, units: Units) -> tuple[Unit, str | None] | None:
    """Unit of a variable, and its label where that becomes another one; none to leave it as it is.

    A number of which nothing is known is refused, so that none goes on unscaled in silence.
    """
    variable = data[name]
    if name in ("parameter", "special_value") or _is_parameter(data, name, units):
        of_parameter = name in ("parameter", "special_value")
        swept = str(data.attrs.get("parameter", "")) if of_parameter else name
        if swept in units.parameters:
            return units.parameters[swept], units.labels[swept]
        if swept == "time":
            return Unit(units.time, "s"), None
    if variable.dtype.kind != "f":
        return None  # counts, words and times of day
    if units.is_foreign(str(variable.attrs.get("units", ""))):
        return None  # such as angles
    unit = _special(data, name, units) or _statistic(name, units) or units.of(name)
    if unit is not None:
        # a frequency is no longer in cycles per unit time
        return unit, "frequency" if name == "frequency" else None
    if name in _NUMBERS or name in units.quantities:
        return None
    raise OptionError(
        f"the unit of {name!r} is not known; give it the attribute units if it is in those of the"
        " machine, or leave it out with drop_vars"
    )


def _is_parameter(data: xr.Dataset, name: str, units: Units) -> bool:
    """Whether a variable holds values of a parameter: as an axis, or varying slowly in a run."""
    if name not in units.parameters:
        return False
    # the 0-1 test has a K too
    dims = (("time",), ("period",), ("point",))
    swept = data.attrs.get("parameter") == name
    return name != "K" or name in data.coords or swept or data[name].dims in dims


def _special(data: xr.Dataset, name: str, units: Units) -> Unit | None:
    """Units of names that mean different things in different results."""
    of = units.of(str(data.attrs.get("variable", "")))
    if name in ("exponent", "exponent_error"):
        return Unit() if "attractor" in data[name].dims else Unit(1.0 / units.time, "1/s")
    if name == "standard_error" and "lyapunov_exponent" in data:
        return units.of("lyapunov_exponent")
    if name == "period":
        return Unit(units.time, "s")  # as a number it is that of the forcing, else a count
    if name in ("amplitude", "p", "q") or (name in _OF_COORDINATE and "start" in data.dims):
        return of
    if name == "best":  # of the quantity that it is the extreme value of
        quantity = str(data.attrs.get("quantity", ""))
        swept = units.parameters.get(quantity)
        return swept or units.of(quantity) or (Unit() if quantity in _NUMBERS else None)
    end = name.removeprefix("from_").removeprefix("to_")  # of a stretch of one regime
    if end != name and end in units.parameters:
        return units.parameters[end]
    if name == "power_density" and of is not None:
        square = f"({of.name})^2" if "/" in of.name else f"{of.name}^2"
        return Unit(of.factor**2 * units.time, f"{square}/Hz" if of.name else "1/Hz")
    return None


def _statistic(name: str, units: Units) -> Unit | None:
    """Unit of a statistic of a state or output, such as its largest value."""
    ends = (f"_{key}" for key in sorted(_STATISTICS, key=len, reverse=True))
    of = next((name.removesuffix(end) for end in ends if name.endswith(end)), "")
    return units.of(of)
