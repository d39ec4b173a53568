"""Options of `best_point`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.periodic_orbits.restart import is_orbit
from nonsmooth.runs.options import check_flag
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["WantedBest", "read_best"]


@dataclass(frozen=True)
class WantedBest:
    """What is looked for along which branch."""

    branch: xr.Dataset
    system: System
    parameter: str
    quantity: str | Callable[[Any], float]  # a variable, or a function of an orbit
    sign: float  # 1 for the largest value, -1 for the smallest
    unstable: bool
    inadmissible: bool
    tolerance: float
    said: dict[str, Any]


def read_best(
    branch: Any, quantity: Any, largest: Any, unstable: Any, inadmissible: Any, tolerance: float
) -> WantedBest:
    """Options, checked."""
    if not (is_orbit(branch) and "special_point" in branch and branch["leg_mode"].ndim == 2):
        raise OptionError(
            f"branch = {type(branch).__name__}: give a branch of orbits, as continue_orbit gives it"
        )
    if "first_parameter" in branch.attrs:
        raise OptionError(
            "branch: this is a curve over two parameters; give a branch of continue_orbit over one"
        )
    if branch.sizes["point"] == 0:
        raise OptionError("branch: there are no points in it; see its message")
    try:
        system = System.from_toml(branch.attrs["system"])
    except KeyError:
        raise OptionError(
            "branch: it does not say of which system it is; give it as continue_orbit gave it"
        ) from None
    if isinstance(quantity, str):
        known = [
            str(name)
            for name, each in branch.data_vars.items()
            if each.dims == ("point",) and each.dtype.kind in "fi" and name != "arclength"
        ]
        if quantity not in known:
            raise OptionError(unknown_name("quantity", quantity, known))
        take: str | Callable[[Any], float] = quantity
    elif callable(quantity):
        take = _checked(quantity)
    else:
        raise OptionError(
            f"quantity = {quantity!r:.60}: give the name of a variable of the branch, such as"
            " 'length', or a function of an orbit"
        )
    parameter = str(branch.attrs["parameter"])
    flags = check_flag("unstable", unstable), check_flag("inadmissible", inadmissible)
    wants_largest = check_flag("largest", largest)
    name = quantity if isinstance(quantity, str) else getattr(quantity, "__name__", "function")
    said = {
        "parameter": parameter, "quantity": name, "largest": int(wants_largest),
        "unstable": int(flags[0]), "inadmissible": int(flags[1]), "tolerance": float(tolerance),
        "period": int(branch.attrs["period"]),
        "phase_of_period": float(branch.attrs["phase_of_period"]),
    }  # fmt: skip
    return WantedBest(
        branch, system, parameter, take, 1.0 if wants_largest else -1.0, *flags, tolerance, said
    )


def _checked(quantity: Callable[[Any], Any]) -> Callable[[Any], float]:
    """The function, whose values are refused where they are no numbers."""

    def take(orbit: Any) -> float:
        value = np.asarray(quantity(orbit))
        if value.size != 1 or value.dtype.kind not in "fiub":
            raise OptionError(
                "quantity: the function returns"
                f" {'several values' if value.size != 1 else value.item()!r:.60}; it takes one"
                " orbit as a dataset and returns one number"
            )
        return float(value.reshape(()))

    return take
