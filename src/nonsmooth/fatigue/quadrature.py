"""Integrals from panel to panel, each halved until both halves say the same."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nonsmooth.fatigue.checks import Array

__all__ = ["panel_integrals"]

_POINTS = 10  # of Gauss and Legendre in a panel
_ROUNDS = 40
_MOST = 20_000  # panels at once; a function that needs more is noise or is not finite


def panel_integrals(
    function: Callable[[Array], Array], edges: Array, tolerance: float
) -> tuple[Array, float]:
    """Integral over each panel, and a bound of the relative error of their sum.

    A panel is halved while its halves differ from it by more than its share of the tolerance, and
    there are not too many: the bound says what was reached.
    """
    found = np.zeros(edges.size - 1)
    error = 0.0
    place = np.arange(found.size)
    left, right = edges[:-1], edges[1:]
    whole = _gauss(function, left, right)
    total = float(np.abs(whole).sum())
    for turn in range(_ROUNDS):
        middle = 0.5 * (left + right)
        first, second = _gauss(function, left, middle), _gauss(function, middle, right)
        off = np.abs(first + second - whole)
        share = tolerance * total * (right - left) / (edges[-1] - edges[0])
        # a kink needs no more than its own share of what is left to be halved
        done = off <= np.maximum(share, 1e-16 * total)
        if turn == _ROUNDS - 1 or 2 * np.count_nonzero(~done) > _MOST:
            done[:] = True
        np.add.at(found, place[done], (first + second)[done])
        error += float(off[done].sum())
        if done.all():
            break
        go = ~done
        place = np.repeat(place[go], 2)
        bounds = np.stack([left[go], middle[go], right[go]], axis=1)
        left, right = bounds[:, :2].ravel(), bounds[:, 1:].ravel()
        whole = np.stack([first[go], second[go]], axis=1).ravel()
    return found, error / total if total > 0.0 else 0.0


def _gauss(function: Callable[[Array], Array], left: Array, right: Array) -> Array:
    nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
    half = 0.5 * (right - left)
    points = 0.5 * (left + right)[:, None] + half[:, None] * nodes
    values = function(points.ravel()).reshape(points.shape)
    return half * (values @ weights)
