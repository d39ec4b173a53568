"""How far long work with ``store=`` is, from its folder alone."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.runs.claims import CLAIMS, is_recent, workers_since
from nonsmooth.runs.store import tasks_of
from nonsmooth.version import __version__

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["STATES", "is_folder_of_tasks", "message_of", "task_progress"]

STATES = ("missing", "claimed", "done", "failed")
_MISSING, _CLAIMED, _DONE = range(3)


def is_folder_of_tasks(path: str | Path) -> bool:
    """Whether long work keeps its tasks in a folder, or in folders in it."""
    return isinstance(path, str | os.PathLike) and bool(_parts_of(Path(path)))


def task_progress(folder: Path) -> xr.Dataset:
    """How far the work in a folder is, with that in folders in it."""
    import xarray as xr

    parts = _parts_of(folder)
    states = [_states_of(part) for part in parts]
    state = np.concatenate(states)
    names = [part.relative_to(folder).as_posix() for part in parts]
    part_of_task = np.repeat(names, [each.size for each in states])
    done, claimed = (int(np.count_nonzero(state == each)) for each in (_DONE, _CLAIMED))
    rate, left = _rate(parts), state.size - done
    flags = {"flag_values": np.arange(4, dtype=np.int8), "flag_meanings": " ".join(STATES)}
    variables: dict[str, Any] = {
        "state": ("task", state, {"long_name": "state", **flags}),
        "tasks": ((), state.size, {"long_name": "tasks of the work"}),
        "done": ((), done, {"long_name": "tasks that are done"}),
        "claimed": ((), claimed, {"long_name": "tasks that are under way"}),
        "rate": ((), rate, {"long_name": "tasks per unit time", "units": "1/s"}),
        "time_left": ((), left / rate if left else 0.0, {"long_name": "time left", "units": "s"}),
    }
    part = ("task", part_of_task, {"long_name": "folder of the task in that of the work"})
    status = "incomplete" if left else "completed"
    return xr.Dataset(variables, {"part": part}, {
        "store": str(folder), "status": status,
        "message": message_of("tasks", state.size, done, claimed, 0),
        "nonsmooth_version": __version__,
    })  # fmt: skip


def message_of(what: str, count: int, done: int, claimed: int, failed: int) -> str:
    """How far it is, in words."""
    if done == count:
        return f"all {count} {what} are done" if count != 1 else f"the only {what[:-1]} is done"
    more = [f"{number} {how}" for number, how in ((claimed, "under way"), (failed, "failed"))
            if number]  # fmt: skip
    return "; ".join([f"{done} of {count} {what} are done", *more])


def _parts_of(folder: Path) -> list[Path]:
    """Folders of work: one, or one for each of several works and of their steps."""
    parts = [folder, *sorted(folder.glob("*-[0-9]*")), *sorted(folder.glob("*-[0-9]*/*-[0-9]*"))]
    return [part for part in parts if tasks_of(part) is not None]


def _states_of(folder: Path) -> np.ndarray:
    """State of each task of a store."""
    told = tasks_of(folder)
    assert told is not None  # only stores are asked
    count, done = told
    state = np.full(count, _MISSING, np.int8)
    for path in (folder / CLAIMS).glob("[0-9]*"):
        if path.name.isdecimal() and int(path.name) < count and is_recent(folder, path.name):
            state[int(path.name)] = _CLAIMED
    state[list(done)] = _DONE
    return state


def _rate(folders: list[Path]) -> float:
    """Tasks per second since the first of the workers that are alive began; nan without any.

    When a task was done is told by the clock of the file server, all else by those of the machines.
    """
    told = [tasks_of(folder) for folder in folders]
    began = min((since for folder in folders for since in workers_since(folder)), default=np.inf)
    times = [at for each in told if each is not None for at in each[1].values() if at > began]
    return len(times) / max(time.time() - began, 1e-3) if times else np.nan
