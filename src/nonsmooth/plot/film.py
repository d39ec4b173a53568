"""A film as an animation of matplotlib: the parts that move, and how fast."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

from matplotlib.animation import FuncAnimation

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

__all__ = ["Film", "FilmPanel"]


class FilmPanel(Protocol):
    """What moves in a part of the figure."""

    artists: list[Artist]

    def show(self, frame: int) -> None:
        """Move the artists to a frame."""


class Film(FuncAnimation):
    """An animation that knows its frames, so that a file of it is quickly written."""

    def __init__(
        self, figure: Figure, panels: Sequence[FilmPanel], count: int, frames_per_second: float
    ) -> None:
        self.figure, self.count, self.frames_per_second = figure, count, frames_per_second
        self._panels = panels
        for artist in self._artists():
            artist.set_animated(True)
            artist.set_in_layout(False)  # or the axes would change their size from frame to frame
        super().__init__(
            figure, self.update, frames=count, interval=1000.0 / frames_per_second, blit=True
        )

    def _artists(self) -> list[Artist]:
        return [artist for panel in self._panels for artist in panel.artists]

    def update(self, frame: int) -> list[Artist]:
        """Move all artists to a frame, and give them, from the back to the front."""
        for panel in self._panels:
            panel.show(frame)
        return self._artists()

    def __del__(self) -> None:
        """Go without the warning of matplotlib: a film may be written, not shown."""
