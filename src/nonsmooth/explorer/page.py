"""The page of a visitor as a Bokeh document: figures, a wire each way, and the session between.

Figures are Bokeh's. Controls stand in ``static/page.html`` and talk to the session in messages:
the page writes JSON into the tags of one model, the session answers in those of another. Both are
models without a view, so that a message does not lay the page out anew.
"""

from __future__ import annotations

import html
import json
from collections.abc import Callable
from importlib.resources import files
from typing import Any

import bokeh
from bokeh.document import Document
from bokeh.events import DoubleTap, SelectionGeometry, Tap
from bokeh.models import ColumnDataSource
from jinja2 import Template

from nonsmooth.explorer.jobs import Crew
from nonsmooth.explorer.openings import presets
from nonsmooth.explorer.panes.diagram import PERIOD_COLOURS, DiagramPane
from nonsmooth.explorer.panes.look import is_zoomed
from nonsmooth.explorer.panes.motion import HistoryPane, PortraitPane
from nonsmooth.explorer.panes.plane import PlanePane
from nonsmooth.explorer.session import Session
from nonsmooth.explorer.tasks import Piece
from nonsmooth.explorer.view import View
from nonsmooth.version import __version__

__all__ = ["build_page"]

_DOUBLE = 500  # milliseconds in which a second click comes, as browsers take it


class _Panes:
    """The figures, and which of them a task is shown in."""

    def __init__(self) -> None:
        self.history, self.portrait = HistoryPane(), PortraitPane()
        self.diagram, self.plane = DiagramPane(), PlanePane()

    def figures(self) -> dict[str, Any]:
        panes = (self.history, self.portrait, self.diagram, self.plane)
        return {pane.plot.name: pane.plot for pane in panes}

    def clear(self, task: str) -> None:
        """Empty the figures of a task."""
        if task == "motion":
            self.history.clear()
            self.portrait.clear()
        elif task == "diagram":
            self.diagram.clear()
        elif task == "plane":
            self.plane.clear()
        elif task == "orbit":
            self.portrait.clear_orbit()
            self.diagram.clear_branch()

    def show(self, task: str, view: View, piece: Piece | None) -> None:
        if piece is None:
            if task == "orbit":
                self.clear(task)
            elif task == "diagram":
                self.diagram.begin(view)
        elif task == "motion":
            self.history.show(view, piece)
            self.portrait.show(view, piece)
        elif task == "diagram":
            self.diagram.show(view, piece)
        elif task == "plane":
            self.plane.show(view, piece)
        elif task == "orbit" and "special" in piece:
            self.diagram.show_branch(piece)
        elif task == "orbit" and piece["turn"]:
            self.portrait.show_orbit(piece)


def build_page(document: Document, view: View, crew: Crew, seconds: float) -> Session:
    """Fill a document with a page, which opens with a view."""
    panes = _Panes()
    to_page, from_page = (ColumnDataSource(name=name) for name in ("to_page", "from_page"))
    count = 0

    def send(message: dict[str, Any]) -> None:
        nonlocal count
        count += 1  # equal messages must differ, or the second would be no change
        to_page.tags = [_packed({**message, "count": count})]

    def later(function: Callable[[], None], milliseconds: int) -> None:
        def guarded() -> None:
            if document.session_context is not None:
                function()

        if milliseconds:
            document.add_timeout_callback(guarded, milliseconds)
        else:
            document.add_next_tick_callback(guarded)

    session = Session(
        view, crew, show=panes.show, clear=panes.clear, send=send, later=later, seconds=seconds
    )
    opened = False

    def hear(attr: str, old: list[str], new: list[str]) -> None:
        nonlocal opened
        if not opened:  # the page is there, and says by its link what it shows
            opened = True
            session.open()
        session.hear(new[0])

    from_page.on_change("tags", hear)
    for name, figure in panes.figures().items():
        # before the figure joins the document, which looks for them then
        if name != "history":
            _hear_taps(figure, session, later)
        figure.on_event(SelectionGeometry, _boxed(session, name))
        document.add_root(figure)
    document.add_root(to_page)
    document.add_root(from_page)
    document.title = "nonsmooth"
    # the page tells in its own words where the server has gone, and begins anew with the next one
    document.config.update(notify_connection_status=False, reconnect_session=False)
    document.template = Template(_static("page.html"))
    document.template_variables.update(_variables())
    document.on_session_destroyed(lambda context: session.close())
    return session


def _hear_taps(
    figure: Any, session: Session, later: Callable[[Callable[[], None], int], None]
) -> None:
    """A click into a figure is a gesture, and two are none.

    Two show all of a figure again that shows a box of it, so there a click waits for a second one.
    """
    waiting: dict[str, Any] | None = None

    def tell(event: Any) -> None:
        nonlocal waiting
        if event.x is None:
            return
        click = {"do": "click", "pane": figure.name, "x": event.x, "y": event.y}
        if waiting:
            forget(event)
        elif is_zoomed(figure):
            waiting = click
            later(lambda: begin(click), _DOUBLE)
        else:
            session.hear(json.dumps(click))

    def begin(click: dict[str, Any]) -> None:
        if waiting is click:
            forget(None)
            session.hear(json.dumps(click))

    def forget(event: Any) -> None:
        nonlocal waiting
        waiting = None

    figure.on_event(Tap, tell)
    figure.on_event(DoubleTap, forget)


def _boxed(session: Session, pane: str) -> Callable[[Any], None]:
    def tell(event: Any) -> None:
        box = event.geometry
        if event.final and box.get("type") == "rect":
            sides = {key: box[key] for key in ("x0", "x1", "y0", "y1")}
            session.hear(json.dumps({"do": "box", "pane": pane, **sides}))

    return tell


def _packed(message: dict[str, Any]) -> dict[str, Any]:
    """Plain values as one text of JSON, which takes a fraction of the time of Bokeh's own way."""
    plain: dict[str, str] = {}
    arrays: dict[str, Any] = {}
    for key, value in message.items():
        try:
            plain[key] = json.dumps(value, allow_nan=False)
        except (TypeError, ValueError):  # with arrays, or with numbers that JSON does not know
            arrays[key] = value
    text = ", ".join(f"{json.dumps(key)}: {value}" for key, value in plain.items())
    return {"plain": "{" + text + "}", "arrays": arrays}


def _static(name: str) -> str:
    return files("nonsmooth.explorer").joinpath("static", name).read_text(encoding="utf-8")


def _variables() -> dict[str, Any]:
    groups: dict[str, list[tuple[int, str]]] = {}
    for number, preset in enumerate(presets()):
        groups.setdefault(preset.group, []).append((number, html.escape(preset.title)))
    return {
        "presets": groups,
        "periods": PERIOD_COLOURS,
        "version": __version__,
        "bokeh_version": bokeh.__version__,
    }
