"""The server of the page: on the loopback, for known origins, with all files of its own.

A page computes what its visitor asks for, and nothing that is typed is executed: equations go
through the grammar of the library. Sockets are opened for pages of this server only, which a
browser states as their origin; so another site that a visitor has open cannot reach it.
"""

from __future__ import annotations

import logging
import os
import re
import socket
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib.resources import files
from typing import TYPE_CHECKING

from nonsmooth.errors import OptionError, RunError, quote
from nonsmooth.explorer.jobs import Crew
from nonsmooth.explorer.links import to_link
from nonsmooth.explorer.view import View

if TYPE_CHECKING:
    from bokeh.server.server import Server

__all__ = ["ExplorerServer", "check_origins"]

_LOOPBACK = "127.0.0.1"
_EVERYWHERE = ""  # all addresses of the machine
_ORIGIN = re.compile(r"([A-Za-z0-9.-]+|\[[0-9A-Fa-f:.]+\]):\d{1,5}")
_MOST_BYTES = 2_000_000  # of a message from a page
_UNUSED = 30_000  # milliseconds after which a page that was left is forgotten
_LONGEST_WAIT = 30.0  # seconds for the server to end


def check_origins(origins: Sequence[str]) -> list[str]:
    """Origins as hosts with a port; a pattern, which would admit every page, is refused."""
    for origin in origins:
        if not _ORIGIN.fullmatch(origin):
            raise OptionError(
                f"allow_origin: {quote(origin)} is not a host with its port, such as"
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
        self.address = _EVERYWHERE if self.origins else _LOOPBACK
        self.port = _usable_port(self.address, port)
        self.crew = Crew()
        self.crew.start()  # while the rest is loaded
        self._server: Server | None = None
        self._thread: threading.Thread | None = None

    @property
    def url(self) -> str:
        """Address of the page, with the view that it opens with."""
        return f"http://{_LOOPBACK}:{self.port}/#{to_link(self.view)}"

    def serve(self, ready: Callable[[], object]) -> None:
        """Serve in this thread until `stop` or an interruption; ``ready`` is called on the way."""
        try:
            # a server belongs to the loop of the thread that makes it
            server = self._server = self._made()
            server.start()
            server.io_loop.add_callback(ready)
            with suppress(KeyboardInterrupt):  # the way to end it
                server.io_loop.start()
            server.stop(wait=False)
            server.io_loop.close(all_fds=True)  # pages that are open see that it has ended
        finally:
            self.crew.close()

    def _made(self) -> Server:
        from bokeh.application import Application
        from bokeh.application.handlers.function import FunctionHandler
        from bokeh.document import Document
        from bokeh.server.server import Server
        from tornado.ioloop import IOLoop
        from tornado.web import StaticFileHandler

        from nonsmooth.explorer.page import build_page

        # pages that are closed while an answer is on its way are no fault of the server
        logging.getLogger("bokeh.server.views.ws").setLevel(logging.ERROR)

        def page(document: Document) -> None:
            build_page(document, self.view, self.crew, self.work_limit)

        folder = str(files("nonsmooth.explorer").joinpath("static"))
        return Server(
            {"/": Application(FunctionHandler(page))},
            port=self.port,
            address=self.address or None,
            allow_websocket_origin=[f"{_LOOPBACK}:{self.port}", *self.origins],
            extra_patterns=[(r"/page/(.*)", StaticFileHandler, {"path": folder})],
            websocket_max_message_size=_MOST_BYTES,
            check_unused_sessions_milliseconds=_UNUSED // 2,
            unused_session_lifetime_milliseconds=_UNUSED,
            io_loop=IOLoop(),
        )

    def start(self) -> None:
        """Serve in a thread of its own."""
        ready = threading.Event()
        thread = threading.Thread(
            target=self.serve, args=(ready.set,), daemon=True, name="nonsmooth explorer"
        )
        self._thread = thread
        thread.start()
        while not ready.wait(0.05):
            if not thread.is_alive():
                raise RunError("the page could not be served; the reason stands above")

    def stop(self) -> None:
        """End the page and its workers."""
        if self._server is not None:
            loop = self._server.io_loop
            loop.add_callback(loop.stop)
        if self._thread is not None:
            self._thread.join(_LONGEST_WAIT)


def _usable_port(address: str, port: int) -> int:
    """The port, or a free one for 0; one that is taken is an error."""
    with socket.socket() as probe:
        if os.name == "posix":  # elsewhere the option would share a port that is taken
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((address, port))
        except OSError as fault:
            raise RunError(
                f"port {port} cannot be served ({fault.strerror or fault}); name another by port=,"
                " or leave it out for one that is free"
            ) from None
        return int(probe.getsockname()[1])
