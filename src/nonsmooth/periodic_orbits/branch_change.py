"""How a branch of orbits goes on where its word stops being valid, or why it ends there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.point import Point
from nonsmooth.errors import RunError
from nonsmooth.periodic_orbits.admissibility import Admissibility
from nonsmooth.periodic_orbits.branch_part import BranchPart, Followed, kind_of, part_of
from nonsmooth.periodic_orbits.branch_start import (
    REGULAR,
    before_graze,
    begin_change,
    goes_on,
    nearest_behind,
    tangent_at,
)
from nonsmooth.periodic_orbits.branch_tests import (
    BranchTests,
    Looked,
    broken_tests,
    largest_along,
    what_of,
)
from nonsmooth.periodic_orbits.cycle_beyond import apart_from_cycle, cycles_beyond
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess, driven_guess
from nonsmooth.periodic_orbits.in_words import in_words
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.newton import solve_orbit
from nonsmooth.periodic_orbits.onto import chatters
from nonsmooth.periodic_orbits.stretch import BranchStart, BranchStretch
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.periodic_orbits.word_change import (
    Change,
    changes_at_once,
    changes_of_word,
    vanishing_leg,
)
from nonsmooth.system.system import System

__all__ = ["SHRINKS", "broken_test", "change_at", "end_at", "past_rebounds"]

Floats = npt.NDArray[np.float64]

_AT_SECTION = ("leg:0", "leg:last")
_BEYOND = 1e-6  # of the range of the parameter: an impact at the section is on one side of it there
_INSIDE = 1e-9  # of the way to the middle of an orbit, which is forgotten at rest
_SHORT = 1e-3  # of the turn: flights at the section behind which no rebound counts by itself
_NEXT = (1e-7, 1e-6, 1e-5, 1e-4)  # of the range of the parameter
_ALIKE = 0.1  # part of the duration of a leg by which it differs there at most
_FARTHER = (1e-3, 2e-3, 5e-3, 1e-2, 2e-2)  # of the range of the parameter
_APPEARS = 1e-6  # part of the turn that a leg lasts where a branch with it begins
SHRINKS = "the cycle shrinks to a point"
_ENDS = {
    "rest": "rebounds end just at the release, and beyond it not before: rest is lost, and"
    " infinitely many orbits begin there",
    "shrink": SHRINKS,
    "slide": "both sides of a surface point at it: beyond, the motion stays there for a while",
    "enter": "the surface does not hold the motion any more: beyond, it leaves it at once",
}
_AT_BORDER = {
    "crossing_sliding": "ends where a surface is crossed at the border of the part that slides",
    "switching_sliding": "ends where the part of a surface that slides begins",
}
_MOST_TELLING = (
    "shrink",
    "rest",
    "slide",
    "short",
    "leg",
    "gain",
    "over",
    "enter",
    "graze",
    "rate",
    "corner",
)
_TOGETHER = 1e-6  # a test that vanishes at the same point as another one
_SLOW = 1e-6  # speed of an impact, beside what the guard comes to in a turn
_NEARBY = 1e-4  # of the size of an orbit: one of another word farther away is no continuation
_NEAR_CYCLE = 0.01  # of the size of a cycle: one farther away is another one
_SETTLED = (1e-6, 1e-5, 1e-4, 1e-3)  # of the range: where motions are let settle beyond a change
_TURNS = 100  # in which they settle
_BACK = 1e4  # times the step that tells how a test grows: to a change behind settled motions
_FAR = 0.05  # of the size of an orbit: motions that settle farther away are others
_CLOSER = 0.01  # part of the way to a change, over which an orbit that joins it comes closer
_SAME = 1e-7  # of the size of an orbit: as close as it can come

# how a branch goes on, and the point there if it is special
_WayOn = tuple[BranchStart, BranchPart | None]


def _motion_at(stretch: BranchStretch, looked: Looked, value: float) -> Guess | None:
    """Legs of the motion from an orbit; None where nothing drives the system.

    It begins in the cell of the orbit where that admits it: a state that has decayed to a border
    of cells lies in several of them.
    """
    running = stretch.options.system.structure.running
    cell = running[stretch.equations.word.modes[0]].name
    first = looked.turn.states[0]
    found = _motion_from(stretch, first, value, 0, cell)
    return found or _motion_from(stretch, first, value, 0)


def _motion_from(
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


def _over_last_rebounds(stretch: BranchStretch, looked: Looked, point: Point) -> BranchStart | None:
    """The same orbit a little beyond, where the section passes the last rebounds, or comes to them.

    They are so short that the next ones follow at once.
    """
    word = stretch.equations.word
    if point.special not in _AT_SECTION:
        return None
    if _section_in_chatter(stretch, word):
        return _over_chatter(stretch, looked, point) if _is_short(looked.turn) else None
    found = chatters(word.modes, word.paths, stretch.legs.tables.wiring)
    if point.special != "leg:last" or all(legs[-1] != len(word) - 2 for legs in found):
        return None  # it is not rest that begins at the section
    return _farther(stretch, looked, point, lambda guess: not _is_short(guess.turn))


def _is_short(turn: Turn) -> bool:
    """Whether the flight over the section is one of the last."""
    flight = float(turn.durations[0] + turn.durations[-1])
    return flight <= _SHORT * float(turn.durations.sum())


def _over_chatter(stretch: BranchStretch, looked: Looked, point: Point) -> BranchStart | None:
    """The same orbit a little beyond, where the section does not lie within its rebounds any more.

    Infinitely many of them pass the section while the parameter changes by little. The motion comes
    to rest in every turn, so it is on the orbit after one.
    """
    if not _section_in_chatter(stretch, stretch.equations.word):
        return None
    return _farther(
        stretch, looked, point, lambda guess: not _section_in_chatter(stretch, guess.word)
    )


def _farther(
    stretch: BranchStretch, looked: Looked, point: Point, done: Callable[[Guess], bool]
) -> BranchStart | None:
    """The same orbit beyond, as far as it takes or as it may be."""
    low, high = stretch.options.bounds
    found: tuple[Guess, float] | None = None
    for part in _FARTHER:
        value = point.p + _way(point) * part * (high - low)
        guess = _same_motion_at(stretch, looked, value)
        if guess is None:  # as behind a bound
            break
        found = guess, value
        if done(guess):
            break
    return None if found is None else _start(stretch, *found, point)


def _within_chatter(stretch: BranchStretch, looked: Looked, point: Point) -> BranchStart | None:
    """The same orbit with other rebounds, where a test has changed its sign within them.

    The last ones are so short that the equations confuse them with none at all. Where an impact
    just passes the section, the engine would find it on either side there, so it is asked beyond.
    """
    word = stretch.equations.word
    name, *numbers = point.special.split(":")
    found = chatters(word.modes, word.paths, stretch.legs.tables.wiring)
    legs = {k for each in found for k in each}
    if name != "motion" and not (numbers and numbers[0].isdigit() and int(numbers[0]) in legs):
        return None
    if not found:
        return None
    value = point.p
    if point.special in _AT_SECTION:
        low, high = stretch.options.bounds
        value += _way(point) * _BEYOND * (high - low)
    guess = _same_motion_at(stretch, looked, value)
    if guess is None or guess.word == word:
        return None
    return _start(stretch, guess, value, point)


def past_rebounds(stretch: BranchStretch, looked: Looked, point: Point) -> BranchStart | None:
    """The same orbit a little beyond, where no step succeeds although nothing happens to it.

    Rounding of the last rebounds before rest may let none succeed. That the motion has the others
    there, of the same durations, tells that it is the same orbit.
    """
    word = stretch.equations.word
    if _section_in_chatter(stretch, word):
        return None
    low, high = stretch.options.bounds
    here = _durations(stretch, Guess(word, looked.turn))
    for part in _NEXT if here else ():
        value = point.p + _way(point) * part * (high - low)
        stretch.set_parameter(point.p)
        guess = _same_motion_at(stretch, looked, value)
        if guess is None or _section_in_chatter(stretch, guess.word):
            return None
        there = _durations(stretch, guess)
        if len(here) != len(there) or any(map(_are_apart, here, there)):
            return None
        start = _start(stretch, guess, value, point)
        if start is not None and goes_on(stretch, replace(start, kind="")):
            return start
    return None


def _durations(stretch: BranchStretch, guess: Guess) -> list[Floats]:
    """Durations of rebounds before each rest, and of what lies between; without those of rest.

    Rest begins where the last rebound that is followed ends. Nothing where there is no such rest.
    """
    word, (_, turn) = guess.word, guess
    found, begin = [], 0
    for legs in chatters(word.modes, word.paths, stretch.legs.tables.wiring):
        found += [turn.durations[begin : legs[0]], turn.durations[legs]]
        begin = legs[-1] + 2
    return [*found, turn.durations[begin:]] if found else []


def _are_apart(these: Floats, those: Floats) -> bool:
    """Whether durations differ, as far as both go on."""
    count = min(these.size, those.size)
    these, those = these[:count], those[:count]
    return bool(np.any(np.abs(these - those) > _ALIKE * np.abs(these)))


def _same_motion_at(stretch: BranchStretch, looked: Looked, value: float) -> Guess | None:
    """What the motion is after a turn in which it rests, if its modes are those of the orbit."""
    states = looked.turn.states
    guess = _motion_from(stretch, states[0], value, 1)
    if guess is None:  # an impact at the section may lie behind the wall by rounding
        inside = states[0] + _INSIDE * (states.mean(axis=0) - states[0])
        guess = _motion_from(stretch, inside, value, 1)
    return guess if guess is not None and _differs_in_rebounds(stretch, guess.word) else None


def _differs_in_rebounds(stretch: BranchStretch, word: Word) -> bool:
    """Whether a word has the modes of the orbit, but for how many rebounds before rest it shows."""
    system = stretch.options.system
    return _cycle(word, system) == _cycle(stretch.equations.word, system)


def _start(stretch: BranchStretch, guess: Guess, value: float, point: Point) -> BranchStart | None:
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
    sign = 1.0 if dp * _way(point) >= 0.0 else -1.0
    return BranchStart(equations, solution.unknowns, value, (sign * du, sign * dp), kind="section")


def _way(point: Point) -> float:
    return float(np.sign(point.tangent_p) or 1.0)


def _section_in_chatter(stretch: BranchStretch, word: Word) -> bool:
    """Whether an orbit begins between rebounds."""
    found = chatters(word.modes, word.paths, stretch.legs.tables.wiring)
    return any(len(word) - 1 in legs or legs[0] == 0 for legs in found)


def _cycle(word: Word, system: System) -> tuple[int, ...]:
    """Modes that events lead to in a turn, from wherever they come first in order."""
    modes = word.collapsed(system.compiled.program.wiring).modes
    turn = modes if word.closes_at_event else modes[:-1]
    if not turn:  # no event is passed
        return ()
    return min(turn[k:] + turn[:k] for k in range(len(turn)))


def change_at(
    stretch: BranchStretch, point: Point, looked: Looked, along: float
) -> tuple[BranchStart | None, BranchPart | None]:
    """How a branch goes on behind a change of its word, and the point there if it is special."""
    ways = [
        _with_other_rebounds,
        _by_change_of_word,
        _by_motion_beyond,
        _by_settled_motion,
        _by_cycle_beyond,
    ]
    # of infinitely many orbits that begin where rest ends none is the nearest one
    for way_on in [] if what_of(point.special) == "rest" else ways:
        found = way_on(stretch, point, looked, along)
        if found is not None:
            return found
    name = point.special
    detail = _ENDS.get(what_of(name), "no orbit of a changed word begins there")
    return None, part_of(stretch, looked, point, along, kind_of(name), detail)


def _with_other_rebounds(
    stretch: BranchStretch, point: Point, looked: Looked, along: float
) -> _WayOn | None:
    """The same orbit, of which other rebounds before rest are followed."""
    for same_orbit in (_over_last_rebounds, _within_chatter):
        stretch.set_parameter(point.p)  # the other one may have left it beyond
        start = same_orbit(stretch, looked, point)
        if start is not None:
            return start, part_of(stretch, looked, point, along, "section", "")
    return None


def _by_change_of_word(
    stretch: BranchStretch, point: Point, looked: Looked, along: float
) -> _WayOn | None:
    """The orbit of a word to which the test leads that has vanished."""
    name = _what_happens(looked, point)
    hidden = name != point.special
    stretch.set_parameter(point.p)
    changes = changes_at_once(stretch.equations, looked.turn, _vanishing(looked, name))
    for change in [*changes, *changes_of_word(stretch.equations, looked.turn, name)]:
        passes = change.kind == "section"  # an event passes it, which is no special point
        start = _over_chatter(stretch, looked, point) if passes else None
        start = start or begin_change(stretch, change, point)
        if start is None:
            continue
        if passes:
            return start, part_of(stretch, looked, point, along, "section", "")
        leg = vanishing_leg(stretch.equations, looked.turn, name)
        start.detail = _detail(stretch, leg, start, point)
        loses_leg = change.opens < 0 and len(start.equations.word) < len(stretch.equations.word)
        touched = _touched(stretch, start) if hidden or loses_leg else ""
        if touched:  # the change is located from the other side, where no leg lasts no time
            before = before_graze(stretch, start, touched)
            if before is not None:
                return before, None
        return start, part_of(stretch, looked, point, along, change.kind, start.detail)
    return None


def _by_motion_beyond(
    stretch: BranchStretch, point: Point, looked: Looked, along: float
) -> _WayOn | None:
    """The orbit near this one on which the engine comes a little beyond."""
    name = _what_happens(looked, point)
    for change in _changes_beyond(stretch, looked, replace(point, special=name)):
        start = begin_change(stretch, change, point)
        if start is None or not _is_near(stretch, start, looked):
            continue
        if name == "motion" and _differs_in_rebounds(stretch, start.equations.word):
            start.kind = "section"  # nothing happens but that another number is followed
            return start, part_of(stretch, looked, point, along, "section", "")
        start.detail = _detail(stretch, name, start, point)
        if _rests(stretch, start.equations.word) and not _rests(stretch, stretch.equations.word):
            located = _located_behind(stretch, start, point)
            if located is not None:
                return located, None
        # at the change itself both words stand, whatever rounding lets the engine find
        stands = replace(looked, admissibility=Admissibility(True))
        return start, part_of(stretch, stands, point, along, kind_of(name), start.detail)
    return None


def _rests(stretch: BranchStretch, word: Word) -> bool:
    """Whether rebounds of an orbit end in rest."""
    return bool(chatters(word.modes, word.paths, stretch.legs.tables.wiring))


def _by_settled_motion(
    stretch: BranchStretch, point: Point, looked: Looked, along: float
) -> _WayOn | None:
    """The orbit that motions a little beyond settle to, if it comes to this one at the change."""
    name = _what_happens(looked, point)
    low, high = stretch.options.bounds
    for part in _SETTLED:
        for way in (_way(point), -_way(point)):
            value = point.p + way * part * (high - low)
            guess = _motion_from(stretch, looked.turn.states[0], value, _TURNS)
            back = abs(value - point.p) if way != _way(point) else None
            if guess is None or _is_known(stretch, guess.word, value, back):
                continue
            start = _start(stretch, guess, value, replace(point, tangent_p=way))
            if start is None or not (
                _joins(stretch, start, looked, point.p) and goes_on(stretch, start)
            ):
                continue
            start.kind = kind_of(name)
            start.detail = _detail(stretch, name, start, point)
            located = _located_behind(stretch, start, point)
            if located is not None:
                return located, None
            stands = replace(looked, admissibility=Admissibility(True))
            return start, part_of(stretch, stands, point, along, start.kind, start.detail)
    return None


def _by_cycle_beyond(
    stretch: BranchStretch, point: Point, looked: Looked, along: float
) -> _WayOn | None:
    """A cycle to which the motion from this one comes back beside the change, if it joins it.

    The motion has not settled, so its word may be that of the orbit on the other side.
    """
    (low, high), way = stretch.options.bounds, _way(point)
    for part in _SETTLED:
        values = [point.p + sign * part * (high - low) for sign in (way, -way)]
        found = [g for value in values for g in cycles_beyond(stretch, looked.turn, point.p, value)]
        guesses = {guess.word: guess for guess in reversed(found)}
        for value, guess in product(values, guesses.values()):
            back = abs(value - point.p) if value == values[1] else None
            if _is_known(stretch, guess.word, value, back):
                continue
            start = _start(stretch, guess, value, replace(point, tangent_p=value - point.p))
            if start is None or not (
                _stands(stretch, start)
                and _joins_cycle(stretch, start, looked, point.p)
                and goes_on(stretch, start)
            ):
                continue
            start.kind = kind_of(point.special)
            start.detail = _detail(stretch, point.special, start, point)
            stands = replace(looked, admissibility=Admissibility(True))
            return start, part_of(stretch, stands, point, along, start.kind, start.detail)
    return None


def _stands(stretch: BranchStretch, start: BranchStart) -> bool:
    """Whether the orbit of a start is a motion there, and behind no test of its word."""
    stretch.set_parameter(start.value)
    looked = BranchTests(start.equations, stretch.options.tolerance).look(start.unknowns)
    return looked.admissibility.admissible and not broken_tests(looked)


def _joins_cycle(stretch: BranchStretch, start: BranchStart, looked: Looked, value: float) -> bool:
    """Whether a cycle beside a change comes to that of the change with the parameter."""
    here = apart_from_cycle(stretch, looked.turn, value, start.equations, start.unknowns)
    stretch.set_parameter(value + _CLOSER * (start.value - value))
    solution = solve_orbit(start.equations, start.unknowns)
    closer = np.inf
    if solution.status == "completed":
        unknowns = solution.unknowns
        closer = apart_from_cycle(stretch, looked.turn, value, start.equations, unknowns)
    stretch.set_parameter(start.value)
    return here <= _NEAR_CYCLE and closer <= max(2.0 * np.sqrt(_CLOSER) * here, _NEARBY)


def _located_behind(
    stretch: BranchStretch, start: BranchStart, point: Point
) -> BranchStart | None:  # fmt: skip
    """The start before the change of its own word, from which that is located.

    Orbits whose motions rebound without end change their words without end just before they come to
    rest, and the last change that they tell is not the one behind which they rest. That lies
    between the last change and the start.
    """
    stretch.set_parameter(start.value)
    name = nearest_behind(stretch, start)
    before = before_graze(stretch, start, name, _BACK) if name else None
    if before is None:
        return None
    # the change lies half way back, as far as it is linear; rest can only end behind the last one
    half = 0.5 * (before.value + start.value)
    if what_of(name) != "rest" and (half - point.p) * (start.value - point.p) <= 0.0:
        return None
    system, word = stretch.options.system, start.equations.word
    way_on = start.detail.rpartition("; ")[2]
    return replace(before, kind=kind_of(name), detail=f"{in_words(system, word, name)}; {way_on}")


def _is_known(stretch: BranchStretch, word: Word, value: float, back: float | None) -> bool:
    """Whether a word is that of the stretch, or, behind a change, of steps past the same value.

    ``back`` is the distance from the change on the side that the branch comes from. A word that it
    had elsewhere may well begin there: between two grazes a resonance comes from the motion
    without contact and goes back to it.
    """
    known = [stretch.equations.word]
    if back is not None:
        known += [each for each in stretch.trail.words if stretch.trail.passes(each, value, back)]
    system = stretch.options.system
    return _cycle(word, system) in {_cycle(each, system) for each in known}


def _what_happens(looked: Looked, point: Point) -> str:
    """What a point is special by: a slow impact where the engine only finds another motion.

    The engine takes an impact for a graze that reaches behind its guard by rounding only, the
    square of its speed.
    """
    if point.special != "motion":
        return point.special
    rates = {name: value for name, value in looked.tests.items() if what_of(name) == "rate"}
    least = min(rates, key=lambda name: rates[name], default="")
    return least if least and abs(rates[least]) <= _SLOW else point.special


def _touched(stretch: BranchStretch, start: BranchStart) -> str:
    """Test of the change behind which a stretch begins; "" where none has its zero there.

    Of two guards that are touched together, and of one that is touched just at the section, only
    one or none has a lowest value within a leg.
    """
    stretch.set_parameter(start.value)
    tests = BranchTests(start.equations, stretch.options.tolerance, whole=False, grows=start.grows)
    found = tests.look(start.unknowns).tests
    grazes = {name: value for name, value in found.items() if what_of(name) == "graze"}
    if start.grows in found and what_of(start.grows) in REGULAR:
        return start.grows
    least = min(grazes, key=lambda name: grazes[name], default="")
    return least if least and grazes[least] < 0.0 else ""


def _vanishing(looked: Looked, name: str) -> list[str]:
    """Tests of the kind of this one that vanish at the same point; none where it is alone."""
    if name in ("motion", *_AT_SECTION):
        return []
    kind = what_of(name)
    found = [
        other
        for other, value in looked.tests.items()
        if what_of(other) == kind and (other == name or abs(value) <= _TOGETHER)
    ]
    return found if len(found) > 1 else []


def _joins(stretch: BranchStretch, start: BranchStart, looked: Looked, value: float) -> bool:
    """Whether an orbit beside a change comes to that of the change with the parameter.

    At the root of the distance at least, as it does behind a graze; another orbit stays apart.
    """
    equations = start.equations
    here = _apart(stretch, equations, start.unknowns, looked)
    stretch.set_parameter(value + _CLOSER * (start.value - value))
    solution = solve_orbit(equations, start.unknowns)
    stretch.set_parameter(start.value)
    if solution.status != "completed":
        return False
    closer = _apart(stretch, equations, solution.unknowns, looked)
    return here <= _FAR and closer <= max(2.0 * np.sqrt(_CLOSER) * here, _SAME)


def _is_near(stretch: BranchStretch, start: BranchStart, looked: Looked) -> bool:
    """Whether an orbit of another word begins where this one is, and not somewhere else."""
    return _apart(stretch, start.equations, start.unknowns, looked) <= _NEARBY


def _apart(stretch: BranchStretch, equations: OrbitEquations, u: Floats, looked: Looked) -> float:
    """Distance between two orbits where they begin, beside the size of the second one.

    That is its size between its events too: it may be at rest where it begins.
    """
    drifting = equations.drifting
    size = largest_along(stretch.equations, looked.turn).max()
    apart = np.where(drifting, 0.0, np.abs(equations.unpack(u).states[0] - looked.turn.states[0]))
    return float(apart.max() / max(float(size), 1e-300))


def _changes_beyond(stretch: BranchStretch, looked: Looked, point: Point) -> Iterator[Change]:
    """What the engine finds a little beyond, as changes to try."""
    kind = kind_of(point.special)
    for guess in _motions_beyond(stretch, looked, point):
        durations = guess.turn.durations
        k, length = int(np.argmin(durations)), float(durations.sum())
        if len(guess.word) > len(stretch.equations.word) and durations[k] < _APPEARS * length:
            # a leg that has just appeared: that it lasts no time may solve the equations too
            yield Change(kind, guess, "", k, _APPEARS * length)
        yield Change(kind, guess)


def _motions_beyond(stretch: BranchStretch, looked: Looked, point: Point) -> Iterator[Guess]:
    """What the motion from the orbit does a little beyond, where there is a period to look at."""
    low, high = stretch.options.bounds
    for way in (_way(point), -_way(point)):
        guess = _motion_at(stretch, looked, point.p + way * _BEYOND * (high - low))
        if guess is not None and guess.word != stretch.equations.word:
            yield guess


def _detail(stretch: BranchStretch, name: str, start: BranchStart, point: Point) -> str:
    """What happens in words: which guard or leg, and whether the parameter turns back."""
    word, system = stretch.equations.word, stretch.options.system
    what = in_words(system, word, name)
    if start.kind == "border_collision":
        what = in_words(system, word, name.replace("corner", "border"))
    elif start.kind in _AT_BORDER:
        kind, *numbers = name.split(":")
        k = int(numbers[0]) if numbers and numbers[0].isdigit() else 0
        k -= kind in ("leg", "rate") and k > 0
        what = f"leg {k + 1} ({system.mode_names[word.modes[k]]}) {_AT_BORDER[start.kind]}"
    # at the border of what slides an orbit is there on either side
    # where an impact has no speed the parameter may change with the square of what does
    before = stretch.trail.way(word) or point.tangent_p
    behind = start.way or start.direction[1]
    turns = start.kind not in _AT_BORDER and before * behind < 0.0
    way = "the branch turns back" if turns else "the branch goes on"
    return f"{what}; {way} as '{start.equations.word.text(system)}'"


def end_at(name: str, looked: Looked, stretch: BranchStretch) -> Followed:
    """Why a branch ends at a change of its word behind which it does not go on."""
    kind = what_of(name)
    if _is_held(stretch, name):
        return Followed(
            kind_of(name),
            f"the branch ends ({kind_of(name)}): the surface there holds what touches it until the"
            " force has grown, so motions beyond are another orbit; find it with find_orbit at"
            " parameters= a little beyond",
        )
    if kind in _ENDS:
        return Followed(kind_of(name), f"the branch ends: {_ENDS[kind]}")
    reason = looked.admissibility.reason
    if not reason and kind != "motion":
        reason = in_words(stretch.options.system, stretch.equations.word, name)
    where = f"{stretch.options.parameter} = {looked.values[stretch.place]:.6g}"
    return Followed(
        kind_of(name),
        f"the branch ends at {where}, where its word stops being valid ({kind_of(name)}"
        + (f": {reason}" if reason else "")
        + "), and no orbit of a changed word goes on from there; inadmissible=True follows the"
        " equations of the word beyond",
    )


def _is_held(stretch: BranchStretch, name: str) -> bool:
    """Whether what happens is at a surface that holds more than it resists with in sliding."""
    kind, *numbers = name.split(":")
    if kind not in ("graze", "rate", "enter") or not numbers:
        return False
    word, k = stretch.equations.word, int(numbers[0])
    e = int(numbers[1]) if kind == "graze" else word.paths[k][0]
    return int(stretch.legs.tables.wiring.exits["onto"][word.modes[k], e]) == e


def broken_test(looked: Looked) -> str:
    """The test behind whose zero an orbit lies that was passed without being located.

    Where an excursion vanishes the equations are nearly singular, and the search may fail there.
    """
    for kind in _MOST_TELLING:
        for name, value in looked.tests.items():
            if what_of(name) == kind and value < 0.0:
                return name
    return "motion"
