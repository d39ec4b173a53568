"""Columns of a bifurcation diagram: what motions do for one parameter value, once settled."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.periodicity import primitive_period, scales
from nonsmooth.engine import records as at
from nonsmooth.engine.loop import SAME
from nonsmooth.engine.status import EventKind, Status
from nonsmooth.errors import ModelError
from nonsmooth.simulation.clock import Instant
from nonsmooth.simulation.lane_runner import LaneRunner, Lanes
from nonsmooth.simulation.outputs import Clock, output_values
from nonsmooth.simulation.stroboscopic import strobes
from nonsmooth.simulation.words import word_of_modes
from nonsmooth.system.system import System

__all__ = ["Look", "Protocol", "run_chain"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Protocol:
    """How every column is computed."""

    system: System
    parameter: str
    transient: int
    record: int
    phase: float
    match: float
    exits: npt.NDArray[np.bool_] | None  # (m, e): events at which states are taken; None: strobes
    after: bool  # whether these are the states after the event
    drifting: npt.NDArray[np.bool_]  # (n,)
    outputs: bool  # whether outputs are worked out at the points


@dataclass(frozen=True)
class Look:
    """What one motion shows; K points, n states."""

    status: Status
    points: Floats  # (K, n + outputs)
    numbers: Integers  # (K,): window of each point
    phases: Floats  # (K,)
    modes: Integers  # (K,)
    period: int  # in periods of the forcing; 0 where none was found
    word: str
    impacts: float  # per period
    drift: Floats  # (n,): change of each state per period
    uncertain: int
    window: float


def run_chain(
    protocol: Protocol,
    runner: LaneRunner,
    stop: threading.Event,
    values: list[float],
    start: Floats,
    mode: int,
) -> list[Look]:
    """One motion through several values, each from where the last one ended.

    Drifting states begin at their first value everywhere. After a value at which the motion ended
    early, or that the system refuses, it begins anew.
    """
    looks: list[Look] = []
    state, how, begin = start, mode, Instant(0, 0.0)
    for value in values:
        lanes = None
        try:
            runner.set_up(protocol.system.parameter_values | {protocol.parameter: value})
        except ModelError:
            looks.append(_nothing(Status.REFUSED, start.size, np.nan))
        else:
            lanes = runner.start(state[None], begin, how)
            looks.append(_look(protocol, runner, lanes, begin, stop, value))
        state, how, begin = start, mode, Instant(0, 0.0)
        if lanes is not None and lanes.status[0] == Status.COMPLETED:
            state = np.where(protocol.drifting, start, lanes.end_state[0])
            how = SAME - int(lanes.anchors.place[0, 1])
            begin = Instant(0, protocol.phase * runner.window)
    return looks


def _look(
    protocol: Protocol,
    runner: LaneRunner,
    lanes: Lanes,
    begin: Instant,
    stop: threading.Event,
    value: float,
) -> Look:
    """Let a motion settle and record it."""
    n, window = lanes.end_state.shape[1], runner.window
    numbers, phases = strobes(
        window, begin, None, protocol.phase, protocol.transient, protocol.record + 1
    )
    if protocol.transient > 0:
        settled = Instant(int(numbers[0]), float(phases[0]))
        runner.run(lanes, settled, np.zeros(0, np.int64), np.zeros(0), stop)
    if lanes.status[0] != Status.COMPLETED:
        return _nothing(Status(int(lanes.status[0])), n, window)
    points, modes, rows, values = runner.record(lanes, 0, numbers, phases)
    status = Status(int(lanes.status[0]))
    if status != Status.COMPLETED:
        return _nothing(status, n, window)
    scale = scales(points, protocol.drifting)
    period = primitive_period(points, protocol.drifting, scale, protocol.match)
    word = ""
    if period:
        word = _word(protocol, rows, values[:, at.PHASE], numbers, phases, modes, period, window)
    kind = rows[:, at.KIND]
    impacts = np.count_nonzero((kind == EventKind.IMPACT) | (kind == EventKind.CORNER))
    drift = (points[-1] - points[0]) / protocol.record
    if protocol.exits is None:
        # the last strobe closes the recorded time and belongs to the next period
        taken = points[:-1], numbers[:-1], phases[:-1], modes[:-1]
    else:
        taken = _at_events(protocol, rows, values, n)
    if protocol.outputs:
        taken = _with_outputs(protocol, runner, value, *taken), *taken[1:]
    return Look(
        status, *taken, period, word, impacts / protocol.record, drift,
        int(lanes.uncertain[0]), window,
    )  # fmt: skip


def _at_events(
    protocol: Protocol, rows: Integers, values: Floats, n: int
) -> tuple[Floats, Integers, Floats, Integers]:
    """States, windows, phases and modes at the chosen events."""
    assert protocol.exits is not None
    chosen = (rows[:, at.EXIT] >= 0) & protocol.exits[rows[:, at.FROM], rows[:, at.EXIT]]
    first = at.EVENT_FLOATS + (n if protocol.after else 0)
    return (
        values[chosen, first : first + n],
        rows[chosen, at.NUMBER],
        values[chosen, at.PHASE],
        rows[chosen, at.TO if protocol.after else at.FROM],
    )


def _with_outputs(
    protocol: Protocol,
    runner: LaneRunner,
    value: float,
    points: Floats,
    numbers: Integers,
    phases: Floats,
    modes: Integers,
) -> Floats:
    """Points with the outputs as further columns."""
    clock = Clock(numbers, phases, runner.tables)
    system = protocol.system.with_parameters(**{protocol.parameter: value})
    found = output_values(system, clock, points.T, modes)
    return np.column_stack([points, *found.values()])


def _word(
    protocol: Protocol,
    rows: Integers,
    phase: Floats,
    numbers: Integers,
    phases: Floats,
    modes: Integers,
    period: int,
    window: float,
) -> str:
    """Modes of the last primitive period, in order."""
    since = (rows[:, at.NUMBER] - numbers[-1 - period]) * window + (phase - phases[-1 - period])
    within = (rows[:, at.KIND] != EventKind.GRAZE) & (since > 0.0)
    entered = [int(modes[-1 - period]), *rows[within, at.TO]]
    return word_of_modes(protocol.system.mode_names, np.array(entered))


def _nothing(status: Status, n: int, window: float) -> Look:
    """A motion that left nothing to look at."""
    whole = np.zeros(0, np.int64)
    return Look(
        status, np.zeros((0, n)), whole, np.zeros(0), whole, 0, "", np.nan,
        np.full(n, np.nan), 0, window,
    )  # fmt: skip
