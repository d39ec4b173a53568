"""Lanes of an ensemble that have a parameter set each, run as motions of a sweep."""

from __future__ import annotations

import threading

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.ensembles.chunk import Chunk, EnsembleProtocol
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Plan
from nonsmooth.runs.outputs import SweptClock, output_values
from nonsmooth.runs.sweep_runner import Motions, Recorded, SweepRunner, SweepStarts, Times
from nonsmooth.system.model.value_checks import rests_alike, sure_values
from nonsmooth.system.system import System

__all__ = ["run_sure_sets"]

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def run_sure_sets(
    protocol: EnsembleProtocol,
    lanes: Integers,
    runner: SweepRunner,
    stop: threading.Event,
    chunk: Chunk,
) -> Bools:
    """Run lanes with a parameter set each that the system takes for sure; which these are.

    The others, and starts that a mode completes or that several modes may take, go one by one.
    """
    system, members = protocol.system, protocol.members
    sets = {name: values[members.set_numbers(lanes)] for name, values in members.sets.items()}
    states = members.states(lanes, system.open_state)
    done = np.zeros(lanes.size, bool)
    if len(protocol.modes) > 1 or not rests_alike(system, sets) or np.any(np.isnan(states)):
        return done
    sure = np.flatnonzero(sure_values(system, sets))
    for first in range(0, sure.size, runner.most):
        some = sure[first : first + runner.most]
        values = np.empty((some.size, len(system.parameters)))
        for k, (name, value) in enumerate(system.parameter_values.items()):
            values[:, k] = sets[name][some] if name in sets else value
        usable = runner.set_up(values)
        plans = [protocol.plan(window) for window in runner.windows[usable].tolist()]
        some = some[usable]
        if not np.all(usable):
            runner.set_up(values[usable])
        if plans:
            ran = _run_plans(protocol, runner, plans, states[some], stop)
            varied = {name: each[some] for name, each in sets.items()}
            _write_recorded(system, plans, *ran, states[some], varied, chunk, some)
            done[some] = True
    return done


def _run_plans(
    protocol: EnsembleProtocol,
    runner: SweepRunner,
    plans: list[Plan],
    states: Floats,
    stop: threading.Event,
) -> tuple[Motions, Recorded]:
    """Run a motion by each plan from time zero."""
    count = len(plans)
    starts = SweepStarts(
        states, np.full(count, protocol.modes[0]), np.zeros(count, np.int64), np.zeros(count)
    )
    times = Times(
        np.stack([plan.sample_number for plan in plans]),
        np.stack([plan.sample_phase for plan in plans]),
    )
    ends = Times(
        np.array([[plan.end.number] for plan in plans]),
        np.array([[plan.end.phase] for plan in plans]),
    )
    motions = runner.start(starts, np.ones(count, bool))
    return motions, runner.run(motions, times, ends=ends, log=False, stop=stop)


def _write_recorded(
    system: System,
    plans: list[Plan],
    motions: Motions,
    recorded: Recorded,
    states: Floats,
    varied: dict[str, Floats],
    chunk: Chunk,
    rows: Integers,
) -> None:
    """Write what motions of a sweep have done into their rows of a chunk."""
    count, samples, n = recorded.states.shape
    chunk["points"][rows, :, :n] = recorded.states
    chunk["modes"][rows] = recorded.modes
    chunk["status"][rows] = recorded.statuses
    chunk["uncertain"][rows] = motions.uncertain
    chunk["estimated"][rows] = motions.estimated
    chunk["initial"][rows] = states
    chunk["end"][rows] = motions.end_states
    ended, places = recorded.statuses != Status.COMPLETED, motions.places
    numbers = np.where(ended, places["number"], [plan.end.number for plan in plans])
    phases = np.where(ended, places["phase"], [plan.end.phase for plan in plans])
    chunk["end_time"][rows] = numbers * recorded.windows + phases
    if system.outputs:
        each = {name: np.repeat(values, samples) for name, values in varied.items()}
        windows = np.repeat(recorded.windows, samples)
        clock = SweptClock(recorded.numbers.ravel(), recorded.phases.ravel(), windows, each)
        found = output_values(
            system, clock, recorded.states.reshape(-1, n).T, recorded.modes.ravel()
        )
        for k, values in enumerate(found.values()):
            chunk["points"][rows, :, n + k] = values.reshape(count, samples)
