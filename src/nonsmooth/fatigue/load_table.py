"""`LoadTable`: loads that change with the length of the crack."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, quote
from nonsmooth.fatigue.checks import Array, finite_array, listed
from nonsmooth.fatigue.load_block import LoadBlock

__all__ = ["LoadTable"]


@dataclass(frozen=True, eq=False)
class LoadTable:
    """Loads at some lengths of the crack, of a rig that answers differently as the crack grows.

    Between two lengths the growth per s is that of both blocks, weighted linearly by the length;
    before the first and after the last the nearest block holds.

    Parameters
    ----------
    cracks : array_like
        Lengths of the crack in mm, increasing.
    blocks : sequence of LoadBlock
        The load at each.

    Raises
    ------
    OptionError
        For lengths that do not increase, or not as many blocks.

    Examples
    --------
    >>> from nonsmooth.fatigue import LoadBlock, LoadTable
    >>> blocks = [LoadBlock.constant_amplitude(0.0, size, 20.0) for size in (100.0, 80.0)]
    >>> table = LoadTable([6.0, 16.0], blocks)
    >>> [(round(weight, 2), block.largest) for weight, block in table.at(8.5)]
    [(0.75, 100.0), (0.25, 80.0)]
    """

    cracks: Any
    blocks: Any

    def __post_init__(self) -> None:
        lengths = finite_array("cracks", self.cracks)
        if lengths.ndim != 1 or lengths.size == 0:
            raise OptionError(f"cracks = {quote(self.cracks)}: give a list of lengths in mm")
        blocks = tuple(listed("blocks", self.blocks, "LoadBlocks, one for each length"))
        if np.any(np.diff(lengths) <= 0.0):
            raise OptionError("cracks must increase, in mm")
        if len(blocks) != lengths.size or not all(isinstance(b, LoadBlock) for b in blocks):
            raise OptionError(
                f"blocks: {lengths.size} lengths of the crack need as many LoadBlocks, and"
                f" {len(blocks)} entries came"
            )
        object.__setattr__(self, "cracks", lengths)
        object.__setattr__(self, "blocks", blocks)

    @checked
    def weights(self, lengths: Array) -> Array:
        """Weight of each block at some lengths.

        Parameters
        ----------
        lengths : numpy.ndarray
            Lengths of the crack, mm.

        Returns
        -------
        numpy.ndarray
            One row for each block; columns sum to one.
        """
        rows = np.eye(self.cracks.size)
        return np.array([np.interp(lengths, self.cracks, row) for row in rows])

    @checked
    def at(self, crack: float) -> list[tuple[float, LoadBlock]]:
        """Blocks that hold at a length, with their weights.

        Parameters
        ----------
        crack : float
            Length in mm.

        Returns
        -------
        list of tuple
            Weight and block, those of weight zero left out.
        """
        found = self.weights(np.array([crack]))[:, 0]
        return [(float(w), b) for w, b in zip(found, self.blocks, strict=True) if w > 0.0]
