"""Colours of what grows: dark at first, pale at last, and a bar that tells which is when."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.plot.style import wrapped

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap

__all__ = ["colour_bar", "growing_colours"]

# from dark blue to ochre in even steps of lightness, alike with every kind of colour vision; the
# pale end would be lost on white
_MAP, _LAST = "cividis", 0.88


def growing_colours() -> Colormap:
    """Colours from the first to the last."""
    import matplotlib
    from matplotlib.colors import ListedColormap

    return ListedColormap(matplotlib.colormaps[_MAP](np.linspace(0.0, _LAST, 256)))


def colour_bar(ax: Axes, drawn: Any, label: str, *, inset: bool = False) -> None:
    """Bar beside the axes with texts of the same size.

    An inset one is as high as axes that have a shape of their own, such as equal scales.
    """
    figure = ax.get_figure(root=True)
    assert figure is not None
    place: dict[str, Any] = {"ax": ax, "pad": 0.02, "aspect": 25}
    if inset:
        place = {"cax": ax.inset_axes((1.03, 0.0, 0.035, 1.0))}
    bar = figure.colorbar(drawn, **place)
    size = float(ax.xaxis.label.get_fontsize())
    bar.set_label(wrapped(label), fontsize=size)
    bar.ax.tick_params(labelsize=size - 1.0, width=0.6, length=2.5)
    bar.ax.yaxis.get_offset_text().set_fontsize(size - 1.0)
    bar.outline.set_linewidth(0.6)
