"""`work`: compute what is missing of a map in tiles, here or wherever an executor computes."""

from __future__ import annotations

import threading
import time
import warnings
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, as_completed
from concurrent.futures import TimeoutError as LateError
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.cluster.executors import executor_of, is_lost, lost_workers, submit
from nonsmooth.cluster.plan_map import planned_question
from nonsmooth.cluster.progress import progress_of
from nonsmooth.cluster.tile_map import tile_map
from nonsmooth.cluster.tile_store import TileStore
from nonsmooth.errors import NonsmoothError, OptionError, ResultWarning, quote
from nonsmooth.progress import Progress
from nonsmooth.runs.claims import Claims
from nonsmooth.runs.crew import Stopped, check_threads, run_tasks
from nonsmooth.runs.options import check_flag, positive_number, whole_number
from nonsmooth.runs.store import trouble
from nonsmooth.runs.sweep_runner import SweepRunner

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["work"]

_LOOK = 1.0  # seconds between two looks at tiles that others compute
_MOST_NAMED = 5  # damaged tiles in a message

_MOST_LOST = 4  # times that a cluster gives up a tile before it counts as failed

DONE, TAKEN, FAILED, LATE, LOST = "done", "taken", "failed", "late", "lost"


def work(
    store: str | Path,
    *,
    tiles: Sequence[int] | None = None,
    executor: Executor | None = None,
    client: Any = None,
    threads: int | None = None,
    max_seconds: float | None = None,
    retry: bool = False,
    patience: float = 120.0,
) -> xr.Dataset:
    """Compute what is missing of a map in tiles, beside any number of others who do so.

    It returns when every tile is done or has failed. Tiles that other workers have claimed are
    waited for, and computed here where such a worker ends or gives no sign of life.

    Parameters
    ----------
    store : str or Path
        Folder that `plan_map` has made.
    tiles : sequence of int, optional
        Numbers of the tiles to look after, from 0 on, row by row; all of them without it.
    executor : concurrent.futures.Executor, optional
        Where tiles are computed, in place of threads of this process: a pool of processes, or any
        other executor whose workers reach the folder under the same path.
    client : distributed.Client, optional
        A client of Dask, as an executor.
    threads : int, optional
        Number of threads; without it, one for each processor. The result does not depend on it.
    max_seconds : float, optional
        No tile is begun after this time. Those that are under way are finished, or, by an executor,
        left to it.
    retry : bool, optional
        Whether tiles that have failed are computed again.
    patience : float, optional
        Seconds without a sign of life from a worker of another machine after which its tile is
        computed here. Workers give one every five seconds. Network file systems show it late, so
        less than a minute serves local disks only.

    Returns
    -------
    xarray.Dataset
        How far the job is, as `progress` tells it; the attribute ``status`` is ``interrupted``
        after Ctrl-C.

    Warns
    -----
    ResultWarning
        Where tiles are damaged, as loss of power leaves them; they are computed again.

    Raises
    ------
    OptionError
        Where the folder is no such store, is of another format or version, or takes no files.
    RunError
        When the disk is full, or an executor has lost its workers. What is done is kept, and the
        same call goes on.

    See Also
    --------
    forecast : how long it will take, before you begin.
    open_map : the map.

    Notes
    -----
    A tile is written variable by variable, each of them whole or not at all, and marked as done at
    the end. A worker may be killed at any moment: it loses the tiles that it had begun. Two workers
    that compute one tile write the same digits; claims only make that rare.

    A tile whose computation raises an exception is recorded with its text as failed, and the others
    go on; `progress` shows the texts.

    Examples
    --------
    >>> import tempfile
    >>> import nonsmooth as ns
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     over = {"omega": [0.7, 0.8, 0.9], "zeta": [0.01, 0.05]}
    ...     _ = ns.cluster.plan_map(f"{folder}/map.zarr", ns.models.soft_impact(), over, tile=2)
    ...     job = ns.cluster.work(f"{folder}/map.zarr", threads=1)
    >>> print(job.attrs["message"])
    all 2 tiles are done
    """
    opened = TileStore.open(store)
    opened.check_version()
    chosen = _chosen(opened, tiles)
    place = executor_of(executor, client)
    workers = check_threads(threads)
    limit = None if max_seconds is None else positive_number("max_seconds", max_seconds)
    deadline = np.inf if limit is None else time.monotonic() + limit
    patient = positive_number("patience", patience)
    again = check_flag("retry", retry)
    with _told_of_disk(opened):
        if again:
            opened.forget_failures(chosen)
        _mend(opened, chosen, patient)
        if place is None:
            complete = _in_threads(opened, chosen, workers, patient, deadline)
        else:
            complete = _in_executor(opened, chosen, place, patient, deadline)
    found = progress_of(opened)
    return found if complete else found.assign_attrs(status="interrupted")


