"""`LoadBlock`: cycles of load that repeat themselves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.fatigue.checks import finite, number_array, positive, record_values
from nonsmooth.fatigue.cycles import count_cycles

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["LoadBlock"]


@dataclass(frozen=True, eq=False)
class LoadBlock:
    """Cycles of load that repeat themselves, in the order in which they end.

    Parameters
    ----------
    minimum, maximum : array_like
        Smallest and largest load of each cycle, in N; positive loads open the crack.
    count : array_like
        How often each occurs in a block; 1 or 0.5 as of `count_cycles`.
    duration : float
        Duration of a block, in s.

    Raises
    ------
    OptionError
        For loads that are not finite, a largest one below the smallest, or no cycle at all.

    See Also
    --------
    count_cycles : the cycles of a record.
    LoadTable : loads that change with the length of the crack.

    Examples
    --------
    >>> from nonsmooth.fatigue import LoadBlock
    >>> load = LoadBlock.constant_amplitude(mean=100.0, amplitude=50.0, frequency=20.0)
    >>> load.minimum.tolist(), load.maximum.tolist(), load.duration
    ([50.0], [150.0], 0.05)
    """

    minimum: Any
    maximum: Any
    count: Any
    duration: float

    def __post_init__(self) -> None:
        names = ("minimum", "maximum", "count")
        columns = [np.atleast_1d(number_array(name, getattr(self, name))) for name in names]
        if len({column.shape for column in columns}) != 1 or columns[0].ndim != 1:
            raise OptionError("minimum, maximum and count: one value each for every cycle")
        if columns[0].size == 0:
            raise OptionError("the load has no cycle: it never turns; give one that varies")
        for name, column in zip(names, columns, strict=True):
            bad = np.flatnonzero(~np.isfinite(column))
            if bad.size:
                raise OptionError(f"{name} of cycle {bad[0]} is not finite")
            column.flags.writeable = False
            object.__setattr__(self, name, column)
        wrong = np.flatnonzero((columns[1] < columns[0]) | (columns[2] < 0.0))
        if wrong.size:
            raise OptionError(
                f"cycle {wrong[0]}: the maximum, {columns[1][wrong[0]]:g} N, is below the minimum,"
                f" {columns[0][wrong[0]]:g} N, or the count is negative"
            )
        object.__setattr__(self, "duration", positive("duration", self.duration, "s"))

    @property
    def n_cycles(self) -> float:
        """Cycles in a block, half ones as halves."""
        return float(self.count.sum())

    @property
    def largest(self) -> float:
        """Largest load, in N."""
        return float(self.maximum.max())

    @classmethod
    def constant_amplitude(
        cls, mean: float, amplitude: float, frequency: float = 20.0
    ) -> LoadBlock:
        """One cycle about a mean.

        Parameters
        ----------
        mean, amplitude : float
            Mean and amplitude of the load, in N.
        frequency : float
            Cycles per s.

        Returns
        -------
        LoadBlock
            A block of one cycle.
        """
        middle, size = finite("mean", mean), positive("amplitude", amplitude, "N")
        length = 1.0 / positive("frequency", frequency, "Hz")
        return cls([middle - size], [middle + size], [1.0], length)

    @classmethod
    def from_record(
        cls,
        load: npt.ArrayLike | xr.DataArray,
        times: npt.ArrayLike | None = None,
        *,
        refine: bool = False,
    ) -> LoadBlock:
        """Cycles of a record that is repeated, its last sample at the beginning of the next block.

        Parameters
        ----------
        load : array_like or xarray.DataArray
            Load in N; a DataArray over ``time`` brings its times.
        times : array_like, optional
            Times of the samples, in s.
        refine : bool, optional
            As of `count_cycles`.

        Returns
        -------
        LoadBlock
            Its cycles, all of them whole.
        """
        import xarray as xr

        if isinstance(load, xr.DataArray) and times is None and "time" in load.coords:
            times = load["time"].values
        if times is None:
            raise OptionError("the load has no times; give times= in s, or a DataArray over time")
        values = load if isinstance(load, xr.DataArray) else record_values("load", load)
        return cls.from_cycles(count_cycles(values, times, repeating=True, refine=refine))

    @classmethod
    @checked
    def from_cycles(cls, cycles: xr.Dataset) -> LoadBlock:
        """Cycles that were counted, in the order in which they end.

        Parameters
        ----------
        cycles : xarray.Dataset
            Result of `count_cycles`, in N over s.

        Returns
        -------
        LoadBlock
            The cycles as a block.
        """
        needed = {"minimum", "maximum", "count"}
        if not needed <= set(cycles.variables) or "duration" not in cycles.attrs:
            raise OptionError("cycles: give a result of count_cycles")
        return cls(
            cycles["minimum"].values,
            cycles["maximum"].values,
            cycles["count"].values,
            float(cycles.attrs["duration"]),
        )
