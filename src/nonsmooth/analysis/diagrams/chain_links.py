"""Columns that follow each other, in links: a chain goes on from any link that is done."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, is_known, unknown_choice

__all__ = ["End", "check_way", "links_of", "pack_end", "take_end"]

_STARTS = ("restart", "follow up", "follow down")
_NAME = "end_of_link"


class End(NamedTuple):
    """Where the last motion of a link has ended, and the next one goes on."""

    state: npt.NDArray[np.float64]
    mode: int
    part: float = 0.0  # of the window that has passed, where that is not known otherwise


def check_way(start: Any) -> str:
    """How columns begin."""
    if not is_known(start, _STARTS):
        raise OptionError(unknown_choice("start", start, _STARTS))
    return str(start)


def links_of(grid: npt.NDArray[np.float64], start: str, size: int) -> list[list[int]]:
    """Columns of each link of so many, in the order in which they are computed."""
    order = np.arange(grid.size) if start == "restart" else np.argsort(grid, kind="stable")
    if start == "follow down":
        order = order[::-1]
    return [order[i : i + size].tolist() for i in range(0, grid.size, size)]


def pack_end(end: End | None) -> dict[str, npt.NDArray[Any]]:
    """Arrays of an end by name; of none, where the next motion begins anew, there are none."""
    if end is None:
        return {}
    return {_NAME: np.array([*end.state, end.part]), f"{_NAME}_mode": np.array(end.mode)}


def take_end(arrays: Mapping[str, npt.NDArray[Any]]) -> tuple[End | None, dict[str, Any]]:
    """The end that arrays of a link tell, and the other arrays."""
    rest = {name: a for name, a in arrays.items() if not name.startswith(_NAME)}
    if _NAME not in arrays:
        return None, rest
    numbers = arrays[_NAME]
    return End(numbers[:-1], int(arrays[f"{_NAME}_mode"]), float(numbers[-1])), rest
