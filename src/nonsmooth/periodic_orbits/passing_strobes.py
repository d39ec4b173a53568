"""Where an event passes a strobe within the turn of an orbit.

The states at that strobe jump there, although nothing happens to the orbit. So the orbit at which
the event is just at the strobe is told twice: with the state before the event, and behind it. A
driven orbit begins at a strobe. If an event passes that one, the word changes, and both stretches
have a point there anyway. Where a clock among the states shows the phase, orbits begin at an event,
and it may pass a strobe like any other.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from nonsmooth.continuation.point import Point
from nonsmooth.periodic_orbits.branch_tests import Looked
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.newton import solve_orbit
from nonsmooth.periodic_orbits.stretch import BranchStretch
from nonsmooth.periodic_orbits.strobes import strobes_of

__all__ = ["orbits_at_strobes"]

Floats = npt.NDArray[np.float64]

_NEAR = 0.25  # of a period: events that are farther from a strobe do not pass it in one step
_STAYS = 1e-9  # of a period, within which an event stays at a strobe
_ROUNDING = 1e-14  # part of the way between two orbits


class _Passage(NamedTuple):
    """An event that passes a strobe, and whether the strobe lies behind it at first."""

    share: float  # of the way between two orbits
    point: Point
    strobe: int
    behind: bool


def orbits_at_strobes(
    stretch: BranchStretch, before: tuple[Point, Looked], after: tuple[Point, Looked]
) -> list[tuple[Point, Looked]]:
    """Orbits between two of one word at which an event is at a strobe, in order, each twice."""
    equations = stretch.equations
    if equations.autonomous:
        return _at_strobes_of_clock(stretch, before, after)
    if equations.period == 1 or equations.word.n_events == 0:
        return []
    first, last = _ahead(before[1]), _ahead(after[1])
    passages = []
    for event, strobe in np.argwhere(first * last < 0.0).tolist():
        found = _passage(stretch, before[0], after[0], event, strobe)
        if found is not None:
            passages.append(found)
    told = []
    sides = {one.strobe: one.behind for one in reversed(_in_order(passages))}
    for one in _in_order(passages):
        try:
            looked = stretch.look(one.point)
            for behind in (one.behind, not one.behind):
                sides[one.strobe] = behind
                strobes = strobes_of(equations, looked.turn, sides)
                told.append((one.point, replace(looked, strobes=strobes)))
        except LegError:
            continue
    return told


def _at_strobes_of_clock(
    stretch: BranchStretch, before: tuple[Point, Looked], after: tuple[Point, Looked]
) -> list[tuple[Point, Looked]]:
    """The same where a clock shows the phase."""
    equations = stretch.equations
    if not (before[1].strobes.times.size == after[1].strobes.times.size > 0):
        return []
    first, last = (
        _ahead_by_clock(equations, looked.turn, looked.strobes.times)
        for looked in (before[1], after[1])
    )
    near = _NEAR * equations.legs.window
    crossed = (first * last < 0.0) & (np.maximum(np.abs(first), np.abs(last)) < near)
    # a clock that is set back at each strobe stays there but for rounding, and another event comes
    # there where the word changes
    crossed &= np.minimum(np.abs(first), np.abs(last)) > _STAYS * equations.legs.window
    found = [
        _passage(stretch, before[0], after[0], event, -1)
        for event in np.flatnonzero(crossed).tolist()
    ]
    told = []
    for event, one in zip(np.flatnonzero(crossed).tolist(), found, strict=True):
        if one is None:
            continue
        try:
            looked = stretch.look(one.point)
        except LegError:
            continue
        turn, times = looked.turn, looked.strobes.times
        away = _nearest(times - turn.instants[event], turn)
        strobe = int(np.argmin(np.abs(away)))
        told += [
            (one.share, one.point, replace(looked, strobes=strobes))
            for behind in (one.behind, not one.behind)
            for strobes in [strobes_of(equations, turn, {strobe: behind})]
        ]
    return [(point, looked) for _, point, looked in sorted(told, key=lambda each: each[0])]


def _ahead_by_clock(equations: OrbitEquations, turn: Turn, times: Floats) -> Floats:
    """By how much the nearest strobe comes behind each event, (legs,); nan where none is."""
    away = _nearest(times[None, :] - turn.instants[:-1, None], turn)
    found = away[np.arange(len(away)), np.argmin(np.abs(away), axis=1)]
    if not equations.word.closes_at_event:
        found[0] = np.nan
    return found


def _nearest(changes: Floats, turn: Turn) -> Floats:
    """Changes of time without whole turns."""
    length = float(turn.instants[-1] - turn.instants[0])
    return np.asarray(changes - length * np.rint(changes / length))


def _in_order(passages: list[_Passage]) -> list[_Passage]:
    return sorted(passages, key=lambda one: one.share)


def _ahead(looked: Looked) -> Floats:
    """By how much each strobe comes behind each event, (events, strobes), the first one left out.

    The orbit begins at that.
    """
    ahead = looked.strobes.times - looked.turn.instants[1:-1, None]
    ahead[:, 0] = 0.0
    return np.asarray(ahead)


def _passage(
    stretch: BranchStretch, before: Point, after: Point, event: int, strobe: int
) -> _Passage | None:
    """The orbit at which an event is at a strobe; None where it is not found between the two."""
    equations = stretch.equations
    found: dict[float, Floats] = {}

    def ahead(share: float) -> float:
        p = before.p + share * (after.p - before.p)
        stretch.set_parameter(p)
        solution = solve_orbit(equations, before.u + share * (after.u - before.u))
        if solution.status != "completed":
            raise LegError("there is no orbit between two of the branch")
        found[share] = solution.unknowns
        turn = equations.unpack(solution.unknowns)
        if equations.autonomous:
            times = strobes_of(equations, turn).times
            if not times.size:
                raise LegError("a clock shows no strobes between two orbits of the branch")
            return float(_ahead_by_clock(equations, turn, times)[event])
        return float(_strobe(equations, strobe) - turn.instants[event + 1])

    try:
        begin = ahead(0.0)
        share = brentq(ahead, 0.0, 1.0, xtol=_ROUNDING, rtol=4.0 * np.finfo(float).eps)
        ahead(share)
    except (LegError, ValueError):  # as where both orbits fall together, behind a fold
        return None
    length = before.arclength + share * (after.arclength - before.arclength)
    p = before.p + share * (after.p - before.p)
    point = replace(before, u=found[share], p=p, arclength=length, special="")
    return _Passage(share, point, strobe, begin > 0.0)


def _strobe(equations: OrbitEquations, number: int) -> float:
    """Time of a strobe of a driven orbit, for the parameters of its legs."""
    return (equations.phase + number) * equations.legs.window
