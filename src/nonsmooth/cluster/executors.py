"""Executors and clients of Dask: where workers compute, and how they are lost."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any, TypeVar

from nonsmooth.errors import OptionError, RunError, quote

__all__ = ["executor_of", "is_lost", "lost_workers", "submit"]

T = TypeVar("T")


def executor_of(executor: Any, client: Any) -> Executor | None:
    """The executor that was given, or that of a client of Dask; None without either."""
    if executor is not None and client is not None:
        raise OptionError("client: an executor is given too; give one of them")
    if client is not None:
        if not hasattr(client, "get_executor"):
            raise OptionError(f"client = {quote(client)}: give a Client of dask.distributed")
        found: Executor = client.get_executor(pure=False)  # the same call may have more to do later
        return found
    if executor is not None and not isinstance(executor, Executor):
        raise OptionError(f"executor = {quote(executor)}: give an Executor of concurrent.futures")
    return executor


def submit(place: Executor, call: Callable[..., T], *arguments: Any) -> Future[T]:
    """Ask an executor for a call; `RunError` where it takes none any more."""
    try:
        return place.submit(call, *arguments)
    except RuntimeError as fault:  # it was shut down, or its workers are lost
        raise lost_workers(fault) from fault


def is_lost(fault: BaseException) -> bool:
    """Whether a cluster says that a worker died, rather than that a call went wrong."""
    return type(fault).__module__.partition(".")[0] == "distributed"


def lost_workers(fault: BaseException) -> RunError:
    """What to say where an executor has no workers left."""
    return RunError(
        f"the executor ended before the work did ({type(fault).__name__}: {fault}). What is"
        " done is kept: give a new executor, and the same call goes on",
        status="interrupted",
    )
