"""What a legend shows of an attractor: its points before its basin."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.plot.attractor_style import AttractorStyle

if TYPE_CHECKING:
    from matplotlib.artist import Artist

__all__ = ["attractor_entry"]


def attractor_entry(style: AttractorStyle, *, basin: bool) -> Artist:
    """Marker of an attractor, before the colour of its basin where that is shown."""
    from matplotlib.lines import Line2D

    dots = style.marker == "."
    return Line2D(
        [],
        [],
        linestyle="-" if basin else "none",
        linewidth=6.0,
        solid_capstyle="butt",
        color=style.basin,
        marker="o" if dots else style.marker,
        markersize=2.6 if dots else style.size,
        markerfacecolor=style.points,
        markeredgecolor=style.points if dots else "white",
        markeredgewidth=0.0 if dots else 0.5,
        label=style.text,
    )
