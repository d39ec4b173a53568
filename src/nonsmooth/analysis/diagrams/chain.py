"""Motions at several values of a parameter, each from a start or from the end of the last one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End
from nonsmooth.analysis.diagrams.column_starts import ColumnStarts, Start
from nonsmooth.engine.lanes import SAME
from nonsmooth.engine.status import Status
from nonsmooth.errors import ModelError
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.lane_runner import LaneRunner, Lanes
from nonsmooth.runs.strobe_times import strobes
from nonsmooth.runs.stroboscopic_map import StroboscopicMap

__all__ = ["Begun", "chain", "end_of_lanes"]


class Begun(NamedTuple):
    """A motion at its beginning; ``length`` is the time between strobes, None for the period."""

    lanes: Lanes
    begin: Instant
    length: float | None


def chain(
    chosen: StroboscopicMap,
    parameter: str,
    drifting: npt.NDArray[np.bool_],
    runner: LaneRunner,
    values: list[float],
    start: Start,
    follow: bool,
    behind: End | None = None,
) -> Iterator[Begun | None]:
    """Set the runner to each value in turn and begin a motion; None where the system refuses it.

    ``start`` gives the initial state and the mode, see `run_lane`, for a value. A motion that is to
    ``follow`` begins where whoever iterates has left the lanes of the last one; drifting states
    begin at their initial value everywhere. After a value at which the motion ended early, or that
    the system refuses, it begins anew. The first motion follows what has ended ``behind`` it.
    Without the name of a parameter none is changed.
    """
    lanes: Lanes | None = None
    columns = None
    if parameter:
        columns = ColumnStarts(chosen, parameter, values, runner.tables, start)
    for i in range(len(values)):
        try:
            if columns is None:
                runner.set_up(chosen.system.parameter_values)
                state, mode = start(chosen.system, runner.tables)
                length = chosen.length
            else:
                column = columns.column(i)
                runner.set_up(column.values)
                begun, length = column.start, column.length
                state, mode = begun(runner.tables) if callable(begun) else begun
        except ModelError:
            lanes, behind = None, None
            yield None
            continue
        begin = Instant(0, 0.0)
        behind = behind if lanes is None else end_of_lanes(lanes)
        if follow and behind is not None:
            state = np.where(drifting, state, behind.state)
            mode = SAME - behind.mode
            number, phase = strobes(runner.window, begin, length, chosen.phase, 0, 1)
            begin = Instant(int(number[0]), float(phase[0]))
        lanes = runner.start(state[None], begin, mode)
        yield Begun(lanes, begin, length)


def end_of_lanes(lanes: Lanes) -> End | None:
    """Where the motion of the first lane has ended; None where it ended early."""
    if lanes.status[0] != Status.COMPLETED:
        return None
    return End(lanes.end_state[0].copy(), int(lanes.anchors.place["mode"][0]))
