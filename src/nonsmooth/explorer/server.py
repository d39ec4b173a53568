"""The server of the page: on the loopback, for known origins, with all files of its own.

A page computes what its visitor asks for, and nothing that is typed is executed: equations go
through the grammar of the library. Sockets are opened for pages of this server only, which a
browser states as their origin; so another site that a visitor has open cannot reach it.
"""

from __future__ import annotations

import re
import socket
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib.resources import files
from typing import TYPE_CHECKING

from nonsmooth.errors import OptionError, RunError
from nonsmooth.explorer.jobs import Crew
from nonsmooth.explorer.links import to_link
from nonsmooth.explorer.view import View

if TYPE_CHECKING:
    from bokeh.server.server import Server

__all__ = ["ExplorerServer", "check_origins"]

_LOOPBACK = "127.0.0.1"
_EVERYWHERE = ""  # all addresses of the machine
_ORIGIN = re.compile(r"[A-Za-z0-9.-]+(:\d{1,5})?|\[[0-9A-Fa-f:.]+\](:\d{1,5})?")
_MOST_BYTES = 2_000_000  # of a message from a page
_UNUSED = 30_000  # milliseconds after which a page that was left is forgotten
_LONGEST_WAIT = 30.0  # seconds for the server to begin


def check_origins(origins: Sequence[str]) -> list[str]:
    """Origins as hosts with a port; a pattern, which would admit every page, is refused."""
    for origin in origins:
        if not _ORIGIN.fullmatch(origin):
            raise OptionError(
                f"allow_origin: {origin!r:.60} is not a host with its port, such as"
                " lecture.example.org:5006; patterns such as * would let every web page in"
            )
    return list(origins)


class ExplorerServer:
    """A page on this machine, served until it is stopped.

    Parameters
    ----------
    view : View
        What the page shows first.
    port : int
        Port; 0 for one that is free.
    allow_origin : sequence of str
        Further origins. With any, the server listens on all addresses of the machine.
    work_limit : float
        Seconds that one task may compute.
    """

    def __init__(
        self, view: View, port: int, allow_origin: Sequence[str], work_limit: float
    ) -> None:
        self.view, self.work_limit = view, work_limit
        self.origins = check_origins(allow_origin)
        self.crew = Crew()
        self.crew.start()  # while the rest is loaded
        self._thread: threading.Thread | None = None
        self._stop_loop = lambda: None
        try:
            self._server = self._make(port)
        except Exception:
            self.crew.close()
            raise

    def _make(self, port: int) -> Server:
        from bokeh.application import Application
        from bokeh.application.handlers.function import FunctionHandler
        from bokeh.document import Document
        from bokeh.server.server import Server
        from tornado.ioloop import IOLoop
        from tornado.web import StaticFileHandler

        from nonsmooth.explorer.page import build_page

        def page(document: Document) -> None:
            build_page(document, self.view, self.crew, self.work_limit)

        address = _EVERYWHERE if self.origins else _LOOPBACK
        port = port or _free_port()
        own = [f"{host}:{port}" for host in (_LOOPBACK, "localhost")]
        folder = str(files("nonsmooth.explorer").joinpath("static"))
        try:
            return Server(
                {"/": Application(FunctionHandler(page))},
                port=port,
                address=address or None,
                allow_websocket_origin=[*own, *self.origins],
                extra_patterns=[(r"/page/(.*)", StaticFileHandler, {"path": folder})],
                websocket_max_message_size=_MOST_BYTES,
                check_unused_sessions_milliseconds=_UNUSED // 2,
                unused_session_lifetime_milliseconds=_UNUSED,
                io_loop=IOLoop(),
            )
        except OSError as fault:
            raise RunError(
                f"port {port} cannot be served ({fault.strerror or fault}); name another by port=,"
                " or leave it out for one that is free"
            ) from None

    @property
    def url(self) -> str:
        """Address of the page, with the view that it opens with."""
        return f"http://{_LOOPBACK}:{self._server.port}/#{to_link(self.view)}"

    def serve(self, opened: Callable[[], object] | None = None) -> None:
        """Serve in this thread until `stop` or an interruption; tell when pages can be opened."""
        self._server.start()
        if opened is not None:
            # a browser may take its time to return
            begin = threading.Thread(target=opened, daemon=True).start
            self._server.io_loop.add_callback(begin)
        try:
            with suppress(KeyboardInterrupt):  # the way to end it
                self._server.io_loop.start()
        finally:
            self._close()

    def start(self) -> None:
        """Serve in a thread of its own."""
        ready = threading.Event()

        def run() -> None:
            import asyncio

            asyncio.set_event_loop(self._server.io_loop.asyncio_loop)
            self._server.io_loop.add_callback(ready.set)
            self.serve()

        self._thread = threading.Thread(target=run, daemon=True, name="nonsmooth explorer")
        self._thread.start()
        ready.wait(_LONGEST_WAIT)

    def stop(self) -> None:
        """End the page and its workers."""
        loop = self._server.io_loop
        loop.add_callback(loop.stop)
        if self._thread is not None:
            self._thread.join(_LONGEST_WAIT)

    def _close(self) -> None:
        self._server.stop(wait=False)
        self.crew.close()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((_LOOPBACK, 0))
        return int(probe.getsockname()[1])
