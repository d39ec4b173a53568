"""A branch of orbits over a parameter, through changes of its word."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.point import Point
from nonsmooth.errors import RunError
from nonsmooth.periodic.branch_start import begin_change
from nonsmooth.periodic.branch_tests import WORD_TESTS, Looked
from nonsmooth.periodic.guess import Guess, driven_guess
from nonsmooth.periodic.legs import LegError, Legs
from nonsmooth.periodic.newton import scale_of
from nonsmooth.periodic.orbit import primitive_parts
from nonsmooth.periodic.stretch import BranchOptions, BranchStart, Stretch
from nonsmooth.periodic.symmetric import is_symmetric
from nonsmooth.periodic.word import Word
from nonsmooth.periodic.word_change import Change, changes_at_once, changes_of_word

__all__ = ["BranchPart", "Followed", "follow_orbits"]

Floats = npt.NDArray[np.float64]

_AGAIN = 1e-6  # arclength from the start of a stretch within which its own change is seen again
_BEYOND = 1e-6  # of the range of the parameter: where the engine is asked
_KINDS = {
    "graze": "grazing", "short": "grazing", "rate": "grazing", "leg": "lost", "gain": "gained",
    "slide": "sliding", "shrink": "hopf", "motion": "word_change",
}  # fmt: skip
_ENDS = {
    "shrink": "the cycle shrinks to a point",
    "slide": "both sides of a surface point at it: beyond, the motion stays there for a while",
}
_MOST_TELLING = ("shrink", "slide", "short", "leg", "gain", "graze", "rate", "corner")
_CLOSED = 1e-5  # scaled distance from where a branch was before
_TOGETHER = 1e-8  # a test that vanishes at the same point as another one
_NEARBY = 1e-3  # of the size of an orbit: one of another word is its continuation
_CRITICAL = 1e-5  # distance from the unit circle of a multiplier that is on it
_NEAR_GRAZE = 1e-2  # part of the turn: branches cross there as an excursion vanishes


@dataclass
class BranchPart:
    """A point of a branch of orbits; ``special`` says what happens there."""

    word: Word
    looked: Looked
    value: float
    arclength: float
    special: str = ""
    detail: str = ""
    test: str = ""  # what vanishes there, as `BranchTests` names it for this word
    way: float = 0.0  # of the parameter along the branch: its sign


@dataclass
class Followed:
    """One end of a branch: its points, and why it ended."""

    parts: list[BranchPart] = field(default_factory=list)
    ended: str = ""
    message: str = ""


def follow_orbits(
    options: BranchOptions,
    legs: Legs,
    start: BranchStart,
    report: Callable[[int], None],
) -> Iterator[BranchPart | Followed]:
    """Points of a branch in order; the last thing given is a `Followed` without points.

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
    stretch: Stretch | None = Stretch(options, legs, start.equations, start.grows)
    first_scale = float(scale_of(start.equations, start.unknowns)[: legs.n].max())
    ended = Followed(
        ended="steps",
        message=f"{options.steps} steps were taken; allow more with steps=, or longer ones with"
        " largest_step=",
    )
    while stretch is not None and done < options.steps:
        branch = stretch.branch(start, options.steps - done)
        begin, following = along, None
        before: Mapping[str, float] = {}  # tests of the last point that was a motion
        for point in branch:
            along = begin + point.arclength
            report(done)
            try:
                looked = stretch.look(point)
            except LegError:
                continue
            name = point.special
            kind = name.split(":")[0]
            if name and name != "bound" and begin > 0.0 and point.arclength <= _AGAIN:
                # where the word has just changed; a graze that was approached along an excursion
                # is located here, from its regular side
                if start.located and name == start.grows:
                    yield _part(stretch, looked, point, along, "grazing", start.detail)
                continue
            if name == "branch_point" and _at_graze(stretch, looked):
                continue
            if name == "branch_point" and primitive_parts(stretch.equations, looked.turn) > 1:
                detail = "the turn passes twice through the orbit that doubles its period here"
                yield replace(_part(stretch, looked, point, along, "halving", detail), test="flip")
                yield Followed(ended="halving", message=f"the branch ends where {detail}")
                return
            if start.located and looked.tests.get(start.grows, 1.0) <= 0.0 and not name:
                continue  # before the graze, on its other side
            if begin > 0.0 and not name and not before and not _may_stand(options, looked):
                continue  # where the word has just changed rounding decides what the engine finds
            if kind in WORD_TESTS and before.get(name, 1.0) < 0.0:
                continue  # it rises there
            lost = kind not in WORD_TESTS and not _may_stand(options, looked)
            if lost:
                name = _broken(looked)
                point = replace(point, special=name)
            if kind not in WORD_TESTS and not lost:
                before = looked.tests
                again = begin > 0.0 and point.arclength == 0.0 and not start.kind
                if not again:  # a stretch that only has another scale begins at the last point
                    yield _part(stretch, looked, point, along, name, "")
                    done += not name
                if not name and point.arclength > 0.0 and stretch.outgrown(point.u):
                    if stretch.is_nothing_beside(first_scale):
                        yield Followed(ended="hopf", message=f"the branch ends: {_ENDS['shrink']}")
                        return
                    way = (point.tangent_u, point.tangent_p)
                    following = BranchStart(stretch.equations, point.u, point.p, way)
                    break
                continue
            following, part = _changed(stretch, point, looked, along)
            if part is not None:
                yield part
            if following is None:
                yield Followed(ended=kind_of(name), message=_says(stretch, name, looked))
                return
            break
        else:
            if branch.ended != "steps":
                ended = Followed(ended=branch.ended, message=branch.message)
            break
        start = following
        done += bool(start.kind)
        if start.kind in ("grazing", "gained", "lost", "corner", "word_change"):
            if any(_same_start(start, other) for other in begun):
                ended = Followed(ended="closed", message="the branch came back to where it was")
                break
            begun.append(start)
        stretch = Stretch(options, legs, start.equations, start.grows)
    yield ended


