"""A variable of a settled motion as Legendre series between its events.

Panels are halved where the last terms of their series are too large, so that means, extremes and
percentiles come with an error that is known.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

__all__ = ["Panels", "fit_panels"]

Floats = npt.NDArray[np.float64]

_NODES = 8
_NODE, _WEIGHT = legendre.leggauss(_NODES)
# values at the nodes to coefficients: the discrete transform is exact for this degree
_TO_COEFFICIENTS = (
    (np.arange(_NODES) + 0.5)[:, None] * legendre.legvander(_NODE, _NODES - 1).T * _WEIGHT
)
_GOOD = 1e-10  # of the largest value: error at which a panel is not halved any more
_HALVINGS = 8
_MOST = 20_000  # panels; a variable that jumps within modes would need ever more
_INSIDE = 1.0 - 1e-9  # just within the ends of a panel, where no node lies
_SHORTEST = 1e-12  # of the duration; what is shorter lies within rounding of an event
_FINE = 32  # parts of a panel in which extremes are looked for, and for percentiles
_PART = 2.0 / _FINE
_NEWTON = 5  # steps from the highest of these places to where the series turns
_FINE_AT = np.linspace(-1.0, 1.0, _FINE + 1)
_EVALUATE = legendre.legvander(_FINE_AT, _NODES - 1)
_MIDDLES = legendre.legvander(0.5 * (_FINE_AT[1:] + _FINE_AT[:-1]), _NODES - 1)


class Panels(NamedTuple):
    """Pieces of a curve."""

    edges: Floats  # (P, 2): begin and end
    coefficients: Floats  # (P, node)
    misses: Floats  # (P,): by how much the series misses the values at the ends

    @property
    def widths(self) -> Floats:
        """Durations of the panels."""
        return self.edges[:, 1] - self.edges[:, 0]

    def errors(self) -> Floats:
        """What the last two terms of each panel amount to, or what its ends are off."""
        return np.maximum(np.abs(self.coefficients[:, -2:]).sum(axis=1), self.misses)

    def take(self, chosen: npt.NDArray[np.bool_]) -> Panels:
        """Some of the panels."""
        return Panels(self.edges[chosen], self.coefficients[chosen], self.misses[chosen])

    def integral(self) -> float:
        """Integral of the variable over time."""
        return float(self.coefficients[:, 0] @ self.widths)

    def integral_of_square(self) -> float:
        """Integral of its square; Legendre polynomials are orthogonal."""
        squares = self.coefficients**2 / (2.0 * np.arange(_NODES) + 1.0)
        return float(squares.sum(axis=1) @ self.widths)

    def highest(self) -> tuple[float, float]:
        """The largest value and its error."""
        values = self.coefficients @ _EVALUATE.T
        highest = values.argmax(axis=1)
        peaks = np.maximum(values.max(axis=1), self._turning_near(_FINE_AT[highest]))
        panel = int(np.argmax(peaks))
        return float(peaks[panel]), float(self.errors()[panel])

    def _turning_near(self, places: Floats) -> Floats:
        """Values where the series turns, next to a place in each panel: a root of its slope."""
        slopes = np.asarray(legendre.legder(self.coefficients, axis=1), float)
        bends = np.asarray(legendre.legder(slopes, axis=1), float)
        low, high = np.maximum(places - _PART, -1.0), np.minimum(places + _PART, 1.0)
        for _ in range(_NEWTON):
            slope, bend = _values(slopes, places), _values(bends, places)
            with np.errstate(divide="ignore", invalid="ignore"):
                step = slope / bend
            places = np.clip(places - np.where(np.isfinite(step), step, 0.0), low, high)
        return _values(self.coefficients, places)

    def lowest(self) -> tuple[float, float]:
        """The smallest value and its error."""
        value, error = self._replace(coefficients=-self.coefficients).highest()
        return 0.0 - value, error  # no negative zero

    def percentiles(self, parts: Floats) -> Floats:
        """Values below which the variable is for some parts of the time, from 0 to 100."""
        values = (self.coefficients @ _MIDDLES.T).ravel()
        weights = np.repeat(self.widths, _FINE)
        order = np.argsort(values, kind="stable")
        passed = np.cumsum(weights[order]) - 0.5 * weights[order]
        return np.asarray(np.interp(parts / 100.0 * weights.sum(), passed, values[order]))


def _values(coefficients: Floats, places: Floats) -> Floats:
    """Series at one place each; (P, n) and (P,)."""
    return np.asarray(
        (legendre.legvander(places, coefficients.shape[1] - 1) * coefficients).sum(axis=1)
    )


def fit_panels(evaluate: Callable[[Floats], Floats], breaks: Floats, duration: float) -> Panels:
    """Panels of what ``evaluate`` gives at times in order, between all the breaks."""
    edges = np.column_stack([breaks[:-1], breaks[1:]])
    edges = edges[edges[:, 1] - edges[:, 0] > _SHORTEST * duration]
    done = Panels(np.zeros((0, 2)), np.zeros((0, _NODES)), np.zeros(0))
    size = 0.0
    for halving in range(_HALVINGS + 1):
        panels, largest = _fit(evaluate, edges)
        size = max(size, largest)
        bad = (panels.errors() > _GOOD * size) & (panels.widths > 2.0 * _SHORTEST * duration)
        if halving == _HALVINGS or len(done.edges) + 2 * np.count_nonzero(bad) > _MOST:
            bad[:] = False
        done = Panels(*(np.concatenate(pair) for pair in zip(done, panels.take(~bad), strict=True)))
        if not np.any(bad):
            break
        low, high = edges[bad].T
        centre = 0.5 * (low + high)
        edges = np.column_stack([low, centre, centre, high]).reshape(-1, 2)
    order = np.argsort(done.edges[:, 0], kind="stable")
    return Panels(done.edges[order], done.coefficients[order], done.misses[order])


def _fit(evaluate: Callable[[Floats], Floats], edges: Floats) -> tuple[Panels, float]:
    """A panel for each pair of edges, in order, and the largest value."""
    middle, half = edges.mean(axis=1), 0.5 * np.diff(edges, axis=1)
    times = middle[:, None] + half * np.concatenate([[-_INSIDE], _NODE, [_INSIDE]])
    values = evaluate(times.ravel()).reshape(times.shape)
    coefficients = values[:, 1:-1] @ _TO_COEFFICIENTS.T
    ends = coefficients @ _EVALUATE[[0, -1]].T
    misses = np.abs(ends - values[:, [0, -1]]).max(axis=1, initial=0.0)
    return Panels(edges, coefficients, misses), float(np.abs(values).max(initial=0.0))
