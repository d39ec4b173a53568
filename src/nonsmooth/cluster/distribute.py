"""`distribute`: one long call, computed by all workers of an executor or of a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Collection
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, wait
from pathlib import Path
from typing import Any

from nonsmooth.cluster.executors import executor_of, is_lost, lost_workers, submit
from nonsmooth.cluster.task_progress import is_folder_of_tasks, task_progress
from nonsmooth.errors import OptionError, quote
from nonsmooth.progress import Progress
from nonsmooth.runs.crew import check_threads
from nonsmooth.runs.options import whole_number

__all__ = ["distribute"]

_LOOK = 1.0  # seconds between two looks at how far the work is


def distribute(
    function: Callable[..., Any],
    *arguments: Any,
    executor: Executor | None = None,
    client: Any = None,
    calls: int | None = None,
    **options: Any,
) -> Any:
    """Make one long call on all workers of an executor or of a Dask cluster, which share its tasks.

    The workers make the same call with the same ``store=``, and so does this process at the end,
    when everything is done. It is the call that you would make without a cluster, with the same
    result.

    Parameters
    ----------
    function : callable
        A function of nonsmooth that has ``store=``: `nonsmooth.ensemble`,
        `nonsmooth.bifurcation_diagram`, `nonsmooth.basins_of_attraction`, `nonsmooth.regime_map`,
        `nonsmooth.waterfall`, `nonsmooth.contact_statistics`, `nonsmooth.erosion_profile`,
        `run_calls`.
    *arguments
        Its arguments by position.
    executor : concurrent.futures.Executor, optional
        A pool of processes, or any other executor whose workers reach the folder of ``store=``
        under the same path.
    client : distributed.Client, optional
        A client of Dask, in place of an executor.
    calls : int, optional
        Number of workers. Without it, all threads of the Dask cluster, or as many as this machine
        has processors.
    **options
        Its arguments by name; ``store`` must be among them. ``threads`` is 1 unless you give it.

    Returns
    -------
    xarray.Dataset or list
        What the function returns.

    Raises
    ------
    OptionError
        Without ``store=``, or without an executor or a client; and what the function raises.
    RunError
        Where all workers are lost, or the executor is shut down. What is done is kept, and the same
        call goes on.
    KeyboardInterrupt
        After Ctrl-C. Calls that workers have begun go on there.

    See Also
    --------
    progress : how far it is, from anywhere.
    work : the same for maps in tiles.

    Notes
    -----
    A worker that is killed loses the tasks that it had begun. Dask begins its call again elsewhere.
    Where Dask gives up a call, as its workers died several times, a new one begins if anything was
    done since. All workers and this process hold the whole result for a moment, when they end; that
    of `nonsmooth.ensemble` stays in its file.

    Examples
    --------
    >>> import tempfile
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> import nonsmooth as ns
    >>> with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:
    ...     diagram = ns.cluster.distribute(
    ...         ns.bifurcation_diagram,
    ...         ns.models.soft_impact(zeta=0.05),
    ...         "omega",
    ...         [0.6, 0.7, 0.8, 0.9],
    ...         executor=pool,
    ...         store=f"{folder}/diagram",
    ...     )
    >>> diagram["period"].values.ravel().tolist()
    [1, 1, 1, 2]
    """
    if "store" not in _parameters(function):
        raise OptionError(
            f"distribute: {getattr(function, '__name__', function)!s:.60} has no store=; call it"
            " through run_calls, which has"
        )
    if options.get("store") is None:
        raise OptionError(
            "distribute: store= is missing; give the path of a folder that all workers reach"
        )
    place = executor_of(executor, client)
    if place is None:
        raise OptionError(
            "distribute: give executor= or client=; without one, make the call itself in as many"
            " processes as you like"
        )
    count = _calls(calls, client)
    shared = {"threads": 1, **options} if "threads" in _parameters(function) else options
    _until_done(place, (function, arguments, shared), count, Path(options["store"]))
    return function(*arguments, **options)


def _calls(calls: int | None, client: Any) -> int:
    if calls is None and client is not None:
        return max(1, sum(client.nthreads().values()))
    return check_threads(None) if calls is None else whole_number("calls", calls)


def _parameters(function: Any) -> Collection[str]:
    """Names of the parameters of a function."""
    import inspect

    try:
        return inspect.signature(function).parameters
    except (TypeError, ValueError):
        raise OptionError(
            f"function = {quote(function)}: give a function of nonsmooth that has store="
        ) from None


Call = tuple[Callable[..., Any], tuple[Any, ...], dict[str, Any]]


def _take_part(call: Call) -> None:
    """Make a call in a worker; who wants the result reads it from the folder."""
    function, arguments, options = call
    found = function(*arguments, **options)
    if hasattr(found, "close"):
        found.close()


def _until_done(place: Executor, call: Call, count: int, store: Path) -> None:
    """Wait until the calls have come to their end, which is when all tasks are done."""
    asked = {submit(place, _take_part, call) for _ in range(count)}
    done, complete = _done(store)[0], False
    lost: BaseException = CancelledError()
    try:
        with Progress("tasks", 100.0) as bar:
            while asked:
                ended, asked = wait(asked, _LOOK, FIRST_COMPLETED)
                now, total = _done(store)
                bar.update(100.0 * now / total)
                for each in ended:
                    fault = each.exception()
                    if fault is None:
                        complete = True
                        continue
                    if not is_lost(fault):
                        raise fault
                    lost = fault
                    if now > done and not complete:  # another attempt is worth it
                        done = now
                        asked.add(submit(place, _take_part, call))
    except (BrokenExecutor, CancelledError) as fault:
        raise lost_workers(fault) from fault
    finally:
        for each in asked:
            each.cancel()
    if not complete:
        raise lost_workers(lost)


def _done(store: Path) -> tuple[int, int]:
    """How many tasks are done, and how many are known."""
    if not is_folder_of_tasks(store):
        return 0, 1
    found = task_progress(store)
    return int(found["done"]), int(found["tasks"])
