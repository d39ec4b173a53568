"""``python -m nonsmooth.explorer.worker``: a process that computes for a page.

It reads jobs from its standard input and writes their pieces to its standard output. A job is
cancelled as Ctrl-C cancels a verb: the library stops at the next place where it can.
"""

from __future__ import annotations

import _thread
import os
import signal
import sys
import threading
from contextlib import suppress
from queue import SimpleQueue
from typing import IO, Any

from nonsmooth.errors import NonsmoothError
from nonsmooth.explorer.messages import read_message, write_message

__all__ = ["main"]

_NICENESS = 5  # long work gives way to the motion that a slider waits for


class _Worker:
    """Main thread computes; a second one listens, so that a job can be cancelled."""

    def __init__(self, source: IO[bytes], target: IO[bytes]) -> None:
        self.source, self.target = source, target
        self.jobs: SimpleQueue[tuple[Any, ...] | None] = SimpleQueue()
        self.lock = threading.Lock()
        self.current = 0  # number of the job under way
        self.cancelled: set[int] = set()

    def listen(self) -> None:
        while (message := read_message(self.source)) is not None:
            if message[0] == "cancel":
                with self.lock:
                    self.cancelled.add(message[1])
                    if self.current == message[1]:
                        _thread.interrupt_main()
            else:
                self.jobs.put(message[1:])
        os._exit(0)  # the page is gone, whatever is under way

    def run(self) -> None:
        threading.Thread(target=self.listen, daemon=True).start()
        write_message(self.target, ("ready",))
        while True:
            try:
                job = self.jobs.get()
                if job is not None:
                    self._do(*job)
            except KeyboardInterrupt:  # it came when its job had just ended
                continue

    def _do(self, number: int, task: str, view: Any, options: dict[str, Any]) -> None:
        from nonsmooth.explorer.tasks import TASKS

        with self.lock:
            self.current = number
        last: tuple[Any, ...] = ("done", number)
        try:
            for piece in TASKS[task](view, **options):
                if number in self.cancelled:
                    break
                write_message(self.target, ("piece", number, piece))
        except KeyboardInterrupt:
            pass
        except NonsmoothError as fault:
            last = ("failed", number, str(fault))
        except Exception as fault:  # the page must hear of it, and go on
            last = ("failed", number, f"{type(fault).__name__}: {fault}")
        with self.lock:
            self.current = 0
            if number in self.cancelled:
                self.cancelled.discard(number)
                last = ("cancelled", number)
        write_message(self.target, last)


def _warm_up() -> None:
    """Load what the first motion needs, so that the first gesture does not wait for it."""
    from nonsmooth.explorer.openings import opening
    from nonsmooth.explorer.tasks import motion

    for _ in motion(opening("soft_impact")):
        pass


def main() -> None:
    """Serve jobs until the input ends."""
    source, target = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever is printed is no message
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if "--nice" in sys.argv and hasattr(os, "nice"):
        os.nice(_NICENESS)
    _warm_up()
    with suppress(BrokenPipeError):  # the page is gone
        _Worker(source, target).run()
    os._exit(0)  # the thread that listens holds the input, for which the interpreter would wait


if __name__ == "__main__":
    main()
