"""Some lanes of an ensemble, run one parameter set after the other."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.ensembles.members import Members
from nonsmooth.engine.status import Status
from nonsmooth.errors import ModelError
from nonsmooth.simulation.clock import Instant, Plan
from nonsmooth.simulation.labels import labels_of
from nonsmooth.simulation.lane_runner import LaneRunner, Lanes
from nonsmooth.simulation.outputs import Clock, output_values
from nonsmooth.system.system import System

__all__ = ["Chunk", "Protocol", "empty_chunk", "run_chunk"]

Floats = npt.NDArray[np.float64]
Chunk = dict[str, npt.NDArray[np.generic]]  # see `empty_chunk`

_BEGIN = Instant(0, 0.0)
_AT_BEGIN = (np.zeros(1, np.int64), np.zeros(1))


@dataclass(frozen=True)
class Protocol:
    """How every lane is run."""

    system: System
    members: Members
    plan: Callable[[float], Plan]  # end and times of samples for a length of the window
    n_points: int
    modes: tuple[int, ...]  # of the starts, the first that admits one; -1 for any


def empty_chunk(protocol: Protocol, count: int, status: Status) -> Chunk:
    """What is told of lanes that were not run.

    shapes: points (lane, point, state or output), modes (lane, point), initial and end (lane,
    state), all else (lane,)
    """
    n = len(protocol.system.states)
    shape = (count, protocol.n_points)
    return {
        "points": np.full((*shape, n + len(protocol.system.outputs)), np.nan),
        "modes": np.full(shape, -1, labels_of(protocol.system).mode_type),
        "initial": np.full((count, n), np.nan),
        "end": np.full((count, n), np.nan),
        "end_time": np.full(count, np.nan),
        "status": np.full(count, int(status), np.int8),
        "uncertain": np.zeros(count, np.int64),
        "estimated": np.zeros(count, np.int64),
    }


def run_chunk(
    protocol: Protocol, first: int, last: int, runner: LaneRunner, stop: threading.Event
) -> Chunk:
    """Run the lanes first ... last - 1."""
    chunk = empty_chunk(protocol, last - first, Status.REFUSED)
    lanes = np.arange(first, last)
    sets = protocol.members.set_numbers(lanes)
    borders = [0, *(np.flatnonzero(np.diff(sets)) + 1).tolist(), lanes.size]
    for low, high in pairwise(borders):
        part = {name: values[low:high] for name, values in chunk.items()}
        _run_set(protocol, int(sets[low]), lanes[low:high], runner, stop, part)
    return chunk


def _run_set(
    protocol: Protocol,
    number: int,
    chosen: npt.NDArray[np.int64],
    runner: LaneRunner,
    stop: threading.Event,
    part: Chunk,
) -> None:
    """Run lanes of one parameter set into their part of a chunk."""
    system, members = protocol.system, protocol.members
    rest = {name: np.nan for name in system.states}
    try:
        system = system.with_parameters(**members.parameters(number))
        rest = system.open_state
        runner.set_up(system.parameter_values)
    except ModelError:
        part["initial"][...] = members.states(chosen, rest)
        return
    plan = protocol.plan(runner.window)
    states = members.states(chosen, rest)
    part["initial"][...] = states
    waiting = np.arange(chosen.size)
    for mode in protocol.modes:
        lanes = runner.start(states[waiting], _BEGIN, mode)
        left_out = np.isnan(states[waiting])
        if np.any(left_out):  # what the mode that is entered makes of it
            began, _ = runner.run(lanes, _BEGIN, *_AT_BEGIN, stop)
            known = part["initial"][waiting]
            part["initial"][waiting] = np.where(left_out, began[:, 0], known)
        points, modes = runner.run(lanes, plan.end, plan.sample_number, plan.sample_phase, stop)
        _write(system, runner, plan, lanes, points, modes, waiting, part)
        waiting = waiting[lanes.anchors.place["mode"] < 0]  # no mode took the start
        if waiting.size == 0:
            break
    at_rest = [system.rest_state[name] for name in system.states]
    initial = part["initial"]
    initial[...] = np.where(np.isnan(initial), at_rest, initial)


def _write(
    system: System,
    runner: LaneRunner,
    plan: Plan,
    lanes: Lanes,
    points: Floats,
    modes: npt.NDArray[np.int64],
    rows: npt.NDArray[np.int64],
    part: Chunk,
) -> None:
    """Write what lanes have done into their rows of a chunk."""
    count, samples, n = points.shape
    part["points"][rows, :, :n] = points
    part["modes"][rows] = modes
    part["status"][rows] = lanes.status
    part["uncertain"][rows] = lanes.uncertain
    part["estimated"][rows] = lanes.estimated
    part["end"][rows] = lanes.end_state
    ended = lanes.status != Status.COMPLETED
    numbers = np.where(ended, lanes.anchors.place["number"], plan.end.number)
    phases = np.where(ended, lanes.anchors.place["phase"], plan.end.phase)
    part["end_time"][rows] = numbers * runner.window + phases
    if system.outputs:
        clock = Clock(
            np.tile(plan.sample_number, count), np.tile(plan.sample_phase, count), runner.tables
        )
        found = output_values(system, clock, points.reshape(-1, n).T, modes.ravel())
        for k, values in enumerate(found.values()):
            part["points"][rows, :, n + k] = values.reshape(count, samples)
