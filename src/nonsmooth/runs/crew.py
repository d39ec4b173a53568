"""Tasks spread over threads; a task that waits is taken by whoever is free.

Kernels let go of the interpreter lock, so threads run side by side. A task knows nothing of the
others and its result is told by its number: the number of threads changes no digit.
"""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Mapping
from queue import Empty, SimpleQueue
from typing import Any, TypeVar

from nonsmooth.progress import Progress
from nonsmooth.runs.options import whole_number

__all__ = ["Later", "Stopped", "check_threads", "run_tasks"]

T = TypeVar("T")
_ATTENTION = 0.05  # seconds after which an interruption is noticed
_LATER = 1.0  # seconds after which a task that had to wait for others is begun again
_AHEAD = 8  # tasks for each thread that are begun or have results which nobody took yet


class Stopped(Exception):
    """Raised in a task that was told to stop; ``done`` is the part of its result it had by then."""

    def __init__(self, done: Any = None) -> None:
        super().__init__()
        self.done = done


class Later(Exception):
    """Raised in a task that others are doing; it is begun again after a while."""


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
    after: Mapping[int, int] | None = None,
    keep_part: Callable[[int, T], None] | None = None,
) -> bool:
    """Run all tasks; ``keep`` is told the number and result of each as it comes.

    The tasks whose numbers are ``done`` are left out. A task with a number in ``after`` begins when
    the result of the task of that number has been kept. ``keep_part`` is told what a task had when
    it was stopped, see `Stopped`. Every thread makes a worker of its own, which its tasks get with
    an event that is set when they should stop. A task that raises `Later` is begun again after a
    while. Returns False where the user interrupted; what was kept stays.
    """
    stop = threading.Event()
    # An interruption may come between any two steps of this thread. Queues that are C throughout
    # are whole then, while futures may be left locked, with the crew waiting for ever.
    todo: SimpleQueue[int | None] = SimpleQueue()
    results: SimpleQueue[tuple[int, Any, BaseException | None]] = SimpleQueue()

    def work() -> None:
        worker = None
        while (i := todo.get()) is not None:
            try:
                if stop.is_set():
                    raise Stopped
                worker = make_worker() if worker is None else worker
                results.put((i, tasks[i](worker, stop), None))
            except BaseException as fault:
                results.put((i, None, fault))

    crew = [threading.Thread(target=work, daemon=True) for _ in range(threads)]
    complete, done_so_far, under_way = True, len(done), 0
    ready, following = _in_order(len(tasks), done, after or {})
    later: list[int] = []
    again = time.monotonic()
    with Progress(label, len(tasks)) as progress:
        try:
            for thread in crew:
                thread.start()
            while True:
                # keep every thread busy; results that nobody has taken yet need memory
                while under_way < _AHEAD * threads and ready:
                    todo.put(ready.popleft())
                    under_way += 1
                if under_way == 0 and not later:
                    break
                if later and time.monotonic() > again:
                    ready.extend(later)
                    later.clear()
                try:
                    i, result, fault = take(results)
                except Empty:  # a first task may take long
                    progress.update(done_so_far)
                    continue
                under_way -= 1
                if isinstance(fault, Later):
                    again = again if later else time.monotonic() + _LATER
                    later.append(i)
                    continue
                if fault is not None:
                    raise fault
                keep(i, result)
                if i in following:
                    ready.appendleft(following[i])
                done_so_far += 1
                progress.update(done_so_far)
        except KeyboardInterrupt:
            complete = False
        finally:
            stop.set()
            for _ in crew:
                todo.put(None)
            for thread in crew:
                if thread.ident is not None:
                    thread.join()
    while not complete and not results.empty():  # what was under way came to its end, or stopped
        i, result, fault = results.get()
        if fault is None:
            keep(i, result)
        elif keep_part and isinstance(fault, Stopped) and fault.done is not None:
            keep_part(i, fault.done)
    return complete


def _in_order(
    count: int, done: Collection[int], after: Mapping[int, int]
) -> tuple[deque[int], dict[int, int]]:
    """Tasks that may begin at once, and which task follows one that is kept."""
    left = [i for i in range(count) if i not in done]
    ready = deque(i for i in left if i not in after or after[i] in done)
    return ready, {after[i]: i for i in left if i in after and after[i] not in done}


def take(results: SimpleQueue[T]) -> T:
    """The next result; `Empty` where none comes in a moment."""
    return results.get(timeout=_ATTENTION)
