"""Units of what the datasets of rigs hold, by the names that the verbs give; one base for all."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "DERIVATIVES",
    "OF_STATES",
    "ONE_MASS",
    "ROTOR",
    "TWO_MASSES",
    "Unit",
    "Units",
    "one_mass_units",
    "rotor_units",
    "table_of",
    "two_mass_units",
    "unit_of",
]


_TIMES = (
    "time", "phase", "event_time", "event_phase", "begin", "end_time",
    "contact_duration", "shortest_contact", "longest_contact", "from_time", "to_time",
    "return_time", "length", "durations", "leg_time", "strobe_times",
)  # fmt: skip
_RATES = ("lyapunov_exponent", "running_exponent", "exponent_sum")  # per unit time
_STATISTICS = (
    "mean", "rms", "in_contact", "min", "min_error", "max", "max_error", "amplitude", "percentile"
)  # fmt: skip
# over ``state``, each in the unit of its state, and derivatives by ``state_0``, ``parameter_0``
OF_STATES = (
    "state_before", "state_after", "points", "initial_state", "end_state", "start_state",
    "image_state", "fixed_state", "leg_states", "settled", "strobes", "saddle",
    "saddle_direction", "track", "nearest",
)  # fmt: skip
# likewise where they have states as a coordinate; elsewhere these names mean other things
_OF_STATES_TOO = ("start", "mean", "deviation")
_OF_REGION = ("factor_centre",)  # over ``state_of_region``
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
    "exponent_per_return", "log_determinant", "arclength", "unsettled", "ended",
    "border_gap", "first_length", "first_deviation", "chaotic_for", "escape_rate_below",
    "width", "crossing", "sense", "place",
    # distances in a space of states, each in its own size, stay those of the model
    "local_integrity", "local_error", "global_integrity", "global_error", "integrity_factor",
    "factor_error", "position_error",
    # of normal forms: their vectors mix all states, so the numbers stay those of the model
    "coefficient", "coefficient_error", "parameter_coefficient", "parameter_coefficient_error",
    "amplitude_factor", "amplitude_power", "reach",
}  # fmt: skip
# what each parameter of a model stands for in a machine
TWO_MASSES = {
    "eta": "frequency of the base",
    "lambda1": "natural frequency on cylinder 1",
    "lambda2": "natural frequency on cylinder 2",
    "theta": "natural frequency on the specimen",
    "eps": "stiffness of a leaf spring over that of a contact",
    "f1": "force on mass 1 downward, weight included",
    "f2": "force on mass 2 upward, weight taken off",
    "xi_Ls": "damping ratio of a leaf spring",
    "xi_s": "damping ratio of the specimen",
    "xi_p1": "damping ratio of cylinder 1",
    "xi_p2": "damping ratio of cylinder 2",
    "open_stiffness": "stiffness of the specimen with its crack open over that closed",
}
ONE_MASS = {
    "xi": "damping ratio",
    "eta": "frequency of the base",
    "d": "static load",
    "crack": "crack length",
    "s": "scale of the specimen's stiffness",
    "kappa": "stiffness of the specimen",
    "kappa_open": "stiffness of the specimen with the crack open",
    "kappa_closed": "stiffness of the specimen with the crack closed",
    "share": "displacement of the specimen over that of the masses",
    "gamma": "deflection at rest",
}
_ACCELERATIONS = ("acceleration1", "acceleration2", "absolute1", "absolute2",
                  "acceleration", "absolute", "base")  # fmt: skip
_SYMBOLS = ("A_b", "omega_Ls", "k_Ls", "omega_M", "k_M")
_TEXT = "mm; mm/s for velocities"
_ROTOR_LENGTHS = ("x", "y", "sx", "sy", "gap")
_ROTOR_VELOCITIES = ("vx", "vy", "ring_vx", "ring_vy")
_ROTOR_FORCES = ("force_x", "force_y", "force", "normal_force")
# what each parameter of the model stands for in a machine
ROTOR = {
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


def table_of(data: xr.Dataset, name: str) -> str:
    """Coordinate of states over which a variable has a column for each, "" for none."""
    if name in _OF_REGION:
        return "state_of_region"
    if name in OF_STATES or name in DERIVATIVES:
        return "state"
    return "state" if name in _OF_STATES_TOO and "state" in data[name].coords else ""


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
        per_iterate = {"attractor", "exponent_number"} & set(data[name].dims)
        return Unit() if per_iterate else Unit(1.0 / units.time, "1/s")
    if name == "value_error":  # of the parameter that was varied
        return units.parameters.get(str(data.attrs.get("parameter", "")))
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


def _quantities(
    length: float, rate: float, force: float, lengths: tuple[str, ...], velocities: tuple[str, ...],
    forces: tuple[str, ...],
) -> dict[str, Unit]:  # fmt: skip
    return {
        **dict.fromkeys(lengths, Unit(length, "mm")),
        **dict.fromkeys(velocities, Unit(length * rate, "mm/s")),
        **dict.fromkeys(forces, Unit(force, "N")),
        **dict.fromkeys(_ACCELERATIONS, Unit(1e-3 * length * rate**2, "m/s^2")),
    }


def two_mass_units(length: float, rate: float, stiffness: float) -> Units:
    """Units of `fatigue_rig`: A_b in mm, omega_Ls in rad/s, k_Ls in N/m."""
    force = 1e-3 * stiffness * length
    hertz = Unit(rate / (2.0 * math.pi), "Hz")
    parameters = {
        **dict.fromkeys(TWO_MASSES, Unit()),
        **dict.fromkeys(("eta", "lambda1", "lambda2", "theta"), hertz),
        **dict.fromkeys(("f1", "f2"), Unit(force, "N")),
    }
    quantities = _quantities(
        length,
        rate,
        force,
        ("X1", "X3", "X4", "deflection"),
        ("X2", "X5"),
        ("load", "contact1", "contact2", "pneumatic1", "pneumatic2"),
    )
    return Units(length, 1.0 / rate, force, parameters, TWO_MASSES, quantities, _TEXT, _SYMBOLS)


def one_mass_units(length: float, rate: float, stiffness: float) -> Units:
    """Units of `breathing_crack` and `one_mass`: A_b in mm, omega_M in rad/s, k_M in N/m."""
    force = 1e-3 * stiffness * length
    parameters = {
        **dict.fromkeys(ONE_MASS, Unit()),
        "eta": Unit(rate / (2.0 * math.pi), "Hz"),
        "d": Unit(force, "N"),
        "crack": Unit(1.0, "mm"),
        "gamma": Unit(length, "mm"),
        **dict.fromkeys(("kappa", "kappa_open", "kappa_closed"), Unit(stiffness, "N/m")),
    }
    quantities = _quantities(
        length, rate, force, ("u", "y", "deflection"), ("v",), ("load", "force")
    )
    return Units(length, 1.0 / rate, force, parameters, ONE_MASS, quantities, _TEXT, _SYMBOLS)


def rotor_units(length: float, time: float, force: float, parameters: dict[str, Unit]) -> Units:
    """Units of a rotor by its length in mm, time in s, force in N."""
    quantities = {
        **dict.fromkeys(_ROTOR_LENGTHS, Unit(length, "mm")),
        **dict.fromkeys(_ROTOR_VELOCITIES, Unit(length / time, "mm/s")),
        **dict.fromkeys(_ROTOR_FORCES, Unit(force, "N")),
        "energy": Unit(force * length, "mJ"),
        "contact_angle": Unit(1.0, "rad"),
        "mu": Unit(),
    }
    text = "mm; mm/s for velocities; 1 for mu"
    return Units(length, time, force, parameters, ROTOR, quantities, text)
