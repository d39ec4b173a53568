"""Items of the chapter computed into a folder by several processes, resumable."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from nonsmooth.runs.crew import check_threads, run_tasks
from nonsmooth.runs.store_lock import lock, unlock
from nonsmooth_chapter.entries import ENTRIES, remove_drafts
from nonsmooth_chapter.items import Item
from nonsmooth_chapter.workers import Worker, Workers

__all__ = ["Outcome", "run_items"]

_MOST = 8  # processes by default; each takes some 400 MB, and its verbs use threads besides


@dataclass
class Outcome:
    """What became of the items of a run.

    Parameters
    ----------
    told : dict of str to dict
        By name, in order of their end: results of `do_item`.
    complete : bool
        False where the user interrupted.

    Examples
    --------
    >>> Outcome({"fig8": {"state": "fault", "message": "no"}}).faults
    {'fig8': 'no'}
    """

    told: dict[str, dict[str, Any]] = field(default_factory=dict)
    complete: bool = True

    @property
    def faults(self) -> dict[str, str]:
        """Items that could not be computed, and why."""
        return {
            n: str(each["message"]) for n, each in self.told.items() if each["state"] == "fault"
        }

    def of(self, name: str) -> dict[str, Any] | None:
        """What is known of an item; None for a fault and for what was not reached."""
        found: dict[str, Any] | None = self.told.get(name, {}).get("told")
        return found


def run_items(
    groups: Sequence[Sequence[Item]], folder: Path, *, processes: int | None, label: str
) -> Outcome:
    """Compute items that a folder does not have yet.

    Parameters
    ----------
    groups : sequence of sequences of Item
        Items of a group are computed in turn by one process, groups side by side.
    folder : pathlib.Path
        Folder of the results; made if it is not there. One run at a time uses it.
    processes : int or None
        Number of processes; by default as many as there are processors, 8 at most.
    label : str
        What the progress bar says.

    Returns
    -------
    Outcome
        Faults are in it, none is raised; nor is an interruption by the user.

    Raises
    ------
    OptionError
        For a folder that another run uses.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run_items([], Path(folder), processes=1, label="nothing").complete
    True
    """
    most = min(_MOST, check_threads(None)) if processes is None else check_threads(processes)
    count = max(1, min(most, len(groups)))
    (folder / ENTRIES).mkdir(parents=True, exist_ok=True)
    handle = lock(folder / ENTRIES / "lock")
    outcome = Outcome()

    def keep(_: int, told: list[dict[str, Any]]) -> None:
        outcome.told |= {str(each["name"]): each for each in told}

    try:
        remove_drafts(folder)
        with Workers(folder, several=count > 1) as workers:
            tasks: list[Callable[[Worker, threading.Event], list[dict[str, Any]]]]
            tasks = [partial(_do_group, workers, list(group)) for group in groups]
            items = sum(len(group) for group in groups)
            outcome.complete = run_tasks(
                tasks, workers.take, threads=count, label=label, keep=keep,
                measure=lambda: (workers.finished, items),
            )  # fmt: skip
        remove_drafts(folder)
    finally:
        unlock(handle)
    return outcome


def _do_group(
    workers: Workers, items: list[Item], worker: Worker, stop: threading.Event
) -> list[dict[str, Any]]:
    return workers.do(worker, items, stop)
