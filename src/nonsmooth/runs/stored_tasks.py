"""Tasks whose results a folder keeps, shared among all processes that make the same call.

Each process goes through all tasks in the same order: it reads what is done, computes what nobody
has claimed, and comes back later to what others are computing. So all of them end with the whole
result, and where one of them is killed the others do its task.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy.typing as npt

from nonsmooth.runs.claims import Claims
from nonsmooth.runs.crew import Later, run_tasks
from nonsmooth.runs.store import Store, task_key

__all__ = ["Computed", "run_stored_tasks", "shared_tasks"]

T = TypeVar("T")


class Computed(NamedTuple):
    """Result of a task that this process has computed, and stored."""

    result: Any


def shared_tasks(
    tasks: list[Callable[[Any, threading.Event], T]],
    store: Store,
    claims: Claims,
    pack: Callable[[T], Mapping[str, npt.NDArray[Any]]],
) -> list[Callable[[Any, threading.Event], Computed | None]]:
    """The tasks, each of which gives None where its result is in the store already.

    ``pack`` makes arrays of a result.
    """

    def shared(i: int) -> Callable[[Any, threading.Event], Computed | None]:
        def run(worker: Any, stop: threading.Event) -> Computed | None:
            if store.is_done(i):
                return None
            if not claims.take(task_key(i)):
                raise Later
            try:
                if store.is_done(i):  # by one whose claim has just ended
                    return None
                result = tasks[i](worker, stop)
                store.put(i, pack(result))
                return Computed(result)
            finally:
                claims.release(task_key(i))

        return run

    return [shared(i) for i in range(len(tasks))]


def run_stored_tasks(
    tasks: list[Callable[[Any, threading.Event], T]],
    make_worker: Callable[[], Any],
    *,
    store: str | Path | None,
    protocol: Mapping[str, Any],
    pack: Callable[[T], Mapping[str, npt.NDArray[Any]]],
    unpack: Callable[[dict[str, npt.NDArray[Any]]], T],
    threads: int,
    label: str,
    keep: Callable[[int, T], None],
    after: Mapping[int, int] | None = None,
    parts: bool = False,
) -> bool:
    """Run tasks as `run_tasks` does, those that the folder ``store`` has not done already.

    ``protocol`` is all that the results depend on, see `Store.open`. ``pack`` makes arrays of a
    result, and ``unpack`` the same result of them. ``keep`` is told every result, former or new,
    and where there are ``parts`` also those of tasks that were stopped: these are not stored.
    """
    keep_part: Any = keep if parts else None
    if store is None:
        return run_tasks(
            tasks, make_worker, threads=threads, label=label, keep=keep, after=after,
            keep_part=keep_part,
        )  # fmt: skip
    folder = Store.open(store, protocol, len(tasks), shared=True)
    done = frozenset(folder.done)
    for i in sorted(done):
        keep(i, unpack(folder.get(i)))

    if len(done) == len(tasks):
        return True

    def keep_both(i: int, found: Computed | None) -> None:
        keep(i, unpack(folder.get(i)) if found is None else found.result)

    with Claims(folder.folder) as claims:
        return run_tasks(
            shared_tasks(tasks, folder, claims, pack), make_worker, threads=threads, label=label,
            keep=keep_both, done=done, after=after, keep_part=keep_part,
        )  # fmt: skip
