"""A drawing of a whole run: arrays of all frames."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

__all__ = ["DrawnShape", "Frames"]


@dataclass(frozen=True, slots=True)
class DrawnShape:
    """A shape in all frames.

    Attributes
    ----------
    kind : {"area", "line", "text"}
        A closed and filled outline, an open line, or a text at a point.
    x, y : numpy.ndarray, shape (frames, points)
        Coordinates; where nothing moves there is one frame, which stands for all. Points of nan are
        gaps in a line.
    visible : numpy.ndarray of bool, shape (frames,) or (1,)
        Whether the shape is there.
    role : str
        What it stands for: a key of `ROLES`.
    text : str
        What is written, of a text.
    """

    kind: Literal["area", "line", "text"]
    x: npt.NDArray[np.float64]
    y: npt.NDArray[np.float64]
    visible: npt.NDArray[np.bool_]
    role: str
    text: str = ""

    @property
    def moves(self) -> bool:
        """Whether two frames can differ."""
        return self.x.shape[0] > 1 or self.visible.size > 1

    def at(self, frame: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], bool]:
        """Coordinates in one frame, and whether the shape is there."""
        place = frame if self.x.shape[0] > 1 else 0
        return self.x[place], self.y[place], bool(self.visible[min(frame, self.visible.size - 1)])


@dataclass(frozen=True, slots=True)
class Frames:
    """All shapes of a drawing, from the back to the front, and the range that they take.

    Attributes
    ----------
    shapes : tuple of DrawnShape
        The shapes.
    x_range, y_range : tuple of float
        What is to be seen; both axes have one scale.
    note : str
        What is not drawn to scale.
    """

    shapes: tuple[DrawnShape, ...]
    x_range: tuple[float, float]
    y_range: tuple[float, float]
    note: str
