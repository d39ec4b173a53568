"""Balls in basins on a grid of cells: the largest one, and those around attractors.

A label is that of the centre of a cell, so a border lies somewhere between two centres. Half the
diagonal of a cell bounds by how much distances may be wrong: outside the basin, a ball of that
radius which touches the border holds the centre of a cell. So from any point the nearest centre
outside is farther than the border, by a diagonal at most, wherever what lies outside is at least a
diagonal wide. The end of the region counts as a border that may be as far off. The cells of an
angle that fill its turn have no end: the last one lies beside the first.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.runs.options import positive_number
from nonsmooth.runs.whole_turns import folded

__all__ = ["Cells", "Integrity", "integrity_of_labels", "read_axis_scales"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

_NOWHERE = "outside"
_FILLS = 1.0 - 1e-9  # of a turn: what is missing of it to rounding


class Ball(NamedTuple):
    """A ball in a basin, in scaled states."""

    centre: Floats  # (d,) states
    radius: float  # nan where there is none
    error: float  # that it may be wrong by, at most
    limit: str  # what ends it: border, region, or outside where its centre is not in the region


class Cells(NamedTuple):
    """A grid of cells, its axes in the order of the states; arrays have the last one first."""

    axes: tuple[Floats, ...]
    scales: Floats  # (d,)
    counts: Mask  # cells whose outcome is known
    periods: Floats  # (d,) of states that are angles, zero of the others

    @property
    def turns(self) -> Floats:
        """Periods of the angles whose turn the cells fill, zero of other states, (d,)."""
        low, high = self.edges.T
        return np.where(high - low >= _FILLS * self.periods, self.periods, 0.0)

    @property
    def edges(self) -> Floats:
        """Ends of the region, (d, 2): outer cells are as wide as their neighbours."""
        return np.array([[1.5 * a[0] - 0.5 * a[1], 1.5 * a[-1] - 0.5 * a[-2]] for a in self.axes])

    @property
    def half_diagonal(self) -> float:
        """Half the diagonal of the largest cell, in scaled states."""
        widths = [float(np.diff(a).max()) for a in self.axes]
        return float(np.linalg.norm(np.array(widths) / self.scales)) / 2.0

    def centres(self, chosen: Mask) -> Floats:
        """Centres of cells, (K, d) in scaled states."""
        places = np.nonzero(chosen)[::-1]
        values = [axis[place] for axis, place in zip(self.axes, places, strict=True)]
        return np.column_stack(values) / self.scales

    def to_region(self, points: Floats) -> Floats:
        """Distances of scaled points to the end of the region, negative outside; (K, d) to (K,)."""
        low, high = (self.edges / self.scales[:, None]).T
        room = np.where(self.turns > 0.0, np.inf, np.minimum(points - low, high - points))
        found: Floats = room.min(axis=1)
        return found

    def within(self, points: Floats) -> Floats:
        """Points (K, d) with their angles within one turn from the begin of the region on."""
        return folded(points, self.edges[:, 0], self.periods)

    def beside(self, chosen: Mask) -> Mask:
        """Cells that are chosen, or touch one that is."""
        from scipy.ndimage import binary_dilation

        around = [(1, 1) if turn > 0.0 else (0, 0) for turn in reversed(self.turns)]
        wider = np.pad(chosen, around, mode="wrap")
        found: Mask = binary_dilation(wider, np.ones((3,) * chosen.ndim, bool))
        return found[tuple(slice(a, a + n) for (a, _), n in zip(around, chosen.shape, strict=True))]

    def to_nearest(self, chosen: Mask, points: Floats) -> Floats:
        """Distances of scaled points from the nearest centre of some cells; (K, d) to (K,)."""
        from scipy.spatial import KDTree

        low, turns = self.edges[:, 0] / self.scales, self.turns / self.scales

        def placed(places: Floats) -> Floats:
            along = np.mod(places - low, np.where(turns > 0.0, turns, np.inf))
            along = np.where(along < turns, along, 0.0)  # a remainder may be a whole turn, rounded
            return np.where(turns > 0.0, along, places)

        tree = KDTree(placed(self.centres(chosen)), boxsize=turns)
        found: Floats = tree.query(placed(points))[0]
        return found


def _to_others(cells: Cells, inside: Mask, points: Floats) -> Floats:
    """Distances of scaled points from the nearest centre outside the basin; infinite without one.

    Of the cells outside only those count that touch another sort: between any other one and a
    point of the basin there is a cell outside that is nearer.
    """
    outside = cells.counts & ~inside
    border = outside & cells.beside(~outside)
    return cells.to_nearest(border, points) if border.any() else np.full(len(points), np.inf)


def _radii(cells: Cells, inside: Mask, points: Floats) -> tuple[Floats, Mask]:
    """Radii of the balls around scaled points, and whether it is the border that ends each.

    Where the end of the region is nearer than any centre outside, the basin may end before by as
    much as elsewhere.
    """
    room = cells.to_region(points)
    to_others = np.where(_is_in(cells, inside, points), _to_others(cells, inside, points), 0.0)
    return np.minimum(to_others, room) - cells.half_diagonal, to_others <= room


def _is_in(cells: Cells, inside: Mask, points: Floats) -> Mask:
    """Whether the cells in which scaled points lie are of a basin, or of no known outcome."""
    places = [
        np.searchsorted((axis[1:] + axis[:-1]) / 2.0, column * scale)
        for axis, column, scale in zip(cells.axes, points.T, cells.scales, strict=True)
    ]
    found: Mask = (inside | ~cells.counts)[tuple(reversed(places))]
    return found


def ball_around(cells: Cells, inside: Mask, points: Floats) -> Ball:
    """The largest ball around the worst placed of some points that lies in a basin.

    shapes: points (K, d), those of an attractor
    """
    points = cells.within(points)
    scaled = points / cells.scales
    if not len(points) or cells.to_region(scaled).min() < 0.0:
        return Ball(np.full(len(cells.axes), np.nan), np.nan, np.nan, _NOWHERE)
    radii, by_border = _radii(cells, inside, scaled)
    worst = int(np.argmin(radii))
    limit = "border" if by_border[worst] else "region"
    return Ball(points[worst], max(float(radii[worst]), 0.0), cells.half_diagonal, limit)


def largest_ball(cells: Cells, inside: Mask) -> Ball:
    """The largest ball in a basin and in the region, its centre one of the cells.

    With a centre elsewhere it may be larger by a diagonal, whence the error.
    """
    half, centres = cells.half_diagonal, cells.centres(inside)
    if not len(centres):
        return Ball(np.full(len(cells.axes), np.nan), 0.0, 1.5 * half, "border")
    radii, by_border = _radii(cells, inside, centres)
    best = int(np.argmax(radii))
    size = max(float(radii[best]) + 0.5 * half, 0.0)
    return Ball(
        centres[best] * cells.scales, size, 1.5 * half, "border" if by_border[best] else "region"
    )


def share_of(cells: Cells, inside: Mask) -> tuple[float, float]:
    """Share of a basin in the cells that count, and a bound of its error.

    A cell with the same outcome as all that it touches is taken to be whole.
    """
    weights = _sizes(cells)
    total = float(weights[cells.counts].sum())
    outside = cells.counts & ~inside
    mixed = (inside & cells.beside(outside)) | (outside & cells.beside(inside))
    return float(weights[inside].sum()) / total, float(weights[mixed].sum()) / total


def _sizes(cells: Cells) -> Floats:
    """Size of each cell."""
    sides: Sequence[Floats] = [
        np.diff(np.concatenate([[low], (a[1:] + a[:-1]) / 2.0, [high]]))
        for a, (low, high) in zip(cells.axes, cells.edges, strict=True)
    ]
    found = np.ones(cells.counts.shape)
    for number, side in enumerate(reversed(sides)):
        found = found * side.reshape([-1 if k == number else 1 for k in range(len(sides))])
    return found


@dataclass
class Integrity:
    """The measures of some attractors, one row for each."""

    states: int  # of the region
    local: list[Ball] = field(default_factory=list)
    factor: list[Ball] = field(default_factory=list)
    share: list[tuple[float, float]] = field(default_factory=list)

    @property
    def variables(self) -> dict[str, Any]:
        """Variables over ``attractor``."""

        def each(values: list[Any], label: str) -> Any:
            kind = str if values and isinstance(values[0], str) else float
            return ("attractor",), np.array(values, kind), {"long_name": label}

        return {
            "local_integrity": each(
                [ball.radius for ball in self.local],
                "distance of the attractor from the border of its basin",
            ),
            "local_error": each([ball.error for ball in self.local], "bound of its error"),
            "local_limit": each(
                [ball.limit for ball in self.local], "what ends the ball around the attractor"
            ),
            "global_integrity": each(
                [share for share, _ in self.share], "share of the region in the basin"
            ),
            "global_error": each([error for _, error in self.share], "bound of its error"),
            "integrity_factor": each(
                [ball.radius for ball in self.factor], "radius of the largest ball in the basin"
            ),
            "factor_error": each([ball.error for ball in self.factor], "bound of its error"),
            "factor_limit": each(
                [ball.limit for ball in self.factor], "what ends the largest ball"
            ),
            "factor_centre": (
                ("attractor", "state_of_region"),
                np.array([ball.centre for ball in self.factor]).reshape(-1, self.states),
                {"long_name": "centre of the largest ball"},
            ),
        }


def integrity_of_labels(
    cells: Cells,
    labels: Integers,
    numbers: Iterable[int],
    points: list[Floats],
    together: set[int],
) -> Integrity:
    """Measures of attractors by number, whose points are given in the states of the region."""
    found = Integrity(len(cells.axes))
    for number, own in zip(numbers, points, strict=True):
        group = together if number in together else {number}
        inside = cells.counts & np.isin(labels, list(group))
        found.local.append(ball_around(cells, inside, own))
        found.share.append(share_of(cells, inside))
        found.factor.append(largest_ball(cells, inside))
    return found


def read_axis_scales(scales: Any, names: list[str]) -> Floats:
    """Sizes of the states of the region, one without a word."""
    if scales is not None and not isinstance(scales, Mapping):
        raise OptionError(
            f"scales = {quote(scales)}: give a mapping of states to sizes, such as {{{names[0]!r}:"
            " 2.0}"
        )
    for name in scales or {}:
        if name not in names:
            raise OptionError(f"scales: {unknown_name('state of the region', name, names)}")
    return np.array(
        [positive_number(f"scales[{name!r}]", (scales or {}).get(name, 1.0)) for name in names]
    )
