"""From an orbit at some parameter values to that at others, in steps Newton's method takes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from nonsmooth.errors import ModelError
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.system.system import System

if TYPE_CHECKING:
    from nonsmooth.periodic_orbits.orbit import OrbitRequest, OrbitResult

__all__ = ["values_of_orbit", "walk_to"]

_SHORTEST = 2.0**-7  # part of the way that is tried at least


def values_of_orbit(system: System, data: Any) -> dict[str, float] | None:
    """Parameter values at which an orbit was found; None where they are not known."""
    try:
        there = System.from_toml(data.attrs["system"])
        name = data.attrs.get("parameter")
        if name:
            there = there.with_parameters(**{name: float(data[name])})
    except (KeyError, ModelError, TypeError, ValueError):
        return None
    values = there.parameter_values
    return values if list(values) == list(system.parameters) else None


def walk_to(
    wanted: OrbitRequest, legs: Legs, known: Guess, begin: dict[str, float], solve: Any
) -> OrbitResult | None:
    """The orbit that an orbit becomes while all parameters go straight to those that are wanted.

    ``solve`` solves a guess at the values of the legs. None where it gets lost on the way, as at a
    fold or a graze.
    """
    end = wanted.system.parameter_values
    if begin == end:
        return None
    done, step, guess = 0.0, 0.5, known
    while step >= _SHORTEST:
        there = min(1.0, done + step)
        values = {name: begin[name] + there * (end[name] - begin[name]) for name in end}
        try:
            system = wanted.system.with_parameters(**values)
            legs.set_values(values)
            found: OrbitResult = solve(replace(wanted, system=system), legs, guess)
        except (LegError, ModelError):
            step *= 0.5
            continue
        if found.orbit is None or not found.orbit.admissibility.admissible:
            step *= 0.5
        elif there == 1.0:
            return found
        else:
            done, step = there, min(2.0 * step, 1.0 - there)
            guess = Guess(found.orbit.word, found.orbit.turn)
    legs.set_values(end)
    return None
