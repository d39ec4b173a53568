"""Figures and claims computed into a folder by several processes, resumable."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Any, TypeVar

from nonsmooth import OptionError, RunError
from nonsmooth_chapter.results import ENTRIES, locked, processors, remove_drafts
from nonsmooth_chapter.worker import Item

__all__ = ["Outcome", "WorkStopped", "Worker", "Workers", "run_items"]


# Processes that compute items for this one; a crash of one costs its item and nothing else.

_ATTENTION = 0.05  # seconds after which a wish to stop is noticed


class WorkStopped(Exception):
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
                f" {self._end()}; `python -m nonsmooth_chapter.worker {self.folder}`"
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
        raise WorkStopped

    def _start(self) -> None:
        # a session of its own: Ctrl-C in the terminal goes to this process alone
        apart: dict[str, Any] = {"start_new_session": True}
        if sys.platform == "win32":
            apart = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
        paths = os.pathsep.join(path or os.getcwd() for path in sys.path)
        self.process = subprocess.Popen(
            [sys.executable, "-m", "nonsmooth_chapter.worker", str(self.folder)],
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
                raise WorkStopped
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


# Items of the chapter computed into a folder by several processes, resumable.

T = TypeVar("T")
_PATIENCE = 1.0  # seconds before a bar appears
_MOST = 8  # processes by default; each takes some 400 MB, and its verbs use threads besides


@dataclass
class Outcome:
    """What became of the items of a run.

    Parameters
    ----------
    told : dict of str to dict
        By name, in order of their end: results of `do_item`.
    complete : bool
        False where the user interrupted.

    Examples
    --------
    >>> Outcome({"fig8": {"state": "fault", "message": "no"}}).faults
    {'fig8': 'no'}
    """

    told: dict[str, dict[str, Any]] = field(default_factory=dict)
    complete: bool = True

    @property
    def faults(self) -> dict[str, str]:
        """Items that could not be computed, and why."""
        return {
            n: str(each["message"]) for n, each in self.told.items() if each["state"] == "fault"
        }

    def of(self, name: str) -> dict[str, Any] | None:
        """What is known of an item; None for a fault and for what was not reached."""
        found: dict[str, Any] | None = self.told.get(name, {}).get("told")
        return found


def run_items(
    groups: Sequence[Sequence[Item]], folder: Path, *, processes: int | None, label: str
) -> Outcome:
    """Compute items that a folder does not have yet.

    Parameters
    ----------
    groups : sequence of sequences of Item
        Items of a group are computed in turn by one process, groups side by side.
    folder : pathlib.Path
        Folder of the results; made if it is not there. One run at a time uses it.
    processes : int or None
        Number of processes; by default as many as there are processors, 8 at most.
    label : str
        What the progress bar says.

    Returns
    -------
    Outcome
        Faults are in it, none is raised; nor is an interruption by the user.

    Raises
    ------
    OptionError
        For a folder that another run uses.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run_items([], Path(folder), processes=1, label="nothing").complete
    True
    """
    count = max(1, min(_number_of(processes), len(groups)))
    (folder / ENTRIES).mkdir(parents=True, exist_ok=True)
    outcome = Outcome()
    with locked(folder / ENTRIES / "lock"):
        remove_drafts(folder)
        with Workers(folder, several=count > 1) as workers:
            outcome.complete = _run_groups(groups, workers, count, label, outcome.told)
        remove_drafts(folder)
    return outcome


def _number_of(processes: int | None) -> int:
    """Number of processes: as given, or as many as there are processors."""
    if processes is None:
        return min(_MOST, processors())
    if processes < 1:
        raise OptionError(f"processes = {processes:g} must be a whole number of at least 1")
    return processes


def _run_groups(
    groups: Sequence[Sequence[Item]],
    workers: Workers,
    count: int,
    label: str,
    told: dict[str, dict[str, Any]],
) -> bool:
    """Compute groups by some threads, one process each; False where the user interrupted."""
    stop = threading.Event()
    # An interruption may come between any two steps of this thread. Queues that are C throughout
    # are whole then, while futures may be left locked, with the threads waiting for ever.
    todo: SimpleQueue[Sequence[Item] | None] = SimpleQueue()
    results: SimpleQueue[list[dict[str, Any]] | BaseException] = SimpleQueue()

    def work() -> None:
        worker = workers.take()
        while (group := todo.get()) is not None and not stop.is_set():
            try:
                results.put(workers.do(worker, group, stop))
            except BaseException as fault:  # raised again in the thread that waits
                results.put(fault)

    threads = [threading.Thread(target=work, daemon=True) for _ in range(count)]
    for group in [*groups, *[None] * count]:
        todo.put(group)
    complete = True
    try:
        for thread in threads:
            thread.start()
        with _Bar(label, sum(map(len, groups))) as bar:
            left = len(groups)
            while left:
                try:
                    _keep(take(results), told)
                    left -= 1
                except Empty:
                    pass
                bar.update(workers.finished)
    except KeyboardInterrupt:
        complete = False
    finally:
        stop.set()
        for thread in threads:
            if thread.ident is not None:
                thread.join()
    while not results.empty():  # what was under way came to its end, or was stopped
        with suppress(WorkStopped):
            _keep(results.get(), told)
    return complete


def _keep(result: list[dict[str, Any]] | BaseException, told: dict[str, dict[str, Any]]) -> None:
    if isinstance(result, BaseException):
        raise result
    told |= {str(each["name"]): each for each in result}


def take(results: SimpleQueue[T]) -> T:
    """The next result; `Empty` where none comes in a moment."""
    return results.get(timeout=_ATTENTION)


class _Bar:
    """Progress on a terminal after a second; nothing in a pipe."""

    def __init__(self, label: str, total: int) -> None:
        self._label, self._total = label, total
        self._began = time.monotonic()
        self._bar: Any = None
        self._task: Any = None

    def __enter__(self) -> _Bar:
        return self

    def update(self, done: int) -> None:
        """Say how much is done."""
        if not sys.stderr.isatty() or time.monotonic() - self._began < _PATIENCE:
            return
        if self._bar is None:
            from rich.console import Console
            from rich.progress import Progress

            self._bar = Progress(console=Console(stderr=True), transient=True)
            self._task = self._bar.add_task(self._label, total=self._total)
            self._bar.start()
        self._bar.update(self._task, completed=done)

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()
