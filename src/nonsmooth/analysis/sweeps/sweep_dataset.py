"""Parts that the datasets of all sweeps share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.options import result_attributes
from nonsmooth.engine.status import Status
from nonsmooth.system.system import System

__all__ = ["parameter_coordinate", "stacked", "statuses", "sweep_attributes"]

Arrays = Mapping[str, npt.NDArray[Any]]


def parameter_coordinate(system: System, parameter: str, grid: npt.NDArray[np.float64]) -> Any:
    """Coordinate of the parameter with its label."""
    return ("parameter",), grid, {"long_name": system.describe.get(parameter, parameter)}


def statuses(found: Sequence[Arrays]) -> Any:
    """How the motions ended."""
    words = [Status(int(one["status"])).word for one in found]
    return ("parameter",), np.array(words, str), {"long_name": "how the motion ended"}


def stacked(found: Sequence[Arrays], name: str, shape: tuple[int, ...]) -> npt.NDArray[np.float64]:
    """One array of each motion below each other; nan where a motion has none."""
    rows = np.full((len(found), *shape), np.nan)
    for i, one in enumerate(found):
        rows[i] = one.get(name, np.nan)
    return rows


def sweep_attributes(
    system: System, found: Sequence[Arrays], complete: bool, options: Mapping[str, Any]
) -> dict[str, Any]:
    """Attributes: the system, how it went, and the options."""
    ended = {Status(int(one["status"])).word for one in found} - {Status.COMPLETED.word}
    message = "completed"
    if not complete:
        message = (
            f"interrupted by the user; {len(found)} values are done and kept, the others are left"
            " out"
        )
    elif ended:
        message = "some motions ended early, see status: " + ", ".join(sorted(ended))
    status = "completed" if complete else "interrupted"
    return result_attributes(system, status, message, options)
