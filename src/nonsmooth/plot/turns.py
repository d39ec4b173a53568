"""Curves and points of angles within one turn of a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.runs.whole_turns import folded, periods_of
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["Turns"]

Floats = npt.NDArray[np.float64]


class Turns(NamedTuple):
    """The turn of each axis that a picture shows."""

    begins: Floats  # (2,)
    periods: Floats  # (2,): zero of what is no angle

    @classmethod
    def none(cls) -> Turns:
        """Axes without angles."""
        return cls(np.zeros(2), np.zeros(2))

    @classmethod
    def of(cls, data: xr.Dataset, names: tuple[str, str], ax: Axes | None) -> Turns:
        """The turns that begin at the lower ends of axes, or half a turn below zero."""
        periods = periods_of(System.from_toml(data.attrs["system"]), names)
        if ax is None:
            return cls(-0.5 * periods, periods)
        return cls(np.array([min(ax.get_xlim()), min(ax.get_ylim())]), periods)

    def folded(self, across: Floats, up: Floats) -> tuple[Floats, Floats]:
        """Points within the turns."""
        points = folded(np.stack([across, up], axis=-1), self.begins, self.periods)
        return points[..., 0], points[..., 1]

    def cut_curve(self, across: Floats, up: Floats) -> tuple[Floats, Floats]:
        """A curve within the turns, with a gap where it leaves them.

        The step over the end of a turn is drawn at both ends, as far as the axes show it.
        """
        if not self.periods.any():
            return across, up
        points = np.column_stack([across, up])
        moved = folded(points, self.begins, self.periods)
        shift = points - moved
        half = np.where(self.periods > 0.0, 0.5 * self.periods, np.inf)
        with np.errstate(invalid="ignore"):
            over = np.flatnonzero(np.any(np.abs(np.diff(shift, axis=0)) > half, axis=1)) + 1
        gap = np.full_like(moved[over], np.nan)
        both = [points[over] - shift[over - 1], gap, points[over - 1] - shift[over]]
        whole = np.insert(moved, np.repeat(over, 3), np.stack(both, axis=1).reshape(-1, 2), axis=0)
        return whole[:, 0], whole[:, 1]

    def show(self, ax: Axes) -> None:
        """Let the axes end where the turns do."""
        ends = self.begins + self.periods
        if self.periods[0] > 0.0:
            ax.set_xlim(float(self.begins[0]), float(ends[0]))
        if self.periods[1] > 0.0:
            ax.set_ylim(float(self.begins[1]), float(ends[1]))
