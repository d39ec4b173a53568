"""What is known of the criticality of a special point."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

__all__ = ["UNDECIDED", "NormalForm", "side_of"]

Complexes = npt.NDArray[np.complex128]

UNDECIDED = "not decided"


def _none() -> Complexes:
    return np.zeros(0, complex)


@dataclass
class NormalForm:
    """A normal form and what follows from it.

    ``amplitude`` times the distance of the parameter to the power of ``power`` is by how much the
    orbits that meet at the point lie apart from the one there, along ``right``.
    """

    criticality: str = UNDECIDED
    detail: str = ""
    coefficient: float = np.nan
    error: float = np.nan
    rate: float = np.nan
    rate_error: float = np.nan
    side: str = ""
    amplitude: float = np.nan
    power: float = np.nan
    reach: float = np.nan  # along ``right``, to where the itinerary was looked at and is the same
    narrow: bool = False  # whether it changes within twice that
    angle: float = np.nan
    resonance: str = ""
    outside: int = 0  # other multipliers outside the unit circle
    right: Complexes = field(default_factory=_none)  # of all states that do not drift
    left: Complexes = field(default_factory=_none)


def side_of(sign: float) -> str:
    """On which side of the point a parameter lies whose distance to it has a sign."""
    return "above" if sign > 0.0 else "below"
