"""Matrices of a rotor with many freedoms: from files, and as texts of equations."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.errors import ModelError
from nonsmooth.matrix_files import read_matrix
from nonsmooth.models.rotors.texts import (
    RingNames,
    ring_modes,
    ring_texts,
    rotor_words,
    with_flow,
)
from nonsmooth.system.parts import Text

__all__ = ["matrix_rotor_words", "ring_words", "square_matrix"]


_REQUIRE = {
    "Omega > 0": "the rotor must turn",
    "k_s > 0": "the ring is held by springs",
    "c_s > 0": "an undamped ring would never come to rest",
    "gamma > 0": "a ring without clearance is a bearing",
    "delta_x >= 0": "springs with a negative preload leave the ring loose",
    "delta_y >= 0": "springs with a negative preload leave the ring loose",
}
_LABELS = {
    "Omega": "speed of the rotor",
    "k_s": "stiffness of a spring of the ring",
    "c_s": "damping of a damper of the ring",
    "gamma": "radial clearance",
    "x": "displacement of the rotor at the ring in x",
    "y": "displacement of the rotor at the ring in y",
    "vx": "velocity of the rotor at the ring in x",
    "vy": "velocity of the rotor at the ring in y",
}
_OTHER_NAMES = ("eta", "nu1", "nu2", "K", "eta_m", "rho")
_CURE = "; an .npz file with all matrices is read by MatrixRotor.from_file"


def matrix_rotor_words(
    matrices: Mapping[str, np.ndarray],
    ring: tuple[int, int],
    unbalance: Iterable[Any],
    load: np.ndarray,
    damped: bool,
    riding: bool,
) -> dict[str, Any]:
    """What `System` takes, but for name and parameters."""
    n = len(load)
    base = rotor_words({})
    flow = _flow(matrices, ring, unbalance, load)
    i, j = ring
    at_ring = RingNames("k_s", "c_s" if damped else None, "gamma", f"v{i}", f"v{j}")
    words = ring_words(f"q{i} + eps_x", f"q{j} + eps_y", at_ring, rides=riding)
    labels = {name: text for name, text in base["describe"].items() if name not in _OTHER_NAMES}
    for k in range(n):
        labels |= {f"q{k}": f"displacement {k}", f"v{k}": f"velocity {k}"}
    left_out = () if damped else ("c_s", "c_s > 0")
    return {
        "states": [*flow, "sx", "sy", "mu"],
        "period": "2*pi/Omega",
        "require": {text: why for text, why in _REQUIRE.items() if text not in left_out},
        "describe": {k: v for k, v in (labels | _LABELS).items() if k not in left_out},
        "definitions": words["definitions"],
        "outputs": {"vx": f"v{i}", "vy": f"v{j}", **words["outputs"]},
        "modes": with_flow(words["modes"], flow),
    }


def ring_words(x: str, y: str, ring: RingNames, *, rides: bool) -> dict[str, Any]:
    """Definitions, outputs and modes of a ring for a rotor at x, y from the centre of the ring.

    Preloads are called ``delta_x delta_y``; the force on the ring is ``Fx Fy``.
    """
    outputs = rotor_words({})["outputs"]
    return {
        "definitions": ring_texts(ring, rides=rides),
        "outputs": {
            "x": x,
            "y": y,
            **outputs,
            "gap": f"{ring.gap} - sqrt(nx**2 + ny**2)",
        },
        "modes": ring_modes(ring, rides=rides),
    }


def _flow(
    matrices: Mapping[str, np.ndarray],
    ring: tuple[int, int],
    unbalance: Iterable[Any],
    load: np.ndarray,
) -> dict[str, Text]:
    """Rates of displacements and velocities."""
    n = len(load)
    cosine, sine, at_ring = np.zeros(n), np.zeros(n), np.zeros((n, 2))
    for x, y, moment, phase in unbalance:
        cosine[x] += moment * math.cos(phase)
        sine[x] -= moment * math.sin(phase)
        cosine[y] += moment * math.sin(phase)
        sine[y] += moment * math.cos(phase)
    at_ring[ring[0], 0] = at_ring[ring[1], 1] = 1.0
    terms: dict[str, np.ndarray] = {}
    for sign, name, after in (
        (-1.0, "stiffness", "q{}"),
        (-1.0, "damping", "v{}"),
        (-1.0, "gyroscopic", "Omega*v{}"),
    ):
        columns = (sign * matrices[name]).T
        terms |= {after.format(k): column for k, column in enumerate(columns)}
    terms["1"] = load
    terms["Omega**2*cos(Omega*t + phi0)"] = cosine
    terms["Omega**2*sin(Omega*t + phi0)"] = sine
    terms["Fx"], terms["Fy"] = -at_ring[:, 0], -at_ring[:, 1]
    solved = np.linalg.solve(matrices["mass"], np.column_stack(list(terms.values())))
    rates: dict[str, Text] = {f"q{k}": f"v{k}" for k in range(n)}
    return rates | {f"v{k}": _sum(solved[k], terms) for k in range(n)}


def _sum(factors: np.ndarray, names: Iterable[str]) -> str:
    parts = [
        f"{'-' if factor < 0.0 else '+'} {abs(float(factor))!r}*{name}"
        for factor, name in zip(factors, names, strict=True)
        if factor != 0.0
    ]
    return " ".join(parts).removeprefix("+ ") or "0"


def square_matrix(name: str, given: Any, size: int | None = None) -> np.ndarray:
    """Square array of finite numbers, from an array or the path of a file."""
    if isinstance(given, str | os.PathLike):
        array, name = read_matrix(name, Path(given), _CURE), f"{name} ({Path(given).name})"
    else:
        array = given
    array = array.toarray() if hasattr(array, "toarray") else array  # sparse, as scipy has it
    try:
        matrix = np.asarray(array)
        if matrix.dtype.kind not in "iuf":
            raise TypeError
        matrix = matrix.astype(float)
    except (TypeError, ValueError, OverflowError):
        raise ModelError(f"{name}: a matrix has real numbers in rows of one length") from None
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or not matrix.size:
        raise ModelError(
            f"{name} has shape {matrix.shape}; it is square, with a row and a column for each"
            " degree of freedom"
        )
    if size is not None and len(matrix) != size:
        raise ModelError(
            f"{name} is {len(matrix)} x {len(matrix)} and the mass matrix {size} x {size}; all"
            " have the same degrees of freedom"
        )
    if not np.isfinite(matrix).all():
        row, column = np.argwhere(~np.isfinite(matrix))[0]
        raise ModelError(f"{name}[{row}, {column}] = {matrix[row, column]} is not finite")
    return matrix
