"""Periodic motions of one period told apart: by whether they drift, and by their words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["shades"]

_MOST_WORDS = 4  # of one period; rarer ones share a shade
_PALEST = 0.7  # part of white in the last shade

Mask = npt.NDArray[np.bool_]
_Part = tuple[str, str, Mask]  # name, colour, where


def shades(grid: xr.Dataset, name: str, colour: str, where: Mask, *, words: bool) -> list[_Part]:
    """Parts of an area of one colour, each with its name and a shade of the colour.

    An area is parted where some of its motions progress and others stand, and with ``words`` by
    the modes that they pass.
    """
    parts = list(_by_progress(grid, name, where))
    if words:
        parts = [part for one in parts for part in _by_word(grid, *one)]
    step = _PALEST / max(1, len(parts) - 1)
    return [(each, _paler(colour, i * step), place) for i, (each, place) in enumerate(parts)]


def _by_progress(grid: xr.Dataset, name: str, where: Mask) -> Iterator[tuple[str, Mask]]:
    variable = "progresses" if "progresses" in grid.data_vars else "progresses_of_motion"
    if variable not in grid.data_vars:
        yield name, where
        return
    periodic = grid["regime"].attrs["flag_meanings"].split().index("periodic")
    progresses = grid[variable].values > 0
    if np.unique(progresses[grid["regime"].values == periodic]).size < 2:
        yield name, where
        return
    yield f"{name}, progresses", where & progresses
    yield f"{name}, stands", where & ~progresses


def _by_word(grid: xr.Dataset, name: str, where: Mask) -> Iterator[tuple[str, Mask]]:
    """The words that most points have, each by itself."""
    variable = "word" if "word" in grid.data_vars else "word_of_motion"
    found = np.array([_turned(word) for word in grid[variable].values.ravel()])
    found = found.reshape(where.shape)
    present, counts = np.unique(found[where], return_counts=True)
    chosen = present[np.argsort(-counts, kind="stable")]
    rest = where & np.isin(found, chosen[_MOST_WORDS:])
    for word in chosen[:_MOST_WORDS]:
        yield f"{name}: {word}", where & (found == word)
    if np.any(rest):
        yield f"{name}: other words", rest


def _turned(word: str) -> str:
    """A word that begins with the first of its turns in alphabetical order.

    A strobe may lie on an event, or be moved across one by a parameter; the motion is the same.
    """
    modes = word.split()
    closes = len(modes) > 1 and modes[0] == modes[-1]
    modes = modes[:-1] if closes else modes
    return " ".join(min((modes[k:] + modes[:k] for k in range(len(modes))), default=modes))


def _paler(colour: str, white: float) -> str:
    """A colour mixed with white."""
    parts = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
    return "#" + "".join(f"{round(part + (255 - part) * white):02X}" for part in parts)
