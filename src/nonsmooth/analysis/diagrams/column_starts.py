"""Parameters and starts of the columns of a diagram, checked together where that says enough."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import Tables
from nonsmooth.maps.stroboscopic import StroboscopicMap
from nonsmooth.simulation.lane_runner import LaneRunner
from nonsmooth.system.sure_values import rests_alike, sure_values
from nonsmooth.system.system import System

__all__ = ["ColumnStarts", "Start"]

Floats = npt.NDArray[np.float64]
Start: TypeAlias = Callable[[System, Tables], tuple[Floats, int]]


class ColumnStarts:
    """Parameters and starts of columns, checked together where that says enough."""

    def __init__(
        self,
        chosen: StroboscopicMap,
        name: str,
        values: list[float],
        runner: LaneRunner,
        start: Start,
    ) -> None:
        self._chosen, self._name, self._values, self._start = chosen, name, values, start
        self._known = dict(chosen.system.parameter_values)
        self._sure = np.zeros(len(values), bool)
        if rests_alike(chosen.system, name) and not isinstance(chosen.period, str):
            self._sure = sure_values(chosen.system, name, np.array(values))
            self._alike = *start(chosen.system, runner.tables), chosen.length

    def set_up(self, runner: LaneRunner, i: int) -> tuple[Floats, int, float | None]:
        """Give a runner value i; initial state and mode, and the time between strobes."""
        if self._sure[i]:
            self._known[self._name] = self._values[i]
            runner.set_up(self._known)
            return self._alike
        chosen = self._chosen.with_parameters(**{self._name: self._values[i]})
        runner.set_up(chosen.system.parameter_values)
        return *self._start(chosen.system, runner.tables), chosen.length
