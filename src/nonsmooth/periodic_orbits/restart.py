"""Guesses from orbits that were found before, as datasets."""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.engine.tables import PATH_LENGTH, exits_of_path
from nonsmooth.errors import OptionError
from nonsmooth.periodic_orbits.equations import Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.system.system import System

__all__ = ["guess_of_dataset", "is_orbit"]


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
        raise OptionError("initial: there is no orbit in this dataset; see its message")
    paths = [_path(int(bits)) for bits in data["leg_path"].values[keep]]
    times = data["leg_time"].values[keep]
    end = times[-1] + data["durations"].values[keep][-1]
    word = Word(tuple(int(m) for m in modes[keep]), tuple(paths))
    return Guess(word, Turn(np.array(states, float), np.append(times, end)))


def _path(bits: int) -> tuple[int, ...]:
    whole = exits_of_path(bits, PATH_LENGTH)
    return whole[: whole.index(-1)] if -1 in whole else whole
