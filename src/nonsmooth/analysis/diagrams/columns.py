"""Columns of a bifurcation diagram: what motions do for one parameter value, once settled."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain import chain
from nonsmooth.analysis.diagrams.column_starts import Start
from nonsmooth.analysis.statistics.periodicity import primitive_period, scales, whole_periods
from nonsmooth.engine.record import Rows
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables
from nonsmooth.maps.of_system import Map
from nonsmooth.maps.stroboscopic import StroboscopicMap
from nonsmooth.simulation.clock import Instant
from nonsmooth.simulation.impacts import happened, impacts_of
from nonsmooth.simulation.lane_runner import LaneRunner, Lanes
from nonsmooth.simulation.outputs import Clock, SweptClock, output_values
from nonsmooth.simulation.stroboscopic import strobes
from nonsmooth.simulation.words import word_of_modes
from nonsmooth.system.system import System

__all__ = ["Look", "Protocol", "nothing", "run_chain", "with_outputs"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Protocol:
    """How every column is computed."""

    chosen: Map
    parameter: str
    transient: int
    record: int
    match: float
    exits: npt.NDArray[np.bool_] | None  # (m, e): events at which states are taken; None: strobes
    after: bool  # whether these are the states after the event
    drifting: npt.NDArray[np.bool_]  # (n,)
    outputs: bool  # whether outputs are worked out at the points

    @property
    def system(self) -> System:
        """The system with the parameters of the call."""
        return self.chosen.system

    @property
    def strobed(self) -> StroboscopicMap:
        """The map, where it is one of strobes."""
        assert isinstance(self.chosen, StroboscopicMap)
        return self.chosen

    @property
    def unit(self) -> str:
        """What iterates of the map are called."""
        chosen = self.chosen
        if isinstance(chosen, StroboscopicMap) and (chosen.length, chosen.every) == (None, 1):
            return "period"
        return "iterate"


@dataclass(frozen=True)
class Look:
    """What one motion shows; K points, n states."""

    status: Status
    points: Floats  # (K, n + outputs)
    numbers: Integers  # (K,): window of each point
    phases: Floats  # (K,)
    modes: Integers  # (K,)
    period: int  # in iterates of the map; 0 where none was found
    word: str
    events: float  # per iterate
    impacts: float  # see `Impacts`
    drift: Floats  # (n,): change of each state per iterate
    uncertain: int
    estimated: int
    window: float  # mean time of an iterate


def run_chain(
    protocol: Protocol,
    runner: LaneRunner,
    stop: threading.Event,
    values: list[float],
    start: Start,
    follow: bool,
) -> list[Look]:
    """Motions at several values of the parameter, see `chain`."""
    looks: list[Look] = []
    windows = np.full(len(values), np.nan)
    begun = chain(
        protocol.strobed, protocol.parameter, protocol.drifting, runner, values, start, follow
    )
    for i, one in enumerate(begun):
        if one is None:
            looks.append(nothing(Status.REFUSED, len(protocol.system.states), np.nan))
            continue
        windows[i] = runner.window
        looks.append(_look(protocol, one.length, runner, one.lanes, one.begin, stop))
    return _with_outputs(protocol, values, windows, looks) if protocol.outputs else looks


def _with_outputs(
    protocol: Protocol, values: list[float], windows: Floats, looks: list[Look]
) -> list[Look]:
    """Looks with the outputs at their points as further columns, all worked out together."""
    counts = [len(look.points) for look in looks]
    points, numbers, phases, modes = (
        np.concatenate([getattr(look, name) for look in looks])
        for name in ("points", "numbers", "phases", "modes")
    )
    parameters = {protocol.parameter: np.repeat(values, counts)}
    clock = SweptClock(numbers, phases, np.repeat(windows, counts), parameters)
    found = output_values(protocol.system, clock, points.T, modes)
    parts = np.split(np.column_stack([points, *found.values()]), np.cumsum(counts)[:-1])
    return [replace(look, points=part) for look, part in zip(looks, parts, strict=True)]


def _look(
    protocol: Protocol,
    length: float | None,
    runner: LaneRunner,
    lanes: Lanes,
    begin: Instant,
    stop: threading.Event,
) -> Look:
    """Let a motion settle and record it."""
    n, window = lanes.end_state.shape[1], runner.window
    every = protocol.strobed.every
    numbers, phases = strobes(
        window, begin, length, protocol.strobed.phase,
        protocol.transient * every, protocol.record * every + 1,
    )  # fmt: skip
    numbers, phases = numbers[::every].copy(), phases[::every].copy()
    if protocol.transient > 0:
        settled = Instant(int(numbers[0]), float(phases[0]))
        runner.run(lanes, settled, np.zeros(0, np.int64), np.zeros(0), stop)
    if lanes.status[0] != Status.COMPLETED:
        return nothing(Status(int(lanes.status[0])), n, window)
    points, modes, rows, states = runner.record(lanes, 0, numbers, phases)
    status = Status(int(lanes.status[0]))
    if status != Status.COMPLETED:
        return nothing(status, n, window)
    scale = scales(points, protocol.drifting)
    period = primitive_period(points, protocol.drifting, scale, protocol.match)
    word = ""
    if period:
        entered = _passed(rows, numbers, phases, -1 - period, window)["to_mode"]
        word = word_of_modes(protocol.system, np.array([int(modes[-1 - period]), *entered]))
    count = whole_periods(protocol.record, period)
    first = -1 - count
    passed = _passed(rows, numbers, phases, first, window)
    lasts = (numbers[-1] - numbers[first]) * window + (phases[-1] - phases[first])
    if protocol.exits is None:
        # the last strobe closes the recorded time and belongs to the next period
        taken = points[:-1], numbers[:-1], phases[:-1], modes[:-1]
    else:
        taken = _at_events(protocol, rows, states)
    return Look(
        status, *taken, period, word,
        len(passed) / count, impacts_of(protocol.system).count(passed) / count,
        (points[-1] - points[first]) / count,
        int(lanes.uncertain[0]), int(lanes.estimated[0]), float(lasts) / count,
    )  # fmt: skip


def _passed(rows: Rows, numbers: Integers, phases: Floats, first: int, window: float) -> Rows:
    """Events from one of some strobes on; one at that instant has not changed its state."""
    since = (rows["number"] - numbers[first]) * window + (rows["phase"] - phases[first])
    passed: Rows = rows[happened(rows) & (since >= 0.0)]
    return passed


def _at_events(
    protocol: Protocol, rows: Rows, states: Floats
) -> tuple[Floats, Integers, Floats, Integers]:
    """States, windows, phases and modes at the chosen events."""
    assert protocol.exits is not None
    chosen = (rows["exit"] >= 0) & protocol.exits[rows["from_mode"], rows["exit"]]
    return (
        states[chosen, 1 if protocol.after else 0],
        rows["number"][chosen],
        rows["phase"][chosen],
        rows["to_mode" if protocol.after else "from_mode"][chosen],
    )


def with_outputs(
    system: System,
    tables: Tables,
    points: Floats,
    numbers: Integers,
    phases: Floats,
    modes: Integers,
) -> Floats:
    """Points with the outputs as further columns."""
    found = output_values(system, Clock(numbers, phases, tables), points.T, modes)
    return np.column_stack([points, *found.values()])


def nothing(status: Status, n: int, window: float) -> Look:
    """A motion that left nothing to look at."""
    whole = np.zeros(0, np.int64)
    return Look(
        status, np.zeros((0, n)), whole, np.zeros(0), whole, 0, "", np.nan, np.nan,
        np.full(n, np.nan), 0, 0, window,
    )  # fmt: skip
