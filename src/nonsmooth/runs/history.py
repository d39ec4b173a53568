"""Periods of a run whose parameters vary slowly: when each begins, and the values in it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["Frozen", "History"]

Array = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Frozen:
    """A period: its number, the time at which it begins, and the values frozen in it."""

    number: int
    origin: float
    values: dict[str, float]


class _Periods(NamedTuple):
    """Periods in a row that were passed in one call, k of them."""

    origins: Array  # (k,)
    windows: Array  # (k,)
    values: dict[str, Array]  # (k,) each
    samples: Integers  # (k,) that were written in each


@dataclass
class History:
    """The periods of a run in order."""

    first: int = 0  # number of the first period
    fault: str = ""  # why the next period was refused
    _stretches: list[_Periods] = field(default_factory=list)
    _count: int = 0

    def add(self, period: Frozen, window: float) -> None:
        """Add a period, in which nothing is sampled yet."""
        values = {name: np.array([value]) for name, value in period.values.items()}
        if not self._stretches:
            self.first = period.number
        self.add_stretch(np.array([period.origin]), window, values, np.zeros(1, np.int64))

    def add_stretch(
        self, origins: Array, window: float, values: dict[str, Array], samples: Integers
    ) -> None:
        """Add periods of one length that follow the last one."""
        windows = np.full(origins.size, window)
        self._stretches.append(_Periods(origins, windows, values, samples))
        self._count += origins.size

    def note_samples(self, written: int) -> None:
        """Note how many samples were written in the last period."""
        self._stretches[-1].samples[-1] = written

    @property
    def last(self) -> Frozen:
        """The last period."""
        stretch = self._stretches[-1]
        values = {name: float(each[-1]) for name, each in stretch.values.items()}
        return Frozen(self.first + self._count - 1, float(stretch.origins[-1]), values)

    @property
    def last_window(self) -> float:
        """Length of the last period."""
        return float(self._stretches[-1].windows[-1])

    @property
    def end(self) -> float:
        """Time at which the last period ends."""
        return self.last.origin + self.last_window

    def times(self, number: Any, phase: Any) -> Any:
        """Times as single numbers."""
        origins = np.append(self._joined("origins"), self.end)
        return origins[np.asarray(number) - self.first] + phase

    def at_samples(self, count: int) -> tuple[Array, dict[str, Array]]:
        """Lengths of the periods, and values of the parameters, at the first samples."""
        rows = np.repeat(np.arange(self._count), self._joined("samples"))[:count]
        values = {
            name: np.concatenate([each.values[name] for each in self._stretches])[rows]
            for name in self._stretches[0].values
        }
        return self._joined("windows")[rows], values

    def attributes(self) -> dict[str, Any]:
        """What a run needs to go on."""
        last = self.last
        return {
            "slow_number": last.number,
            "slow_origin": last.origin,
            "slow_values": " ".join(f"{name}={value!r}" for name, value in last.values.items()),
        }

    def _joined(self, name: str) -> Any:
        return np.concatenate([getattr(each, name) for each in self._stretches])
