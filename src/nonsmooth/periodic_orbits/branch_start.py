"""Where a stretch of a branch begins, and in which direction; the branch that begins at a flip."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.follow import follow
from nonsmooth.continuation.point import Point
from nonsmooth.errors import NonsmoothError
from nonsmooth.periodic_orbits.branch_tests import BranchTests, is_of_word, what_of
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.family import member_of_family
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.newton import null_vector, row_scale, scale_of, solve_orbit
from nonsmooth.periodic_orbits.stretch import BranchOptions, BranchStart, BranchStretch, scale_along
from nonsmooth.periodic_orbits.touches import Change
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.runs.whole_turns import periods_of_states, whole_turns

__all__ = [
    "REGULAR",
    "before_graze",
    "begin_change",
    "doubled_start",
    "goes_on",
    "is_crossed",
    "nearest_behind",
    "passed_twice",
    "tangent_at",
]

Floats = npt.NDArray[np.float64]

REGULAR = ("graze", "corner", "slide", "enter", "rest")  # tests that are smooth where a leg begins
_SOLVED = 1e-7  # scaled residual of a start where the equations are singular
_ASTRAY = 1e-6  # of the size of an orbit that changes its word: as far from its guess as none is
_GAIN = 1e4  # of a residual: a solution that far from its guess is not better than that
_JUST_BEFORE = 1e-6  # of a test that is about to become positive
_ROUNDED = 1e-12  # of the scale of an equation: derivatives that are zero
_ZERO = 1e-6  # of the next singular value: one that is zero, but for rounding
_OFF = 1e-3  # of the range of the parameter: away from orbits that cross a branch
_NEWTON = 20
_SMALL = 1e-6  # scaled step that tells which way a test grows
_BEYOND = 1e-6  # of a test of the word that is negative at a start, more than rounding is
_SHORTER = (1.0, 0.1, 0.02)  # parts of the first duration of an excursion
_BEFORE = 2.0  # times the way to a graze, from which on it is located
_FARTHEST = 1e3  # times the step that tells how a test grows
_FIRSTS = (0.2, 0.02)  # parts of the first step by which a new word is tried
# part of the first step: shorter ones only succeed where legs that last no time solve anything
_LEAST = 2e-3


def tangent_at(equations: OrbitEquations, unknowns: Floats) -> tuple[Floats, float]:
    """Direction of the branch at an orbit, in unknowns and parameter."""
    du, dp, _ = _tangent(equations, unknowns)
    return du, dp


def _tangent(equations: OrbitEquations, unknowns: Floats) -> tuple[Floats, float, bool]:
    """The same, and whether orbits at one value of the parameter cross the branch there.

    Of the directions of both the one is taken in which the parameter changes most: where a symmetry
    is broken, the others are at a right angle to it.
    """
    _, jacobian, moved = equations.evaluate(unknowns)
    scale = scale_of(equations, unknowns)
    size = max(1.0, abs(float(moved[:, 0] @ moved[:, 0])) ** 0.5)
    matrix = np.column_stack([jacobian * scale, moved[:, 0] / size])
    weights = np.abs(matrix).max(axis=1, keepdims=True)
    _, sizes, vectors = np.linalg.svd(matrix / np.where(weights > 0.0, weights, 1.0))
    crosses = bool(sizes.size > 1 and sizes[-1] <= _ZERO * sizes[-2])
    free = vectors[-2:] if crosses else vectors[-1:]
    direction = free.T @ free[:, -1] if crosses else free[0]
    direction = direction / max(float(np.linalg.norm(direction)), 1e-300)
    return direction[:-1] * scale, float(direction[-1]) / size, crosses


def is_crossed(equations: OrbitEquations, unknowns: Floats) -> bool:
    """Whether orbits at one value of the parameter cross the branch, as a family of them does."""
    _, jacobian, moved = equations.evaluate(unknowns)
    scale = scale_of(equations, unknowns)
    rows = row_scale(equations, scale, jacobian)
    parts = np.column_stack([np.abs(jacobian) * scale, np.abs(moved[:, 0])]) / rows[:, None]
    if np.any(parts.max(axis=1) <= _ROUNDED):
        return True
    return _tangent(equations, unknowns)[2]


def begin_change(stretch: BranchStretch, change: Change, point: Point) -> BranchStart | None:
    """Start of the stretch behind a change; None where no motion of the new word begins there.

    An excursion that has changed once more when it is as long as it should be to begin with is
    tried at a shorter one.
    """
    for part in _SHORTER if change.opens >= 0 else (1.0,):
        shorter = replace(change, duration=part * change.duration)
        start = _begin_change(stretch, shorter, point)
        if start is not None:
            return start
    return None


def _begin_change(stretch: BranchStretch, change: Change, point: Point) -> BranchStart | None:
    """Start of the stretch behind a change with an excursion of its duration."""
    equations = stretch.equations.of_word(change.guess.word, change.guess.turn.states[0])
    try:
        unknowns, value = equations.pack(change.guess.turn), point.p
        stretch.set_parameter(value)
        if change.opens >= 0:
            found = _solve_opened(stretch, equations, unknowns, value, change)
        else:
            found = _solve(equations, unknowns, value)
        if found is None:
            return None
        unknowns, value = found
        stretch.set_parameter(value)
        du, dp, crosses = _tangent(equations, unknowns)
        way = _way(stretch, equations, unknowns, value, (du, dp), change, point)
        if crosses and change.kind == "section":
            unknowns, value = _off_crossing(stretch, equations, unknowns, value, (du, dp), way)
            before, (du, dp) = dp, tangent_at(equations, unknowns)
            way = way if dp * before >= 0.0 else -way
    except LegError:
        return None
    start = BranchStart(equations, unknowns, value, (way * du, way * dp), change.grows, change.kind)
    if change.opens >= 0 and _has_changed_again(stretch, start):
        return None
    return start if goes_on(stretch, start) else None


def _solve(
    equations: OrbitEquations, unknowns: Floats, value: float
) -> tuple[Floats, float] | None:
    """The orbit at this parameter; the guess itself where it is one and the equations singular.

    Of a family of orbits that solve them to rounding it is the nearest one.
    """
    solution = solve_orbit(equations, unknowns)
    away = np.abs((solution.unknowns - unknowns) / scale_of(equations, unknowns)).max()
    if not away <= _ASTRAY:
        member = member_of_family(equations, unknowns) if equations.autonomous else None
        guess = solve_orbit(equations, unknowns, steps=0)
        if member is None and guess.residual <= min(_SOLVED, away / _GAIN):
            return unknowns, value
        solution = member or solution
    if solution.status == "completed":
        return solution.unknowns, value
    return (solution.unknowns, value) if solution.residual <= _SOLVED else None


def _off_crossing(
    stretch: BranchStretch, equations: OrbitEquations, unknowns: Floats, value: float,
    direction: tuple[Floats, float], way: float,
) -> tuple[Floats, float]:  # fmt: skip
    """An orbit a little farther along the branch, where no others cross it; the same if none is.

    No equation says there which of them goes on.
    """
    (low, high), (du, dp) = stretch.options.bounds, direction
    along = way * _OFF * (high - low) / max(abs(dp), 1e-300)
    if low <= value + along * dp <= high:
        stretch.set_parameter(value + along * dp)
        found = solve_orbit(equations, unknowns + along * du)
        if found.status == "completed":
            return found.unknowns, value + along * dp
        stretch.set_parameter(value)
    return unknowns, value


def _solve_opened(
    stretch: BranchStretch,
    equations: OrbitEquations,
    unknowns: Floats,
    value: float,
    change: Change,
) -> tuple[Floats, float] | None:
    """The orbit with an excursion of the prescribed duration, at the parameter where it exists."""
    first = len(equations.word) * stretch.legs.n - 1  # column of instant j is first + j
    scale = scale_of(equations, unknowns)
    n = equations.size
    matrix, right = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
    for _ in range(_NEWTON):
        residual, jacobian, moved = equations.evaluate(unknowns)
        turn = equations.unpack(unknowns)
        matrix[:n, :n], matrix[:n, n] = jacobian, moved[:, 0]
        matrix[n] = 0.0
        for instant, sign in ((change.opens, -1.0), (change.opens + 1, 1.0)):
            if 1 <= instant <= equations.n_instants:
                matrix[n, first + instant] = sign
        right[:n], right[n] = residual, turn.durations[change.opens] - change.duration
        try:
            step = np.linalg.solve(matrix, -right)
        except np.linalg.LinAlgError:
            return None
        if not np.all(np.isfinite(step)):
            return None
        unknowns, value = unknowns + step[:n], value + float(step[n])
        stretch.set_parameter(value)
        if float(np.abs(step[:n] / scale).max()) <= 1e-10:
            inside = stretch.options.bounds[0] <= value <= stretch.options.bounds[1]
            return (unknowns, value) if inside else None
    return None


def _way(
    stretch: BranchStretch, equations: OrbitEquations, unknowns: Floats, value: float,
    direction: tuple[Floats, float], change: Change, point: Point,
) -> float:  # fmt: skip
    """Sign of the direction in which the change opens up."""
    du, dp = direction
    if change.opens >= 0:
        first = len(equations.word) * stretch.legs.n - 1
        instants = np.zeros(len(equations.word) + 1)
        instants[1 : 1 + equations.n_instants] = du[first + 1 :]
        rate = instants[change.opens + 1] - instants[change.opens]
        return 1.0 if rate > 0.0 else -1.0
    if not change.grows:
        return 1.0 if dp * point.tangent_p >= 0.0 else -1.0
    size = float(np.sqrt(np.mean((du / scale_of(equations, unknowns)) ** 2))) + abs(dp)
    tests = BranchTests(equations, stretch.options.tolerance, whole=False, grows=change.grows)
    found = []
    for way in (1.0, -1.0):
        h = way * _SMALL / max(size, 1e-300)
        stretch.set_parameter(value + h * dp)
        found.append(tests.look(unknowns + h * du).tests.get(change.grows, np.nan))
    stretch.set_parameter(value)
    if found[0] == found[1] or not np.all(np.isfinite(found)):
        return 1.0 if dp * point.tangent_p >= 0.0 else -1.0
    return 1.0 if found[0] > found[1] else -1.0


def goes_on(stretch: BranchStretch, start: BranchStart) -> bool:
    """Whether the first orbits of a new stretch are motions; they tell its way too.

    The word may change again after less than a first step, so shorter ones are tried.
    """
    return any(_goes_on(stretch, start, part) for part in _FIRSTS)


def _goes_on(stretch: BranchStretch, start: BranchStart, part: float) -> bool:
    """The same with steps of some part of the first one of a branch."""
    trial = BranchStretch(stretch.options, stretch.legs, start.equations, start.grows)
    step = part * stretch.options.step
    least = max(stretch.options.smallest_step, _LEAST * stretch.options.step)
    trial.set_parameter(start.value)
    try:
        branch = follow(
            trial.residual, start.unknowns, start.value, direction=start.direction, step=step,
            smallest_step=least, largest_step=step, steps=2,
            bounds=stretch.options.bounds, scale=scale_along(start.equations, start.unknowns),
            parameter_scale=stretch.options.bounds[1] - stretch.options.bounds[0],
        )  # fmt: skip
        points = [point for point in branch if point.special in ("", "bound")]
    except NonsmoothError:
        return False
    start.way = float(np.sign(points[-1].p - start.value)) if points else 0.0
    if stretch.trail.leads_back(start.equations.word, points):
        return False
    if stretch.options.inadmissible or start.kind == "section":  # where nothing happens to it
        return len(points) > 1
    return any(trial.look(point).admissibility.admissible for point in points[1:])


def _has_changed_again(stretch: BranchStretch, start: BranchStart) -> bool:
    """Whether the word has changed once more where an excursion has its first duration."""
    if stretch.options.inadmissible:
        return False
    stretch.set_parameter(start.value)
    tests = BranchTests(start.equations, stretch.options.tolerance, whole=False, grows=start.grows)
    return any(
        value < -_BEYOND
        for name, value in tests.look(start.unknowns).tests.items()
        if is_of_word(name) and what_of(name) != "short"
    )


def before_graze(
    stretch: BranchStretch, start: BranchStart, graze: str, farthest: float = _FARTHEST
) -> BranchStart | None:
    """The start of a stretch moved to before its graze, so that it is located from there.

    Where the branch turns back, the first orbit may lie behind it, by as little as the excursion
    lasted. None where no orbit before it is found.
    """
    equations, (du, dp) = start.equations, start.direction
    tests = BranchTests(equations, stretch.options.tolerance, whole=False, grows=graze)

    def lowest(unknowns: Floats, value: float) -> float:
        stretch.set_parameter(value)
        return tests.look(unknowns).tests.get(graze, np.nan)

    try:
        here = lowest(start.unknowns, start.value)
        if here <= 0.0:
            return replace(start, grows=graze, located=True)
        size = float(np.sqrt(np.mean((du / scale_of(equations, start.unknowns)) ** 2))) + abs(dp)
        h = _SMALL / max(size, 1e-300)
        rate = (lowest(start.unknowns + h * du, start.value + h * dp) - here) / h
        back = _BEFORE * here / rate if rate > 0.0 else np.nan
        if not back <= farthest * h:
            return None
        value = start.value - back * dp
        stretch.set_parameter(value)
        solution = solve_orbit(equations, start.unknowns - back * du)
        if solution.status != "completed" or not lowest(solution.unknowns, value) <= 0.0:
            return None
    except LegError:
        return None
    return replace(start, unknowns=solution.unknowns, value=value, grows=graze, located=True)


def nearest_behind(stretch: BranchStretch, start: BranchStart) -> str:
    """The test that was zero last, of those that are smooth where a stretch begins; "" for none.

    Or is so at once, where the stretch has been found to begin a little before.
    """
    equations, (du, dp) = start.equations, start.direction
    tests = BranchTests(equations, stretch.options.tolerance, whole=False)
    size = float(np.sqrt(np.mean((du / scale_of(equations, start.unknowns)) ** 2))) + abs(dp)
    h = _SMALL / max(size, 1e-300)
    found = []
    try:
        for step in (0.0, h):
            stretch.set_parameter(start.value + step * dp)
            found.append(tests.look(start.unknowns + step * du).tests)
    except LegError:
        return ""
    here, later = found
    back = {
        name: value / (later[name] - value)
        for name, value in here.items()
        if what_of(name) in REGULAR and name in later and later[name] > value > -_JUST_BEFORE
    }
    return min(back, key=lambda name: abs(back[name]), default="")


def _solved_start(
    options: BranchOptions, legs: Legs, guess: Guess, value: float, direction: Any
) -> BranchStart | None:
    """Start of a branch from a guess at a value of the parameter."""
    equations = OrbitEquations(
        legs, guess.word, period=options.period, phase=options.phase,
        autonomous=options.autonomous, origin=guess.turn.states[0],
        reference=guess.turn.states[0].copy(),
    )  # fmt: skip
    solution = solve_orbit(equations, equations.pack(guess.turn))
    if solution.status != "completed":
        return None
    tangent = tangent_at(equations, solution.unknowns)
    way = 1.0 if tangent[1] * direction >= 0.0 else -1.0
    return BranchStart(equations, solution.unknowns, value, (way * tangent[0], way * tangent[1]))


def doubled_start(options: BranchOptions, legs: Legs, guess: Guess, value: float) -> BranchStart:
    """Start on the doubled branch: the orbit passed twice, and the direction in which they differ.

    ``options`` have the period of the doubled orbit. At the flip the equations of the doubled
    orbit are singular; their null vector leads to it, the parameter being stationary there.
    """
    word, turn = passed_twice(options, legs, guess)
    equations = OrbitEquations(
        legs, word, period=options.period, phase=options.phase, autonomous=options.autonomous,
        origin=turn.states[0], reference=turn.states[0].copy(),
    )  # fmt: skip
    unknowns = equations.pack(turn)
    return BranchStart(equations, unknowns, value, (null_vector(equations, unknowns), 0.0))


def passed_twice(options: BranchOptions, legs: Legs, guess: Guess) -> Guess:
    """A turn passed twice, the legs standing for its parameter."""
    word, turn = guess
    length = float(turn.instants[-1] - turn.instants[0])
    ends = legs.follow(word, turn.states, turn.instants).nexts[-1]
    change = ends - turn.states[0]
    drifting = np.array([name in options.system.drift_states for name in options.system.states])
    shift = np.where(drifting, change, whole_turns(change, periods_of_states(options.system)))
    if word.closes_at_event:
        twice = Word(word.modes * 2, word.paths * 2)
        states = np.vstack([turn.states, turn.states + shift])
        instants = np.concatenate([turn.instants, turn.instants[1:] + length])
    else:
        # the last leg of the first turn and the first one of the second are one
        twice = Word(word.modes + word.modes[1:], word.paths[:-1] + word.paths)
        states = np.vstack([turn.states, turn.states[1:] + shift])
        instants = np.concatenate([turn.instants[:-1], turn.instants[1:] + length])
    return Guess(twice, Turn(states, instants))
