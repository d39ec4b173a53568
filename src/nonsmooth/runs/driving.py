"""Whether something drives a system, and whether strobes see it at one phase."""

from __future__ import annotations

import numpy as np

from nonsmooth.engine.tables import Tables

__all__ = ["hides_phase", "is_driven"]

_TURN = 1e-9  # of a forcing between strobes, beside their number, within which it is a whole one


def is_driven(tables: Tables) -> bool:
    """Whether time stands in a system: as harmonics, as powers, or as signals."""
    return bool(tables.harmonics.shape[1] or tables.sizes.powers or tables.signals.shape[0])


def hides_phase(tables: Tables, length: float) -> bool:
    """Whether strobes see the forcing at different phases, for lack of a common period.

    Those phases neither grow nor die away, and are no states.
    """
    turns = tables.harmonics[0] * length / (2.0 * np.pi)
    return bool(np.any(np.abs(turns - np.rint(turns)) > _TURN * np.maximum(1.0, turns)))
