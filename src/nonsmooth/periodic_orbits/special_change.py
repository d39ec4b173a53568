"""How a curve of special points goes on where the word of its orbits changes.

A graze is located from its regular side, as on a branch: on the other side a short excursion
changes multipliers by as much as it lasts, and a curve of flips that meets a curve of grazes
touches it there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.extended import Held
from nonsmooth.continuation.point import Point
from nonsmooth.errors import NonsmoothError
from nonsmooth.periodic_orbits.branch_tests import BranchTests, Looked
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.newton import scale_of
from nonsmooth.periodic_orbits.special_condition import CurveStart, SpecialCondition
from nonsmooth.periodic_orbits.touches import Change
from nonsmooth.periodic_orbits.word_change import changes_of_word

__all__ = ["CurvePiece", "pieces_behind"]

Floats = npt.NDArray[np.float64]

_SHORTER = (0.1, 0.01, 1.0)  # parts of the usual duration of an excursion: short ones are nearer
_SAME = 1e-5  # of a test: it vanishes at the change too
_FIRST_STEPS = 2  # by which a new word is tried
_AT_CHANGE = 1e-9  # of a test: it vanishes here
_STEPS_BACK = 40  # to where a change is located
_SMALL = 1e-6  # scaled step that tells which way a test grows


@dataclass(frozen=True)
class CurvePiece:
    """A part of a curve with one word; ``located`` is the change where it is known from there."""

    condition: SpecialCondition
    start: CurveStart
    located: Point | None = None


def pieces_behind(
    condition: SpecialCondition, point: Point, looked: Looked, test: str
) -> Iterator[CurvePiece]:
    """Curves of the same condition on which orbits of a changed word are motions."""
    condition.set_parameters(float(point.u[-1]), point.p)
    for change in changes_of_word(condition.equations, looked.turn, test):
        for piece in _pieces(condition, change, point):
            if _goes_on(piece):
                yield piece


def _pieces(condition: SpecialCondition, change: Change, point: Point) -> Iterator[CurvePiece]:
    """Curves of the same condition that begin with a changed word."""
    equations = condition.equations.of_word(change.guess.word, change.guess.turn.states[0])
    p, q = float(point.u[-1]), point.p
    for test in _tests_of_change(condition, equations, change, p, q):
        new = SpecialCondition(condition.asked, condition.legs, equations, test)
        for part in _SHORTER if change.opens >= 0 else (1.0,):
            piece = _piece(new, change, part, point)
            if piece is not None:
                yield piece


def _piece(
    condition: SpecialCondition, change: Change, part: float, point: Point
) -> CurvePiece | None:
    """The curve from the change on, with an excursion of a part of its first duration."""
    equations, turn = condition.equations, change.guess.turn
    p, q = float(point.u[-1]), point.p
    for held in _coordinates(condition, change):
        guess = _shortened(turn, change, part) if change.opens >= 0 else turn
        try:
            found = condition.point_near(equations.pack(guess), p, q, held)
            if found is None:
                continue
            start = _located_start(condition, change, found)
            if start is None:
                way = 1.0 if change.opens >= 0 else _way(condition, change, found, point)
                start = CurvePiece(condition, _start(found, way))
        except (LegError, NonsmoothError):
            continue
        return start
    return None


def _coordinates(condition: SpecialCondition, change: Change) -> list[Floats]:
    """What is held to come to the curve: the duration of an excursion, or a parameter."""
    size = condition.equations.size
    held = np.zeros((2, size + 2))
    if change.opens < 0:
        held[0, -1], held[1, -2] = 1.0, 1.0
        return list(held)
    first = len(condition.equations.word) * condition.legs.n - 1  # column of instant j is first + j
    held[0, first + change.opens], held[0, first + change.opens + 1] = -1.0, 1.0
    return [held[0]]


def _shortened(turn: Turn, change: Change, part: float) -> Turn:
    instants = turn.instants.copy()
    less = 0.5 * (1.0 - part) * change.duration
    instants[change.opens] += less
    instants[change.opens + 1] -= less
    return Turn(turn.states, instants)


def _start(found: Held, way: float) -> CurveStart:
    du, dq = found.direction
    return CurveStart(found.u, found.p, found.q, (way * du, way * dq))


def _located_start(condition: SpecialCondition, change: Change, found: Held) -> CurvePiece | None:
    """The curve from the change itself on, as the new word knows it; None where it knows none."""
    if change.opens >= 0 or not change.grows:
        return None
    condition.set_parameters(found.p, found.q)
    tests = BranchTests(
        condition.equations, condition.asked.options.tolerance, whole=False, grows=change.grows
    )
    here = tests.look(found.u).tests.get(change.grows, np.nan)
    nearest: tuple[Point, float] | None = None
    for way in (1.0, -1.0) if abs(here) > _AT_CHANGE else ():
        for each in condition.curve(_start(found, way), _STEPS_BACK, grows=change.grows):
            if nearest is not None and each.arclength >= nearest[0].arclength:
                break
            if each.special == change.grows:
                nearest = each, 1.0 if here < 0.0 else -1.0
                break
    if nearest is None:
        return None
    at, way = nearest
    direction = way * at.tangent_u, way * at.tangent_p
    return CurvePiece(condition, CurveStart(at.u[:-1], float(at.u[-1]), at.p, direction), at)


def _tests_of_change(
    condition: SpecialCondition, equations: OrbitEquations, change: Change, p: float, q: float
) -> Iterator[str]:
    """Names that the test of a condition may have for a changed word, whose legs are others."""
    kind, *numbers = condition.test.split(":")
    if not numbers:
        yield condition.test
        return
    unknowns = equations.pack(change.guess.turn)
    for k in range(len(equations.word)):
        name = ":".join([kind, str(k), *numbers[1:]])
        condition.set_parameters(p, q)
        tests = BranchTests(equations, condition.asked.options.tolerance, whole=False, grows=name)
        try:
            value = tests.look(unknowns).tests.get(name, np.nan)
        except LegError:
            continue
        if name != change.grows and abs(value) <= _SAME:
            yield name


def _way(condition: SpecialCondition, change: Change, found: Held, point: Point) -> float:
    """Sign of the direction in which the change opens up."""
    du, dq = found.direction
    options = condition.asked.options
    straight = 1.0 if dq * point.tangent_p >= 0.0 else -1.0
    if not change.grows:
        return straight
    (low, high), (lowest, highest) = condition.asked.first_bounds, options.bounds
    scale = np.append(scale_of(condition.equations, found.u), high - low)
    size = float(np.sqrt(np.mean((du / scale) ** 2))) + abs(dq) / (highest - lowest)
    tests = BranchTests(condition.equations, options.tolerance, whole=False, grows=change.grows)
    beside = []
    for way in (1.0, -1.0):
        h = way * _SMALL / max(size, 1e-300)
        condition.set_parameters(found.p + h * float(du[-1]), found.q + h * dq)
        there = tests.look(found.u + h * du[:-1]).tests
        beside.append(there.get(change.grows, np.nan))
    if beside[0] == beside[1] or not np.all(np.isfinite(beside)):
        return straight
    return 1.0 if beside[0] > beside[1] else -1.0


def _goes_on(piece: CurvePiece) -> bool:
    """Whether the first orbits of a changed word are motions, by the tests of the word too."""
    condition = piece.condition
    try:
        points = [
            point
            for point in condition.curve(piece.start, _FIRST_STEPS)
            if point.special in ("", "bound")
        ]
        looked = [condition.look(point) for point in points[1:]]
    except (LegError, NonsmoothError):
        return False
    return any(each.admissibility.admissible for each in looked)