def _same_start(one: BranchStart, other: BranchStart) -> bool:
    """Whether two stretches begin at the same orbit, in the same direction."""
    if one.equations.word != other.equations.word:
        return False
    scale = scale_of(one.equations, one.unknowns)
    apart = np.abs((one.unknowns - other.unknowns) / scale).max()
    same_way = float((one.direction[0] / scale) @ (other.direction[0] / scale)) > 0.0
    near = abs(one.value - other.value) <= _CLOSED * (1.0 + abs(one.value))
    return bool(apart <= _CLOSED and near and same_way)


def _broken(looked: Looked) -> str:
    """The test behind whose zero an orbit lies that was passed without being located.

    Where an excursion vanishes the equations are nearly singular, and the search may fail there.
    """
    for kind in _MOST_TELLING:
        for name, value in looked.tests.items():
            if name.split(":")[0] == kind and value < 0.0:
                return name
    return "motion"


def _may_stand(options: BranchOptions, looked: Looked) -> bool:
    """Whether an orbit is a motion, or need not be one."""
    return options.inadmissible or looked.admissibility.admissible


def kind_of(name: str) -> str:
    """What a test of the word is called where it ends a branch."""
    kind = name.split(":")[0]
    return _KINDS.get(kind, kind)


def _part(
    stretch: Stretch, looked: Looked, point: Point, along: float, special: str, detail: str
) -> BranchPart:
    if special in ("flip", "torus") and not _is_critical(looked, special):
        special = ""  # a pole of the test, or two real multipliers whose product is one
    if special == "branch_point" and is_symmetric(stretch.equations, looked.turn):
        special = "symmetry_breaking"
    test = point.special if special else ""
    way = float(np.sign(point.tangent_p))
    return BranchPart(stretch.equations.word, looked, point.p, along, special, detail, test, way)


def _is_critical(looked: Looked, kind: str) -> bool:
    """Whether a multiplier is at -1, or a pair of them on the unit circle."""
    values = looked.multipliers.multipliers
    values = values[np.isfinite(values)]
    if kind == "flip":
        return bool(np.any(np.abs(values + 1.0) <= _CRITICAL))
    near = np.abs(np.abs(values) - 1.0) <= _CRITICAL
    return bool(np.any(near & (np.abs(values.imag) > _CRITICAL)))


def _at_graze(stretch: Stretch, looked: Looked) -> bool:
    """Whether branches cross only because an excursion has no duration."""
    return any(
        name.startswith("short") and value < _NEAR_GRAZE for name, value in looked.tests.items()
    )


