"""The lanes of an ensemble as tasks, and where their results go."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.ensembles.chunk import (
    Chunk,
    EnsembleProtocol,
    Runners,
    empty_chunk,
    run_chunk,
)
from nonsmooth.analysis.ensembles.ensemble_dataset import (
    Frame,
    dataset_in_file,
    dataset_in_memory,
    open_whole,
)
from nonsmooth.engine.status import Status
from nonsmooth.errors import OptionError
from nonsmooth.runs.claims import Claims
from nonsmooth.runs.crew import run_tasks
from nonsmooth.runs.devices import device_for
from nonsmooth.runs.memory import free_memory, size_text
from nonsmooth.runs.store import Store
from nonsmooth.runs.stored_tasks import Computed, shared_tasks

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Work"]

_FEWEST = 64  # tasks, so that many processors have work
_MOST_LANES, _MOST_WINDOWS, _MOST_BYTES = 4096, 50_000, 4 * 2**20  # in a task
_LANES_ON_DEVICE, _BYTES_ON_DEVICE = 2**17, 2**28  # in a task of a graphics device
_MOST_MEMORY = 0.5  # part of the free memory that a result may take
_LOOK = 0.2  # seconds between two looks at a file that another process writes
_RESULT = "result"  # the file in a store, and the claim to write it


class Work:
    """Lanes in tasks whose size depends on the ensemble only, not on the number of threads."""

    def __init__(
        self, protocol: EnsembleProtocol, windows: int, tolerance: float, threads: int
    ) -> None:
        self.protocol = protocol
        self.tolerance = tolerance
        self.threads = threads
        self.count = protocol.members.count
        lane = empty_chunk(protocol, 1, Status.INTERRUPTED)
        self.lane_bytes = sum(part.nbytes for part in lane.values())
        self.size = max(1, self._most_in_task(windows))
        self.n_tasks = -(-self.count // self.size)

    def _most_in_task(self, windows: int) -> int:
        if device_for(self.protocol.system) is not None:
            return min(_LANES_ON_DEVICE, _BYTES_ON_DEVICE // self.lane_bytes, self.count)
        most = min(_MOST_LANES, _MOST_WINDOWS // windows, _MOST_BYTES // self.lane_bytes)
        return min(most, -(-self.count // _FEWEST))

    def in_memory(self, frame: Frame) -> xr.Dataset:
        """Run all lanes; refused where the result is too large."""
        size, free = self.count * self.lane_bytes, free_memory()
        if size > _MOST_MEMORY * free:
            raise OptionError(
                f"the result of {self.count} runs takes {size_text(size)}, and {size_text(free)}"
                " of memory are free: give store= a folder, from which it is read when needed, or"
                " record less"
            )
        whole = empty_chunk(self.protocol, self.count, Status.INTERRUPTED)

        def keep(i: int, chunk: Chunk) -> None:
            _fill(whole, slice(*self._lanes(i)), chunk)

        complete = run_tasks(
            self._tasks(), self._runners, threads=self.threads, label="ensemble", keep=keep
        )
        return dataset_in_memory(frame, whole, complete)

    def in_store(self, frame: Frame, path: str | Path, asked: Mapping[str, Any]) -> xr.Dataset:
        """Run the lanes that a store has not yet; the result is read from a file in it."""
        if device_for(self.protocol.system) is not None:
            asked = {**asked, "device": "gpu"}  # whose tasks are others
        store = Store.open(path, asked, self.n_tasks, shared=True)
        if store.read_only and (written := open_whole(store.folder / f"{_RESULT}.nc")):
            return written

        def keep(i: int, _: Computed | None) -> None:
            store.done.add(i)

        with Claims(store.folder) as claims:
            complete = run_tasks(
                shared_tasks(self._tasks(), store, claims, pack=dict), self._runners,
                threads=self.threads, label="ensemble", keep=keep, done=frozenset(store.done),
            )  # fmt: skip
            return self._in_file(frame, store, claims, complete)

    def _in_file(self, frame: Frame, store: Store, claims: Claims, complete: bool) -> xr.Dataset:
        """The result, from a file that one of the processes writes that share the store."""
        target, waited = store.folder / f"{_RESULT}.nc", False
        while not claims.take(_RESULT):
            waited = True
            time.sleep(_LOOK)
        try:
            # one that was interrupted does not put a part in place of the whole
            if (waited or not complete) and (written := open_whole(target)):
                return written
            size = self.count * self.lane_bytes
            return dataset_in_file(frame, self._chunks(store), size, complete, target)
        finally:
            claims.release(_RESULT)

    def _runners(self) -> Runners:
        return Runners(self.protocol.system, self.tolerance)

    def _tasks(self) -> list[Callable[[Runners, threading.Event], Chunk]]:
        return [self._task(i) for i in range(self.n_tasks)]

    def _task(self, i: int) -> Callable[[Runners, threading.Event], Chunk]:
        return lambda runners, stop: run_chunk(self.protocol, *self._lanes(i), runners, stop)

    def _chunks(self, store: Store) -> Iterator[tuple[int, Chunk]]:
        """What a store holds, in the order of the lanes; those that were not run tell so.

        Many small chunks are put together: each one that is written takes a while by itself.
        """
        together = max(1, _MOST_BYTES // (self.size * self.lane_bytes))
        for begin in range(0, self.n_tasks, together):
            tasks = range(begin, min(begin + together, self.n_tasks))
            first, last = self._lanes(tasks[0])[0], self._lanes(tasks[-1])[1]
            whole = empty_chunk(self.protocol, last - first, Status.INTERRUPTED)
            for i in store.done.intersection(tasks):
                low, high = self._lanes(i)
                _fill(whole, slice(low - first, high - first), store.get(i))
            yield first, whole

    def _lanes(self, i: int) -> tuple[int, int]:
        """First lane of a task, and the first one after it."""
        return i * self.size, min((i + 1) * self.size, self.count)


def _fill(whole: Chunk, lanes: slice, chunk: Chunk) -> None:
    """Put a chunk into its place in a larger one."""
    for name, values in chunk.items():
        whole[name][lanes] = values
