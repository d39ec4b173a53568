"""Guesses for a given word: motions that happen to follow it, then random durations."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import EventKind
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.word import Word, path_of_bits
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.runner import NoMode, build_tables, run_plan
from nonsmooth.runs.start import resolve_start
from nonsmooth.system.system import System

__all__ = ["guesses_in_motion", "random_guesses"]

Floats = npt.NDArray[np.float64]

_SWEEPS = 3  # of the states, for fixed instants


def guesses_in_motion(
    system: System, initial: Any, words: list[Word], *, period: int, phase: float, periods: int,
    tolerance: float,
) -> Iterator[Guess]:  # fmt: skip
    """Stretches of a driven motion that follow one of some words, the nearly closed ones first.

    Words count rebounds that accumulate as one; those of the guesses have all that were followed.
    """
    tables = build_tables(system)
    window = tables.window
    start = resolve_start(system, tables, initial, None, None, True)
    if start.anchor is not None:
        return
    first = start.instant.number + (start.instant.phase > phase * window)
    numbers = first + np.arange(periods + 1, dtype=np.int64)
    plan = Plan(
        Instant(int(numbers[-1]), phase * window), numbers, np.full(periods + 1, phase * window)
    )
    try:
        outcome = run_plan(
            tables, plan, tolerance, state=start.state, begin=start.instant, mode=start.modes[0]
        )
    except NoMode:
        return
    rows, after = outcome.events, outcome.event_states[:, 1]
    lasting = ~np.isin(rows["kind"], (EventKind.GRAZE, EventKind.START))
    rows, after = rows[lasting], after[lasting]
    times = (rows["number"] - first) * window + rows["phase"] - phase * window
    states, modes = outcome.records.sample_state, outcome.records.sample_mode
    drifting = np.array([name in system.drift_states for name in system.states])
    sample = np.where(drifting, 0.0, states)
    reached = outcome.n_samples
    wiring = system.compiled.program.wiring
    wanted = {(word.modes, word.paths) for word in (each.collapsed(wiring) for each in words)}
    found = []
    for k in range(max(0, reached - period)):
        low, high = np.searchsorted(times, [k * window, (k + period) * window], side="right")
        part = slice(int(low), int(high))
        paths = [path_of_bits(int(r["path"]), int(r["passes"])) for r in rows[part]]
        if None in paths:
            continue
        visited = (int(modes[k]), *(int(m) for m in rows["to_mode"][part]))
        word = Word(visited, (*[path for path in paths if path is not None], ()))
        seen = word.collapsed(wiring)
        if (seen.modes, seen.paths) in wanted:
            gap = float(np.abs(sample[k + period] - sample[k]).max())
            inner = times[part] - k * window
            instants = np.concatenate([[0.0], inner, [period * window]]) + phase * window
            legs = np.vstack([states[k][None], after[part]])
            found.append((gap, Guess(word, Turn(legs, instants))))
    for _, guess in sorted(found, key=lambda pair: pair[0]):
        yield guess


def random_guesses(
    equations: OrbitEquations, length: float, count: int, seed: int
) -> Iterator[Floats]:
    """Unknowns for random durations of the legs: states follow, as far as flows are linear."""
    rng = np.random.default_rng(seed)
    word, n = equations.word, equations.legs.n
    for _ in range(count):
        shares = rng.dirichlet(np.full(len(word), rng.choice([0.4, 1.0, 3.0])))
        span = length if not equations.autonomous else length * rng.uniform(0.2, 3.0)
        begin = equations.phase * equations.legs.window
        instants = begin + span * np.concatenate([[0.0], np.cumsum(shares)])
        states = np.where(equations.drifting, equations.origin, 0.0) + np.zeros((len(word), n))
        unknowns = equations.pack(Turn(states, instants))
        try:
            for _ in range(_SWEEPS):
                residual, jacobian, _ = equations.evaluate(unknowns)
                size = len(word) * n
                step = np.linalg.lstsq(jacobian[:size, :size], -residual[:size], rcond=None)[0]
                unknowns[:size] += step
        except (LegError, np.linalg.LinAlgError):
            continue
        if np.all(np.isfinite(unknowns)):
            yield unknowns
