"""Some lanes of an ensemble, run together, and what is told of them as arrays."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.ensembles.members import Members
from nonsmooth.analysis.settle import Group, ParameterSets, settle
from nonsmooth.engine.status import Status
from nonsmooth.errors import ModelError
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.lane_runner import LaneRunner
from nonsmooth.runs.outputs import SampleClock, SweptClock, output_values
from nonsmooth.runs.start import mode_numbers
from nonsmooth.runs.sweep_runner import Recorded, SweepRunner, Times
from nonsmooth.system.system import System

__all__ = ["Chunk", "EnsembleProtocol", "Runners", "empty_chunk", "run_chunk"]

Chunk = dict[str, npt.NDArray[np.generic]]  # see `empty_chunk`
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_BEGIN = Instant(0, 0.0)
_AT_BEGIN = (np.zeros(1, np.int64), np.zeros(1))


@dataclass(frozen=True)
class EnsembleProtocol:
    """How every lane is run."""

    system: System
    members: Members
    plan: Callable[[float], Plan]  # samples for a length of the window, the last one at the end
    n_points: int
    mode: str | None  # of the starts


def empty_chunk(protocol: EnsembleProtocol, count: int, status: Status) -> Chunk:
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
    if protocol.members.sets and np.unique(sets).size == lanes.size:
        _run_sets(protocol, lanes, runners.of_sets, stop, chunk)
        return chunk
    borders = [0, *(np.flatnonzero(np.diff(sets)) + 1).tolist(), lanes.size]
    for low, high in pairwise(borders):
        part = {name: values[low:high] for name, values in chunk.items()}
        _run_set(protocol, int(sets[low]), lanes[low:high], runners.of_set, stop, part)
    return chunk


def _run_sets(
    protocol: EnsembleProtocol,
    lanes: Integers,
    runner: SweepRunner,
    stop: threading.Event,
    chunk: Chunk,
) -> None:
    """Run lanes with a parameter set each into their chunk."""
    system, members = protocol.system, protocol.members
    numbers = members.set_numbers(lanes)
    sets = {name: values[numbers] for name, values in members.sets.items()}

    def write(group: Group, recorded: Recorded) -> list[None]:
        motions, windows = group.motions, recorded.windows
        rows = slice(group.numbers[0], group.numbers[-1] + 1)
        for row, start in zip(group.numbers, group.starts, strict=True):
            chunk["initial"][row] = (
                _refused_start(protocol, int(numbers[row]), lanes[row : row + 1])
                if start is None
                else start.state
            )
        ended, places = recorded.statuses != Status.COMPLETED, motions.places
        at_end = np.where(ended, places["number"], recorded.numbers[:, -1])
        phase_at_end = np.where(ended, places["phase"], recorded.phases[:, -1])
        count = recorded.numbers.shape[1]
        clock = SweptClock(
            recorded.numbers.ravel(), recorded.phases.ravel(), np.repeat(windows, count),
            {name: np.repeat(values[rows], count)
             for name, values in sets.items()},
        )  # fmt: skip
        part = {name: values[rows] for name, values in chunk.items()}
        _write_points(system, part, np.arange(group.count), recorded.states, recorded.modes, clock)
        part["status"][:], part["end"][:] = recorded.statuses, motions.end_states
        part["uncertain"][:], part["estimated"][:] = motions.uncertain, motions.estimated
        part["end_time"][:] = at_end * windows + phase_at_end
        return []

    settle(
        runner, stop, sets=ParameterSets(system, sets, members.mappings(lanes), protocol.mode),
        times=partial(_times, protocol), reduce=write, log=False,
    )  # fmt: skip


def _times(protocol: EnsembleProtocol, group: Group) -> Times:
    """Times of the samples of each motion."""
    numbers = np.zeros((group.count, protocol.n_points), np.int64)
    phases = np.zeros(numbers.shape)
    for i in np.flatnonzero(group.usable).tolist():
        plan = protocol.plan(float(group.windows[i]))
        numbers[i], phases[i] = plan.sample_number, plan.sample_phase
    return Times(numbers, phases)


def _run_set(
    protocol: EnsembleProtocol,
    number: int,
    chosen: Integers,
    runner: LaneRunner,
    stop: threading.Event,
    part: Chunk,
) -> None:
    """Run lanes of one parameter set into their part of a chunk.

    They do not take the path of `settle`, which makes tables for each motion and looks at each
    start: thousands of short lanes share their tables here, and go through the engine in one call.
    """
    members = protocol.members
    try:
        system = protocol.system.with_parameters(**members.parameters(number))
        runner.set_up(system.parameter_values)
    except ModelError:
        part["initial"][...] = _refused_start(protocol, number, chosen)
        return
    plan = protocol.plan(runner.window)
    states = members.states(chosen, system.open_state)
    part["initial"][...] = states
    waiting = np.arange(chosen.size)
    for mode in mode_numbers(system, protocol.mode):
        lanes = runner.start(states[waiting], _BEGIN, mode)
        left_out = np.isnan(states[waiting])
        if np.any(left_out):  # what the mode that is entered makes of it
            began, _ = runner.run(lanes, _BEGIN, *_AT_BEGIN, stop)
            known = part["initial"][waiting]
            part["initial"][waiting] = np.where(left_out, began[:, 0], known)
        points, modes = runner.run(lanes, plan.end, plan.sample_number, plan.sample_phase, stop)
        clock = SampleClock(
            np.tile(plan.sample_number, waiting.size), np.tile(plan.sample_phase, waiting.size),
            runner.tables,
        )  # fmt: skip
        _write_points(system, part, waiting, points, modes, clock)
        ended, places = lanes.status != Status.COMPLETED, lanes.anchors.place
        at_end = np.where(ended, places["number"], plan.end.number)
        phase_at_end = np.where(ended, places["phase"], plan.end.phase)
        part["status"][waiting], part["end"][waiting] = lanes.status, lanes.end_state
        part["uncertain"][waiting], part["estimated"][waiting] = lanes.uncertain, lanes.estimated
        part["end_time"][waiting] = at_end * runner.window + phase_at_end
        waiting = waiting[places["mode"] < 0]  # no mode took the start
        if waiting.size == 0:
            break
    at_rest = [system.rest_state[name] for name in system.states]
    initial = part["initial"]
    initial[...] = np.where(np.isnan(initial), at_rest, initial)


def _refused_start(protocol: EnsembleProtocol, number: int, chosen: Integers) -> Floats:
    """Initial states of lanes whose parameter set is refused, as far as they are known."""
    members, system = protocol.members, protocol.system
    try:
        rest = system.with_parameters(**members.parameters(number)).open_state
    except ModelError:
        rest = dict.fromkeys(system.states, np.nan)
    return members.states(chosen, rest)


def _write_points(
    system: System,
    part: Chunk,
    rows: Integers,
    states: Floats,
    modes: Integers,
    clock: SampleClock,
) -> None:
    """Write samples and their outputs into rows of a chunk."""
    count, samples, n = states.shape
    part["points"][rows, :, :n] = states
    part["modes"][rows] = modes
    outputs = output_values(system, clock, states.reshape(-1, n).T, modes.ravel())
    for k, values in enumerate(outputs.values()):
        part["points"][rows, :, n + k] = values.reshape(count, samples)
