"""Curves in the colours of the modes: one line for each, and one for the jumps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bokeh.models import ColumnDataSource, GlyphRenderer

from nonsmooth.explorer.panes.look import QUIET

__all__ = ["ModeLines"]


class ModeLines:
    """Lines of one figure, made when a mode is first seen and empty where it is not."""

    def __init__(self, plot: Any, *, dash: str = "solid", width: float = 1.6) -> None:
        self.plot, self.dash, self.width = plot, dash, width
        self.lines: dict[tuple[str, str], tuple[ColumnDataSource, GlyphRenderer]] = {}

    def show(self, curves: Mapping[str, Any], colours: Mapping[str, str]) -> None:
        """Draw curves by the names of their modes; those under no name are jumps."""
        wanted = {(name, colours.get(name, QUIET)): points for name, points in curves.items()}
        for key, points in wanted.items():
            if key not in self.lines:
                self.lines[key] = self._new(*key)
            self.lines[key][0].data = {"x": points[0], "y": points[1]}
        for key, (source, _) in self.lines.items():
            if key not in wanted and len(source.data["x"]):
                source.data = {"x": [], "y": []}

    def _new(self, name: str, colour: str) -> tuple[ColumnDataSource, GlyphRenderer]:
        source = ColumnDataSource({"x": [], "y": []})
        jump = not name
        line = self.plot.line(
            "x",
            "y",
            source=source,
            line_color=colour,
            line_width=0.7 if jump else self.width,
            line_dash="dotted" if jump else self.dash,
            level="underlay" if jump else "glyph",
        )
        return source, line
