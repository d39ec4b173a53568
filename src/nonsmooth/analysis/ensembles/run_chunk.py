"""Some lanes of an ensemble: those of one parameter set together, or sets with a lane each."""

from __future__ import annotations

import threading
from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.ensembles.chunk import Chunk, EnsembleProtocol, empty_chunk
from nonsmooth.analysis.ensembles.sure_sets import run_sure_sets
from nonsmooth.engine.status import Status
from nonsmooth.errors import ModelError
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.lane_runner import LaneRunner, Lanes
from nonsmooth.runs.outputs import SampleClock, output_values
from nonsmooth.runs.sweep_runner import SweepRunner
from nonsmooth.system.system import System

__all__ = ["Runners", "run_chunk"]

Floats = npt.NDArray[np.float64]

_BEGIN = Instant(0, 0.0)
_AT_BEGIN = (np.zeros(1, np.int64), np.zeros(1))


class Runners:
    """What one thread runs lanes with; each is made when it is first needed."""

    def __init__(self, system: System, tolerance: float) -> None:
        self._system, self._tolerance = system, tolerance

    @cached_property
    def of_set(self) -> LaneRunner:
        """For many lanes with one parameter set."""
        return LaneRunner(self._system, self._tolerance)

    @cached_property
    def of_sets(self) -> SweepRunner:
        """For parameter sets with one lane each."""
        return SweepRunner(self._system, self._tolerance)


def run_chunk(
    protocol: EnsembleProtocol, first: int, last: int, runners: Runners, stop: threading.Event
) -> Chunk:
    """Run the lanes first ... last - 1."""
    chunk = empty_chunk(protocol, last - first, Status.REFUSED)
    lanes = np.arange(first, last)
    sets = protocol.members.set_numbers(lanes)
    left = np.ones(lanes.size, bool)
    if protocol.members.sets and np.unique(sets).size == lanes.size:
        left = ~run_sure_sets(protocol, lanes, runners.of_sets, stop, chunk)
    borders = [0, *(np.flatnonzero(np.diff(sets)) + 1).tolist(), lanes.size]
    for low, high in pairwise(borders):
        if left[low]:
            part = {name: values[low:high] for name, values in chunk.items()}
            _run_set(protocol, int(sets[low]), lanes[low:high], runners.of_set, stop, part)
    return chunk


def _run_set(
    protocol: EnsembleProtocol,
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
        clock = SampleClock(
            np.tile(plan.sample_number, count), np.tile(plan.sample_phase, count), runner.tables
        )
        found = output_values(system, clock, points.reshape(-1, n).T, modes.ravel())
        for k, values in enumerate(found.values()):
            part["points"][rows, :, n + k] = values.reshape(count, samples)