class TileWorker:
    """What computes tiles in one process."""

    def __init__(self, store: TileStore, claims: Claims) -> None:
        self.store, self.claims = store, claims
        self.question = planned_question(store)
        self._own = threading.local()

    def runner(self) -> SweepRunner:
        """What this thread computes with."""
        if not hasattr(self._own, "runner"):
            self._own.runner = SweepRunner(self.question.system, self.question.tolerance)
        runner: SweepRunner = self._own.runner
        return runner

    def complete(self, number: int, runner: SweepRunner, stop: threading.Event) -> str:
        """Compute a tile, unless it is done or somebody else has it; how that went."""
        store, tile = self.store, self.store.at(number)
        if store.is_done(tile):
            return DONE
        if not self.claims.take(tile.key):
            return TAKEN
        try:
            if store.is_done(tile):  # by one whose claim has just ended
                return DONE
            began = time.perf_counter()
            try:
                found = tile_map(self.question, store.levels, tile.rows, tile.columns, runner, stop)
            except Stopped:
                raise
            except Exception as fault:
                store.fail(tile, fault)
                return FAILED
            store.put(tile, found, time.perf_counter() - began)
            return DONE
        finally:
            self.claims.release(tile.key)


def _in_threads(
    store: TileStore, chosen: list[int], threads: int, patience: float, deadline: float
) -> bool:
    """Compute tiles in threads of this process; False where the user interrupted."""
    with Claims(store.job, patience) as claims:
        worker = TileWorker(store, claims)

        def task(number: int, runner: SweepRunner, stop: threading.Event) -> str:
            if time.monotonic() > deadline:
                return LATE
            return worker.complete(number, runner, stop)

        def compute(numbers: list[int], keep: Callable[[int, str], None]) -> bool:
            return run_tasks(
                [partial(task, number) for number in numbers],
                worker.runner,
                threads=threads,
                label="tiles of the map",
                keep=lambda i, outcome: keep(numbers[i], outcome),
            )

        return _until_done(store, chosen, compute)


def _in_executor(
    store: TileStore, chosen: list[int], executor: Executor, patience: float, deadline: float
) -> bool:
    """Compute tiles wherever the executor does; False where the user interrupted."""
    path, identity = str(store.folder.absolute()), store.identity
    losses: Counter[int] = Counter()

    def compute(numbers: list[int], keep: Callable[[int, str], None]) -> bool:
        if time.monotonic() > deadline:
            keep(numbers[0], LATE)
            return True
        asked = {
            submit(executor, _complete, path, identity, number, patience): number
            for number in numbers
        }
        left = None if deadline == np.inf else deadline - time.monotonic()
        try:
            with Progress("tiles of the map", len(asked)) as bar:
                for k, future in enumerate(as_completed(asked, left)):
                    number = asked[future]
                    keep(number, _outcome(store, number, future, losses))
                    bar.update(k + 1)
        except LateError:
            keep(numbers[0], LATE)
        except KeyboardInterrupt:
            return False
        finally:
            for future in asked:
                future.cancel()
        return True

    return _until_done(store, chosen, compute)


