"""One variable over another, in the colours of the modes, with the periodic orbit nearby."""

from __future__ import annotations

import numpy as np
from bokeh.models import ColumnDataSource

from nonsmooth.explorer.panes.by_mode import ModeLines
from nonsmooth.explorer.panes.look import INK, axis_text, fit, new_figure
from nonsmooth.explorer.tasks import Piece
from nonsmooth.explorer.view import View

__all__ = ["Portrait"]


class Portrait:
    """The pane of the phase portrait; a click is a start."""

    def __init__(self) -> None:
        self.plot = new_figure("portrait", boxes=False)
        self.lines = ModeLines(self.plot)
        self.orbit = ColumnDataSource({"x": [], "y": []})
        self.orbit_line = self.plot.line(
            "x", "y", source=self.orbit, line_color=INK, line_width=2.2, line_dash="solid"
        )

    def show(self, view: View, piece: Piece) -> None:
        """Show a motion."""
        x, y = view.portrait
        self.lines.show(piece["portrait"], piece["colours"])
        for axis_range, name in ((self.plot.x_range, x), (self.plot.y_range, y)):
            values = piece["values"][name]
            fit(axis_range, float(np.nanmin(values)), float(np.nanmax(values)))
        self.plot.xaxis.axis_label = axis_text(x, piece["labels"][x])
        self.plot.yaxis.axis_label = axis_text(y, piece["labels"][y])
        self.clear_orbit()

    def show_orbit(self, piece: Piece) -> None:
        """Show the orbit: solid where it is stable, dashed where it is not."""
        x, y = piece["curve"]
        self.orbit.data = {"x": x, "y": y}
        self.orbit_line.glyph.line_dash = "solid" if piece["stable"] else "dashed"

    def clear_orbit(self) -> None:
        """Show none."""
        if len(self.orbit.data["x"]):
            self.orbit.data = {"x": [], "y": []}
