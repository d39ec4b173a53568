"""Rates of the states anywhere on a motion."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import Tables
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.outputs import Clock, output_values
from nonsmooth.system.system import System

__all__ = ["Rates"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


class Rates:
    """Rates of the states anywhere, from their equations."""

    def __init__(self, system: System, tables: Tables, origin: Integers | None = None) -> None:
        """``origin``: number of each mode in the system, where the tables have others."""
        self.origin = np.arange(len(system.mode_names)) if origin is None else origin
        self.system, self.names = _with_rates(system)
        self.tables = tables

    def at(self, here: Instant, mode: int, state: Floats) -> Floats:
        """Rates at an instant, in a mode of the tables."""
        number, phase = np.array([here.number]), np.array([here.phase])
        rates: Floats = self.of_many(number, phase, np.array([mode]), state[None])[0]
        return rates

    def of_many(self, number: Integers, phase: Floats, modes: Integers, states: Floats) -> Floats:
        """Rates at many instants, each in a mode of the tables; shapes: states (L, n)."""
        clock = Clock(number, phase, self.tables)
        found = output_values(self.system, clock, states.T, self.origin[modes])
        rates = [np.broadcast_to(found[name], number.shape) for name in self.names]
        stacked: Floats = np.stack(rates, axis=1).astype(float)
        return stacked


@lru_cache(maxsize=32)
def _with_rates(system: System) -> tuple[System, tuple[str, ...]]:
    """System with the rate of each state as an output, and their names."""
    taken = {*system.states, *system.outputs, *system.definitions, *system.parameters}
    names = []
    for state in system.states:
        name = f"rate_of_{state}"
        while name in taken:
            name += "_"
        names.append(name)
    rates = {name: f"rate({state})" for name, state in zip(names, system.states, strict=True)}
    return replace(system, outputs={**system.outputs, **rates}), tuple(names)
