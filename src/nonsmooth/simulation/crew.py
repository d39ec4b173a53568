"""Tasks spread over threads; a task that waits is taken by whoever is free.

Kernels let go of the interpreter lock, so threads run side by side. A task knows nothing of the
others and its result is told by its number: the number of threads changes no digit.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Collection
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice
from typing import Any, TypeVar

from nonsmooth.simulation.options import whole_number
from nonsmooth.simulation.progress import Progress

__all__ = ["Stopped", "check_threads", "run_tasks"]

T = TypeVar("T")
_ATTENTION = 0.05  # seconds after which an interruption is noticed
_AHEAD = 8  # tasks for each thread that are begun or have results which nobody took yet


class Stopped(Exception):
    """Raised in a task that was told to stop."""


def check_threads(threads: Any) -> int:
    """Number of threads: as given, or as many as this process may use processors."""
    if threads is not None:
        return whole_number("threads", threads)
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return os.cpu_count() or 1


def run_tasks(
    tasks: list[Callable[[Any, threading.Event], T]],
    make_worker: Callable[[], Any],
    *,
    threads: int,
    label: str,
    keep: Callable[[int, T], None],
    done: Collection[int] = (),
) -> bool:
    """Run all tasks; ``keep`` is told the number and result of each as it comes.

    The tasks whose numbers are ``done`` are left out. Every thread makes a worker of its own,
    which its tasks get with an event that is set when they should stop. Returns False where the
    user interrupted; what was kept stays.
    """
    stop = threading.Event()
    local = threading.local()

    def run(i: int) -> tuple[int, T]:
        if stop.is_set():
            raise Stopped
        if not hasattr(local, "worker"):
            local.worker = make_worker()
        return i, tasks[i](local.worker, stop)

    complete, done_so_far = True, len(done)
    remaining = iter([i for i in range(len(tasks)) if i not in done])
    waiting: set[Future[tuple[int, T]]] = set()

    def hand_out() -> None:
        """Keep every thread busy; results that nobody has taken yet need memory."""
        room = _AHEAD * threads - len(waiting)
        waiting.update(pool.submit(run, i) for i in islice(remaining, room))

    with ThreadPoolExecutor(max_workers=threads) as pool, Progress(label, len(tasks)) as progress:
        try:
            hand_out()
            while waiting:
                ended, _ = wait(waiting, timeout=_ATTENTION, return_when=FIRST_COMPLETED)
                for future in ended:
                    keep(*future.result())
                    waiting.discard(future)
                done_so_far += len(ended)
                progress.update(done_so_far)
                hand_out()
        except KeyboardInterrupt:
            complete = False
        finally:
            stop.set()
            for future in waiting:
                future.cancel()
    for future in waiting:  # what was under way came to its end, or stopped
        if not complete and not future.cancelled() and future.exception() is None:
            keep(*future.result())
    return complete
