"""Processes that compute items for this one; a crash of one costs its item and nothing else."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Any

from nonsmooth import RunError
from nonsmooth_chapter.items import Item

__all__ = ["Stopped", "Worker", "Workers"]

_ATTENTION = 0.05  # seconds after which a wish to stop is noticed


class Stopped(Exception):
    """Raised in a thread that was told to stop."""


class Worker:
    """One process and what it is asked; started anew where it came to its end.

    Parameters
    ----------
    folder : pathlib.Path
        Folder of the results.

    Examples
    --------
    >>> Worker(Path("results")).process is None
    True
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.process: subprocess.Popen[str] | None = None
        self._lines: SimpleQueue[str] = SimpleQueue()

    def do(self, item: Item, stop: threading.Event) -> dict[str, Any]:
        """Result of `do_item` in the process; a fault where that ends by itself."""
        told = self._ask({"item": list(item)}, stop)
        if told is not None:
            return told
        said = f"the process that computed it ended with code {self._end()}"
        return {"name": item.name, "kind": item.kind, "state": "fault", "message": said}

    def start(self, stop: threading.Event) -> None:
        """Start the process and wait until it answers."""
        if self._ask({"ready": True}, stop) is None:
            raise RunError(
                "a process that computes could not be started: it ended with code"
                f" {self._end()}; `python -m nonsmooth_chapter.worker_main {self.folder}`"
                " shows why"
            )

    def close(self) -> None:
        """End the process, whatever it is at."""
        if self.process is not None:
            self.process.kill()
            self._end()

    def _end(self) -> int:
        assert self.process is not None
        code = self.process.wait()
        for stream in (self.process.stdin, self.process.stdout):
            if stream is not None:
                with suppress(OSError):  # what was written last found no reader
                    stream.close()
        self.process = None
        return code

    def _ask(self, question: dict[str, Any], stop: threading.Event) -> dict[str, Any] | None:
        """Answer of the process, None where it ended instead."""
        if self.process is None:
            self._start()
        assert self.process is not None and self.process.stdin is not None
        try:
            self.process.stdin.write(json.dumps(question) + "\n")
            self.process.stdin.flush()
        except OSError:
            return None
        while not stop.is_set():
            try:
                line = self._lines.get(timeout=_ATTENTION)
            except Empty:
                continue
            return json.loads(line) if line else None
        raise Stopped

    def _start(self) -> None:
        # a session of its own: Ctrl-C in the terminal goes to this process alone
        apart: dict[str, Any] = {"start_new_session": True}
        if sys.platform == "win32":
            apart = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
        paths = os.pathsep.join(path or os.getcwd() for path in sys.path)
        self.process = subprocess.Popen(
            [sys.executable, "-m", "nonsmooth_chapter.worker_main", str(self.folder)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, encoding="utf-8",
            env=os.environ | {"PYTHONPATH": paths, "MPLBACKEND": "Agg"}, **apart,
        )  # fmt: skip
        self._lines = SimpleQueue()
        threading.Thread(target=_read, args=(self.process.stdout, self._lines), daemon=True).start()


def _read(stream: Any, lines: SimpleQueue[str]) -> None:
    """Pass lines on; an empty one at the end."""
    try:
        for line in stream:
            lines.put(line)
    except (OSError, ValueError):  # closed from the other side
        pass
    lines.put("")


class Workers:
    """All processes of a run, ended together.

    Parameters
    ----------
    folder : pathlib.Path
        Folder of the results.
    several : bool
        Whether there is more than one; then the first one loads the kernels before the others
        begin, so that only one of them compiles what is not compiled yet.

    Examples
    --------
    >>> with Workers(Path("results"), several=False) as workers:
    ...     worker = workers.take()
    """

    def __init__(self, folder: Path, *, several: bool) -> None:
        self._folder = folder
        self._cold = several
        self._lock = threading.Lock()
        self._all: list[Worker] = []
        self.finished = 0  # items, as a progress bar shows them

    def take(self) -> Worker:
        """One process more, which starts with its first item."""
        worker = Worker(self._folder)
        self._all.append(worker)
        return worker

    def do(
        self, worker: Worker, items: Sequence[Item], stop: threading.Event
    ) -> list[dict[str, Any]]:
        """Results of items that one process computes in turn, as they may share what they need."""
        while not self._lock.acquire(timeout=_ATTENTION):
            if stop.is_set():
                raise Stopped
        try:
            if self._cold:
                worker.start(stop)
                self._cold = False
        finally:
            self._lock.release()
        results = []
        for item in items:
            results.append(worker.do(item, stop))
            with self._lock:
                self.finished += 1
        return results

    def __enter__(self) -> Workers:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for worker in self._all:
            worker.close()
