"""How all panes look: fonts, grids and tools, so that they line up."""

from __future__ import annotations

from typing import Any

from bokeh.models import BoxSelectTool, BoxZoomTool, Range1d
from bokeh.plotting import figure

__all__ = ["INK", "QUIET", "axis_text", "bare", "fit", "is_zoomed", "new_figure"]

INK, QUIET, GRID = "#1f2933", "#5f6b76", "#e6eaee"
_FONT = "system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif"
_LEFT, _BOTTOM = 62, 44  # pixels for ticks and labels, alike everywhere
_MOST_UPWARD = 31  # characters beside the upward axis of a page with 720 pixels
_ROOM = 0.05  # beside the data, on each side
_ROUNDING = 1e-12  # of a value: ends that differ by less are one value


def new_figure(name: str, *, boxes: bool) -> Any:
    """Figure with the look of the page; where a box computes, it is drawn by dragging."""
    plot = figure(
        name=name,
        sizing_mode="stretch_both",
        min_width=120,
        min_height=120,
        x_range=Range1d(0.0, 1.0),
        y_range=Range1d(0.0, 1.0),
        tools=[],
        toolbar_location=None,
        min_border_left=_LEFT,
        min_border_bottom=_BOTTOM,
        min_border_top=8,
        min_border_right=14,
        outline_line_color="#c3cad1",
        background_fill_color="#ffffff",
        border_fill_color="#ffffff",
        lod_threshold=None,
    )
    drag = BoxSelectTool(persistent=False) if boxes else BoxZoomTool()
    plot.add_tools(drag)
    plot.toolbar.active_drag = drag
    for axis in plot.axis:
        axis.axis_label_text_font = axis.major_label_text_font = _FONT
        axis.axis_label_text_font_size, axis.major_label_text_font_size = "13px", "12px"
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_color, axis.major_label_text_color = INK, QUIET
        axis.axis_line_color = axis.major_tick_line_color = "#9aa5b1"
        axis.minor_tick_line_color = None
        axis.axis_label_standoff = 6
    plot.yaxis.ticker.desired_num_ticks = 5
    plot.xaxis.ticker.desired_num_ticks = 6
    plot.grid.grid_line_color = GRID
    return plot


def bare(plot: Any) -> None:
    """Take the labels from the axes of a figure that shows nothing."""
    plot.xaxis.axis_label = plot.yaxis.axis_label = ""


def axis_text(name: str, label: tuple[str, str], most: int = _MOST_UPWARD) -> str:
    """Text of an axis: symbol, meaning and unit; without the meaning where that is too long."""
    words, unit = label
    behind = f" [{unit}]" if unit not in ("", "1") else ""
    text = f"{name}: {words}{behind}"
    return f"{name}{behind}" if words in ("", name) or len(text) > most else text


def fit(axis_range: Any, low: float, high: float, *, room: float = _ROOM) -> None:
    """Let a range hold two ends, with some room beside them; a double click comes back to it."""
    size = max(abs(low), abs(high))
    reach = (high - low) * room if high - low > _ROUNDING * size else (size or 1.0) * _ROOM
    start, end = low - reach, high + reach
    axis_range.update(start=start, end=end, reset_start=start, reset_end=end)


def is_zoomed(plot: Any) -> bool:
    """Whether a visitor has drawn a box that a figure shows larger."""
    ranges = (plot.x_range, plot.y_range)
    return any((r.start, r.end) != (r.reset_start, r.reset_end) for r in ranges)
