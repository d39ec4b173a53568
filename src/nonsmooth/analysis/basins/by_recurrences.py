"""Basins by following the centre of every cell, and what every method does with the rest."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor
from nonsmooth.analysis.basins.attractor_search import (
    ENDED,
    FIRST_LOOK,
    INADMISSIBLE,
    NOT_COMPUTED,
    UNSETTLED,
    AttractorSearch,
    FoundAttractors,
    SearchOptions,
    SettledStarts,
    drift_mask,
    find_attractors,
    measure_of,
)
from nonsmooth.analysis.basins.folded_runner import runner_within_turns
from nonsmooth.analysis.basins.recurrences import Known, KnownCycles, confirm_visits, new_visits
from nonsmooth.analysis.basins.region import Box, Grid
from nonsmooth.analysis.options import SharedOptions
from nonsmooth.engine.attractors import Landmarks, visit
from nonsmooth.engine.status import Status
from nonsmooth.errors import OptionError
from nonsmooth.progress import Progress
from nonsmooth.runs.crew import Stopped
from nonsmooth.runs.devices import device_for
from nonsmooth.runs.stored_tasks import run_stored_tasks

__all__ = [
    "Basins", "by_recurrences", "label_grid", "label_starts", "look_closer", "search_from",
]  # fmt: skip

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_TOGETHER = 1024  # starts in a task: some hundredths of a second of work
_ON_DEVICE = 2**17  # the same on a graphics device
_BLOCK = 16  # images between two looks at who has come to an attractor
_PATIENCE = 1000  # iterates after which starts are left for a closer look

_AT_ONCE = 256  # starts that are looked at more closely together


def label_starts(
    states: Callable[[Integers], Floats],
    count: int,
    marks: Landmarks,
    cycles: KnownCycles,
    make_runner: Callable[[], Any],
    *,
    longest: int,
    threads: int,
    store: str | Path | None,
    protocol: Mapping[str, Any],
    together: int = _TOGETHER,
) -> tuple[SettledStarts, bool]:
    """Label starts 0 ... count - 1, whose states are given by number, some together in a task.

    Those that come to no known attractor are `UNSETTLED`. Returns also whether all were done.
    """
    settled = SettledStarts.of(np.full(count, NOT_COMPUTED, np.int64))
    if together == _ON_DEVICE:
        protocol = {**protocol, "device": "gpu"}  # whose tasks are others
    chunks = [np.arange(i, min(i + together, count)) for i in range(0, count, together)]

    def keep(i: int, part: SettledStarts) -> None:
        _put(settled, chunks[i], part)

    complete = run_stored_tasks(
        [_task(states, chunk, marks, cycles, min(longest, _PATIENCE)) for chunk in chunks],
        make_runner,
        store=store,
        protocol=protocol,
        pack=lambda part: dict(vars(part)),
        unpack=SettledStarts.of_arrays,
        threads=threads,
        label="basins",
        keep=keep,
    )
    return settled, complete


def _put(settled: SettledStarts, places: Integers, part: SettledStarts) -> None:
    """Put what some starts came to in its place."""
    for name, values in vars(part).items():
        getattr(settled, name)[places] = values


def _task(
    states: Callable[[Integers], Floats],
    chunk: Integers,
    marks: Landmarks,
    cycles: KnownCycles,
    longest: int,
) -> Callable[[Any, threading.Event], SettledStarts]:
    def run(runner: Any, stop: threading.Event) -> SettledStarts:
        return _label(runner, states(chunk), marks, cycles, longest, stop)

    return run


def _label(
    runner: Any,
    starts: Floats,
    marks: Landmarks,
    cycles: KnownCycles,
    longest: int,
    stop: threading.Event,
) -> SettledStarts:
    """Labels of some starts by one runner."""
    count = len(starts)
    label, needed = np.full(count, UNSETTLED, np.int64), np.full(count, longest, np.int64)
    ending = np.zeros(count, np.int64)
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
        needed[left[lost]], ending[left[lost]] = done, lanes.status[lost]
        kept = np.flatnonzero(~arrived & ~ended)
        done += images.shape[1]
        left, lanes = left[kept], lanes.select(kept)
        visits = visits.part(kept)
    return SettledStarts(label, needed, ending)


@dataclass(frozen=True)
class Basins:
    """Label of every cell, and the attractors."""

    attractors: list[Attractor]
    settled: SettledStarts
    complete: bool
    probability: Floats | None = None  # of the label, where the method tells
    notes: Mapping[str, Any] = field(default_factory=dict)  # what the method tells beside
    remark: str = ""  # that the message ends with


def look_closer(search: AttractorSearch, grid: Grid, settled: SettledStarts) -> bool:
    """Settle cells that came to no known attractor; in place. False after an interruption."""
    left = np.flatnonzero(settled.label == UNSETTLED)
    with Progress("cells that take longer", left.size) as progress:
        try:
            for i in range(0, left.size, _AT_ONCE):
                some = left[i : i + _AT_ONCE]
                _put(settled, some, search.settle(grid.states(some)))
                progress.update(i + some.size)
        except KeyboardInterrupt:
            return False
    return True


def search_from(chosen: Any, states: Floats, how: SearchOptions) -> AttractorSearch:
    """A search whose units are those of motions from states all over a grid; (K, n)."""
    if not len(states):
        raise OptionError(
            "no mode admits the centre of any cell; choose another region, or finer cells"
        )
    runner, drifting = runner_within_turns(chosen, how.tolerance), drift_mask(chosen.system)
    some = states[:: max(1, len(states) // _AT_ONCE)]
    images, _ = runner.iterate(runner.start(some), FIRST_LOOK)
    known = Known(measure_of(images, some, drifting, how.cells))
    return AttractorSearch(
        runner, known, drifting, match=how.match, longest=how.longest, record=how.record
    )


def by_recurrences(
    chosen: Any,
    grid: Grid,
    how: SearchOptions,
    shared: SharedOptions,
    protocol: dict[str, Any],
) -> Basins:
    """Follow the centre of every cell until it has come to an attractor."""
    ends = np.array([[axis[0], axis[-1]] for axis in grid.axes])
    found = find_attractors(chosen, Box(ends[:, 0], ends[:, 1], grid.completion), how)
    if not found.complete:
        nothing = np.full(grid.size, NOT_COMPUTED)
        return Basins(found.known.attractors, SettledStarts.of(nothing), False)
    return label_grid(chosen, grid, found, how, shared, protocol)


def label_grid(
    chosen: Any,
    grid: Grid,
    found: FoundAttractors,
    how: SearchOptions,
    shared: SharedOptions,
    protocol: dict[str, Any],
) -> Basins:
    """Follow the centre of every cell to the attractors that are found, or to further ones."""
    settled, complete = label_starts(
        grid.states, grid.size, found.known.landmarks(), found.known.cycles(),
        lambda: runner_within_turns(chosen, how.tolerance), longest=how.longest,
        threads=shared.workers, store=shared.store, protocol=protocol,
        together=_TOGETHER if device_for(chosen.system) is None else _ON_DEVICE,
    )  # fmt: skip
    if complete:
        complete = look_closer(found.search, grid, settled)
    resting = found.known.cycles().unconfirmed(settled.label)
    remark = (
        f"{resting} cells come to cycles that attract too slowly to be confirmed: they rest on"
        " trial starts around these"
    )
    return Basins(
        found.known.attractors, settled, complete, notes={"unconfirmed_cells": resting},
        remark=remark if resting else "",
    )  # fmt: skip
