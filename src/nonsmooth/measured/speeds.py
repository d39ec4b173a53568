"""Speed of a machine by its marks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["speed_attributes"]


def speed_attributes(marks: npt.NDArray[np.float64]) -> dict[str, Any]:
    """Mean speed in radians per unit time, its spread over revolutions, number of marks."""
    single = 2.0 * math.pi / np.diff(marks)
    mean = 2.0 * math.pi * (marks.size - 1) / float(marks[-1] - marks[0])
    spread = float(np.sqrt(np.mean((single - mean) ** 2)))
    return {"speed": mean, "speed_spread": spread, "n_marks": int(marks.size)}
