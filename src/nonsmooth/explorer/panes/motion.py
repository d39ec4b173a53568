"""The motion in the colours of its modes: over time with its events, and as a phase portrait."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, HoverTool

from nonsmooth.explorer.panes.look import INK, QUIET, axis_text, fit, new_figure
from nonsmooth.explorer.tasks import Piece
from nonsmooth.explorer.view import View

__all__ = ["HistoryPane", "PortraitPane"]

_DASHES = ("solid", "dashed", "dotted", "dotdash")
_MOST_ACROSS = 27  # characters below the portrait, which is narrow
_NO_EVENTS: dict[str, list[Any]] = {
    key: [] for key in ("x", "y", "name", "when", "reason", "certificate", "fill")
}
_TIP = """
<div style="font: 13px system-ui, sans-serif; max-width: 320px">
<b>@name</b> at @when<br>@reason<br><span style="color: #5f6b76">@certificate</span></div>
"""


_NO_LINES: dict[str, list[Any]] = {key: [] for key in ("x", "y", "colour", "width", "dash")}


def _new_lines(plot: Any) -> ColumnDataSource:
    """Lines of all modes in one source, which is one message to the page, as a slider needs."""
    source = ColumnDataSource(dict(_NO_LINES))
    plot.multi_line(
        "x", "y", source=source, line_color="colour", line_width="width", line_dash="dash"
    )
    return source


def _lines(
    curves: Mapping[str, Any], colours: Mapping[str, str], *, dash: str = "solid", width: float
) -> list[tuple[Any, Any, str, float, str]]:
    """Lines of one variable by the names of their modes, over those under no name: jumps."""
    order = sorted(curves, key=lambda name: name != "")
    return [
        (*curves[name], colours.get(name, QUIET), *((width, dash) if name else (0.7, "dotted")))
        for name in order
    ]


def _columns(lines: Iterable[tuple[Any, ...]]) -> dict[str, list[Any]]:
    columns = [list(column) for column in zip(*lines, strict=True)]
    return dict(zip(_NO_LINES, columns, strict=True)) if columns else dict(_NO_LINES)


class HistoryPane:
    """The pane of the time history."""

    def __init__(self) -> None:
        self.plot = new_figure("history", boxes=False)
        self.lines = _new_lines(self.plot)
        self.events = ColumnDataSource(dict(_NO_EVENTS))
        marks = self.plot.scatter(
            "x", "y", source=self.events, size=6, line_color=INK, fill_color="fill", line_width=0.8
        )
        self.plot.add_tools(HoverTool(renderers=[marks], tooltips=_TIP, attachment="vertical"))

    def clear(self) -> None:
        """Show no motion."""
        self.lines.data = dict(_NO_LINES)
        self.events.data = dict(_NO_EVENTS)

    def show(self, view: View, piece: Piece) -> None:
        """Show a motion."""
        self.lines.data = _columns(
            line
            for k, (curves, dash) in enumerate(zip(piece["history"], _DASHES, strict=False))
            for line in _lines(curves, piece["colours"], dash=dash, width=1.3 if k else 1.6)
        )
        rows = piece["events"][1:]  # the first one is the start
        name = view.drawn[0]
        self.events.data = {
            "x": [row["time"] for row in rows],
            "y": [row["at"][name] for row in rows],
            "name": [row["name"].replace("_", " ") for row in rows],
            "when": [f"t = {row['time']:.8g}" for row in rows],
            "reason": [row["reason"] for row in rows],
            "certificate": [row["certificate"] for row in rows],
            "fill": ["#ffffff" if row["certificate"] == "certified" else INK for row in rows],
        }
        values = [piece["values"][each] for each in view.drawn]
        fit(self.plot.x_range, float(piece["time"][0]), float(piece["time"][-1]), room=0.01)
        fit(self.plot.y_range, min(map(_least, values)), max(map(_most, values)))
        self.plot.xaxis.axis_label = axis_text("t", piece["labels"]["time"])
        labels = piece["labels"]
        one = len(view.drawn) == 1
        self.plot.yaxis.axis_label = (
            axis_text(name, labels[name]) if one else ", ".join(_with_unit(labels, view.drawn))
        )


class PortraitPane:
    """The pane of the phase portrait; a click is a start."""

    def __init__(self) -> None:
        self.plot = new_figure("portrait", boxes=False)
        self.plot.xaxis.ticker.desired_num_ticks = 3  # the pane is narrow
        self.lines = _new_lines(self.plot)
        self.orbit = ColumnDataSource({"x": [], "y": []})
        self.orbit_line = self.plot.line(
            "x", "y", source=self.orbit, line_color=INK, line_width=2.2, line_dash="solid"
        )

    def clear(self) -> None:
        """Show no motion."""
        self.lines.data = dict(_NO_LINES)
        self.clear_orbit()

    def show(self, view: View, piece: Piece) -> None:
        """Show a motion."""
        x, y = view.portrait
        self.lines.data = _columns(_lines(piece["portrait"], piece["colours"], width=1.6))
        for axis_range, name in ((self.plot.x_range, x), (self.plot.y_range, y)):
            values = piece["values"][name]
            fit(axis_range, float(np.nanmin(values)), float(np.nanmax(values)))
        self.plot.xaxis.axis_label = axis_text(x, piece["labels"][x], _MOST_ACROSS)
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


def _with_unit(labels: dict[str, tuple[str, str]], names: tuple[str, ...]) -> list[str]:
    return [axis_text(name, ("", labels[name][1])) for name in names]


def _least(values: Any) -> float:
    return float(np.nanmin(values))


def _most(values: Any) -> float:
    return float(np.nanmax(values))
