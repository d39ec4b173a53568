"""Runs of small piecewise-linear automata to 40 digits.

A mode is a matrix M (z' = M z) and a list of exits in declared order. Constants and harmonics
are states of z like any other: a forced oscillator x'' = -x + cos(w t) has z = (x, v, c, s, 1)
with c' = -w s, s' = w c. An exit has a guard row h (h . z positive inside the mode), the mode it
leads to, and a reset matrix R (z becomes R z; left out: unchanged).

    modes = {
        "free": LinearMode(
            matrix=[[0, 1, 0], [0, 0, -1], [0, 0, 0]],             # z = (height, velocity, 1)
            exits=[LinearExit([1, 0, 0], to="free", reset=[[0, 0, 0], [0, "-0.5", 0], [0, 0, 1]])],
        )
    }
    run = hybrid_run(modes, z0=[1, 0, 1], mode0="free", t_end=2.5)

Entries may be doubles (exact), integers, text or mpf. A reset that puts the state exactly onto
the surface (the first row above) spares the run a rounding error, no more.

One instant: after an exit, the first exit in declared order that must fire, fires, until none
must. An exit must fire where its guard is negative, or zero with its first non-zero derivative
negative; zero throughout holds. Zero means below 1e-40 times sum(|h|) max(|z|).
Coming back without reset to a mode already passed in the instant, or 100 steps, is an error.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from mpmath import mp, mpf

from .crossing import Crossing, first_crossing, leading_derivative
from .flow import Rows, exact_flow

DIGITS = 50
ZERO = mpf(10) ** -40
LONGEST_INSTANT = 100


class LinearExit(NamedTuple):
    guard: Sequence[Any]
    to: str
    reset: Rows | None = None


class LinearMode(NamedTuple):
    matrix: Rows
    exits: Sequence[LinearExit]


class HybridEvent(NamedTuple):
    """One instant. ``path`` names (mode, number of the exit) for each step of it."""

    time: mpf
    mode_from: str
    mode_to: str
    path: list[tuple[str, int]]
    before: list[mpf]
    after: list[mpf]


@dataclass
class HybridRun:
    """``nearest_miss`` is the least ``gap`` of first_crossing along the run."""

    events: list[HybridEvent] = field(default_factory=list)
    state: list[mpf] = field(default_factory=list)
    mode: str = ""
    nearest_miss: mpf = mp.inf


def hybrid_run(
    modes: Mapping[str, LinearMode],
    z0: Sequence[Any],
    mode0: str,
    t_end: Any,
    *,
    max_events: int = 1000,
    search: Callable[..., Crossing] = first_crossing,
) -> HybridRun:
    """The run from z0 in mode0 at time 0 up to t_end. A start that must leave does so as event.

    ``search`` may be `modal.first_crossing`, which is for stiff modes.
    """
    with mp.workdps(DIGITS + 10):
        end, time = mpf(t_end), mpf(0)
        run = HybridRun(state=[mpf(x) for x in z0], mode=mode0)
        _instant(run, modes, time, None)
        while time < end:
            exit_number, step = _next_exit(run, modes[run.mode], end - time, search)
            matrix = modes[run.mode].matrix
            run.state = list(exact_flow(matrix, run.state, step, digits=DIGITS + 5))
            time += step
            if exit_number is None:
                break
            if len(run.events) == max_events:
                raise RuntimeError(f"more than {max_events} events before t = {mp.nstr(time, 12)}")
            _instant(run, modes, time, exit_number)
        return run


def _next_exit(
    run: HybridRun, mode: LinearMode, duration: mpf, search: Callable[..., Crossing]
) -> tuple[int | None, mpf]:
    """The exit that fires first, and when; of those that fire together, the first declared."""
    number, nearest = None, duration
    for i, each in enumerate(mode.exits):
        time, gap = search(
            mode.matrix, run.state, each.guard, nearest, digits=DIGITS, zero_tolerance=ZERO
        )
        run.nearest_miss = min(run.nearest_miss, gap)
        if time is not None and (number is None or time < nearest - ZERO):
            number, nearest = i, time
    return number, nearest


def _instant(
    run: HybridRun, modes: Mapping[str, LinearMode], time: mpf, exit_number: int | None
) -> None:
    """Pass exits until a mode holds; ``exit_number`` is the one that fired, None at a start."""
    before, mode_before = run.state, run.mode
    path: list[tuple[str, int]] = []
    passed = {run.mode}
    if exit_number is None:
        exit_number = _must_fire(run, modes[run.mode])
    while exit_number is not None:
        path.append((run.mode, exit_number))
        fired = modes[run.mode].exits[exit_number]
        run.mode = fired.to
        if fired.reset is not None:
            run.state = [
                sum(mpf(r) * x for r, x in zip(row, run.state, strict=True)) for row in fired.reset
            ]
        elif fired.to in passed:
            raise RuntimeError(f"no mode holds at t = {mp.nstr(time, 12)}: {path}")
        if len(path) > LONGEST_INSTANT:
            raise RuntimeError(f"no end of exits at t = {mp.nstr(time, 12)}")
        passed.add(run.mode)
        exit_number = _must_fire(run, modes[run.mode])
    if path:
        run.events.append(HybridEvent(time, mode_before, run.mode, path, before, run.state))


def _must_fire(run: HybridRun, mode: LinearMode) -> int | None:
    matrix = [[mpf(x) for x in row] for row in mode.matrix]
    for i, each in enumerate(mode.exits):
        guard = [mpf(x) for x in each.guard]
        if leading_derivative(matrix, run.state, guard, ZERO)[1] < 0:
            return i
    return None
