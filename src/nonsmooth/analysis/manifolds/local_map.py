"""The map of a saddle in scaled coordinates, whose origin is a point of the orbit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.family import SectionStarts
from nonsmooth.analysis.returns.images import Images, imaging_of, settle
from nonsmooth.engine.lanes import ANY
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.maps import Map
from nonsmooth.runs.poincare_map import PoincareMap

__all__ = ["Coordinates", "Itineraries", "LocalMap"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Texts = npt.NDArray[np.str_]

_TOGETHER = 512  # starts at once, which bounds the memory of their event logs
_LONGEST = 1000  # windows that a section is waited for


class Coordinates(NamedTuple):
    """Coordinates of a plane, or of all states, whose origin is a point of the orbit."""

    origin: Floats  # (n,) states
    active: Integers  # (m,) states that count: drifts do not
    scales: Floats  # (m,)
    basis: Floats  # (m, d) orthonormal directions of scaled states

    def states(self, points: Floats) -> Floats:
        """States of points; shapes: (L, d) to (L, n)."""
        states = np.tile(self.origin, (len(points), 1))
        states[:, self.active] += points @ self.basis.T * self.scales
        return states

    def points(self, states: Floats) -> Floats:
        """Coordinates of states; shapes: (..., n) to (..., d)."""
        away = (states[..., self.active] - self.origin[self.active]) / self.scales
        found: Floats = away @ self.basis
        return found

    @property
    def rounding(self) -> float:
        """Coordinates that differ by less have the same states."""
        size = np.abs(self.origin[self.active] / self.scales).max(initial=0.0)
        return float(np.finfo(float).eps * size)


class Itineraries(NamedTuple):
    """Images of points, and what happens on the way to them."""

    points: Floats  # (L, d)
    keys: Integers  # (L,) the same number for the same itinerary
    words: Texts  # (L,) modes on the way


class LocalMap:
    """Applies the map of a saddle to points in `Coordinates`.

    ``mode`` is that in which the origin lies; other points begin in the mode that fits. ``turns``
    is what angles of the orbit grow by in one application, (n,). It is taken off all images, so
    that the orbit of a rotation is a fixed point and its curves go on without a jump.
    """

    def __init__(
        self,
        chosen: Map,
        tolerance: float,
        coordinates: Coordinates,
        mode: int = ANY,
        turns: Floats | None = None,
    ) -> None:
        self.chosen, self.coordinates, self._tolerance = chosen, coordinates, tolerance
        self._mode = mode
        self.turns = np.zeros(len(coordinates.origin)) if turns is None else turns
        self._runner = chosen.runner(tolerance)
        self._imagings = {1: imaging_of(chosen, tolerance, _LONGEST)}
        self._keys: dict[str, int] = {}

    def at(self, origin: Floats, basis: Floats | None = None) -> LocalMap:
        """The same map with another origin, and perhaps another plane."""
        basis = self.coordinates.basis if basis is None else basis
        found = LocalMap.__new__(LocalMap)
        found.__dict__.update(self.__dict__)
        found.coordinates = self.coordinates._replace(origin=origin, basis=basis)
        return found

    def states_after(self, states: Floats, count: int) -> Floats:
        """States after some applications; nan where the motion ends before."""
        if isinstance(self.chosen, PoincareMap):
            for _ in range(count):
                states = self._images(states, 1).states
            return states
        return self._runner.last(self._runner.start(states, ANY), count)[0] - count * self.turns

    def after(self, points: Floats, count: int = 1) -> Floats:
        """Images of points after some applications; nan where there are none."""
        states = self.coordinates.states(points)
        return self.coordinates.points(self.states_after(states, count))

    def reset_at_start(self, points: Floats) -> Floats:
        """Where resets at the very start lead points; nan where there is none."""
        imaging = self._imagings[1]
        begun = settle(
            imaging.engine, self._starts(self.coordinates.states(points), imaging.begin),
            self._tolerance,
        )  # fmt: skip
        found = self.coordinates.points(begun.anchors.state)
        return np.where(begun.jumped[:, None], found, np.nan)

    def derivative(self, state: Floats) -> tuple[Floats, Floats] | None:
        """Image of one state, and the derivative of the image; None where there is none."""
        found = self._runner.images(state, self._mode, 1)
        return None if found is None else (found[0][-1] - self.turns, found[2])

    def itineraries(self, points: Floats, count: int = 1) -> Itineraries:
        """Images of points after some applications, with all that happens on the way."""
        images = self._images(self.coordinates.states(points), count)
        texts = np.char.add(np.char.add(images.words, "|"), images.exits)
        texts = np.where(images.there, texts, "-")
        keys = [self._keys.setdefault(text, len(self._keys)) for text in texts.tolist()]
        return Itineraries(
            self.coordinates.points(images.states), np.array(keys, np.int64), images.words
        )

    def _images(self, states: Floats, count: int) -> Images:
        imaging = self._imagings.get(count)
        if imaging is None:
            imaging = imaging_of(self.chosen**count, self._tolerance, count * _LONGEST)
            self._imagings[count] = imaging
        begin = imaging.begin
        parts = []
        for first in range(0, max(1, len(states)), _TOGETHER):
            some = states[first : first + _TOGETHER]
            parts.append(imaging.images(self._starts(some, begin)))
        whole = parts[0] if len(parts) == 1 else _joined(parts)
        return whole._replace(states=whole.states - count * self.turns)

    @staticmethod
    def _starts(states: Floats, begin: Instant) -> SectionStarts:
        size = len(states)
        return SectionStarts(
            states, np.full(size, begin.number), np.full(size, begin.phase), np.full((size, 1), ANY)
        )


def _joined(parts: list[Images]) -> Images:
    return Images(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
