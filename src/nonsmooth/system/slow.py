"""Slowly varying parameters: texts of time that give their values for a whole period."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.system.model.value_checks import condition_of, first_unmet
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import evaluate, evaluate_shared
from nonsmooth.system.text.expressions import name_set

__all__ = ["SlowParameters"]

Array = npt.NDArray[np.float64]


class SlowParameters:
    """The slow parameters of a system: their values at a time, and what keeps them from it."""

    def __init__(self, system: System) -> None:
        self.system = system
        self.names = tuple(system.structure.slow)
        self._fixed = {k: v for k, v in system.parameter_values.items() if k not in self.names}

    @property
    def changes_clock(self) -> bool:
        """Whether the period, or a frequency of the equations, follows a slow parameter."""
        structure = self.system.structure
        nodes = [*structure.period_nodes, *structure.frequencies]
        return any(name in name_set(node) for node in nodes for name in self.names)

    def at(self, time: float) -> dict[str, float]:
        """Values at a time."""
        values = self.at_times(np.array([time]))
        return {name: float(each[0]) for name, each in values.items()}

    def at_times(self, times: Array) -> dict[str, Array]:
        """Values at several times, each with the same digits as alone."""
        names = {**self._fixed, "t": times, "pi": np.pi}
        return {
            name: np.broadcast_to(evaluate_shared(node, names, {}, lambda _: None), times.shape)
            for name, node in self.system.structure.slow.items()
        }

    def admissible(self, values: Mapping[str, Array]) -> npt.NDArray[np.bool_]:
        """Which of several values the system takes; `fault` says why not."""
        admissible = np.all([np.isfinite(each) for each in values.values()], axis=0)
        names = {**self.system.parameter_values, **values}
        for condition in self.system.require:
            admissible &= np.asarray(evaluate(condition_of(condition), names), dtype=bool)
        return np.asarray(admissible)

    def all_values(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Values of all parameters."""
        return {**self.system.parameter_values, **values}

    def rows(self, values: Mapping[str, Array]) -> Array:
        """Values of all parameters in their order, a row for each of several times."""
        return np.stack(np.broadcast_arrays(*self.all_values(values).values()), axis=-1)

    def fault(self, values: Mapping[str, float]) -> str:
        """What the system has against some values; empty where it takes them."""
        for name, value in values.items():
            if not np.isfinite(value):
                return f"{name} is {value}, which is not a finite number"
        return first_unmet(self.system.require, self.all_values(values))

    def followed_by(self, parameter: str) -> bool:
        """Whether a slow parameter, or the period, changes with a parameter."""
        nodes = [*self.system.structure.slow.values(), *self.system.structure.period_nodes]
        return any(parameter in name_set(node) for node in nodes)
