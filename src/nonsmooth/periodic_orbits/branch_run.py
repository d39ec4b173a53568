"""A branch of orbits over a parameter, stretch by stretch, each with a word of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.admissibility import Admissibility
from nonsmooth.periodic_orbits.branch_change import end_at
from nonsmooth.periodic_orbits.branch_part import BranchPart, Followed
from nonsmooth.periodic_orbits.branch_start import tangent_at
from nonsmooth.periodic_orbits.branch_tests import broken_tests, is_of_word, what_of
from nonsmooth.periodic_orbits.cycle_plane import direction_on, on_new_plane, on_plane_of
from nonsmooth.periodic_orbits.in_words import in_words
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.newton import scale_of
from nonsmooth.periodic_orbits.stretch import (
    BranchOptions,
    BranchStart,
    BranchStretch,
    spread_along,
)
from nonsmooth.periodic_orbits.stretch_walk import BY_ROUNDING, StretchWalk
from nonsmooth.periodic_orbits.trail import Trail
from nonsmooth.periodic_orbits.unbounded import LastOrbits

__all__ = ["follow_orbits"]

Floats = npt.NDArray[np.float64]

_NOWHERE = "no orbit of a changed word begins there"
_CLOSED = 1e-5  # scaled distance from where a branch was before
_LEAST = 1e-2  # of the size of the first orbit: smaller ones are not measured by their own
_NO_CHANGE = ("", "section")  # kinds of starts at which the word stays, but for its beginning


def follow_orbits(
    options: BranchOptions,
    legs: Legs,
    start: BranchStart,
    report: Callable[[int], None],
) -> Iterator[BranchPart | Followed]:
    """Points of a branch in order, and at last why it ended.

    ``report`` is told how many steps are done; it may raise to stop.
    """
    waits: BranchPart | None = None
    for each in _with_ends(options, legs, start, report):
        # rounding changes the words of orbits at last that become long or shrink to a point
        by_rounding = (
            each.ended == "unbounded" if isinstance(each, Followed) else each.test == "shrink"
        )
        if waits is not None and not by_rounding:
            yield waits
        waits = each if isinstance(each, BranchPart) and each.special == "word_change" else None
        if waits is None:
            yield each


def _with_ends(
    options: BranchOptions,
    legs: Legs,
    start: BranchStart,
    report: Callable[[int], None],
) -> Iterator[BranchPart | Followed]:
    """The same; a word that changes by rounding is a point of its own."""
    way, stands = 0.0, None
    held: list[BranchPart] = []  # where an event passes the section, and what else is there
    last = LastOrbits(options)
    for each in _follow(options, legs, start, report):
        if isinstance(each, Followed):
            yield from held
            shrunk = last.shrunk(each)
            if shrunk is not None:
                yield shrunk
                told = f"the branch ends at {options.parameter} = {shrunk.value:.8g}"
                each = Followed(shrunk.special, f"{told}: {shrunk.detail}")
            yield last.end(each)
            return
        if not (options.inadmissible or each.looked.admissibility.admissible) and stands:
            each = _within_rounding(each, stands)
        stands = each
        if each.special == "section":
            yield from held
            held = [replace(each, special="")]
            continue
        if each.special == "fold":
            way = -way
        elif is_of_word(each.test):  # the parameter may turn back there
            way = 0.0
        elif held and (each.special or each.arclength <= held[0].arclength):
            held.append(each)
            continue
        elif not each.special:
            if held and way * each.way < 0.0:
                # just where an event passes
                held[0] = replace(held[0], special="fold", test="fold")
            way = each.way
        yield from held
        held = []
        yield each
        if not each.special:
            last.add(each)
            if last.are_far:
                yield last.end()
                return


def _within_rounding(change: BranchPart, motion: BranchPart) -> BranchPart:
    """A change that rounding has placed beyond itself.

    Both words stand at the change itself. Where only the engine tells it, it is told at the last
    motion before.
    """
    # of tests of one kind that vanish together, one has been located, and others lie beside it
    broken = broken_tests(change.looked, -max(BY_ROUNDING, change.looked.rounding))
    if {what_of(name) for name in broken} <= {what_of(change.test)} - {"motion"}:
        looked = replace(change.looked, admissibility=Admissibility(True))
        return replace(change, looked=looked)
    return replace(
        motion, special=change.special, detail=change.detail, test=change.test,
        unbounded=change.unbounded,
    )  # fmt: skip


def _follow(
    options: BranchOptions, legs: Legs, start: BranchStart, report: Callable[[int], None]
) -> Iterator[BranchPart | Followed]:
    """The same; an event that passes the section is a point of its own."""
    done, along, trail, home = 0, 0.0, Trail(), start
    unexplained: list[float] = []
    begun: list[BranchStart] = []  # stretches behind changes of the word
    # the last change of the word with its stretch, until a motion is found behind it
    change: tuple[BranchPart, BranchStretch] | None = None
    first = scale_of(start.equations, start.unknowns)[: legs.n]
    spread = spread_along(start.equations, start.unknowns)
    # what is driven and shrinks is known to the rounding of what drives it
    least = np.zeros(legs.n) if options.autonomous else _LEAST * first
    while done < options.steps:
        if start.equations.is_smooth_cycle:
            laid = _on_new_plane(options, legs, start)
            here = laid if start is home else _on_plane_of(options, legs, home, laid)
            start = laid
        else:
            here = home
        trail.begin()
        stretch = BranchStretch(options, legs, start.equations, start.grows, least, trail)
        walk = StretchWalk(stretch, start, along, spread, here)
        for part in walk.points(options.steps - done, partial(_report, report, done)):
            if change is not None:
                yield change[0]
            change = (part, stretch) if is_of_word(part.test) else None
            if change is None:
                yield part
        if walk.leads_nowhere and change is not None:
            part, before = change
            what = in_words(options.system, part.word, part.test)
            yield replace(part, detail=f"{what}; {_NOWHERE}")
            yield _with_doubts(end_at(part.test, part.looked, before), options, unexplained)
            return
        if walk.following is None and change is not None:
            yield change[0]
            change = None
        unexplained += walk.check.unexplained
        if walk.ended is not None:
            yield _with_doubts(walk.ended, options, unexplained)
            return
        if walk.following is None:
            break
        start, along = walk.following, walk.along
        done += walk.done + bool(start.kind or not walk.done)
        if start.kind not in _NO_CHANGE:
            if any(_same_start(start, other) for other in begun):
                if change is not None:
                    yield change[0]
                closed = Followed("closed", "the branch came back to where it was: it is closed")
                yield _with_doubts(closed, options, unexplained)
                return
            begun.append(start)
    if change is not None:
        yield change[0]
    message = (
        f"{options.steps} steps were taken; allow more with steps=, or longer ones with"
        " largest_step="
    )
    yield _with_doubts(Followed("steps", message), options, unexplained)


def _with_doubts(ended: Followed, options: BranchOptions, unexplained: Sequence[float]) -> Followed:
    """The end of a branch with places at which its stability changes for no known reason."""
    if not unexplained:
        return ended
    places = ", ".join(f"{value:.10g}" for value in dict.fromkeys(unexplained))
    return replace(
        ended,
        message=f"{ended.message} (near {options.parameter} = {places} the number of multipliers"
        " outside the unit circle changes, and no special point was found that tells why; take a"
        " smaller largest_step=)",
    )


def _on_new_plane(options: BranchOptions, legs: Legs, start: BranchStart) -> BranchStart:
    """The same start of a cycle, on a plane that its flow passes at a steep angle."""
    BranchStretch(options, legs, start.equations).set_parameter(start.value)
    equations = on_new_plane(start.equations, start.unknowns)
    tangent = tangent_at(equations, start.unknowns)
    direction = direction_on(equations, start.unknowns, tangent, start.direction)
    return replace(start, equations=equations, direction=direction)


def _on_plane_of(
    options: BranchOptions, legs: Legs, home: BranchStart, start: BranchStart
) -> BranchStart:
    """Where a branch of cycles began, on the plane of a later start; that itself where it cannot.

    So the branch is seen to be closed on whatever plane it comes back.
    """
    if not home.equations.is_smooth_cycle:
        return start
    BranchStretch(options, legs, start.equations).set_parameter(home.value)
    try:
        unknowns = on_plane_of(start.equations, home.equations, home.unknowns)
    except LegError:
        return start
    if unknowns is None:
        return start
    tangent = tangent_at(start.equations, unknowns)
    direction = direction_on(start.equations, unknowns, tangent, home.direction)
    return replace(home, equations=start.equations, unknowns=unknowns, direction=direction)


def _report(report: Callable[[int], None], before: int, done: int) -> None:
    """Tell how many steps are done in all stretches."""
    report(before + done)


def _same_start(one: BranchStart, other: BranchStart) -> bool:
    """Whether two stretches begin at the same orbit, in the same direction."""
    if one.equations.word != other.equations.word:
        return False
    scale = scale_of(one.equations, one.unknowns)
    apart = np.abs(one.equations.without_turns(one.unknowns - other.unknowns) / scale).max()
    same_way = float((one.direction[0] / scale) @ (other.direction[0] / scale)) > 0.0
    near = abs(one.value - other.value) <= _CLOSED * (1.0 + abs(one.value))
    return bool(apart <= _CLOSED and near and same_way)
