"""A diagram as tasks: chains of columns for one initial state each."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import numpy.typing as npt

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

__all__ = ["chains", "diagram_tasks", "make_worker"]

_TOGETHER = 16  # columns in a task: a few milliseconds of work


def diagram_tasks(
    protocol: Protocol,
    grid: npt.NDArray[np.float64],
    given: list[Any],
    mode: str | None,
    start: str,
) -> tuple[list[Any], list[tuple[int, list[int]]]]:
    """Tasks, and the lane and the columns that each one computes."""
    tasks, places = [], []
    for lane, each in enumerate(given):
        for links in chains(grid, start):
            tasks.append(_task(protocol, grid[links].tolist(), each, mode, start))
            places.append((lane, links))
    return tasks, places


def _task(
    protocol: Protocol, values: list[float], initial: Any, mode: str | None, start: str
) -> Any:
    """Some columns of one lane, each by itself or one after the other."""

    def begin(system: System, tables: Tables) -> tuple[npt.NDArray[np.float64], int]:
        # states that are not given are those at rest, which may depend on the parameter
        found = resolve_start(system, tables, initial, None, mode, repeated=True)
        return found.state, found.modes[0]

    chain: Any = run_section_chain if isinstance(protocol.chosen, PoincareMap) else run_strobe_chain

    def run(runner: Any, stop: threading.Event) -> list[Look]:
        return list(chain(protocol, runner, stop, values, begin, follow=start != "restart"))

    return run


def make_worker(chosen: Map, tolerance: float) -> SweepRunner | SectionRunner:
    """What one thread runs motions with."""
    if isinstance(chosen, PoincareMap):
        return chosen.runner(tolerance)
    return SweepRunner(chosen.system, tolerance)


def chains(grid: npt.NDArray[np.float64], start: str) -> list[list[int]]:
    """Columns that one task computes, in order."""
    if start == "restart":
        return [
            list(range(i, min(i + _TOGETHER, grid.size))) for i in range(0, grid.size, _TOGETHER)
        ]
    order = np.argsort(grid, kind="stable")
    return [(order if start == "follow up" else order[::-1]).tolist()]
