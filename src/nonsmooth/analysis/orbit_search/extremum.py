"""The largest value of a smooth function on an interval, its place to nearly all digits."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev

__all__ = ["Extremum", "largest_inside"]

Floats = npt.NDArray[np.float64]

_NODES = 24
_TAIL = 4  # coefficients that tell whether a polynomial has converged
_CONVERGED = 1e-13  # of the largest value
_ROUNDING = 1e-15
_MOST = 60  # intervals, each inside the one before
_NARROW = 1e-13  # of the first interval


class Extremum(NamedTuple):
    """A largest value; ``inside`` where the function falls on both sides."""

    place: float
    value: float
    inside: bool


def largest_inside(
    function: Callable[[float], float], low: float, high: float, ends: tuple[float, float]
) -> Extremum:
    """Largest value between two places at which the function is known.

    The polynomial through values at Chebyshev nodes is differentiated: an extremum by values alone
    would be right to half the digits. Where it has not converged, the interval is halved and more
    around the best node. nan values are passed over.
    """
    whole = (low, high)
    known = {low: ends[0], high: ends[1]}
    for _ in range(_MOST):
        nodes = chebyshev.chebpts1(_NODES)
        places = 0.5 * (low + high) + 0.5 * (high - low) * nodes
        values = np.array([function(float(x)) for x in places])
        known |= dict(zip(places.tolist(), values.tolist(), strict=True))
        if np.all(np.isfinite(values)):
            found = _by_polynomial(nodes, values)
            if found is not None:
                place = 0.5 * (low + high) + 0.5 * (high - low) * found
                inner = function(place)
                if np.isfinite(inner):
                    known[place] = inner
                    best = max(known, key=lambda x: _number(known[x]))
                    # neighbours beat the extremum by rounding alone
                    if inner >= known[best] - 1e-12 * abs(known[best]):
                        return Extremum(place, inner, True)
        order = sorted(known)
        best = max(order, key=lambda x: _number(known[x]))
        k = order.index(best)
        low, high = order[max(k - 1, 0)], order[min(k + 1, len(order) - 1)]
        if not high - low > _NARROW * (whole[1] - whole[0]):
            break
    best = max(known, key=lambda x: _number(known[x]))
    return Extremum(best, known[best], best not in whole)


def _number(value: float) -> float:
    return value if np.isfinite(value) else -np.inf


def _by_polynomial(nodes: Floats, values: Floats) -> float | None:
    """Where the polynomial through values has its largest extremum inside; None without one."""
    size = float(np.abs(values).max())
    middle = float(values.mean())
    series = chebyshev.chebfit(nodes, values - middle, _NODES - 1)
    if np.abs(series[-_TAIL:]).max() > _CONVERGED * size:
        return None
    kept = np.flatnonzero(np.abs(series) > _ROUNDING * size)
    series = series[: int(kept[-1]) + 1] if kept.size else series[:1]
    if series.size < 3:
        return None
    roots = chebyshev.chebroots(chebyshev.chebder(series))
    real = np.sort(roots.real[(np.abs(roots.imag) <= 1e-9) & (np.abs(roots.real) <= 1.0)])
    bend = chebyshev.chebval(real, chebyshev.chebder(series, 2))
    real = real[bend < 0.0]
    if not real.size:
        return None
    return float(real[np.argmax(chebyshev.chebval(real, series))])
