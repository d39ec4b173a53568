"""Whirl of the nodes of a shaft: the forward and the backward part of an elliptic orbit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.structures.coordinates import NodePlane, planes

__all__ = ["directions_of", "whirl_of", "whirl_parts"]

Array = npt.NDArray[Any]

_STILL = 1e-9  # of the largest entry of a shape, which may be an angle
_STRAIGHT = 1e-6  # share of the difference of both parts below which an orbit is a line


def whirl_parts(amplitudes: Array, planes: Sequence[NodePlane]) -> tuple[Array, Array]:
    """Forward and backward amplitude of each node, over the first axis.

    With x = Re X exp(i w t) and y likewise, x + i y = f exp(i w t) + conj(b) exp(-i w t).
    """
    x = amplitudes[[each.x for each in planes]]
    y = amplitudes[[each.y for each in planes]]
    return (x + 1j * y) / 2.0, (x - 1j * y) / 2.0


def whirl_of(amplitudes: Array, names: Sequence[str], speed: float) -> Array | None:
    """Share of forward less that of backward whirl in all nodes: 1 forward, -1 backward circles.

    Forward is the sense in which the shaft turns, from x to y at rest. Of motions in which no node
    is displaced, it is that of the rotations. None where no node has coordinates in both x and y.
    """
    shares = []
    for kind in ("", "r"):
        known = planes(names, kind)
        if not known:
            continue
        forward, backward = (np.sum(np.abs(p) ** 2, axis=0) for p in whirl_parts(amplitudes, known))
        whole = forward + backward
        still = np.sqrt(whole) <= _STILL * np.abs(amplitudes).max(axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            shares.append(np.where(still, np.nan, (forward - backward) / whole))
    if not shares:
        return None
    found = np.where(np.isnan(shares[0]), shares[-1], shares[0])
    return -found if speed < 0.0 else found


def directions_of(whirl: Array) -> Array:
    """Word for each share: forward, backward, straight, or none where no node moves."""
    words = np.select(
        [np.isnan(whirl), whirl > _STRAIGHT, whirl < -_STRAIGHT],
        ["none", "forward", "backward"],
        "straight",
    )
    return words.astype(object)
