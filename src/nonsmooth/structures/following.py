"""Modes followed along a value, such as the speed, by their shapes and their eigenvalues.

All eigenvalues near zero are followed: pairs of conjugate ones, of which the upper one is taken,
and real ones. Where a pair becomes two real ones, its path goes on with one of them and a path
begins with the other; where two real ones become a pair, one path ends. Which paths are handed out
is chosen at the end, when it is known which of them oscillate.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.structures.eigenpairs import Eigenpairs, is_small, nearest_to_zero
from nonsmooth.structures.pencil import Pencil

__all__ = ["ALIKE", "FollowedModes", "assurance", "follow", "nearby"]

Array = npt.NDArray[Any]

ALIKE = 0.7  # of the modal assurance criterion, with which two shapes are those of one mode
_HALVINGS = 6  # of a step in which shapes change more, or a motion begins or ends to oscillate
_MORE = 4  # modes beyond those that are followed, which may come in between
_ENDS = 1.0  # unlikeness, at most 2, from which the path of a real eigenvalue rather ends
_NO_PLACE = 4.0  # that with which an oscillating one does: where there are fewer eigenvalues


class FollowedModes(NamedTuple):
    """Rows for values, in order, with a column for each mode; not numbers where there is none."""

    at: npt.NDArray[np.float64]
    values: npt.NDArray[np.complex128]
    vectors: npt.NDArray[np.complex128]
    """By value, coordinate and mode."""
    likeness: npt.NDArray[np.float64]
    """Modal assurance criterion with the row before."""
    near: tuple[npt.NDArray[np.complex128], ...]
    """By row, all eigenvalues among which the modes were found."""

    def rows(self, given: Array) -> FollowedModes:
        """Those of given values; the criterion is the least since the one before."""
        places = [int(np.flatnonzero(self.at == value)[0]) for value in given]
        begins = [0, *(place + 1 for place in places[:-1])]
        likeness = [
            # a path that begins between two values has no criterion before it
            np.fmin.reduce(self.likeness[begin : end + 1], axis=0)
            for begin, end in zip(begins, places, strict=True)
        ]
        values = self.values[places]
        return FollowedModes(
            self.at[places],
            values,
            self.vectors[places],
            np.where(np.isnan(values), np.nan, np.array(likeness)),
            tuple(self.near[place] for place in places),
        )


class _PathPoint(NamedTuple):
    at: float
    value: complex
    vector: Array
    likeness: float


@dataclass
class _EigenvaluePath:
    """One eigenvalue, from row to row."""

    asked_for: bool  # one of the slowest that oscillate at the first value
    points: dict[int, _PathPoint] = field(default_factory=dict)
    ended: bool = False

    @property
    def last(self) -> _PathPoint:
        return next(reversed(self.points.values()))

    @property
    def watched(self) -> bool:
        """Whether it is to be told from others: it is asked for, or has begun to oscillate."""
        return self.asked_for or (self._began_real and self.last.value.imag > 0.0)

    @property
    def _began_real(self) -> bool:
        return next(iter(self.points.values())).value.imag == 0.0

    def expected(self, value: float) -> complex:
        """Where it goes on, along the line through its last two points."""
        if len(self.points) < 2:
            return self.last.value
        before, here = list(self.points.values())[-2:]
        share = (value - here.at) / (here.at - before.at)
        guess = here.value + share * (here.value - before.value)
        return complex(guess.real, max(guess.imag, 0.0))

    def shown(self, limit: float, overdamped: bool) -> bool:
        """Whether it is handed out: asked for, or begun beside one that is, and not at rest."""
        if self.asked_for:
            return True
        found = np.array([each.value for each in self.points.values()])
        inside = np.abs(found) <= limit
        if overdamped:
            return bool((inside & (found.imag == 0.0)).any() and found.any())
        return self._began_real and bool((inside & (found.imag > 0.0)).any())


class _Matches(NamedTuple):
    """For each path that has not ended the place among all eigenvalues, -1 for none."""

    places: Array
    likeness: Array


def follow(
    pencil_at: Callable[[float], Pencil], values: Array, count: int, *, overdamped: bool
) -> FollowedModes:
    """The slowest modes at the first value that oscillate, and what becomes of them.

    Beside these, those that begin to oscillate behind it, and with ``overdamped`` real eigenvalues:
    none that stays farther from zero than all modes asked for. There are rows for all values, and
    for those in between that it took to tell modes apart.
    """
    found = _Follower(pencil_at, count)
    for value in values:
        found.go(float(value), _HALVINGS)
    return found.result(overdamped)


def nearby(pencil: Pencil, count: int) -> Eigenpairs:
    """Modes among which those are that are followed; of a small structure all."""
    return nearest_to_zero(pencil, None if is_small(pencil.structure.size) else 2 * count + _MORE)


class _Follower:
    """Paths of all eigenvalues near zero, up to one value after the other."""

    def __init__(self, pencil_at: Callable[[float], Pencil], count: int) -> None:
        self.pencil_at = pencil_at
        self.count = count
        self.at: list[float] = []
        self.near: list[Array] = []
        self.paths: list[_EigenvaluePath] = []

    def go(self, value: float, halvings: int) -> None:
        """Add a row; by way of the middle where it is not clear what becomes of a mode."""
        pencil = self.pencil_at(value)
        pairs = nearby(pencil, self.count)
        open_paths = [each for each in self.paths if not each.ended]
        matches = _matched(open_paths, value, pairs, pencil.M)
        if halvings and self.at and self._unclear(open_paths, matches, pairs):
            self.go((self.at[-1] + value) / 2.0, halvings - 1)
            self.go(value, halvings - 1)
            return
        self._add(value, pairs, open_paths, matches)

    def _limit(self, rows: slice) -> float:
        """The largest eigenvalue of the modes asked for; no limit where these are all."""
        asked = [path for path in self.paths if path.asked_for]
        if len(asked) < self.count:
            return np.inf
        points = [point for path in asked for point in list(path.points.values())[rows]]
        return max(abs(point.value) for point in points)

    def _unclear(self, paths: list[_EigenvaluePath], matches: _Matches, pairs: Eigenpairs) -> bool:
        limit = self._limit(slice(-1, None))
        for path, place, alike in zip(paths, matches.places, matches.likeness, strict=True):
            if path.watched and not alike >= ALIKE:
                return True
            value = path.last.value
            if path.asked_for or 0.0 < abs(value) <= limit:
                oscillates = place >= 0 and pairs.values[place].imag > 0.0
                if place < 0 or oscillates != (value.imag > 0.0):
                    return True
        return False

    def _add(
        self, value: float, pairs: Eigenpairs, paths: list[_EigenvaluePath], matches: _Matches
    ) -> None:
        row, first = len(self.at), not self.at
        self.at.append(value)
        self.near.append(pairs.values)
        for path, place, alike in zip(paths, matches.places, matches.likeness, strict=True):
            if place < 0:
                path.ended = True
                continue
            at = complex(pairs.values[place])
            path.points[row] = _PathPoint(value, at, pairs.vectors[:, place], float(alike))
        asked = np.flatnonzero(pairs.values.imag > 0.0)[: self.count] if first else ()
        for place in np.setdiff1d(np.arange(len(pairs.values)), matches.places):
            at = complex(pairs.values[place])
            begin = _PathPoint(value, at, pairs.vectors[:, place], 1.0 if first else np.nan)
            self.paths.append(_EigenvaluePath(place in asked, {row: begin}))

    def result(self, overdamped: bool) -> FollowedModes:
        limit = self._limit(slice(None))
        shown = [path for path in self.paths if path.shown(limit, overdamped)]
        shown.sort(key=lambda path: not path.asked_for)  # first those, the others as they begin
        size = self.pencil_at(self.at[0]).structure.size
        values = np.full((len(self.at), len(shown)), complex(np.nan, np.nan))
        vectors = np.full((len(self.at), size, len(shown)), complex(np.nan, np.nan))
        likeness = np.full(values.shape, np.nan)
        for column, path in enumerate(shown):
            for row, point in path.points.items():
                values[row, column] = point.value
                vectors[row, :, column] = point.vector
                likeness[row, column] = point.likeness
        return FollowedModes(np.array(self.at), values, vectors, likeness, tuple(self.near))


def _matched(paths: list[_EigenvaluePath], value: float, pairs: Eigenpairs, mass: Any) -> _Matches:
    """Which eigenvalues at a value go on with the paths, and how much alike their shapes are."""
    from scipy.optimize import linear_sum_assignment

    if not paths:
        return _Matches(np.zeros(0, int), np.zeros(0))
    expected = np.array([path.expected(value) for path in paths])
    alike = assurance(np.array([path.last.vector for path in paths]).T, pairs.vectors, mass)
    distance = np.abs(expected[:, None] - pairs.values)
    scale = np.abs(expected)[:, None] + np.abs(pairs.values)
    apart = distance / np.where(scale > 0.0, scale, 1.0)
    ends = np.array([_NO_PLACE if path.last.value.imag > 0.0 else _ENDS for path in paths])
    cost = np.hstack([1.0 - alike + apart, np.where(np.eye(len(paths)) > 0.0, ends, 1e3)])
    _, columns = linear_sum_assignment(cost)
    none = columns >= len(pairs.values)
    places = np.where(none, -1, columns)
    return _Matches(places, np.where(none, np.nan, alike[np.arange(len(paths)), places]))


def assurance(first: Array, second: Array, mass: Any) -> Array:
    """Modal assurance criterion of each shape with each other one, in the norm of the mass."""
    weighted = mass @ second
    between = np.abs(first.conj().T @ weighted) ** 2
    own = np.einsum("ij,ij->j", first.conj(), mass @ first).real
    other = np.einsum("ij,ij->j", second.conj(), weighted).real
    return between / np.outer(own, other)
