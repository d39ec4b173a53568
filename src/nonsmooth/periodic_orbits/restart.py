"""Orbits from orbits that were found before, as datasets, at the same parameters or at others."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.engine.tables import PATH_LENGTH, exits_of_path
from nonsmooth.errors import ModelError, OptionError
from nonsmooth.periodic_orbits.equations import Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.system.system import System

if TYPE_CHECKING:
    from nonsmooth.periodic_orbits.orbit import OrbitRequest, OrbitResult

__all__ = ["guess_of_dataset", "is_orbit", "parameters_elsewhere", "values_of_orbit", "walk_to"]


_SHORTEST = 2.0**-7  # part of the way that is tried at least


def is_orbit(data: Any) -> bool:
    """Whether something is an orbit, or a point of a branch, as a dataset."""
    return hasattr(data, "data_vars") and "leg_states" in data and "leg_path" in data


def guess_of_dataset(system: System, data: Any) -> Guess:
    """Word and legs of an orbit of the same system, at whatever parameters."""
    if data["leg_states"].dims != ("leg", "state"):
        raise OptionError(
            "initial: these are several orbits; take one of them, as in branch.isel(point=0)"
        )
    names = str(data["leg_mode"].attrs.get("flag_meanings", "")).split()
    if names != list(system.mode_names) or data.sizes["state"] != len(system.states):
        raise OptionError(
            f"initial: the orbit belongs to a system with the modes {', '.join(names)}, not to"
            f" {system.name!r}; give it to its own system"
        )
    modes = np.atleast_1d(data["leg_mode"].values).astype(int)
    keep = modes >= 0
    states = data["leg_states"].values[keep]
    if not keep.any() or not np.all(np.isfinite(states)):
        raise OptionError(
            f"initial: there is no orbit in this dataset, whose message is:"
            f" {data.attrs.get('message', '')}"
        )
    paths = [_path(int(bits)) for bits in data["leg_path"].values[keep]]
    times = data["leg_time"].values[keep]
    end = times[-1] + data["durations"].values[keep][-1]
    word = Word(tuple(int(m) for m in modes[keep]), tuple(paths))
    return Guess(word, Turn(np.array(states, float), np.append(times, end)))


def _path(bits: int) -> tuple[int, ...]:
    whole = exits_of_path(bits, PATH_LENGTH)
    return whole[: whole.index(-1)] if -1 in whole else whole


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


def parameters_elsewhere(system: System, data: Any) -> str:
    """At which other values of parameters an orbit was found, "" where at those of the system."""
    there = values_of_orbit(system, data) if is_orbit(data) else None
    known = system.parameter_values
    other = {name: value for name, value in (there or {}).items() if value != known[name]}
    if not other:
        return ""
    return (
        f"the orbit of initial= belongs to parameters={other}, and the system has"
        f" {', '.join(f'{name} = {known[name]:.9g}' for name in other)}: for the orbit there,"
        " repeat parameters="
    )


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
