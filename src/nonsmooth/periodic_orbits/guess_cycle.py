"""Guesses of limit cycles: where a motion that nothing drives comes nearly back."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.record import columns
from nonsmooth.engine.status import EventKind
from nonsmooth.periodic_orbits.equations import Turn
from nonsmooth.periodic_orbits.guess import Guess, run_for_guess
from nonsmooth.periodic_orbits.word import Word, path_of_bits
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.runner import Outcome, build_tables
from nonsmooth.runs.start import Start, resolve_start, start_at_end
from nonsmooth.system.system import System

__all__ = ["cycle_guesses"]

Floats = npt.NDArray[np.float64]

_WINDOWS = 64  # in which a return is looked for, per period
_SAMPLES = 128  # in a window
_FINER = (4096, 64, 1)  # samples in a window beside that: a fast cycle is found in a short stretch
_RESOLVED = 0.3  # of the spread of the states: the median way between samples of a cycle
_NEAR = (1e-3, 1e-2, 5e-2)  # of the spread of the states: the first return as near is taken
_MOST_EVENTS = 256


def cycle_guesses(
    system: System, initial: Any, *, period: int, transient: int, mode: str | None, tolerance: float
) -> Iterator[Guess]:
    """Legs of a motion from an event to its nearest return, or around a smooth cycle.

    ``transient`` counts windows. Guesses of short cycles come first; none where the motion does not
    come back.
    """
    tables = build_tables(system)
    start = resolve_start(system, tables, initial, None, mode, True)
    if start.anchor is not None:
        start = start_at_end(start)
    begin = start.instant.number + transient
    drifting = np.array([name in system.drift_states for name in system.states])
    for finer in _FINER:
        samples, final = _SAMPLES * finer, finer == _FINER[-1]
        plan, step = _plan(tables.window, samples, period, begin, start, transient)
        outcome = run_for_guess(system, tables, start, plan, tolerance)
        found = _between_events(system, outcome, begin, drifting, period, final)
        found = found or _around(outcome, drifting, period, step, final)
        if found is not None:
            yield found


def _plan(
    window: float, samples: int, period: int, begin: int, start: Start, transient: int
) -> tuple[Plan, float]:
    """Samples of so many per window, their number being the same; and the time between them."""
    count = _WINDOWS * _SAMPLES * period + 1
    step = window / samples
    number = begin + np.arange(count) // samples
    phase: Floats = np.asarray((np.arange(count) % samples) * step)
    if transient == 0:
        phase[0] = max(phase[0], start.instant.phase)
    return Plan(Instant(int(number[-1]), float(phase[-1])), number, phase), step


def _is_resolved(outcome: Outcome, drifting: npt.NDArray[np.bool_]) -> bool:
    """Whether samples follow the motion, rather than being anywhere on it."""
    states = np.where(drifting, 0.0, outcome.records.sample_state)
    spread = np.ptp(states, axis=0)
    if not np.any(spread > 0.0):
        return True
    ways = np.abs(np.diff(states, axis=0)) / np.where(spread > 0.0, spread, 1.0)
    return bool(np.median(ways.max(axis=1)) <= _RESOLVED)


def _between_events(
    system: System, outcome: Outcome, begin: int, drifting: npt.NDArray[np.bool_], period: int,
    final: bool,
) -> Guess | None:  # fmt: skip
    """From an event to a return of the same kind, the first that is near; at last the nearest."""
    window, rows = outcome.window, outcome.events
    keep = (rows["number"] >= begin) & ~np.isin(rows["kind"], (EventKind.GRAZE, EventKind.START))
    rows, states = rows[keep][:_MOST_EVENTS], outcome.event_states[keep, 1][:_MOST_EVENTS]
    if len(rows) < 2:
        return None
    times = (rows["number"] - begin) * window + rows["phase"]
    kinds = columns(rows, "from_mode", "path", "to_mode")
    same = np.all(kinds == kinds[0], axis=1)
    samples = np.where(drifting, 0.0, outcome.records.sample_state)
    spread = np.maximum(np.ptp(samples, axis=0), 1e-12)
    apart = np.where(drifting, 0.0, np.abs(states - states[0]) / spread).max(axis=1)
    returns = np.flatnonzero(same)[1:]
    for near in _NEAR:
        if np.any(apart[returns] <= near):
            turn = int(returns[apart[returns] <= near][0])
            break
    else:
        if returns.size == 0 or not final:
            return None
        turn = int(returns[np.argmin(apart[returns])])
    last = min(turn * period, len(rows) - 1)
    paths = [path_of_bits(int(r["path"]), int(r["passes"])) for r in rows[1 : last + 1]]
    if any(path is None for path in paths):
        return None
    modes = tuple(int(m) for m in rows["to_mode"][:last])
    word = Word(modes, tuple(path for path in paths if path is not None))
    return Guess(word, Turn(states[:last].copy(), times[: last + 1] - times[0]))


def _around(
    outcome: Outcome, drifting: npt.NDArray[np.bool_], period: int, step: float, final: bool
) -> Guess | None:
    """Once around a cycle without events, from its first sample."""
    states = np.where(drifting, 0.0, outcome.records.sample_state)
    spread = np.ptp(states, axis=0)
    at_rest = not np.any(spread > 1e-9 * (np.abs(states).max(axis=0) + 1e-12))
    if at_rest or not _is_resolved(outcome, drifting):
        return None
    scaled = (states - states[0]) / np.where(spread > 0.0, spread, 1.0)
    forward = scaled @ (scaled[1] - scaled[0])
    crossings = np.flatnonzero((forward[1:-1] < 0.0) & (forward[2:] >= 0.0)) + 2
    if crossings.size == 0:
        return None
    # between samples, on the plane across the flow at the first one
    part = forward[crossings] / (forward[crossings] - forward[crossings - 1])
    before, behind = scaled[crossings - 1], scaled[crossings]
    apart = np.abs(behind + part[:, None] * (before - behind)).max(axis=1)
    near = np.flatnonzero(apart <= _NEAR[-1])
    if not (near.size or final):
        return None
    k = int(near[0]) if near.size else int(np.argmin(apart))
    length = (crossings[k] - part[k]) * step * period
    word = Word((int(outcome.records.sample_mode[0]),), ((),))
    first = outcome.records.sample_state[:1].copy()
    return Guess(word, Turn(first, np.array([0.0, length])))
