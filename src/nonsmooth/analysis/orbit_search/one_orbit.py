"""One orbit that a user hands back, and the system to which it belongs."""

from __future__ import annotations

from typing import Any

from nonsmooth.errors import ModelError, OptionError
from nonsmooth.periodic_orbits.restart import is_orbit
from nonsmooth.system.system import System

__all__ = ["system_of_one"]


def system_of_one(orbit: Any) -> System:
    """The system of an orbit; a branch keeps the parameter of each point beside it.

    Raises `OptionError` for what is no orbit, or several.
    """
    if not is_orbit(orbit):
        raise OptionError(
            f"orbit = {type(orbit).__name__}: give a result of find_orbit, or one orbit of a"
            " branch, as in branch.isel(point=0)"
        )
    if orbit["length"].ndim:
        over = str(orbit["length"].dims[0])
        raise OptionError(
            f"orbit: these are {orbit.sizes[over]} orbits over {over!r}; take one, as in"
            f" branch.isel({over}=3)"
        )
    try:
        system = System.from_toml(orbit.attrs["system"])
        name = orbit.attrs.get("parameter")
        return system.with_parameters(**{name: float(orbit[name])}) if name else system
    except (KeyError, ModelError, TypeError, ValueError) as fault:
        raise OptionError(f"orbit: its attributes do not give its system: {fault}") from None
