"""Modes followed along a value, such as the speed, by their shapes and their eigenvalues."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.structures.eigenpairs import Eigenpairs, nearest_to_zero
from nonsmooth.structures.pencil import Pencil

__all__ = ["ALIKE", "FollowedModes", "assurance", "follow", "nearby"]

Array = npt.NDArray[Any]

ALIKE = 0.7  # of the modal assurance criterion, with which two shapes are those of one mode
_HALVINGS = 6  # of a step in which shapes change more
_MORE = 4  # modes beyond those that are followed, which may come in between


class FollowedModes(NamedTuple):
    """Rows for values, in order, with a column for each mode."""

    at: npt.NDArray[np.float64]
    values: npt.NDArray[np.complex128]
    vectors: npt.NDArray[np.complex128]
    """By value, coordinate and mode."""
    likeness: npt.NDArray[np.float64]
    """Modal assurance criterion with the row before."""

    def rows(self, given: Array) -> FollowedModes:
        """Those of given values; the criterion is the least since the one before."""
        places = [int(np.flatnonzero(self.at == value)[0]) for value in given]
        begins = [0, *(place + 1 for place in places[:-1])]
        likeness = [
            self.likeness[begin : end + 1].min(axis=0)
            for begin, end in zip(begins, places, strict=True)
        ]
        return FollowedModes(
            self.at[places], self.values[places], self.vectors[places], np.array(likeness)
        )


class _ModesAt(NamedTuple):
    at: float
    pairs: Eigenpairs
    likeness: Array


def follow(pencil_at: Callable[[float], Pencil], values: Array, count: int) -> FollowedModes:
    """The slowest modes at the first value that oscillate, and what becomes of them.

    There are rows for all values, and for those in between that it took to tell modes apart.
    """
    begin = nearby(pencil_at(float(values[0])), count)
    moving = np.flatnonzero(begin.values.imag > 0.0)[:count]
    found = [_ModesAt(float(values[0]), _chosen(begin, moving), np.ones(len(moving)))]
    for value in values[1:]:
        _step(pencil_at, found, float(value), _HALVINGS, count)
    return FollowedModes(
        np.array([each.at for each in found]),
        np.array([each.pairs.values for each in found]),
        np.array([each.pairs.vectors for each in found]),
        np.array([each.likeness for each in found]),
    )


def nearby(pencil: Pencil, count: int) -> Eigenpairs:
    """Modes among which those are that are followed."""
    return nearest_to_zero(pencil, 2 * count + _MORE)


def _chosen(pairs: Eigenpairs, order: Array) -> Eigenpairs:
    return Eigenpairs(pairs.values[order], pairs.vectors[:, order])


def _step(
    pencil_at: Callable[[float], Pencil],
    found: list[_ModesAt],
    value: float,
    halvings: int,
    count: int,
) -> None:
    """Add the same modes at another value; by way of the middle where shapes change much."""
    pencil = pencil_at(value)
    pairs = nearby(pencil, count)
    order, likeness = _matched(found, value, pairs, pencil.M)
    if (likeness >= ALIKE).all() or halvings == 0:
        found.append(_ModesAt(value, _chosen(pairs, order), likeness))
        return
    _step(pencil_at, found, (found[-1].at + value) / 2.0, halvings - 1, count)
    _step(pencil_at, found, value, halvings - 1, count)


def _matched(
    found: list[_ModesAt], value: float, pairs: Eigenpairs, mass: Any
) -> tuple[Array, Array]:
    """Which modes at a value are the last ones found, and how much alike their shapes are."""
    from scipy.optimize import linear_sum_assignment

    here = found[-1]
    expected = here.pairs.values
    if len(found) > 1:
        before = found[-2]
        share = (value - here.at) / (here.at - before.at)
        expected = expected + share * (expected - before.pairs.values)
    alike = assurance(here.pairs.vectors, pairs.vectors, mass)
    distance = np.abs(expected[:, None] - pairs.values)
    scale = np.abs(expected)[:, None] + np.abs(pairs.values)
    apart = distance / np.where(scale > 0.0, scale, 1.0)
    rows, columns = linear_sum_assignment(1.0 - alike + apart)
    return columns, alike[rows, columns]


def assurance(first: Array, second: Array, mass: Any) -> Array:
    """Modal assurance criterion of each shape with each other one, in the norm of the mass."""
    weighted = mass @ second
    between = np.abs(first.conj().T @ weighted) ** 2
    own = np.einsum("ij,ij->j", first.conj(), mass @ first).real
    other = np.einsum("ij,ij->j", second.conj(), weighted).real
    return between / np.outer(own, other)
