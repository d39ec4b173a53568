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
from nonsmooth.models.rotors.texts import first_guess, rotor_words
from nonsmooth.system.parts import Exit, Mode

__all__ = ["matrix_rotor_words", "ring_words", "square_matrix"]


_SHARED = ("reach", "springs", "preload", "pull")
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
) -> dict[str, Any]:
    """What `System` takes, but for name and parameters."""
    n = len(load)
    base = rotor_words({})
    flow = _flow(matrices, ring, unbalance, load)
    i, j = ring
    words = ring_words(f"q{i} + eps_x", f"q{j} + eps_y")
    labels = {name: text for name, text in base["describe"].items() if name not in _OTHER_NAMES}
    for k in range(n):
        labels |= {f"q{k}": f"displacement {k}", f"v{k}": f"velocity {k}"}
    return {
        "states": [*flow, "sx", "sy", "mu"],
        "period": "2*pi/Omega",
        "require": _REQUIRE,
        "describe": labels | _LABELS,
        "definitions": words["definitions"],
        "outputs": {"vx": f"v{i}", "vy": f"v{j}", **words["outputs"]},
        "modes": {
            name: Mode(
                flow | dict(mode.flow), mode.exits, mode.slaved, mode.definitions, mode.cells
            )
            for name, mode in words["modes"].items()
        },
    }


def ring_words(x: str, y: str) -> dict[str, Any]:
    """Definitions, outputs and modes of a ring for a rotor at x, y from the centre of the ring.

    Stiffness ``k_s``, damping ``c_s``, clearance ``gamma``, preloads ``delta_x delta_y``; the
    force on the ring is ``Fx Fy``.
    """
    base = rotor_words({})
    return {
        "definitions": {
            "nx": "x - sx",
            "ny": "y - sy",
            **{n: t for n, t in base["definitions"].items() if n.startswith(_SHARED)},
            "Fx": "k_s*pull_x + c_s*springs_x*rate(sx)",
            "Fy": "k_s*pull_y + c_s*springs_y*rate(sy)",
            "size": "sqrt(Fx**2 + Fy**2)",
            "stored": str(base["definitions"]["stored"]).replace("0.5*K*", "0.5*k_s*"),
        },
        "outputs": {
            "x": x,
            "y": y,
            **base["outputs"],
            "gap": "gamma - sqrt(nx**2 + ny**2)",
        },
        "modes": _ring_modes(base["modes"]["contact"].cells),
    }


def _ring_modes(cells: dict[str, str]) -> dict[str, Mode]:
    contact = Exit(
        "gamma**2 - nx**2 - ny**2",
        to="contact",
        reset=first_guess("gamma", "2*(reach/gamma - 1)"),
        name="contact",
    )
    return {
        "free": Mode(
            {
                "sx": "-k_s/c_s*(sx + preload_x)",
                "sy": "-k_s/c_s*(sy + preload_y)",
            },
            slaved={"mu": "0"},
            definitions={"Fx": "0", "Fy": "0", "size": "0"},
            exits=[contact],
            cells=dict.fromkeys(cells, "free"),
        ),
        "contact": Mode(
            {},
            slaved={
                "sx": "pull_x = mu*nx",
                "sy": "pull_y = mu*ny",
                "mu": "nx**2 + ny**2 = gamma**2",
            },
            exits=[Exit("nx*Fx + ny*Fy", to="free", reset={"mu": "0"}, name="release")],
            cells=cells,
        ),
    }


def _flow(
    matrices: Mapping[str, np.ndarray],
    ring: tuple[int, int],
    unbalance: Iterable[Any],
    load: np.ndarray,
) -> dict[str, str]:
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
    rates = {f"q{k}": f"v{k}" for k in range(n)}
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
