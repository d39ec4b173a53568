"""How a branch of orbits goes on where its word stops being valid, or why it ends there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.point import Point
from nonsmooth.periodic_orbits.admissibility import Admissibility
from nonsmooth.periodic_orbits.branch_part import BranchPart, Followed, kind_of, part_of
from nonsmooth.periodic_orbits.branch_start import (
    REGULAR,
    before_graze,
    begin_change,
    goes_on,
    nearest_behind,
)
from nonsmooth.periodic_orbits.branch_tests import (
    BranchTests,
    Looked,
    broken_tests,
    what_of,
)
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.in_words import in_words
from nonsmooth.periodic_orbits.motion_beyond import (
    is_near,
    joins,
    motion_at,
    motions_nearby,
    start_of,
    way_of,
)
from nonsmooth.periodic_orbits.onto import chatters
from nonsmooth.periodic_orbits.other_rebounds import (
    cycle_of,
    differs_in_rebounds,
    over_chatter,
    over_last_rebounds,
    within_chatter,
)
from nonsmooth.periodic_orbits.stretch import BranchStart, BranchStretch
from nonsmooth.periodic_orbits.touches import Change
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.periodic_orbits.word_change import (
    changes_at_once,
    changes_of_word,
    vanishing_leg,
)

__all__ = ["SHRINKS", "broken_test", "change_at", "end_at"]

Floats = npt.NDArray[np.float64]

_BEYOND = 1e-6  # of the range of the parameter: an impact at the section is on one side of it there
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
_NEARLY_GONE = 1e-4  # of the turn: a leg whose equations are nearly singular, as it vanishes
_SLOW = 1e-6  # speed of an impact, beside what the guard comes to in a turn
_NEARBY = (1e-6, 1e-5, 1e-4, 1e-3)  # of the range: how far from a change motions are looked at
_BACK = 1e4  # times the step that tells how a test grows: to a change behind settled motions

# how a branch goes on, and the point there if it is special
_WayOn = tuple[BranchStart, BranchPart | None]


def change_at(
    stretch: BranchStretch, point: Point, looked: Looked, along: float
) -> tuple[BranchStart | None, BranchPart | None]:
    """How a branch goes on behind a change of its word, and the point there if it is special."""
    ways = [
        _with_other_rebounds,
        _by_change_of_word,
        _by_motion_beyond,
        _by_motions_nearby,
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
    for same_orbit in (over_last_rebounds, within_chatter):
        stretch.set_parameter(point.p)  # the other one may have left it beyond
        start = same_orbit(stretch, looked, point)
        if start is not None:
            return start, part_of(stretch, looked, point, along, "section", "")
    return None


def _by_change_of_word(
    stretch: BranchStretch, point: Point, looked: Looked, along: float
) -> _WayOn | None:
    """The orbit of a word to which the test leads that has vanished."""
    name = _what_happens(stretch, looked, point)
    hidden = name != point.special
    stretch.set_parameter(point.p)
    changes = changes_at_once(
        stretch.equations, looked.turn, _vanishing(stretch.equations.word, looked, name)
    )
    for change in [*changes, *changes_of_word(stretch.equations, looked.turn, name)]:
        passes = change.kind == "section"  # an event passes it, which is no special point
        start = over_chatter(stretch, looked, point) if passes else None
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
    name = _what_happens(stretch, looked, point)
    for change in _changes_beyond(stretch, looked, replace(point, special=name)):
        start = begin_change(stretch, change, point)
        if start is None or not is_near(stretch, start, looked):
            continue
        if name == "motion" and differs_in_rebounds(stretch, start.equations.word):
            start.kind = "section"  # nothing happens but that another number is followed
            return start, part_of(stretch, looked, point, along, "section", "")
        start.detail = _detail(stretch, name, start, point)
        new, old = start.equations.word, stretch.equations.word
        begins_to_rest = _rests(stretch, new) and not _rests(stretch, old)
        # a word with fewer legs has none that are about to vanish
        if begins_to_rest or len(new) < len(old):
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


def _by_motions_nearby(
    stretch: BranchStretch, point: Point, looked: Looked, along: float
) -> _WayOn | None:
    """The orbit that motions beside the change come to, if it joins the one of the change."""
    name = _what_happens(stretch, looked, point)
    for value, guess in _beside(stretch, point, looked):
        behind = (value - point.p) * way_of(point) < 0.0
        if _is_known(stretch, guess.word, value, abs(value - point.p) if behind else None):
            continue
        start = start_of(stretch, guess, value, replace(point, tangent_p=value - point.p))
        if start is None or not (
            _stands(stretch, start)
            and joins(stretch, start, looked, point.p)
            and goes_on(stretch, start)
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


def _beside(stretch: BranchStretch, point: Point, looked: Looked) -> Iterator[tuple[float, Guess]]:
    """Orbits near a change with values of the parameter where they may be, the nearest first.

    One that is found on one side may be that of the other side.
    """
    low, high = stretch.options.bounds
    for part in _NEARBY:
        values = [point.p + way * part * (high - low) for way in (way_of(point), -way_of(point))]
        found = [
            each for value in values for each in motions_nearby(stretch, looked, point.p, value)
        ]
        guesses = {guess.word: guess for guess in reversed(found)}
        yield from product(values, guesses.values())


def _stands(stretch: BranchStretch, start: BranchStart) -> bool:
    """Whether the orbit of a start is a motion there, and behind no test of its word."""
    stretch.set_parameter(start.value)
    looked = BranchTests(start.equations, stretch.options.tolerance).look(start.unknowns)
    return looked.admissibility.admissible and not broken_tests(looked)


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
    half, away = 0.5 * (before.value + start.value), start.value - point.p
    if what_of(name) != "rest" and away != 0.0 and (half - point.p) * away <= 0.0:
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
    return cycle_of(word, system) in {cycle_of(each, system) for each in known}


def _what_happens(stretch: BranchStretch, looked: Looked, point: Point) -> str:
    """What a point is special by: a slow impact where the engine only finds another motion.

    The engine takes an impact for a graze that reaches behind its guard by rounding only, the
    square of its speed. It may pass the section there. Where a leg vanishes onto a surface on which
    motion slides, it is also at the border of what slides there, and has no speed; that it lasts no
    time solves its equations too, so that its speed may have any sign.
    """
    kind, *numbers = point.special.split(":")
    if kind in ("enter", "rate"):
        k = int(numbers[0])
        lasts, rate = (abs(looked.tests.get(f"{name}:{k}", 1.0)) for name in ("leg", "rate"))
        slow = rate <= lasts if kind == "enter" else _comes_from_surface(stretch, k)
        return f"leg:{k}" if slow and lasts <= _NEARLY_GONE else point.special
    if point.special != "motion" and not _at_section(stretch.equations.word, point.special):
        return point.special
    rates = {name: value for name, value in looked.tests.items() if what_of(name) == "rate"}
    least = min(rates, key=lambda name: rates[name], default="")
    return least if least and abs(rates[least]) <= _SLOW else point.special


def _comes_from_surface(stretch: BranchStretch, k: int) -> bool:
    """Whether leg k leaves the surface onto which it leads, and is no flight between impacts."""
    word, wiring = stretch.equations.word, stretch.legs.tables.wiring
    before = (k - 1) % len(word)
    if word.last_target(wiring, k) == word.modes[k] or not word.paths[before]:
        return False
    return not any(wiring.resets(word.modes[i], word.paths[i][0]) for i in (before, k))


def _at_section(word: Word, name: str) -> bool:
    """Whether an event passes the strobe at which an orbit begins."""
    return name in ("leg:0", "leg:last") and not word.closes_at_event


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


def _vanishing(word: Word, looked: Looked, name: str) -> list[str]:
    """Tests of the kind of this one that vanish at the same point; none where it is alone."""
    if name == "motion" or _at_section(word, name):
        return []
    kind, together = what_of(name), max(_TOGETHER, looked.rounding)
    found = [
        other
        for other, value in looked.tests.items()
        if what_of(other) == kind and (other == name or abs(value) <= together)
    ]
    return found if len(found) > 1 else []


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
    for way in (way_of(point), -way_of(point)):
        guess = motion_at(stretch, looked, point.p + way * _BEYOND * (high - low))
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
        what = f"leg {k} ({system.mode_names[word.modes[k]]}) {_AT_BORDER[start.kind]}"
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
