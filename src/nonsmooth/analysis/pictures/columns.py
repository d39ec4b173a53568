"""The attractors at each value of the parameter, and which of them go over into each other.

Starts drawn from the region find the attractors of a column. Two more passes, up and down, start
from the attractors of the neighbour: they find attractors with small basins that the neighbour has
too, and tell where each attractor leads when the parameter takes a step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor
from nonsmooth.analysis.basins.attractor_search import (
    FoundAttractors,
    SearchOptions,
    SettledStarts,
    find_attractors,
    search_among,
)
from nonsmooth.analysis.basins.region import Box
from nonsmooth.analysis.pictures.chunks import Chunks, pack_known, unpack_known
from nonsmooth.engine.lanes import ANY
from nonsmooth.runs.maps import Map

__all__ = ["Column", "follow_numbers", "settle_columns"]

Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Column:
    """What starts come to at one value; attractors are numbered from 1 within the column."""

    value: float
    found: FoundAttractors
    # where the attractors of the columns before and behind lead here; 0 and less for nowhere
    from_below: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    from_above: Integers = field(default_factory=lambda: np.zeros(0, np.int64))

    @property
    def attractors(self) -> list[Attractor]:
        """Those found, in the order of their numbers."""
        return self.found.known.attractors

    @property
    def labels(self) -> Integers:
        """Number of the attractor that each random start came to; 0 and less for none."""
        return self.found.settled.label

    def starts_from(self, others: Sequence[Attractor]) -> Integers:
        """Where motions lead here that begin on the attractors of a neighbour."""
        if not others:
            return np.zeros(0, np.int64)
        states = np.array([each.points[-1] for each in others])
        return self.found.search.settle(states, ANY).label


def settle_columns(
    maps: Sequence[tuple[float, Map]],
    box_of: Callable[[Map], Box],
    how: SearchOptions,
    report: Callable[[int], None],
    chunks: Chunks | None = None,
) -> tuple[list[Column], bool]:
    """Columns in the order of the values, and whether all are there.

    ``report`` is told how many columns are done, each of which counts once in each of two passes.
    Of ``chunks`` each takes one.
    """
    chunks = Chunks() if chunks is None else chunks
    columns: list[Column] = []
    try:
        for value, chosen in maps:
            below = columns[-1:]
            found: list[Column] = chunks.take(
                partial(_first_column, value, chosen, box_of, how, below),
                _packed,
                partial(_unpacked, [(value, chosen)], how),
            )
            columns += found
            report(len(columns))
        for k in reversed(range(len(columns) - 1)):
            found = chunks.take(
                partial(_linked, columns[k], columns[k + 1]),
                _packed,
                partial(_unpacked, maps[k : k + 2], how),
            )
            columns[k : k + 2] = found
            report(2 * len(columns) - k - 1)
    except KeyboardInterrupt:
        return columns, False
    return columns, True


def _first_column(
    value: float,
    chosen: Map,
    box_of: Callable[[Map], Box],
    how: SearchOptions,
    below: Sequence[Column],
) -> list[Column]:
    """The column at a value, which no column above has been linked to yet."""
    found = find_attractors(chosen, box_of(chosen), how, silent=True)
    if not found.complete:
        raise KeyboardInterrupt
    column = Column(value, found)
    if below:
        column = Column(value, found, from_below=column.starts_from(below[-1].attractors))
    return [column]


def _linked(here: Column, above: Column) -> list[Column]:
    """Two neighbours, the first of which has been looked at from the second as well."""
    links = here.starts_from(above.attractors)
    # an attractor that only the column above had is followed upwards as well
    known = len(above.from_below)
    late = above.starts_from(here.attractors[known:])
    return [
        replace(here, from_above=links),
        replace(above, from_below=np.concatenate([above.from_below, late])),
    ]


def _packed(columns: list[Column]) -> dict[str, npt.NDArray[Any]]:
    """Columns as arrays, with all that their searches know."""
    arrays: dict[str, npt.NDArray[Any]] = {}
    for k, column in enumerate(columns):
        found = column.found
        arrays |= {
            **{f"{k}.{name}": values for name, values in vars(found.settled).items()},
            f"{k}.drawn": np.array(found.drawn), f"{k}.from_below": column.from_below,
            f"{k}.from_above": column.from_above, **pack_known(found.known, f"{k}.known."),
        }  # fmt: skip
    return arrays


def _unpacked(
    maps: Sequence[tuple[float, Map]], how: SearchOptions, arrays: dict[str, npt.NDArray[Any]]
) -> list[Column]:
    """The columns of arrays that `_packed` made."""
    columns = []
    for k, (value, chosen) in enumerate(maps):
        known = unpack_known(arrays, f"{k}.known.")
        settled = SettledStarts.of_arrays(arrays, f"{k}.")
        drawn = int(arrays[f"{k}.drawn"])
        found = FoundAttractors(known, search_among(chosen, known, how), settled, drawn, True)
        columns.append(Column(value, found, arrays[f"{k}.from_below"], arrays[f"{k}.from_above"]))
    return columns


def follow_numbers(columns: Sequence[Column]) -> list[Integers]:
    """Numbers of attractors along the parameter, for the attractors of each column.

    Two attractors of neighbouring columns are one where each leads to the other: a motion that
    begins on either comes to the other when the parameter takes the step, up and down. Where a
    motion comes to another attractor and does not return, the first one has ended. Where the way
    down was interrupted, the way up alone tells.
    """
    numbers: list[Integers] = []
    used = 0
    for k, column in enumerate(columns):
        own = np.zeros(len(column.attractors), np.int64)
        if k:
            below = columns[k - 1]
            back = below.from_above
            for i, label in enumerate(column.from_below.tolist()):
                j = label - 1
                returns = back[j] == i + 1 if 0 <= j < len(back) else not back.size
                if label > 0 and own[j] == 0 and returns:
                    own[j] = numbers[-1][i]
        for j in np.flatnonzero(own == 0):
            used += 1
            own[j] = used
        numbers.append(own)
    return numbers
