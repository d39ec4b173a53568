"""Numbers that vanish where flips or tori of a curve change their criticality.

The cubic coefficient itself has poles: where another multiplier is 1, as a curve of folds is
touched there, and on a curve of flips where another one is -1. So it is multiplied by what vanishes
there, and changes its sign nowhere but at its zeros.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.normal_forms.directional import Narrow
from nonsmooth.analysis.normal_forms.smooth_points import cubic_of
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.word_map import WordMap
from nonsmooth.system.system import System

__all__ = ["CHANGES", "CriticalityAlong"]

Floats = npt.NDArray[np.float64]

CHANGES = {"flip": "generalised_flip", "torus": "chenciner"}  # by the kind of the curve
_LEVELS = 7  # steps of differences: enough for a sign, at each of many points
_LEAST = 1e-300  # no zero, and nothing in sums


class CriticalityAlong:
    """The number that tells the criticality of flips, or of tori, at the points of a curve."""

    def __init__(self, system: System, parameter: str, kind: str) -> None:
        """``parameter``: any of the system, as return maps have one; it is held."""
        self._legs, self._kind = Legs(system, (parameter,)), kind

    def __call__(self, equations: OrbitEquations, unknowns: Floats, values: Floats) -> float:
        """The number for an orbit, nan where no coefficient is known; values of all parameters.

        A coefficient within its error has no sign, and counts as positive, so that rounding about
        zero is no change.
        """
        self._legs.set_values(values)
        own = OrbitEquations(
            self._legs, equations.word, period=equations.period, phase=equations.phase,
            autonomous=equations.autonomous, origin=equations.origin,
            reference=None if equations.reference is None else equations.reference.copy(),
        )  # fmt: skip
        try:
            own.evaluate(unknowns)  # a cycle without events gets its plane here
            found = cubic_of(WordMap(own, unknowns), self._kind, _LEVELS)
        except (LegError, Narrow, np.linalg.LinAlgError):
            return np.nan
        if found is None:
            return np.nan
        here, (value, error) = found
        size = abs(value) if abs(value) <= error else value
        poles = np.prod(1.0 - here.others)
        if self._kind == "flip":
            poles *= np.prod(1.0 + here.others)
        return float(size * poles.real) or _LEAST
