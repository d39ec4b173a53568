"""Work aside: processes that compute in pieces, are cancelled, and are limited in time.

Processes and not threads, because a page must stay quick beside work that holds the interpreter,
and because a process that does not heed a cancellation can be ended.
"""

from __future__ import annotations

import itertools
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from nonsmooth.explorer.messages import read_message, write_message
from nonsmooth.explorer.view import View

__all__ = ["Crew", "Job"]

_PATIENCE = 2.0  # seconds that a worker has to heed a cancellation
_NUMBERS = itertools.count(1)


@dataclass(eq=False)
class Job:
    """One task for a view; ``tell`` hears ``(event, job, value)``, in another thread.

    Events are ``piece`` with a piece, ``done``, ``failed`` with a message, and ``limit`` with the
    seconds after which the job was stopped. A job that was cancelled is not heard of again.
    """

    task: str
    view: View
    tell: Callable[[str, Job, Any], None]
    seconds: float = 60.0
    options: dict[str, Any] = field(default_factory=dict)
    number: int = field(default_factory=lambda: next(_NUMBERS))
    cancelled: bool = False
    limited: bool = False


class Crew:
    """Worker processes and the jobs that wait for them.

    Parameters
    ----------
    quick : int
        Workers for motions, which a slider waits for.
    slow : int
        Workers for all else.
    """

    def __init__(self, quick: int = 1, slow: int = 2) -> None:
        self.lock = threading.RLock()
        self.closed = False
        self.benches = {
            True: _Bench(self, quick, nice=False),
            False: _Bench(self, slow, nice=True),
        }

    def start(self) -> None:
        """Start one worker of each kind; the first motion does not wait for the slow ones."""
        with self.lock:
            self.benches[True].start_one(then=self._start_slow)

    def _start_slow(self) -> None:
        with self.lock:
            if not self.closed and not self.benches[False].workers:
                self.benches[False].start_one()

    def submit(self, job: Job) -> Job:
        """Begin a job, or let it wait for the next worker."""
        with self.lock:
            if self.closed:
                job.cancelled = True
                return job
            self._bench(job).add(job)
        return job

    def cancel(self, job: Job | None) -> None:
        """Stop a job; nothing is heard of it any more."""
        if job is None:
            return
        with self.lock:
            if not job.cancelled:
                job.cancelled = True
                self._bench(job).stop(job)

    def _bench(self, job: Job) -> _Bench:
        return self.benches[job.task == "motion"]

    def close(self) -> None:
        """End all workers, and wait until they have ended."""
        with self.lock:
            self.closed = True
            ended = [worker for bench in self.benches.values() for worker in bench.close()]
        for worker in ended:
            worker.hearing.join(_PATIENCE)


class _Bench:
    """Workers of one kind, and the queue in front of them."""

    def __init__(self, crew: Crew, size: int, *, nice: bool) -> None:
        self.crew, self.size, self.nice = crew, size, nice
        self.workers: list[_Process] = []
        self.waiting: deque[Job] = deque()

    def start_one(self, then: Callable[[], None] | None = None) -> _Process:
        worker = _Process(self, then)
        self.workers.append(worker)
        return worker

    def add(self, job: Job) -> None:
        self.waiting.append(job)
        self.deal()

    def deal(self) -> None:
        """Give the jobs that wait to workers that are free."""
        while self.waiting:
            free = next((worker for worker in self.workers if worker.job is None), None)
            if free is None and len(self.workers) < self.size:
                free = self.start_one()
            if free is None:
                return
            free.begin(self.waiting.popleft())

    def stop(self, job: Job) -> None:
        if job in self.waiting:
            self.waiting.remove(job)
        for worker in self.workers:
            if worker.job is job:
                worker.interrupt()

    def gone(self, worker: _Process) -> None:
        """A worker has ended: its job has failed, the others go to a new one."""
        with self.crew.lock:
            if worker in self.workers:
                self.workers.remove(worker)
            job, worker.job = worker.job, None
            if self.crew.closed:
                return
            self.deal()
        if job is not None and not job.cancelled:
            job.tell("failed", job, "the process that computed this has ended; try again")

    def close(self) -> list[_Process]:
        self.waiting.clear()
        for worker in self.workers:
            worker.end()
        return list(self.workers)


class _Process:
    """One worker process, and the thread that hears it; ``then`` is called when it is ready."""

    def __init__(self, bench: _Bench, then: Callable[[], None] | None = None) -> None:
        self.bench, self.then = bench, then
        self.job: Job | None = None
        self.timer: threading.Timer | None = None
        words = [sys.executable, "-m", "nonsmooth.explorer.worker"]
        self.process = subprocess.Popen(
            [*words, *(["--nice"] if bench.nice else [])],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C at the terminal is for the page alone
        )
        self.hearing = threading.Thread(target=self._hear, daemon=True)
        self.hearing.start()

    def begin(self, job: Job) -> None:
        self.job = job
        self.timer = threading.Timer(job.seconds, self._too_long, (job,))
        self.timer.daemon = True
        self.timer.start()
        self._send(("job", job.number, job.task, job.view, job.options))

    def interrupt(self) -> None:
        """Ask the worker to stop its job, and end it where it does not."""
        job = self.job
        assert job is not None
        self._send(("cancel", job.number))
        timer = threading.Timer(_PATIENCE, self._end_if_still, (job,))
        timer.daemon = True
        timer.start()

    def _end_if_still(self, job: Job) -> None:
        with self.bench.crew.lock:
            if self.job is job:
                self.end()

    def _too_long(self, job: Job) -> None:
        with self.bench.crew.lock:
            if self.job is not job or job.cancelled:
                return
            job.limited = job.cancelled = True
            self.interrupt()
        job.tell("limit", job, job.seconds)

    def _send(self, message: tuple[Any, ...]) -> None:
        assert self.process.stdin is not None
        try:
            write_message(self.process.stdin, message)
        except OSError:
            self.process.kill()  # the thread that hears it sees the end

    def _hear(self) -> None:
        assert self.process.stdout is not None
        while (message := read_message(self.process.stdout)) is not None:
            if message[0] != "ready":
                self._tell(*message)
            elif self.then is not None:
                self.then()
        self.process.wait()
        for stream in (self.process.stdin, self.process.stdout):
            assert stream is not None
            with suppress(OSError):  # of a message that did not leave
                stream.close()
        self.bench.gone(self)

    def _tell(self, event: str, number: int, value: Any = None) -> None:
        with self.bench.crew.lock:
            job = self.job
            if job is None or job.number != number:
                return
            if event != "piece":
                self.job = None
                if self.timer is not None:
                    self.timer.cancel()
                self.bench.deal()
        if not job.cancelled:
            job.tell(event, job, value)

    def end(self) -> None:
        """End the process at once."""
        if self.timer is not None:
            self.timer.cancel()
        self.process.kill()
