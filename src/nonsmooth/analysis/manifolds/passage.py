"""From the first piece of an unstable manifold to that of a stable one, by the map alone.

A start at a place on the straight first piece of the unstable manifold is mapped some times, which
gives a point of the curve, and then some times more, until it is beside the straight first piece of
the stable manifold. How far it then is across that piece is a function of the place, and its zeros
are points of both manifolds. Neither curve is needed for it, so it is exact up to rounding and the
deviation of the first pieces.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.manifolds.local_map import LocalMap
from nonsmooth.analysis.manifolds.saddle import SaddlePoint

__all__ = ["Passage", "Root"]

Floats = npt.NDArray[np.float64]

_PARTS = 16  # into which a bracket is divided at once
_LEVELS = 16  # more than 16 digits


class Root(NamedTuple):
    """A place at which the function vanishes, and how sharply it is known."""

    place: Floats  # (K,)
    width: Floats  # (K,) of the last bracket


class Passage(NamedTuple):
    """Maps to take from one first piece to the other."""

    out: SaddlePoint  # of the unstable manifold
    side: float
    into: SaddlePoint  # of the stable manifold
    images: int  # applications of the map of the first saddle, up to the point
    ahead: int  # applications of that of the second one, from the point on
    shift: Floats  # (n,) whole turns of angles by which the point lies beyond the stable curve

    def states(self, places: Floats) -> Floats:
        """States of the points that starts at some places lead to; (K,) to (K, n)."""
        here = self.out.here
        states = here.coordinates.states(self.side * places[:, None] * self.out.direction)
        return here.states_after(states, self.images) if self.images else states

    def across(self, places: Floats) -> Floats:
        """How far the points are across the stable direction in the end; nan where they end."""
        here, states = self.into.here, self.states(places) - self.shift
        if self.ahead:
            states = here.states_after(states, self.ahead)
        found: Floats = here.coordinates.points(states) @ self.into.leaving
        return found

    def along(self, place: float) -> float:
        """How far along the stable direction the point of a place is in the end."""
        here, states = self.into.here, self.states(np.array([place])) - self.shift
        if self.ahead:
            states = here.states_after(states, self.ahead)
        return float(here.coordinates.points(states)[0] @ self.into.dual)

    def roots(self, low: Floats, high: Floats) -> Root:
        """Zeros between places where the function has different signs; shapes (K,)."""
        parts = np.linspace(0.0, 1.0, _PARTS + 1)
        rows = np.arange(low.size)
        for _ in range(_LEVELS):
            places = low[:, None] + parts * (high - low)[:, None]
            signs = np.sign(self.across(places.ravel())).reshape(places.shape)
            changes = (signs[:, 1:] != signs[:, :1]) & np.isfinite(signs[:, 1:])
            first = np.argmax(changes, axis=1)
            narrower = places[rows, first], places[rows, first + 1]
            if np.all((narrower[0] == low) & (narrower[1] == high)):
                break
            low, high = narrower
        return Root(0.5 * (low + high), high - low)

    def largest(self, low: float, high: float, way: float) -> tuple[float, float]:
        """Where the function, times ``way``, is largest between two places, and its value.

        Each level looks between the neighbours of the largest of some values. A top that is a
        corner is found to rounding, a smooth one to the root of it, which its value does not feel.
        """
        best, value = 0.5 * (low + high), -np.inf
        for _ in range(_LEVELS):
            places = np.linspace(low, high, 2 * _PARTS + 1)
            values = way * self.across(places)
            values = np.where(np.isfinite(values), values, -np.inf)
            top = int(np.argmax(values))
            if values[top] > value:
                best, value = float(places[top]), float(values[top])
            narrower = places[max(top - 1, 0)], places[min(top + 1, places.size - 1)]
            if not narrower[1] - narrower[0] < high - low:
                break
            low, high = float(narrower[0]), float(narrower[1])
        return best, value

    def directions(self, place: float) -> tuple[Floats, Floats] | None:
        """Tangent of the unstable manifold at a point, and normal of the stable one.

        In the plane of the stable manifold. None where a derivative is missing.
        """
        frame, out = self.into.here.coordinates, self.out.here.coordinates
        start = out.states(self.side * np.array([[place]]) * self.out.direction)[0]
        reached = _carried(self.out.here, start, self.images)
        if reached is None:
            return None
        begun = self.side * out.basis @ self.out.direction * out.scales
        onward = _carried(self.into.here, reached[0] - self.shift, self.ahead)
        if onward is None:
            return None
        active = frame.active
        along = (reached[1][np.ix_(active, out.active)] @ begun) / frame.scales
        normal = (frame.basis @ self.into.leaving) / frame.scales
        normal = (normal @ onward[1][np.ix_(active, active)]) * frame.scales
        return frame.basis.T @ along, frame.basis.T @ normal

    def later(self, more: int, ahead: int) -> Passage:
        """The same passage, whose point is that of some applications later.

        The point then lies beyond the stable curve by what that of the first orbit and that of the
        second one turn less or more in these applications, which take both the same time.
        """
        out, into = self.out.here, self.into.here
        apart = out.chosen.every / into.chosen.every * into.turns - out.turns
        return self._replace(
            images=self.images + more, ahead=ahead, shift=self.shift + more * apart
        )

    def angle(self, place: float) -> tuple[float, float]:
        """Angle of both manifolds at a point, and the sense in which one crosses the other."""
        found = self.directions(place)
        if found is None:
            return np.nan, np.nan
        along, normal = found
        product = float(along @ normal)
        size = float(np.linalg.norm(along) * np.linalg.norm(normal))
        return float(np.arcsin(min(abs(product) / size, 1.0))), float(np.sign(product))


def _carried(here: LocalMap, state: Floats, count: int) -> tuple[Floats, Floats] | None:
    """State after some applications of a map, and its derivative by the first one."""
    whole = np.eye(state.size)
    for _ in range(count):
        found = here.derivative(state)
        if found is None:
            return None
        state, whole = found[0], found[1] @ whole
    return state, whole
