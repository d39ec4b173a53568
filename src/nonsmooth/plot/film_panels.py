"""The parts of a film: the machine, the phase portrait and the history with its cursor.

Each part draws what stands still once, and has artists that move. `show` moves them to a frame.
"""

from __future__ import annotations

from itertools import dropwhile
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.drawings import ROLES, DrawnShape, Frames
from nonsmooth.plot.histories import draw_lines, mode_label
from nonsmooth.plot.portrait import phase_portrait
from nonsmooth.plot.style import axis_label, finish_axes, mode_colours, wrapped
from nonsmooth.plot.trace import curve

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

__all__ = ["EventFlash", "HistoryPanel", "MachinePanel", "PortraitPanel"]

_TRAIL = 0.12  # of the film, behind the point of the portrait
_ALERT = "#D55E00"
_LETTERS = 7.0


class MachinePanel:
    """Shapes of a drawing; those before the first one that moves are drawn once."""

    def __init__(self, frames: Frames, ax: Axes, title: str) -> None:
        ax.set_aspect("equal", adjustable="box")
        ax.set_xlim(*frames.x_range)
        ax.set_ylim(*frames.y_range)
        ax.set_xticks([])
        ax.set_yticks([])
        ax.set_title(title, fontsize=_LETTERS + 1.0, loc="left")
        made = [
            (shape, _artist(shape, ax, order)) for order, shape in enumerate(frames.shapes, start=1)
        ]
        # a shape in front of one that moves is drawn anew with it, or it would be covered
        self._moving = list(dropwhile(lambda pair: not pair[0].moves, made))
        self.artists: list[Artist] = [artist for _, artist in self._moving]
        for shape, artist in made:
            _place(artist, shape, 0)

    def show(self, frame: int) -> None:
        """Move the shapes."""
        for shape, artist in self._moving:
            _place(artist, shape, frame)


def _artist(shape: DrawnShape, ax: Axes, order: int) -> Any:
    """Artist of matplotlib for a shape, in front of those before it."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Polygon

    role = ROLES[shape.role]
    dashes: Any = (0, (4.0, 3.0)) if role.dashed else "-"
    if shape.kind == "text":
        colour = role.edge or "black"
        return ax.text(
            0.0, 0.0, shape.text, color=colour, ha="center", va="center", fontsize=_LETTERS,
            zorder=order, clip_on=True,
        )  # fmt: skip
    if shape.kind == "line":
        colour = role.edge or role.fill or "black"
        line = Line2D([], [], color=colour, linewidth=role.width, linestyle=dashes, zorder=order)
        return ax.add_line(line)
    area = Polygon(
        np.zeros((1, 2)), facecolor=role.fill or "none", edgecolor=role.edge or "none",
        linewidth=role.width, linestyle=dashes, zorder=order, joinstyle="round",
    )  # fmt: skip
    return ax.add_patch(area)


def _place(artist: Any, shape: DrawnShape, frame: int) -> None:
    x, y, visible = shape.at(frame)
    artist.set_visible(visible)
    if not visible:
        return
    if shape.kind == "text":
        artist.set_position((x[0], y[0]))
    elif shape.kind == "line":
        artist.set_data(x, y)
    else:
        artist.set_xy(np.column_stack([x, y]))


class PortraitPanel:
    """The phase portrait of the film, the way just travelled, and where the motion is."""

    def __init__(self, run: xr.Dataset, of_frames: xr.Dataset, x: str, y: str, ax: Axes) -> None:
        several = len(set(run["mode"].attrs.get("flag_meanings", "").split())) > 1
        phase_portrait(run, x, y, ax=ax, phases=several, surfaces=True, legend=False)
        for line in ax.lines:
            line.set_alpha(0.55)
        self._time = of_frames["time"].values
        self._x, self._y = of_frames[x].values, of_frames[y].values
        self._way = curve(run, [x, y])  # with its corners at events
        self._length = _TRAIL * (self._time[-1] - self._time[0])
        (self._trail,) = ax.plot([], [], color="black", linewidth=1.1)
        (self._point,) = ax.plot([], [], "o", color="black", markersize=4.5)
        self.artists: list[Artist] = [self._trail, self._point]

    def show(self, frame: int) -> None:
        """Move the point and its trail."""
        now = self._time[frame]
        first = np.searchsorted(self._way.time, now - self._length)
        last = np.searchsorted(self._way.time, now, side="right")
        self._trail.set_data(*self._way.values[:, first:last])
        self._point.set_data(self._x[[frame]], self._y[[frame]])


class HistoryPanel:
    """A variable over the time of the film, with a cursor."""

    def __init__(self, run: xr.Dataset, of_frames: xr.Dataset, variable: str, ax: Axes) -> None:
        draw_lines(run, [variable], ax, None, {})
        finish_axes(ax, axis_label(run["time"]), "")
        # beside so low a panel there is no room for more than a word
        size = float(ax.xaxis.label.get_fontsize())
        ax.set_title(wrapped(axis_label(run[variable]), np.inf, size), loc="left", fontsize=size)
        self._time = of_frames["time"].values
        self._cursor = ax.axvline(self._time[0], color=_ALERT, linewidth=1.2)
        self.artists: list[Artist] = [self._cursor]

    def show(self, frame: int) -> None:
        """Move the cursor."""
        self._cursor.set_xdata([self._time[frame]] * 2)


class EventFlash:
    """The name of the mode, and of an event for a moment after it."""

    def __init__(self, run: xr.Dataset, ax: Axes, moment: float) -> None:
        self._time, self._moment = run["time"].values, moment
        self._modes = np.array(run["mode"].attrs.get("flag_meanings", "").split())
        self._mode = run["mode"].values
        self._colours = mode_colours(run)
        happens = run["event_kind"].values != "start"
        self._when: npt.NDArray[np.float64] = run["event_time"].values[happens]
        self._what = run["event_name"].values[happens].astype(str)
        self._name = ax.text(
            0.03, 0.955, "", transform=ax.transAxes, ha="left", va="top", fontsize=_LETTERS
        )
        self._name.set_zorder(1e4)
        self._name.set_bbox({"boxstyle": "round,pad=0.25", "edgecolor": "none", "alpha": 0.6})
        self._event = ax.text(
            0.98, 0.965, "", transform=ax.transAxes, ha="right", va="top", color=_ALERT,
            fontsize=_LETTERS + 1.0, fontweight="bold",
        )  # fmt: skip
        (self._frame,) = ax.plot(
            [0, 1, 1, 0, 0], [0, 0, 1, 1, 0], transform=ax.transAxes, color=_ALERT, linewidth=3.0,
            clip_on=False, zorder=1e4, scalex=False, scaley=False,
        )  # fmt: skip
        self._event.set_zorder(1e4)
        self.artists: list[Artist] = [self._frame, self._name, self._event]

    def show(self, frame: int) -> None:
        """Say which mode it is, and what has just happened."""
        mode = str(self._modes[self._mode[frame]])
        self._name.set_text(mode_label(mode))
        box = self._name.get_bbox_patch()
        assert box is not None
        box.set_facecolor(self._colours[mode])
        now = self._time[frame]
        last = int(np.searchsorted(self._when, now, side="right")) - 1
        recent = last >= 0 and now - self._when[last] <= self._moment
        self._event.set_visible(recent)
        self._frame.set_visible(recent)
        if recent:
            self._event.set_text(mode_label(self._what[last]))
