"""Motions a little beyond a change of the word, and whether an orbit there joins the one before.

A driven orbit is looked at from strobe to strobe. A cycle has no such time, so its motion is
followed from a place half way along its longest leg, until it comes back to where its first event
was.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.point import Point
from nonsmooth.errors import RunError
from nonsmooth.periodic_orbits.branch_start import tangent_at
from nonsmooth.periodic_orbits.branch_tests import Looked, largest_along
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.guess import Guess, cycle_guesses, driven_guess
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.newton import solve_orbit
from nonsmooth.periodic_orbits.stretch import BranchStart, BranchStretch

__all__ = [
    "is_near",
    "joins",
    "motion_at",
    "motion_from",
    "motions_nearby",
    "start_of",
    "way_of",
]

Floats = npt.NDArray[np.float64]

_TURNS = 100  # in which driven motions settle
_PLACES = 200  # along each leg of a cycle, at which it is compared
_CLOSER = 0.01  # part of the way to a change, over which an orbit that joins it comes closer
_MOST_PASSED = 10_000  # events of a motion that begins on a cycle: beyond, thresholds may meet
_NEARBY = 1e-4  # of the size of an orbit: one of another word farther away is no continuation
# of the size of an orbit, driven or a cycle: one farther away is another one, and as close as it
# can come to the orbit of the change
_FAR, _SAME = 0.05, 1e-7
_FAR_CYCLE, _SAME_CYCLE = 0.01, 1e-4


def motion_at(stretch: BranchStretch, looked: Looked, value: float) -> Guess | None:
    """Legs of the motion from an orbit; None where nothing drives the system.

    It begins in the cell of the orbit where that admits it: a state that has decayed to a border
    of cells lies in several of them.
    """
    running = stretch.options.system.structure.running
    cell = running[stretch.equations.word.modes[0]].name
    first = looked.turn.states[0]
    found = motion_from(stretch, first, value, 0, cell)
    return found or motion_from(stretch, first, value, 0)


def motion_from(
    stretch: BranchStretch, first: Floats, value: float, turns: int, mode: str | None = None
) -> Guess | None:
    """Legs of the motion from a state, after some turns."""
    options = stretch.options
    low, high = options.bounds
    if options.autonomous or not low <= value <= high:
        return None
    names = list(options.system.parameters)
    state = dict(zip(options.system.states, first.tolist(), strict=True))
    values = dict(zip(names, stretch.legs.values.tolist(), strict=True))
    try:
        there = options.system.with_parameters(**values | {options.parameter: value})
        return driven_guess(
            there, state, period=options.period, phase=options.phase,
            transient=turns * options.period, mode=mode, tolerance=options.tolerance,
        )  # fmt: skip
    except (RunError, ValueError):
        return None


def motions_nearby(
    stretch: BranchStretch, looked: Looked, here: float, value: float
) -> Iterator[Guess]:  # fmt: skip
    """Orbits to which motions from the orbit at ``here`` come at another value of the parameter.

    A driven motion is let settle. That of a cycle has not, so it may tell the word of the other
    side of the change.
    """
    if stretch.options.autonomous:
        yield from _cycles_nearby(stretch, looked, here, value)
        return
    guess = motion_from(stretch, looked.turn.states[0], value, _TURNS)
    if guess is not None:
        yield guess


def _cycles_nearby(
    stretch: BranchStretch, looked: Looked, here: float, value: float
) -> Iterator[Guess]:  # fmt: skip
    """Cycles near the motion that begins on a cycle; none where it does not come back."""
    options, equations, turn = stretch.options, stretch.equations, looked.turn
    low, high = options.bounds
    if equations.is_smooth_cycle or not low <= value <= high:
        return
    stretch.set_parameter(here)
    leg = int(np.argmax(turn.durations))
    middle = float(0.5 * (turn.instants[leg] + turn.instants[leg + 1]))
    state = equations.states_along(turn, np.array([middle]))[0]
    values = dict(zip(options.system.parameters, stretch.legs.values.tolist(), strict=True))
    try:
        there = options.system.with_parameters(**values | {options.parameter: value})
        yield from cycle_guesses(
            there,
            dict(zip(options.system.states, state.tolist(), strict=True)),
            period=1,
            transient=0,
            mode=options.system.structure.running[equations.word.modes[leg]].name,
            tolerance=options.tolerance,
            most_events=_MOST_PASSED,
        )
    except (RunError, ValueError):  # it ends on the way, or is refused there
        return


def start_of(
    stretch: BranchStretch, guess: Guess, value: float, point: Point
) -> BranchStart | None:
    """The branch from there on, in the direction that it has; None where it is no motion."""
    try:
        stretch.set_parameter(value)
        equations = stretch.equations.of_word(guess.word, guess.turn.states[0])
        solution = solve_orbit(equations, equations.pack(guess.turn))
        if solution.status != "completed":
            return None
        du, dp = tangent_at(equations, solution.unknowns)
    except LegError:
        return None
    sign = 1.0 if dp * way_of(point) >= 0.0 else -1.0
    return BranchStart(equations, solution.unknowns, value, (sign * du, sign * dp), kind="section")


def way_of(point: Point) -> float:
    """Sign with which the parameter changes along the branch."""
    return float(np.sign(point.tangent_p) or 1.0)


def is_near(stretch: BranchStretch, start: BranchStart, looked: Looked) -> bool:
    """Whether an orbit of another word begins where this one is, and not somewhere else."""
    return _apart(stretch, start.equations, start.unknowns, looked) <= _NEARBY


def joins(stretch: BranchStretch, start: BranchStart, looked: Looked, here: float) -> bool:
    """Whether an orbit beside a change comes to that of the change, at ``here``.

    At the root of the distance at least, as it does behind a graze; another orbit stays apart.
    """
    cycles = stretch.options.autonomous
    far, same = (_FAR_CYCLE, _SAME_CYCLE) if cycles else (_FAR, _SAME)

    def apart(u: Floats) -> float:
        if cycles:
            stretch.set_parameter(here)
            return _apart_along(stretch, start.equations, u, looked)
        return _apart(stretch, start.equations, u, looked)

    first = apart(start.unknowns)
    stretch.set_parameter(here + _CLOSER * (start.value - here))
    solution = solve_orbit(start.equations, start.unknowns)
    found = solution.status == "completed"
    closer = apart(solution.unknowns) if found else np.inf
    stretch.set_parameter(start.value)
    return first <= far and closer <= max(2.0 * np.sqrt(_CLOSER) * first, same)


def _apart(stretch: BranchStretch, equations: OrbitEquations, u: Floats, looked: Looked) -> float:
    """Distance between two orbits where they begin, beside the size of the second one.

    That is its size between its events too: it may be at rest where it begins.
    """
    drifting = equations.drifting
    size = largest_along(stretch.equations, looked.turn).max()
    apart = np.where(drifting, 0.0, np.abs(equations.unpack(u).states[0] - looked.turn.states[0]))
    return float(apart.max() / max(float(size), 1e-300))


def _apart_along(
    stretch: BranchStretch, equations: OrbitEquations, u: Floats, looked: Looked
) -> float:  # fmt: skip
    """Largest distance of the states at the events of a cycle from another one, beside its size.

    And the difference of their lengths, beside the length. The other one is taken as a line of
    straight pieces, so less than 1e-4 is nothing.
    """
    new, old, turn = equations.unpack(u), stretch.equations, looked.turn
    count, drifting = len(old.word), equations.drifting
    legs = np.repeat(np.arange(count), _PLACES)
    parts = np.tile(np.linspace(0.0, 1.0, _PLACES), count)
    along = old.states_in_legs(turn, legs, turn.instants[legs] + parts * turn.durations[legs])
    along = np.where(drifting, 0.0, along)
    size = np.maximum(np.ptp(along, axis=0), 1e-300)
    points = np.where(drifting, 0.0, new.states) / size
    by_leg = along.reshape(count, _PLACES, -1) / size
    first, step = (
        each.reshape(-1, size.size) for each in (by_leg[:, :-1], np.diff(by_leg, axis=1))
    )
    away = points[:, None] - first
    part = (away * step).sum(axis=2) / np.maximum((step * step).sum(axis=1), 1e-300)
    distance = np.abs(away - np.clip(part, 0.0, 1.0)[..., None] * step).max(axis=2).min(axis=1)
    length = abs(float(np.ptp(new.instants) / np.ptp(turn.instants)) - 1.0)
    return max(float(distance.max()), length)
