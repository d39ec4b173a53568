"""Columns of a bifurcation diagram over a return map: what its points do, once settled.

They do not take the path of `settle`, which has to know the times of a record before: how long a
motion takes to its next point shows when it gets there, so each motion is searched by itself.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End
from nonsmooth.analysis.diagrams.columns import DiagramProtocol, Look, nothing, with_outputs
from nonsmooth.analysis.statistics.periodicity import scales, settled_periods, whole_periods
from nonsmooth.engine.lanes import SAME
from nonsmooth.engine.record import Rows
from nonsmooth.engine.status import Status
from nonsmooth.errors import ModelError
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.impacts import impacts_of
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.runs.section_runner import SectionLanes, SectionRunner
from nonsmooth.runs.section_search import SectionPoints
from nonsmooth.runs.start import resolve_start
from nonsmooth.runs.words import rebounds_of, word_of_modes

__all__ = ["run_section_chain"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def run_section_chain(
    runner: SectionRunner,
    stop: threading.Event,
    *,
    protocol: DiagramProtocol,
    values: list[float],
    initial: Any,
    mode: str | None,
    follow: Callable[[], End | None] | None,
) -> tuple[list[Look], End | None]:
    """Motions at several values of the parameter.

    Where motions follow each other, one goes on from just behind the last point of the other.
    """
    looks: list[Look] = []
    last = None if follow is None else follow()
    for value in values:
        try:
            chosen = protocol.chosen.with_parameters(**{protocol.parameter: value})
            assert isinstance(chosen, PoincareMap)
            runner.set_up(chosen)
        except ModelError:
            looks.append(nothing(Status.REFUSED, len(protocol.system.states), np.nan))
            last = None
            continue
        start = resolve_start(
            chosen.system, runner.engine.tables, initial, None, mode, repeated=True
        )
        state, first_mode = start.state, start.modes[0]
        begin = Instant(0, 0.0)
        if follow is not None and last is not None:
            state = np.where(protocol.drifting, state, last.state)
            first_mode = SAME - last.mode
            begin = Instant(0, last.part * runner.engine.window)
        lanes = runner.start(
            state[None], first_mode, begin, behind=follow is not None and last is not None
        )
        look, points = _look(protocol, runner, lanes, stop)
        looks.append(look)
        last = None
        if points is not None:
            part = float(points.phase[-1]) / runner.engine.window
            last = End(protocol.folded(points.states[1, -1:])[0], int(points.modes[1, -1]), part)
    return looks, last


def _look(
    protocol: DiagramProtocol, runner: SectionRunner, lanes: SectionLanes, stop: threading.Event
) -> tuple[Look, SectionPoints | None]:
    """Let a motion settle and record it, later again where it shows no period; its points too."""
    transient, passed = protocol.transient, 0
    look, points = _look_after(protocol, runner, lanes, transient, passed, stop)
    while look.status == Status.COMPLETED and look.period == 0:
        passed = look.transient + protocol.record + 1
        transient = protocol.next_transient(transient)
        if not transient:
            break
        # the last point of a record is passed already
        look, points = _look_after(protocol, runner, lanes, max(transient, passed), passed, stop)
    return look, points


def _look_after(
    protocol: DiagramProtocol,
    runner: SectionRunner,
    lanes: SectionLanes,
    transient: int,
    passed: int,
    stop: threading.Event,
) -> tuple[Look, SectionPoints | None]:
    """Record a motion after so many points, some of which it has passed already."""
    n, window = lanes.lanes.end_state.shape[1], runner.engine.window
    if transient > passed:
        runner.take(lanes, 0, transient - passed, stop)
    points, rows, _ = runner.take(lanes, 0, protocol.record + 1, stop)
    status = Status(int(lanes.status[0]))
    if status != Status.COMPLETED:
        return nothing(status, n, np.nan), None
    side = 0 if runner.chosen.side == "before" else 1
    states, modes = protocol.folded(points.states[side]), points.modes[side]
    since = (points.number - points.number[0]) * window + (points.phase - points.phase[0])
    period = _period(protocol, states, since, lanes.ways[0].still.size)
    count = whole_periods(protocol.record, period)
    first = -1 - count
    events = rows[points.row[first] + 1 : points.row[-1] + 1]
    events = events[runner.is_event(events)]
    # the last point closes the recorded time and belongs to the next iterate
    taken = states[:-1], points.number[:-1], points.phase[:-1], modes[:-1]
    if protocol.outputs:
        found = with_outputs(runner.chosen.system, runner.engine.tables, *taken)
        taken = found, *taken[1:]
    look = Look(
        status,
        *taken,
        period,
        _word(runner, points, rows, period) if period else "",
        len(events) / count,
        impacts_of(runner.engine.system).count(events) / count,
        (points.states[side][-1] - points.states[side][first]) / count,
        int(lanes.lanes.uncertain[0]),
        int(lanes.lanes.estimated[0]),
        float(since[-1] - since[first]) / count,
        transient,
    )
    return look, points


def _period(protocol: DiagramProtocol, states: Floats, since: Floats, size: Floats) -> int:
    """Primitive period of points, the times between which repeat as well.

    A state that the section fixes is compared with its size elsewhere, not with its rounding.
    """
    drifting = np.append(protocol.drifting, True)
    points = np.column_stack([states, since])
    scale = scales(points, drifting)
    scale[:-1] = np.where(protocol.drifting, scale[:-1], np.maximum(scale[:-1], size))
    return int(settled_periods(points[None], drifting, protocol.match, scale[None])[0])


def _word(runner: SectionRunner, points: SectionPoints, rows: Rows, period: int) -> str:
    """Modes of the last primitive period, in order."""
    first = int(points.row[-1 - period])
    between = slice(first + 1, int(points.row[-1]))
    passed = rows[between][runner.is_event(rows)[between]]
    modes = [int(points.modes[1, -1 - period]), *runner.origin[passed["to_mode"]]]
    return word_of_modes(runner.chosen.system, np.array(modes), rebounds_of(passed))
