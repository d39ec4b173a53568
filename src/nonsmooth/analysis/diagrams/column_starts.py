"""Parameters and starts of the columns of a diagram, checked together where that says enough."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import Tables
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.model.value_checks import rests_alike, sure_values
from nonsmooth.system.system import System

__all__ = ["Column", "ColumnStarts", "Start"]

Floats = npt.NDArray[np.float64]
Start: TypeAlias = Callable[[System, Tables], tuple[Floats, int]]


class Column(NamedTuple):
    """One column: values of all parameters, time between strobes (None: the period), its start.

    The start is known, or found with the tables of the column.
    """

    values: dict[str, float]
    length: float | None
    start: tuple[Floats, int] | Callable[[Tables], tuple[Floats, int]]


class ColumnStarts:
    """Parameters and starts of columns, checked together where that says enough.

    ``tables`` are those of the system as it is.
    """

    def __init__(
        self,
        chosen: StroboscopicMap,
        name: str,
        values: list[float],
        tables: Tables,
        start: Start,
    ) -> None:
        self._chosen, self._name, self._values, self._start = chosen, name, values, start
        self._known = chosen.system.parameter_values
        self._sure = np.zeros(len(values), bool)
        if rests_alike(chosen.system, [name]) and not isinstance(chosen.period, str):
            self._sure = sure_values(chosen.system, {name: np.array(values)})
            self._alike = start(chosen.system, tables)

    def column(self, i: int) -> Column:
        """Column i; `ModelError` where the system refuses its value."""
        value = {self._name: self._values[i]}
        if self._sure[i]:
            return Column(self._known | value, self._chosen.length, self._alike)
        chosen = self._chosen.with_parameters(**value)
        system = chosen.system
        return Column(
            system.parameter_values, chosen.length, lambda tables: self._start(system, tables)
        )
