"""The bifurcation diagram: columns coarse to fine, periods in colour, branches over it."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, HoverTool, LinearColorMapper

from nonsmooth.explorer.limits import label_and_unit
from nonsmooth.explorer.panes.look import INK, axis_text, bare, fit, new_figure
from nonsmooth.explorer.tasks import Piece
from nonsmooth.explorer.view import View
from nonsmooth.plot.period_colours import LONGER, NOT_SETTLED, PERIODS

__all__ = ["PERIOD_COLOURS", "DiagramPane"]

# Names and colours in a legend, those of pictures for print, and the ink that is legible on each.
PERIOD_COLOURS = [
    *((str(n), colour, INK if n <= 3 else "#ffffff") for n, colour in PERIODS.items()),
    (f">{len(PERIODS)}", LONGER, "#ffffff"),
    ("none", NOT_SETTLED, INK),
]


class DiagramPane:
    """The pane of the diagram; a click runs at that value, a box computes it finer."""

    def __init__(self) -> None:
        self.plot = new_figure("diagram", boxes=True)
        self.source = ColumnDataSource({"x": [], "y": [], "period": []})
        palette = [NOT_SETTLED, *PERIODS.values(), LONGER]
        by_period = LinearColorMapper(palette=palette, low=-0.5, high=len(palette) - 0.5)
        self.plot.scatter(
            "x", "y", source=self.source, size=3.2, line_color=None, nonselection_fill_alpha=1.0,
            fill_color={"field": "period", "transform": by_period},
        )  # fmt: skip
        self.stable = ColumnDataSource({"x": [], "y": []})
        self.unstable = ColumnDataSource({"x": [], "y": []})
        for source, dash in ((self.stable, "solid"), (self.unstable, "dashed")):
            self.plot.line("x", "y", source=source, line_color=INK, line_width=2.0, line_dash=dash)
        self.special = ColumnDataSource({"x": [], "y": [], "kind": []})
        marks = self.plot.scatter(
            "x", "y", source=self.special, size=8, marker="diamond", fill_color="#ffffff",
            line_color=INK, line_width=1.4,
        )  # fmt: skip
        self.plot.add_tools(_hover(marks))
        self.parts: list[Piece] = []

    def clear(self) -> None:
        """Show no diagram."""
        self.parts = []
        self.source.data = {"x": [], "y": [], "period": []}
        bare(self.plot)

    def begin(self, view: View) -> None:
        """Make room for a new diagram: what was there lies in the new ranges, pale and coarse."""
        self.parts = []
        if view.between:
            fit(self.plot.x_range, *sorted(view.between), room=0.0)
        if view.height:
            fit(self.plot.y_range, *view.height, room=0.0)

    def show(self, view: View, piece: Piece) -> None:
        """Add columns; all of them where they replace coarser ones."""
        if piece["done"] == piece["count"] == len(piece["numbers"]):
            self.parts = []
        self.parts.append(piece)
        x, y, period = (
            np.concatenate([part[key] for part in self.parts])
            for key in ("parameter", "value", "period")
        )
        self.source.data = {"x": x, "y": y, "period": period.astype(float)}
        if not view.height and y.size:
            fit(self.plot.y_range, float(y.min()), float(y.max()))
        described = label_and_unit(view.system.describe.get(view.over, ""))
        self.plot.xaxis.axis_label = axis_text(view.over, described, 70)
        self.plot.yaxis.axis_label = axis_text(view.shown, piece["label"])

    def show_branch(self, piece: Piece) -> None:
        """Draw a branch: stable parts solid, unstable ones dashed, special points as diamonds."""
        x, y, stable = piece["parameter"], piece["value"], piece["stable"]
        for source, part in ((self.stable, stable), (self.unstable, ~stable)):
            source.data = _chains(x, y, part)
        rows = [row for row in piece["special"] if row["kind"] not in ("bound", "closed")]
        self.special.data = {
            "x": [row["value"] for row in rows],
            "y": [row["height"] for row in rows],
            "kind": [row["kind"].replace("_", " ") for row in rows],
        }

    def clear_branch(self) -> None:
        """Draw none."""
        for source in (self.stable, self.unstable):
            source.data = {"x": [], "y": []}
        self.special.data = {"x": [], "y": [], "kind": []}


def _hover(marks: Any) -> Any:
    return HoverTool(renderers=[marks], tooltips="@kind at @x{0.000000}")


def _chains(x: np.ndarray, y: np.ndarray, part: np.ndarray) -> dict[str, np.ndarray]:
    """Ways between neighbours of one kind, with gaps; a change belongs to the part before it."""
    ways = part[:-1]
    shown = np.append(ways, False) | np.append(False, ways)
    hidden_way = np.append(~ways, True)
    x, y = np.where(shown, x, np.nan), np.where(shown, y, np.nan)
    gaps = np.flatnonzero(hidden_way & shown) + 1
    return {"x": np.insert(x, gaps, np.nan), "y": np.insert(y, gaps, np.nan)}
