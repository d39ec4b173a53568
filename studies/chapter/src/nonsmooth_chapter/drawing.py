"""Parts of drawings of machines: springs, dashpots, arrows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["arrow", "bare", "damper", "spring"]

_TEXT = 8


def arrow(ax: Axes, tail: Any, head: Any, colour: str, name: str, width: float = 1.2) -> None:
    """Draw an arrow, with a name at its head.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    tail, head : array_like
        Its ends.
    colour : str
        Its colour.
    name : str
        Text at its head, or none.
    width : float, optional
        Of its line, in points.

    Examples
    --------
    >>> from nonsmooth.plot import print_figure
    >>> ax = print_figure()[1][0]
    >>> arrow(ax, (0, 0), (1, 1), "black", "$F$")
    >>> ax.texts[-1].get_text()
    '$F$'
    """
    ax.annotate(
        "", tuple(head), tuple(tail),
        arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": width, "shrinkA": 0,
                    "shrinkB": 0, "mutation_scale": 8},
    )  # fmt: skip
    if name:
        ax.annotate(
            name, tuple(head), (3, 2), textcoords="offset points", color=colour, fontsize=_TEXT
        )


def spring(ax: Axes, begin: np.ndarray, end: np.ndarray) -> None:
    """Draw a spring.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    begin, end : numpy.ndarray
        Its ends.

    Examples
    --------
    >>> from nonsmooth.plot import print_figure
    >>> ax = print_figure()[1][0]
    >>> spring(ax, np.zeros(2), np.array([0.0, 1.0]))
    >>> len(ax.lines)
    1
    """
    along = np.array([0.0, 0.2, *np.linspace(0.25, 0.75, 8), 0.8, 1.0])
    across = np.array([0.0, 0.0, *(0.1 * (-1.0) ** np.arange(8)), 0.0, 0.0])
    way = end - begin
    side = np.array([-way[1], way[0]]) / np.hypot(*way)
    ax.plot(*(begin[:, None] + way[:, None] * along + side[:, None] * across), color="black",
            linewidth=0.8)  # fmt: skip


def damper(ax: Axes, begin: np.ndarray, end: np.ndarray) -> None:
    """Draw a dashpot.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    begin, end : numpy.ndarray
        Its ends.

    Examples
    --------
    >>> from nonsmooth.plot import print_figure
    >>> ax = print_figure()[1][0]
    >>> damper(ax, np.zeros(2), np.array([0.0, 1.0]))
    >>> len(ax.lines)
    6
    """
    way = end - begin
    side = 0.1 * np.array([-way[1], way[0]]) / np.hypot(*way)
    at = [begin + part * way for part in (0.35, 0.55, 0.65)]
    parts = [
        (begin, at[1]), (at[1] - 0.8 * side, at[1] + 0.8 * side), (at[2], end),
        (at[2] - side, at[2] + side), (at[0] + side, at[2] + side), (at[0] - side, at[2] - side),
    ]  # fmt: skip
    for part in parts:
        ax.plot(*np.stack(part).T, color="black", linewidth=0.8)


def bare(ax: Axes, across: tuple[float, float], up: tuple[float, float]) -> None:
    """Leave nothing of the axes but their drawing, to scale.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        The axes.
    across, up : tuple of float
        Ranges of both.

    Examples
    --------
    >>> from nonsmooth.plot import print_figure
    >>> ax = print_figure()[1][0]
    >>> bare(ax, (0, 1), (0, 2))
    >>> ax.get_ylim() == (0, 2)
    True
    """
    ax.set_xlim(*across)
    ax.set_ylim(*up)
    ax.set_aspect("equal")
    ax.set_axis_off()