def _changed(
    stretch: Stretch, point: Point, looked: Looked, along: float
) -> tuple[BranchStart | None, BranchPart | None]:
    """How a branch goes on behind a change of its word, and the point there if it is special."""
    name = point.special
    stretch.set_parameter(point.p)
    changes = changes_at_once(stretch.equations, looked.turn, _vanishing(looked, name))
    changes = changes or changes_of_word(stretch.equations, looked.turn, name)
    for change in changes:
        start = begin_change(stretch, change, point)
        if start is not None:
            if change.kind == "section":
                return start, _part(stretch, looked, point, along, "section", "")
            start.detail = _detail(stretch, name, start, point)
            if name.startswith("short"):  # the graze is located from the other side
                start.located = True
                return start, None
            return start, _part(stretch, looked, point, along, change.kind, start.detail)
    for guess in _motions_beyond(stretch, looked, point):
        change = Change(kind_of(name), guess)
        start = begin_change(stretch, change, point)
        if start is not None and _is_near(start, looked):
            start.detail = _detail(stretch, name, start, point)
            return start, _part(stretch, looked, point, along, kind_of(name), start.detail)
    detail = _ENDS.get(name.split(":")[0], "no orbit of a changed word begins there")
    return None, _part(stretch, looked, point, along, kind_of(name), detail)


def _vanishing(looked: Looked, name: str) -> list[str]:
    """Tests of the kind of this one that vanish at the same point; none where it is alone."""
    if name in ("motion", "leg:0", "leg:last") or name.startswith("corner"):
        return []
    kind = name.split(":")[0]
    found = [
        other
        for other, value in looked.tests.items()
        if other.split(":")[0] == kind and (other == name or abs(value) <= _TOGETHER)
    ]
    return found if len(found) > 1 else []


def _is_near(start: BranchStart, looked: Looked) -> bool:
    """Whether an orbit of another word begins where this one is, and not somewhere else."""
    first, drifting = looked.turn.states[0], start.equations.drifting
    other = start.equations.unpack(start.unknowns).states[0]
    size = np.abs(looked.turn.states - np.where(drifting, first, 0.0)).max(axis=0)
    apart = np.where(drifting, 0.0, np.abs(other - first))
    return bool(np.all(apart <= _NEARBY * max(float(size.max()), 1e-300)))


def _motions_beyond(stretch: Stretch, looked: Looked, point: Point) -> Iterator[Guess]:
    """What the motion from the orbit does a little beyond, where there is a period to look at."""
    options = stretch.options
    if options.autonomous:
        return
    names = list(options.system.parameters)
    low, high = options.bounds
    state = dict(zip(options.system.states, looked.turn.states[0].tolist(), strict=True))
    for way in (np.sign(point.tangent_p) or 1.0, -(np.sign(point.tangent_p) or 1.0)):
        value = point.p + way * _BEYOND * (high - low)
        there = options.system.with_parameters(
            **dict(zip(names, stretch.legs.values.tolist(), strict=True))
            | {options.parameter: value}
        )
        try:
            guess = driven_guess(
                there, state, period=options.period, phase=options.phase, transient=0, mode=None,
                tolerance=options.tolerance,
            )  # fmt: skip
        except Exception as fault:
            if not isinstance(fault, (RunError, ValueError)):
                raise
            continue
        if guess.word != stretch.equations.word:
            yield guess


def _detail(stretch: Stretch, name: str, start: BranchStart, point: Point) -> str:
    """What happens in words: which guard or leg, and whether the parameter turns back."""
    word, system = stretch.equations.word, stretch.options.system
    kind, *numbers = name.split(":")
    k = int(numbers[0]) if numbers and numbers[0].isdigit() else 0
    mode = system.mode_names[word.modes[k]]
    exits = system.compiled.exit_names
    what = {
        "graze": f"leg {k + 1} ({mode})",
        "rate": f"leg {k + 1} ({mode})",
        "short": f"leg {k + 1} ({mode}) vanishes",
        "leg": f"leg {k + 1} ({mode}) vanishes",
        "gain": f"a leg appears behind leg {k + 1} ({mode})",
        "corner": f"two guards of leg {k + 1} ({mode})",
        "slide": f"both sides of a surface behind leg {k + 1} ({mode}) point at it",
    }.get(kind, "the motion changes")
    if kind in ("graze", "corner"):
        what += f" touches {exits[word.modes[k]][int(numbers[1])]!r}"
    turns = start.direction[1] * point.tangent_p < 0.0
    way = "the branch turns back" if turns else "the branch goes on"
    return f"{what}; {way} as '{start.equations.word.text(system)}'"


def _says(stretch: Stretch, name: str, looked: Looked) -> str:
    reason = looked.admissibility.reason
    return (
        f"the branch ends where its word stops being valid ({kind_of(name)}"
        + (f": {reason}" if reason else "")
        + "), and no orbit of a changed word goes on from there; inadmissible=True follows the"
        " equations of the word beyond"
    )
