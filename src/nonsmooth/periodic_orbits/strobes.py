"""The strobes of an orbit: its states once in every period of the system.

A driven orbit begins at a strobe. One of a system that nothing drives may begin anywhere, and has
strobes only where a state of the system is a clock that the period of the system resets: they are
those of a run whose clock begins as the system says.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.system.compile.clock_states import clock_states
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import constant_value

__all__ = ["NO_STROBES", "Strobes", "strobes_of"]

Floats = npt.NDArray[np.float64]

_AT_STROBE = 1e-12  # part of the period by which an event may lie off a strobe by rounding
_WHOLE = (
    1e-9  # of a period, within which a turn lasts a whole number, and a clock is set back by one
)


class Strobes(NamedTuple):
    """Times and states at the strobes of one turn, in order."""

    times: Floats  # (K,)
    states: Floats  # (K, n)


NO_STROBES = Strobes(np.zeros(0), np.zeros((0, 0)))


def strobes_of(
    equations: OrbitEquations, turn: Turn, behind: Mapping[int, bool] | None = None
) -> Strobes:
    """Strobes of an orbit, none where it has no phase to take them at.

    ``behind`` tells of later strobes of a driven orbit, or of any of one with a clock, by their
    numbers, on which side of an event they lie that is just there.
    """
    window = equations.legs.window
    if equations.autonomous:
        return _of_clock(equations, turn, behind or {})
    times = turn.instants[0] + window * np.arange(equations.period)
    if equations.period == 1:
        return Strobes(times, turn.states[:1])
    # an event at the section is on the same side of each strobe as of the first one
    ahead = _AT_STROBE * window
    sides = np.full(times.size, ahead if turn.durations[-1] <= ahead else -ahead)
    for number, is_behind in (behind or {}).items():
        sides[number] = ahead if is_behind else -ahead
    later = equations.states_along(turn, times[1:], sides[1:])
    return Strobes(times, np.concatenate([turn.states[:1], later]))


def _of_clock(equations: OrbitEquations, turn: Turn, behind: Mapping[int, bool]) -> Strobes:
    """Strobes where a clock of the system shows the phase, none without such a clock."""
    system, period = equations.legs.system, equations.legs.window
    turns = float(turn.instants[-1] - turn.instants[0]) / period
    count = round(turns)
    clocks = clock_states(system.structure) if system.period_value is not None else {}
    if not clocks or count < 1 or abs(turns - count) > _WHOLE * count:
        return NO_STROBES
    values = dict(zip(system.parameters, equations.legs.values.tolist(), strict=True))
    for name, node in clocks.items():
        rate, shown = constant_value(node, values), turn.states[:, system.states.index(name)]
        # what the clock would show without its resets, in periods since the turn began
        passed = (shown - shown[0]) / (rate * period)
        back = (turn.instants[:-1] - turn.instants[0]) / period - passed
        if np.any(np.abs(back - np.rint(back)) > _WHOLE * count):
            continue  # it keeps another time
        begin = _first_value(system, name, values)
        wait = (begin - shown[0]) / (rate * period) + equations.phase
        # a strobe at a reset holds the state before it, as a sample of a run does
        wait -= np.ceil(wait - _AT_STROBE) - 1.0
        times = turn.instants[0] + (wait + np.arange(count)) * period
        sides = np.full(count, -_AT_STROBE * period)
        for number, is_behind in behind.items():
            sides[number] = _AT_STROBE * period if is_behind else -_AT_STROBE * period
        # behind the event with which the turn begins is its beginning, and no more its end
        over = (times + sides >= turn.instants[-1]) & (sides > 0.0)
        times = np.where(over, turn.instants[0], times)
        legs = np.searchsorted(turn.instants[1:-1], times + sides, side="right")
        for tick in _ticks(back, count):
            at = np.abs(times - turn.instants[tick]) <= _AT_STROBE * period
            at[list(behind)] = False
            # events at the same instant are before the tick or behind it, as the word says
            legs[at] = tick - 1
        states = equations.states_in_legs(turn, legs, times)
        order = np.argsort(times, kind="stable")
        return Strobes(times[order], states[order])
    return NO_STROBES


def _ticks(back: Floats, count: int) -> list[int]:
    """Numbers of the instants at which a clock is set back, that of the end among them.

    ``back`` says of each leg how many periods the clock is behind, without these of the turn.
    """
    behind = np.append(np.rint(back), count)
    return [k for k in range(1, behind.size) if behind[k] > behind[k - 1]]


def _first_value(system: System, state: str, values: Mapping[str, float]) -> float:
    """What ``initial`` of a system gives a state, for some values of the parameters."""
    equation = system.structure.initial.get(state)
    if equation is None:
        return 0.0
    return constant_value(system.structure.static_form.form(equation).constant_part, values)
