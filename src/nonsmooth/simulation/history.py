"""Periods of a run whose parameters vary slowly: when each begins, and the values in it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["Frozen", "History"]

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Frozen:
    """A period: its number, the time at which it begins, and the values frozen in it."""

    number: int
    origin: float
    values: dict[str, float]


@dataclass
class History:
    """The periods of a run in order."""

    periods: list[Frozen] = field(default_factory=list)
    windows: list[float] = field(default_factory=list)
    samples: list[int] = field(default_factory=list)  # that were written in each
    fault: str = ""  # why the next period was refused

    def add(self, period: Frozen, window: float) -> None:
        """Add a period."""
        self.periods.append(period)
        self.windows.append(window)
        self.samples.append(0)

    @property
    def end(self) -> float:
        """Time at which the last period ends."""
        return self.periods[-1].origin + self.windows[-1]

    def times(self, number: Any, phase: Any) -> Any:
        """Times as single numbers."""
        origins = np.array([*(period.origin for period in self.periods), self.end])
        return origins[np.asarray(number) - self.periods[0].number] + phase

    def at_samples(self, count: int) -> tuple[Array, dict[str, Array]]:
        """Lengths of the periods, and values of the parameters, at the first samples."""
        rows = np.repeat(np.arange(len(self.periods)), self.samples)[:count]
        values = {
            name: np.array([period.values[name] for period in self.periods])[rows]
            for name in self.periods[0].values
        }
        return np.array(self.windows)[rows], values

    def attributes(self) -> dict[str, Any]:
        """What a run needs to go on."""
        last = self.periods[-1]
        return {
            "slow_number": last.number,
            "slow_origin": last.origin,
            "slow_values": " ".join(f"{name}={value!r}" for name, value in last.values.items()),
        }
