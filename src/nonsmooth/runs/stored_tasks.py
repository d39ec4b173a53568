"""Tasks over threads whose results may be kept in a folder, so that the work can be resumed."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy.typing as npt

from nonsmooth.runs.crew import run_tasks
from nonsmooth.runs.store import Store

__all__ = ["run_stored_tasks"]

T = TypeVar("T")


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
    keep_part = keep if parts else None
    if store is None:
        return run_tasks(
            tasks, make_worker, threads=threads, label=label, keep=keep, after=after,
            keep_part=keep_part,
        )  # fmt: skip
    with Store.open(store, protocol, len(tasks)) as folder:
        done = frozenset(folder.done)
        for i in sorted(done):
            keep(i, unpack(folder.get(i)))

        def keep_both(i: int, result: T) -> None:
            folder.put(i, pack(result))
            keep(i, result)

        return run_tasks(
            tasks, make_worker, threads=threads, label=label, keep=keep_both, done=done,
            after=after, keep_part=keep_part,
        )  # fmt: skip
