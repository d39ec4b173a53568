"""Basins by sharing each cell among the cells to which its points go."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor_options import Search
from nonsmooth.analysis.basins.attractor_search import (
    ENDED,
    INADMISSIBLE,
    UNSETTLED,
    AttractorSearch,
    Settled,
)
from nonsmooth.analysis.basins.cell_labels import NOT_COMPUTED
from nonsmooth.analysis.basins.cell_mapping import ENDS, NOWHERE, REFUSED, Part, map_points
from nonsmooth.analysis.basins.cell_shares import closed_classes, end_shares, transitions
from nonsmooth.analysis.basins.found_basins import Basins, search_from
from nonsmooth.analysis.basins.region import Grid
from nonsmooth.engine.loop import ANY
from nonsmooth.errors import OptionError

__all__ = ["by_cell_shares"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_SIDE = 3  # points along each state of a cell
_MOST_MEMBERS = 64  # cells of a class that are followed by the exact map


def by_cell_shares(
    chosen: Any,
    grid: Grid,
    how: Search,
    threads: int,
    store: str | Path | None,
    protocol: dict[str, Any],
) -> Basins:
    """Map points of every cell once, and follow the chain of cells that this makes."""
    if store is not None:
        raise OptionError("store= is for method='recurrences' alone; leave it out")
    source, image, states, complete = _images(chosen, grid, how, threads)
    count = grid.size
    if not complete:
        nothing = np.full(count, NOT_COMPUTED)
        return Basins([], Settled(nothing, np.zeros_like(nothing)), False)
    # two more cells that nothing leaves: motions that end, and those that do not come back
    image = np.where(image == ENDS, count, np.where(image == NOWHERE, count + 1, image))
    sinks = np.array([count, count + 1])
    matrix = transitions(np.append(source, sinks), np.append(image, sinks), count + 2)
    search = search_from(chosen, states[np.unique(source)], how)
    classes = closed_classes(matrix)
    reached, several = _attractors_of(search, classes[:count], states)
    found = search.known.attractors
    ends = np.zeros((count + 2, len(found) + 2))
    inside = np.flatnonzero(classes[:count] >= 0)
    ends[inside, reached[classes[inside]]] = 1.0
    ends[count, -1] = ends[count + 1, 0] = 1.0
    shares = end_shares(matrix, ends)[:count]
    label = np.argmax(shares, axis=1)
    label = np.where(label == len(found) + 1, ENDED, label)
    empty = ~np.isin(np.arange(count), source)
    label[empty] = INADMISSIBLE
    probability = np.where(empty, np.nan, shares.max(axis=1))
    notes = {"classes_of_several_attractors": several}
    return Basins(found, Settled(label, np.zeros(count, np.int64)), True, probability, notes)


def _images(
    chosen: Any, grid: Grid, how: Search, threads: int
) -> tuple[Integers, Integers, Floats, bool]:
    """Cells of points and of their images, and a state for every cell.

    A cell none of whose points is admissible has the image that first lies in it as its point.
    """
    count = grid.size
    inner = grid.inner_states(np.arange(count), _SIDE)
    states = grid.states(np.arange(count))
    points, source = inner.reshape(-1, inner.shape[2]), np.repeat(np.arange(count), inner.shape[1])
    sources, images, complete = [], [], True
    while len(points) and complete:
        image = np.full(len(points), REFUSED, np.int64)
        landing = np.empty_like(points)

        def keep(
            places: Integers, part: Part, image: Integers = image, landing: Floats = landing
        ) -> None:
            image[places], landing[places] = part.image, part.landing

        complete = map_points(
            grid, points, np.full(len(points), ANY), 1, lambda: chosen.runner(how.tolerance),
            threads, keep, "points of cells",
        )  # fmt: skip
        admitted = image != REFUSED
        cells, first = np.unique(source[admitted], return_index=True)
        states[cells] = points[admitted][first]
        sources.append(source[admitted])
        images.append(image[admitted])
        to = np.flatnonzero(image >= 0)
        entered, which = np.unique(image[to], return_index=True)
        new = ~np.isin(entered, np.concatenate(sources))
        points, source = landing[to[which[new]]], entered[new]
    return np.concatenate(sources), np.concatenate(images), states, complete


def _attractors_of(
    search: AttractorSearch, classes: Integers, states: Floats
) -> tuple[Integers, int]:
    """Attractor of each closed class of cells, and how many classes hold more than one."""
    count = int(classes.max(initial=-1)) + 1
    reached, several = np.full(count, UNSETTLED, np.int64), 0
    for number in range(count):
        members = np.flatnonzero(classes == number)
        some = members[:: max(1, members.size // _MOST_MEMBERS)]
        label = search.settle(states[some]).label
        values, times = np.unique(label[label > 0], return_counts=True)
        if values.size:
            reached[number] = values[times.argmax()]
        several += int(values.size > 1)
    return reached, several
