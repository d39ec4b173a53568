"""Basins of attraction in the colours of `nonsmooth.plot`, or points of a section."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource

from nonsmooth.explorer.panes.look import axis_text, bare, fit, new_figure
from nonsmooth.explorer.tasks import Piece
from nonsmooth.explorer.view import View
from nonsmooth.plot.attractor_style import ENDED_EARLY, INADMISSIBLE, NOT_COMPUTED, UNSETTLED

__all__ = ["PlanePane"]

_OTHERS = {0: UNSETTLED, -1: ENDED_EARLY, -2: INADMISSIBLE, -3: NOT_COMPUTED}
_NO_IMAGE: dict[str, list[Any]] = {"image": [], "x": [], "y": [], "dw": [], "dh": []}
_NO_POINTS: dict[str, list[Any]] = {"x": [], "y": [], "colour": []}


class PlanePane:
    """The pane of starts; a click is a start, a box computes it finer."""

    def __init__(self) -> None:
        self.plot = new_figure("plane", boxes=True)
        self.plot.grid.visible = False
        self.plot.xaxis.ticker.desired_num_ticks = 4  # numbers of a small region are long
        self.image = ColumnDataSource(dict(_NO_IMAGE))
        self.plot.image_rgba("image", "x", "y", "dw", "dh", source=self.image, level="image")
        self.points = ColumnDataSource(dict(_NO_POINTS))
        self.plot.scatter(
            "x", "y", source=self.points, size=2.5, fill_color="colour", line_color=None
        )
        self.attractors = ColumnDataSource(dict(_NO_POINTS))
        self.plot.scatter(
            "x", "y", source=self.attractors, size=6, fill_color="colour", line_color="#ffffff",
            line_width=0.8,
        )  # fmt: skip

    def clear(self) -> None:
        """Show neither basins nor points."""
        self.image.data = dict(_NO_IMAGE)
        self.points.data, self.attractors.data = dict(_NO_POINTS), dict(_NO_POINTS)
        bare(self.plot)

    def show(self, view: View, piece: Piece) -> None:
        """Show basins or points."""
        across, up = view.plane
        self.plot.xaxis.axis_label = axis_text(across, piece["labels"][across], 46)
        self.plot.yaxis.axis_label = axis_text(up, piece["labels"][up])
        if "attractors" in piece:
            self._show_basins(piece)
        else:
            self._show_points(view, piece)

    def _show_basins(self, piece: Piece) -> None:
        left, right, low, high = piece["region"]
        rows, columns = piece["label"].shape
        # centres of cells are the values, so the picture reaches half a cell beyond them
        half = (right - left) / (columns - 1) / 2, (high - low) / (rows - 1) / 2
        self.image.data = {
            "image": [_image(piece)],
            "x": [left - half[0]],
            "y": [low - half[1]],
            "dw": [right - left + 2 * half[0]],
            "dh": [high - low + 2 * half[1]],
        }
        points = [each["points"] for each in piece["attractors"]]
        colours = [[each["colour"]] * each["points"][0].size for each in piece["attractors"]]
        self.attractors.data = {
            "x": np.concatenate([each[0] for each in points]) if points else [],
            "y": np.concatenate([each[1] for each in points]) if points else [],
            "colour": [colour for each in colours for colour in each],
        }
        self.points.data = dict(_NO_POINTS)
        fit(self.plot.x_range, left - half[0], right + half[0], room=0.0)
        fit(self.plot.y_range, low - half[1], high + half[1], room=0.0)

    def _show_points(self, view: View, piece: Piece) -> None:
        self.image.data = dict(_NO_IMAGE)
        self.attractors.data = dict(_NO_POINTS)
        self.points.data = {key: piece[key] for key in ("x", "y", "colour")}
        if view.region:
            fit(self.plot.x_range, *view.region[:2], room=0.0)
            fit(self.plot.y_range, *view.region[2:], room=0.0)
        elif len(piece["x"]):
            fit(self.plot.x_range, float(np.min(piece["x"])), float(np.max(piece["x"])))
            fit(self.plot.y_range, float(np.min(piece["y"])), float(np.max(piece["y"])))


def _image(piece: Piece) -> np.ndarray:
    """Labels as colours, four bytes each."""
    colours = _OTHERS | {each["number"]: each["basin"] for each in piece["attractors"]}
    label = piece["label"].astype(int)
    lowest = min(colours)
    table = np.zeros((max(colours) - lowest + 1, 4), np.uint8)
    for number, colour in colours.items():
        table[number - lowest] = (*(int(colour[k : k + 2], 16) for k in (1, 3, 5)), 255)
    return table[label - lowest].view(np.uint32).reshape(label.shape)
