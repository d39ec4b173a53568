"""Labels of many starts, chunk by chunk over threads: the attractor to which each one comes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor_search import ENDED, INADMISSIBLE, UNSETTLED, Settled
from nonsmooth.analysis.basins.confirmation import Cycles, confirm_visits
from nonsmooth.analysis.basins.recurrences import new_visits
from nonsmooth.engine.attractors import Landmarks, visit
from nonsmooth.engine.status import Status
from nonsmooth.runs.crew import Stopped
from nonsmooth.runs.store import run_stored_tasks

__all__ = ["NOT_COMPUTED", "label_starts"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

NOT_COMPUTED = -3  # label of a cell that an interruption left out
_TOGETHER = 1024  # starts in a task: some hundredths of a second of work
_BLOCK = 16  # images between two looks at who has come to an attractor
_PATIENCE = 1000  # iterates after which starts are left for a closer look


def label_starts(
    states: Callable[[Integers], Floats],
    count: int,
    marks: Landmarks,
    cycles: Cycles,
    make_runner: Callable[[], Any],
    *,
    longest: int,
    threads: int,
    store: str | Path | None,
    protocol: Mapping[str, Any],
) -> tuple[Settled, bool]:
    """Label starts 0 ... count - 1, whose states are given by number.

    Those that come to no known attractor are `UNSETTLED`. Returns also whether all were done.
    """
    label = np.full(count, NOT_COMPUTED, np.int64)
    needed = np.zeros(count, np.int64)
    chunks = [np.arange(i, min(i + _TOGETHER, count)) for i in range(0, count, _TOGETHER)]

    def keep(i: int, settled: Settled) -> None:
        label[chunks[i]], needed[chunks[i]] = settled.label, settled.needed

    complete = run_stored_tasks(
        [_task(states, chunk, marks, cycles, min(longest, _PATIENCE)) for chunk in chunks],
        make_runner,
        store=store,
        protocol=protocol,
        pack=lambda settled: {"label": settled.label, "needed": settled.needed},
        unpack=lambda arrays: Settled(arrays["label"], arrays["needed"]),
        threads=threads,
        label="basins",
        keep=keep,
    )
    return Settled(label, needed), complete


def _task(
    states: Callable[[Integers], Floats],
    chunk: Integers,
    marks: Landmarks,
    cycles: Cycles,
    longest: int,
) -> Callable[[Any, threading.Event], Settled]:
    def run(runner: Any, stop: threading.Event) -> Settled:
        return _label(runner, states(chunk), marks, cycles, longest, stop)

    return run


def _label(
    runner: Any,
    starts: Floats,
    marks: Landmarks,
    cycles: Cycles,
    longest: int,
    stop: threading.Event,
) -> Settled:
    """Labels of some starts by one runner."""
    count = len(starts)
    label, needed = np.full(count, UNSETTLED, np.int64), np.full(count, longest, np.int64)
    lanes, left, visits, done = runner.start(starts), np.arange(count), new_visits(count), 0
    while left.size and done < longest:
        if stop.is_set():
            raise Stopped
        images, _ = runner.iterate(lanes, min(_BLOCK, longest - done), stop)
        visit(images, done + 1, marks, visits)
        confirm_visits(runner, lanes, images[:, -1], cycles, visits)
        arrived, ended = visits.label > 0, lanes.status != Status.COMPLETED
        label[left[arrived]] = visits.label[arrived]
        needed[left[arrived]] = visits.needed[arrived]
        lost = ended & ~arrived
        refused = (lanes.status == Status.INADMISSIBLE) & np.isnan(images[:, 0, 0])
        label[left[lost]] = np.where(refused[lost], INADMISSIBLE, ENDED)
        needed[left[lost]] = done
        kept = np.flatnonzero(~arrived & ~ended)
        done += images.shape[1]
        left, lanes = left[kept], lanes.select(kept)
        visits = visits.part(kept)
    return Settled(label, needed)
