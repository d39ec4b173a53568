"""Modes followed along a value, such as the speed, by their shapes and their eigenvalues."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.structures.eigenpairs import Eigenpairs, nearest_to_zero
from nonsmooth.structures.pencil import Pencil

__all__ = ["FollowedModes", "follow"]

Array = npt.NDArray[Any]

_ALIKE = 0.7  # of the modal assurance criterion, with which two shapes are those of one mode
_HALVINGS = 6  # of a step in which shapes change more
_MORE = 4  # modes beyond those that are followed, which may come in between


class FollowedModes(NamedTuple):
    """One row for each value, one column for each mode."""

    values: npt.NDArray[np.complex128]
    vectors: npt.NDArray[np.complex128]
    """By value, coordinate and mode."""
    likeness: npt.NDArray[np.float64]
    """Modal assurance criterion with the row before; of refined steps the least."""


class _ModesAt(NamedTuple):
    at: float
    pairs: Eigenpairs
    mass: Any


def follow(pencil_at: Callable[[float], Pencil], values: Array, count: int) -> FollowedModes:
    """The slowest modes at the first value that oscillate, and what becomes of them."""
    begin = _point(pencil_at, float(values[0]), count)
    moving = np.flatnonzero(begin.pairs.values.imag > 0.0)[:count]
    here = begin._replace(pairs=_chosen(begin.pairs, moving))
    before = None
    found = [(here, np.ones(len(moving)))]
    for value in values[1:]:
        there, alike = _step(pencil_at, here, before, float(value), _HALVINGS, count)
        before, here = here, there
        found.append((here, alike))
    return FollowedModes(
        np.array([point.pairs.values for point, _ in found]),
        np.array([point.pairs.vectors for point, _ in found]),
        np.array([alike for _, alike in found]),
    )


def _point(pencil_at: Callable[[float], Pencil], value: float, count: int) -> _ModesAt:
    pencil = pencil_at(value)
    return _ModesAt(value, nearest_to_zero(pencil, 2 * count + _MORE), pencil.M)


def _chosen(pairs: Eigenpairs, order: Array) -> Eigenpairs:
    return Eigenpairs(pairs.values[order], pairs.vectors[:, order])


def _step(
    pencil_at: Callable[[float], Pencil],
    here: _ModesAt,
    before: _ModesAt | None,
    value: float,
    halvings: int,
    count: int,
) -> tuple[_ModesAt, Array]:
    """The same modes at another value; by way of the middle where shapes change much."""
    point = _point(pencil_at, value, count)
    order, alike = _matched(here, before, point)
    there = point._replace(pairs=_chosen(point.pairs, order))
    if (alike >= _ALIKE).all() or halvings == 0:
        return there, alike
    middle, first = _step(pencil_at, here, before, (here.at + value) / 2.0, halvings - 1, count)
    there, second = _step(pencil_at, middle, here, value, halvings - 1, count)
    return there, np.minimum(first, second)


def _matched(here: _ModesAt, before: _ModesAt | None, there: _ModesAt) -> tuple[Array, Array]:
    """Which modes of one point are those of the last, and how much alike their shapes are."""
    from scipy.optimize import linear_sum_assignment

    expected = here.pairs.values
    if before is not None and here.at != before.at:
        share = (there.at - here.at) / (here.at - before.at)
        expected = expected + share * (expected - before.pairs.values)
    alike = _assurance(here.pairs.vectors, there.pairs.vectors, there.mass)
    distance = np.abs(expected[:, None] - there.pairs.values)
    scale = np.abs(expected)[:, None] + np.abs(there.pairs.values)
    apart = distance / np.where(scale > 0.0, scale, 1.0)
    rows, columns = linear_sum_assignment(1.0 - alike + apart)
    return columns, alike[rows, columns]


def _assurance(first: Array, second: Array, mass: Any) -> Array:
    """Modal assurance criterion of each shape with each other one, in the norm of the mass."""
    weighted = mass @ second
    between = np.abs(first.conj().T @ weighted) ** 2
    own = np.einsum("ij,ij->j", first.conj(), mass @ first).real
    other = np.einsum("ij,ij->j", second.conj(), weighted).real
    return between / np.outer(own, other)
