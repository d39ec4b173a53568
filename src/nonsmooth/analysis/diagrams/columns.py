"""Columns of a bifurcation diagram: what motions do for one parameter value, once settled."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.column_starts import Start
from nonsmooth.analysis.diagrams.motions import Motions, Recording
from nonsmooth.analysis.statistics.periodicity import primitive_period, scales
from nonsmooth.engine.record import Rows
from nonsmooth.engine.status import EventKind, Status
from nonsmooth.engine.tables import Tables
from nonsmooth.maps.of_system import Map
from nonsmooth.maps.stroboscopic import StroboscopicMap
from nonsmooth.simulation.outputs import Clock, SweptClock, output_values
from nonsmooth.simulation.sweep_runner import Motion, SweepRunner
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
    impacts: float  # of these, with a reset
    drift: Floats  # (n,): change of each state per iterate
    uncertain: int
    window: float  # mean time of an iterate


def run_chain(
    protocol: Protocol,
    runner: SweepRunner,
    stop: threading.Event,
    values: list[float],
    start: Start,
    follow: bool,
) -> list[Look]:
    """Motions at several values of the parameter, see `Motions`."""
    motions = Motions(
        protocol.strobed, protocol.parameter, runner, start,
        Recording(protocol.transient, protocol.record), follow=follow,
    )  # fmt: skip
    found = list(motions.run(values, stop))
    looks = [_look(protocol, motion) for motion in found]
    if not protocol.outputs:
        return looks
    return _with_outputs(protocol, values, [motion.window for motion in found], looks)


def _with_outputs(
    protocol: Protocol, values: list[float], windows: list[float], looks: list[Look]
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


def _look(protocol: Protocol, motion: Motion) -> Look:
    """What is seen of the record of a motion."""
    if motion.status != Status.COMPLETED:
        return nothing(motion.status, motion.end_state.size, motion.window)
    points, modes, numbers, phases = motion.states, motion.modes, motion.numbers, motion.phases
    rows, window = motion.rows, motion.window
    scale = scales(points, protocol.drifting)
    period = primitive_period(points, protocol.drifting, scale, protocol.match)
    word = ""
    if period:
        word = _word(protocol, rows, rows["phase"], numbers, phases, modes, period, window)
    kind = rows["kind"]
    events = np.count_nonzero(kind != EventKind.GRAZE) / protocol.record
    impacts = np.count_nonzero(kind == EventKind.IMPACT) / protocol.record
    drift = (points[-1] - points[0]) / protocol.record
    lasts = (numbers[-1] - numbers[0]) * window + (phases[-1] - phases[0])
    lasts = float(lasts) / protocol.record
    if protocol.exits is None:
        # the last strobe closes the recorded time and belongs to the next period
        taken = points[:-1], numbers[:-1], phases[:-1], modes[:-1]
    else:
        taken = _at_events(protocol, rows, motion.event_states)
    return Look(
        motion.status, *taken, period, word, events, impacts, drift, motion.uncertain, lasts
    )


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


def _word(
    protocol: Protocol,
    rows: Rows,
    phase: Floats,
    numbers: Integers,
    phases: Floats,
    modes: Integers,
    period: int,
    window: float,
) -> str:
    """Modes of the last primitive period, in order."""
    since = (rows["number"] - numbers[-1 - period]) * window + (phase - phases[-1 - period])
    within = (rows["kind"] != EventKind.GRAZE) & (since > 0.0)
    entered = [int(modes[-1 - period]), *rows["to_mode"][within]]
    return word_of_modes(protocol.system, np.array(entered))


def nothing(status: Status, n: int, window: float) -> Look:
    """A motion that left nothing to look at."""
    whole = np.zeros(0, np.int64)
    return Look(
        status, np.zeros((0, n)), whole, np.zeros(0), whole, 0, "", np.nan, np.nan,
        np.full(n, np.nan), 0, window,
    )  # fmt: skip
