"""A diagram as tasks: some columns for one initial state each."""

from __future__ import annotations

import threading
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End, links_of
from nonsmooth.analysis.diagrams.columns import Look, Protocol
from nonsmooth.analysis.diagrams.section_columns import run_section_chain
from nonsmooth.analysis.diagrams.strobe_columns import run_strobe_chain
from nonsmooth.engine.tables import Tables
from nonsmooth.runs.maps import Map
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.runs.section_runner import SectionRunner
from nonsmooth.runs.start import resolve_start
from nonsmooth.runs.sweep_runner import SweepRunner
from nonsmooth.system.system import System

__all__ = ["Tasks", "diagram_tasks", "make_worker"]

Done = tuple[list[Look], End | None]


class Tasks(NamedTuple):
    """Tasks of a diagram; where columns follow each other, one begins at the end of another."""

    tasks: list[Any]
    places: list[tuple[int, list[int]]]  # lane and columns of each
    after: dict[int, int]  # the task that each one follows
    ends: dict[int, End | None]  # of tasks that are done


def diagram_tasks(
    protocol: Protocol,
    grid: npt.NDArray[np.float64],
    given: list[Any],
    mode: str | None,
    start: str,
) -> Tasks:
    """Tasks, and the lane and the columns that each one computes."""
    found = Tasks([], [], {}, {})
    for lane, each in enumerate(given):
        for k, columns in enumerate(links_of(grid, start)):
            number = len(found.tasks)
            if k and start != "restart":
                found.after[number] = number - 1
            values = grid[columns].tolist()
            found.tasks.append(_task(protocol, values, each, mode, start, found, number))
            found.places.append((lane, columns))
    return found


def _task(
    protocol: Protocol,
    values: list[float],
    initial: Any,
    mode: str | None,
    start: str,
    all_tasks: Tasks,
    number: int,
) -> Any:
    """Some columns of one lane, each by itself or one after the other."""

    def begin(system: System, tables: Tables) -> tuple[npt.NDArray[np.float64], int]:
        # states that are not given are those at rest, which may depend on the parameter
        found = resolve_start(system, tables, initial, None, mode, repeated=True)
        return found.state, found.modes[0]

    chain: Any = run_section_chain if isinstance(protocol.chosen, PoincareMap) else run_strobe_chain

    def run(runner: Any, stop: threading.Event) -> Done:
        behind = all_tasks.ends.get(all_tasks.after.get(number, -1))
        follow = start != "restart"
        return chain(protocol, runner, stop, values, begin, follow=follow, behind=behind)

    return run


def make_worker(chosen: Map, tolerance: float) -> SweepRunner | SectionRunner:
    """What one thread runs motions with."""
    if isinstance(chosen, PoincareMap):
        return chosen.runner(tolerance)
    return SweepRunner(chosen.system, tolerance)
