"""Equations of a reduced structure with its bearings, as texts of states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.structures.bearing import Bearing
from nonsmooth.structures.contributions import Attachment, Contribution
from nonsmooth.structures.coordinates import is_rotation
from nonsmooth.structures.speed_texts import coefficient_pieces, piecewise_definitions, varies
from nonsmooth.structures.state_names import state_name, velocity_name, weighted_sum

__all__ = ["LinearPart", "bearing_part", "joined", "linear_part"]

Floats = npt.NDArray[np.float64]


@dataclass
class LinearPart:
    """Forces by the states, and what they accelerate; natural modes have unit masses."""

    forces: dict[str, list[str]]
    """Terms of the force on each state that is a displacement."""
    accelerations: Mapping[str, str]
    """Accelerations of those that are coordinates of the structure, by the forces on them."""
    turns: bool
    """Whether the speed Omega of the shaft stands in the texts."""


def linear_part(place: Attachment) -> LinearPart:
    """Texts of the matrices of a reduced structure, without its bearings."""
    form = place.form
    names, k = form.coordinates, len(form.states)
    velocities = [f"v{name}" for name in names]
    rows = []
    for i in range(len(names)):
        terms = [
            weighted_sum(zip(-form.stiffness[i], names, strict=True)),
            weighted_sum(zip(-form.damping[i], velocities, strict=True)),
        ]
        turned = weighted_sum(zip(-form.gyroscopic[i], velocities, strict=True))
        if turned:
            terms.append(f"Omega*({turned})")
        rows.append([term for term in terms if term])
    inverse = np.linalg.inv(form.mass[:k, :k])
    size = np.sqrt(np.diag(inverse))
    inverse[np.abs(inverse) <= 1e-15 * k * np.outer(size, size)] = 0.0
    forces = [f"sum_of_forces_{name}" for name in names[:k]]
    return LinearPart(
        dict(zip(names, rows, strict=True)),
        {
            name: weighted_sum(zip(row, forces, strict=True))
            for name, row in zip(names[:k], inverse, strict=True)
        },
        turns=bool(form.gyroscopic.any()),
    )


def bearing_part(
    place: Attachment,
    bearing: Bearing,
    held: Floats,
    called: str,
    speed_range: tuple[float, float] | None,
) -> Contribution:
    """Forces of a bearing, less what the stiffness of the natural modes has of it.

    Constant coefficients become parameters, those that depend on the speed definitions.
    """
    made = Contribution()
    names = [place.structure.coordinates[place.structure.index(c)] for c in bearing.coordinates]
    pieces = coefficient_pieces(bearing, speed_range)
    if not bearing.constant:
        made.turns = True
        known = "speed_range" if bearing.speed_range is None else "table"
        begin, end = pieces[0].begin, pieces[-1].end
        for condition, way in ((f"Omega >= {begin!r}", "begins"), (f"Omega <= {end!r}", "ends")):
            made.require[condition] = (
                f"the {known} of {called} {way} there; turn within, or give a longer one"
            )
    for i, row in enumerate(names):
        terms = []
        for j, column in enumerate(names):
            for which, (letter, word) in enumerate((("k", "stiffness"), ("c", "damping"))):
                state = state_name(column) if which == 0 else velocity_name(column)
                at = state_name(row) if i == j else f"{state_name(row)}_{state_name(column)}"
                name = f"{called}_{letter}_{at}"
                value = float(pieces[0].coefficients[-1, which, i, j])
                if varies(pieces, (which, i, j)):
                    made.definitions |= piecewise_definitions(name, "Omega", pieces, (which, i, j))
                elif value != 0.0:
                    made.parameters[name] = value
                    where, unit = at.replace("_", " by "), _unit(row, column, which)
                    made.describe[name] = f"{word} of {called} at {where} [{unit}]"
                else:
                    name = ""
                less = float(held[i, j]) if which == 0 else 0.0
                if less:
                    terms.append(f"-({name or '0'} - {less!r})*{state}")
                elif name:
                    terms.append(f"-{name}*{state}")
        if terms:
            force = f"{called}_on_{state_name(row)}"
            made.definitions[force] = joined(terms)
            made.loads.append((force, place.at({row: 1.0})))
    return made


def _unit(row: str, column: str, which: int) -> str:
    """Unit of a stiffness, or of a damping, by the coordinates of the force and of the motion."""
    force, length = "N m" if is_rotation(row) else "N", "rad" if is_rotation(column) else "m"
    return f"{force}{' s' if which else ''}/{length}"


def joined(terms: Sequence[str]) -> str:
    """Sum of texts that are sums or products, each with its own sign."""
    text = "".join(f" - {term[1:]}" if term[:1] == "-" else f" + {term}" for term in terms)
    return text.removeprefix(" + ") if text[:3] == " + " else f"-{text[3:]}" if text else "0"
