"""`explore`: a page in the browser, in which a system is seen to move."""

from __future__ import annotations

import sys
import threading
import webbrowser
from collections.abc import Sequence
from typing import Any

from nonsmooth.errors import OptionError, RunError, quote
from nonsmooth.explorer.openings import opening, view_of, view_of_link
from nonsmooth.explorer.view import View
from nonsmooth.system.system import System

__all__ = ["Exploration", "explore"]

_PORTS = (0, 65535)
_HEIGHT = 860  # of the page within a notebook, in pixels
_LONGEST = 3600.0  # seconds of work that a page may be given


class Exploration:
    """A page that is served, as `explore` gives it; in a notebook it is shown in its cell.

    Attributes
    ----------
    url : str
        Address of the page, with the view that it opens with.
    """

    def __init__(self, server: Any) -> None:
        self._server = server
        self.url: str = server.url

    def stop(self) -> None:
        """End the page; it does not answer any more."""
        self._server.stop()

    def _repr_html_(self) -> str:
        from html import escape

        style = f"width: 100%; height: {_HEIGHT}px; border: 0"
        return f'<iframe src="{escape(self.url)}" style="{style}" title="explorer"></iframe>'

    def __repr__(self) -> str:
        return f"<Exploration at {self.url}; stop() ends it>"


def explore(
    system: System | None = None,
    *,
    link: str = "",
    port: int = 0,
    allow_origin: Sequence[str] = (),
    work_limit: float = 60.0,
    browser: bool | None = None,
    wait: bool = False,
) -> Exploration:
    """Open a page in the browser, in which a system moves while you change it.

    The page has the equations in an editor and a slider for each parameter. It shows the machine in
    motion, the motion over time and in a phase portrait, a bifurcation diagram, and basins of
    attraction or a section. A click in one pane runs or starts the motion there in all of them.
    What you see is a link, and a script that gives the same digits.

    Parameters
    ----------
    system : System, optional
        What the page opens with; the ground mole without it.
    link : str, optional
        What the page opens with instead: a link to a view, or its part behind the ``#``.
    port : int, optional
        Port on this machine: 1 or more, up to 65535; 0 for one that is free.
    allow_origin : sequence of str, optional
        Hosts with their port, such as ``["lecture.example.org:5006"]``, whose pages may use this
        server. With any of them the server listens on all addresses of the machine, see Notes.
    work_limit : float, optional
        Seconds that one diagram, basin or branch may take before it stops with a message.
    browser : bool, optional
        Whether to open the page in the browser; without it, unless this is a notebook.
    wait : bool, optional
        Whether to serve until Ctrl-C, as the shell does; otherwise the call returns at once, and
        the page lives as long as this program.

    Returns
    -------
    Exploration
        With the ``url`` of the page and ``stop()``; in a notebook it shows the page.

    Raises
    ------
    OptionError
        For a port out of its range, an origin that is a pattern, a link that is damaged.
    RunError
        When Bokeh is missing: ``pip install "nonsmooth[explore]"``. When the port is taken.

    Notes
    -----
    The server listens on 127.0.0.1, so no other machine reaches it, and it opens sockets to its own
    pages only, so no web page that you have open elsewhere does. Nothing that is typed is executed:
    equations go through the grammar of the library, links and gestures are data that is checked.
    Everything that the page loads comes from this server.

    ``allow_origin`` is for a lecture hall. It exposes the server: everyone who reaches the machine
    under that name may open pages, and so have it compute for as long as ``work_limit`` allows,
    task after task. There is no password and no encryption, and what is typed travels in the clear.
    Nobody sees files of the machine or another visitor's page in this way. End the server after
    the lecture.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> page = ns.explore(ns.models.moling(b=0.12), browser=False)
    >>> page.url.partition("#")[2].split("&")[:2]
    ['model=moling', 'p.b=0.12']
    >>> page.stop()
    """
    view = _view(system, link)
    _check(port, work_limit)
    try:
        import bokeh  # noqa: F401 -- the import asks whether it is installed
    except ImportError:
        raise RunError(
            'explore needs Bokeh, which is not installed: pip install "nonsmooth[explore]"'
        ) from None
    from nonsmooth.explorer.server import ExplorerServer

    server = ExplorerServer(view, port, list(allow_origin), work_limit)
    page = Exploration(server)
    if browser is None:
        browser = "ipykernel" not in sys.modules
    if wait:
        server.serve(lambda: _tell(page.url, browser))
        return page
    server.start()
    if browser:
        webbrowser.open(page.url)
    return page


def _tell(url: str, browser: bool) -> None:
    print(f"the page is at {url}\nCtrl-C ends it", file=sys.stderr, flush=True)
    if browser:  # which may take its time to return
        threading.Thread(target=webbrowser.open, args=(url,), daemon=True).start()


def _view(system: System | None, link: str) -> View:
    if link:
        if system is not None:
            raise OptionError("link: it has a system of its own; give one of system and link")
        view = view_of_link(link.partition("#")[2] or link)
        view.check()
        return view
    if system is None:
        return opening()
    if not isinstance(system, System):
        raise OptionError(f"system: give a System, such as ns.models.moling(), not {quote(system)}")
    return view_of(system)


def _check(port: Any, work_limit: Any) -> None:
    whole = isinstance(port, int) and not isinstance(port, bool)
    if not whole or not _PORTS[0] <= port <= _PORTS[1]:
        raise OptionError(f"port = {quote(port)} is not a whole number from 1 to {_PORTS[1]}, or 0")
    number = isinstance(work_limit, int | float) and not isinstance(work_limit, bool)
    if not number or not 0.0 < work_limit <= _LONGEST:
        raise OptionError(
            f"work_limit = {quote(work_limit)} is not a number of seconds, above 0 and at most"
            f" {_LONGEST:g}"
        )
