"""When a cell mapping has taken enough iterates: labels that stay after a doubling."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from nonsmooth.analysis.basins.region import Grid

__all__ = ["DOUBLINGS", "SETTLED", "Changes"]

DOUBLINGS = 9  # of the iterates of a cell mapping: 256 at most
_LEAST_ITERATES, _TWICE = 8, 2  # doublings in a row, since coarse pictures may agree by chance
SETTLED = 1e-3  # part of the cells that may still change by doubling
_AWAY = 3  # cells from those of another label; nearer ones depend on the size of cells
_FEW = 0.01  # part of all cells; of fewer that are away, all count


class Changes:
    """What doublings have changed."""

    def __init__(self, grid: Grid) -> None:
        self.last = 1.0  # part of the labels that the last doubling changed
        self._grid, self._stayed = grid, 0

    def note(
        self, before: npt.NDArray[np.int64], label: npt.NDArray[np.int64], open_part: float = 0.0
    ) -> None:
        """Take in the labels before and after a doubling, and the part that has none yet."""
        self.last = _changed_by(before, label, self._grid)
        stays = self.last <= SETTLED and open_part <= SETTLED
        self._stayed = self._stayed + 1 if stays else 0

    def have_ended(self, iterates: int) -> bool:
        """Whether further iterates would change little."""
        return self._stayed >= _TWICE and iterates >= _LEAST_ITERATES


def _changed_by(before: npt.NDArray[np.int64], label: npt.NDArray[np.int64], grid: Grid) -> float:
    """Part of the cells away from others that have another label than before."""
    picture = label.reshape(grid.shape)
    width = 2 * _AWAY + 1
    away = ndimage.maximum_filter(picture, width) == ndimage.minimum_filter(picture, width)
    if np.count_nonzero(away) < _FEW * picture.size:
        away = np.ones_like(away)
    return float(np.mean((before != label)[away.ravel()]))
