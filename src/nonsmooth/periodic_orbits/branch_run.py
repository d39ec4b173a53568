"""A branch of orbits over a parameter, stretch by stretch, each with a word of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from nonsmooth.periodic_orbits.branch_part import BranchPart, Followed
from nonsmooth.periodic_orbits.branch_walk import StretchWalk
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.newton import scale_of
from nonsmooth.periodic_orbits.stretch import BranchOptions, BranchStart, Stretch

__all__ = ["follow_orbits"]

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
    way, section = 0.0, None
    for each in _follow(options, legs, start, report):
        if isinstance(each, BranchPart):
            if each.special == "section":
                section = each
                continue
            if each.special == "fold":
                way, section = -way, None
            elif not each.special and (section is None or each.arclength > section.arclength):
                if section is not None and way * each.way < 0.0:
                    yield replace(section, special="fold")  # just where an event passes the section
                way, section = each.way, None
        yield each


def _follow(
    options: BranchOptions, legs: Legs, start: BranchStart, report: Callable[[int], None]
) -> Iterator[BranchPart | Followed]:
    """The same; an event that passes the section is a point of its own."""
    done, along = 0, 0.0
    begun: list[BranchStart] = []  # stretches behind changes of the word
    first = scale_of(start.equations, start.unknowns)[: legs.n]
    # what is driven and shrinks is known to the rounding of what drives it
    least = np.zeros(legs.n) if options.autonomous else _LEAST * first
    while done < options.steps:
        stretch = Stretch(options, legs, start.equations, start.grows, least)
        walk = StretchWalk(stretch, start, along, float(first.max()))
        yield from walk.points(options.steps - done, partial(_report, report, done))
        if walk.ended is not None:
            yield walk.ended
            return
        if walk.following is None:
            break
        start, along = walk.following, walk.along
        done += walk.done + bool(start.kind)
        if start.kind not in _NO_CHANGE:
            if any(_same_start(start, other) for other in begun):
                yield Followed("closed", "the branch came back to where it was: it is closed")
                return
            begun.append(start)
    yield Followed(
        "steps",
        f"{options.steps} steps were taken; allow more with steps=, or longer ones with"
        " largest_step=",
    )


def _report(report: Callable[[int], None], before: int, done: int) -> None:
    """Tell how many steps are done in all stretches."""
    report(before + done)


def _same_start(one: BranchStart, other: BranchStart) -> bool:
    """Whether two stretches begin at the same orbit, in the same direction."""
    if one.equations.word != other.equations.word:
        return False
    scale = scale_of(one.equations, one.unknowns)
    apart = np.abs((one.unknowns - other.unknowns) / scale).max()
    same_way = float((one.direction[0] / scale) @ (other.direction[0] / scale)) > 0.0
    near = abs(one.value - other.value) <= _CLOSED * (1.0 + abs(one.value))
    return bool(apart <= _CLOSED and near and same_way)