def _outcome(store: TileStore, number: int, future: Future[str], losses: Counter[int]) -> str:
    """What became of a tile in an executor.

    A cluster gives up a tile when several workers died while they had it. They may have died of
    something else; only a tile that is given up again and again has failed.
    """
    try:
        return future.result()
    except (OSError, NonsmoothError):
        raise
    except (BrokenExecutor, CancelledError) as fault:
        raise lost_workers(fault) from fault
    except Exception as fault:
        losses[number] += 1
        if is_lost(fault) and losses[number] < _MOST_LOST:
            return LOST
        store.fail(store.at(number), fault)
        return FAILED


_workers: dict[tuple[str, str, float], TileWorker] = {}
_making = threading.Lock()


def _complete(path: str, identity: str, number: int, patience: float) -> str:
    """Compute a tile in a process of an executor, which keeps what it needs for the next one."""
    with _making:
        key = (path, identity, patience)
        if key not in _workers:
            store = TileStore.open(path)
            store.check_version()
            claims = Claims(store.job, patience)
            claims.begin()
            _workers[key] = TileWorker(store, claims)
    worker = _workers[key]
    return worker.complete(number, worker.runner(), threading.Event())


def _until_done(
    store: TileStore,
    chosen: Collection[int],
    compute: Callable[[list[int], Callable[[int, str], None]], bool],
) -> bool:
    """Compute what is missing, pass by pass, until nobody has anything left to do.

    Each worker takes tiles in an order of its own, so that they seldom meet; no result depends on
    it.
    """
    order = np.random.default_rng()
    while True:
        settled = store.done() | set(store.failures())
        missing = [number for number in chosen if number not in settled]
        if not missing:
            return True
        outcomes: dict[int, str] = {}
        if not compute(order.permutation(missing).tolist(), outcomes.__setitem__):
            return False
        if LATE in outcomes.values():
            return True
        if set(outcomes.values()) == {TAKEN}:
            try:
                time.sleep(_LOOK)
            except KeyboardInterrupt:
                return False


def _chosen(store: TileStore, tiles: Sequence[int] | None) -> list[int]:
    """Numbers of the tiles to look after."""
    if tiles is None:
        return list(range(store.count))
    try:
        numbers = [whole_number("tiles", each, 0) for each in tiles]
    except TypeError:
        raise OptionError(f"tiles = {quote(tiles)}: give a list of numbers of tiles") from None
    for number in numbers:
        if number >= store.count:
            raise OptionError(
                f"tiles: there is no tile {number}; they are counted from 0 to {store.count - 1}"
            )
    return sorted(set(numbers))


def _mend(store: TileStore, chosen: list[int], patience: float) -> None:
    """Look at the tiles that are done; those that are damaged count as missing.

    They are forgotten under a claim, as nobody may write a tile while its chunks are removed.
    """
    done, damaged = store.done(), []
    suspects = [each for each in chosen if each in done and store.damaged(store.at(each))]
    if not suspects:
        return
    with Claims(store.job, patience) as claims:
        for tile in map(store.at, suspects):
            if not claims.take(tile.key):
                continue
            if what := store.damaged(tile):
                damaged.append(f"tile {store.number(tile)} ({what})")
                store.forget(tile)
            claims.release(tile.key)
    if damaged:
        more = f" and {len(damaged) - _MOST_NAMED} more" if len(damaged) > _MOST_NAMED else ""
        warnings.warn(
            f"the store {str(store.folder)!r} has damaged tiles, which are computed again:"
            f" {', '.join(damaged[:_MOST_NAMED])}{more}",
            ResultWarning,
            stacklevel=3,
        )


@contextmanager
def _told_of_disk(store: TileStore) -> Iterator[None]:
    """Say what to do where files could not be written."""
    try:
        yield
    except OSError as fault:
        raise trouble(store.folder, "a file in it", fault) from fault
