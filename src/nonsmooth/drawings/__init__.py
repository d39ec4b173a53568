"""Drawings of machines as data: shapes whose coordinates are texts of states and parameters.

A drawing knows nothing of who shows it. `Drawing.frames` works out all coordinates of all samples
of a run at once, as plain arrays of lines and areas, which a plot, a film or a page can draw. The
drawings of the models are the files in `machines`.
"""

from __future__ import annotations

from nonsmooth.drawings.drawing import Drawing
from nonsmooth.drawings.frames import DrawnShape, Frames
from nonsmooth.drawings.library import drawing_of
from nonsmooth.drawings.roles import ROLES, Role

__all__ = ["ROLES", "Drawing", "DrawnShape", "Frames", "Role", "drawing_of"]
