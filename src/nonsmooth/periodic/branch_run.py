"""A branch of orbits over a parameter, through changes of its word."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.point import Point
from nonsmooth.errors import RunError
from nonsmooth.periodic.branch_start import begin_change
from nonsmooth.periodic.branch_tests import WORD_TESTS, Looked
from nonsmooth.periodic.guess import Guess, driven_guess
from nonsmooth.periodic.legs import LegError, Legs
from nonsmooth.periodic.stretch import BranchOptions, BranchStart, Stretch
from nonsmooth.periodic.word import Word
from nonsmooth.periodic.word_change import Change, changes_of_word

__all__ = ["BranchPart", "Followed", "follow_orbits"]

Floats = npt.NDArray[np.float64]

_AGAIN = 1e-6  # arclength from the start of a stretch within which its own change is seen again
_BEYOND = 1e-6  # of the range of the parameter: where the engine is asked
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
    done, along = 0, 0.0
    stretch: Stretch | None = Stretch(options, legs, start.equations)
    ended = Followed(ended="steps", message=f"{options.steps} steps were taken; allow more, steps=")
    while stretch is not None and done < options.steps:
        branch = stretch.branch(start, options.steps - done)
        begin, following = along, None
        for point in branch:
            along = begin + point.arclength
            report(done)
            try:
                looked = stretch.look(point)
            except LegError:
                continue
            name = point.special
            kind = name.split(":")[0]
            if name and point.arclength <= _AGAIN and name == start.grows:
                if start.kind == "grazing":  # the graze itself, found from its regular side
                    yield _part(stretch, looked, point, along, "grazing", start.detail)
                continue
            if name == "branch_point" and _at_graze(stretch, looked):
                continue
            if kind not in WORD_TESTS:
                yield _part(stretch, looked, point, along, name, "")
                done += not name
                continue
            following, part = _changed(stretch, point, looked, along)
            if part is not None:
                yield part
            if following is None:
                yield Followed(ended=kind_of(name), message=_says(stretch, name, looked))
                return
            break
        else:
            ended = Followed(ended=branch.ended, message=branch.message)
            break
        start = following
        done += 1
        stretch = Stretch(options, legs, start.equations)
    yield ended


def kind_of(name: str) -> str:
    """What a test of the word is called where it ends a branch."""
    kind = name.split(":")[0]
    return {"graze": "grazing", "short": "grazing", "rate": "grazing", "leg": "lost",
            "gain": "gained", "motion": "end"}.get(kind, kind)  # fmt: skip


def _part(
    stretch: Stretch, looked: Looked, point: Point, along: float, special: str, detail: str
) -> BranchPart:
    if special == "torus" and not _is_torus(looked):
        special = ""  # two real multipliers whose product is one
    return BranchPart(stretch.equations.word, looked, point.p, along, special, detail)


def _is_torus(looked: Looked) -> bool:
    values = looked.multipliers.multipliers
    nearest = values[np.argmin(np.abs(np.abs(values) - 1.0))] if values.size else 0.0
    return bool(abs(complex(nearest).imag) > 1e-8)


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
    changes = changes_of_word(stretch.equations, looked.turn, name)
    for change in changes:
        start = begin_change(stretch, change, point)
        if start is not None:
            if change.kind == "section":
                return start, None
            start.detail = _detail(stretch, name, start, point)
            if name.startswith("short"):  # the graze is located from the other side
                return start, None
            return start, _part(stretch, looked, point, along, change.kind, start.detail)
    for guess in _motions_beyond(stretch, looked, point):
        change = Change(kind_of(name), guess)
        start = begin_change(stretch, change, point)
        if start is not None:
            start.detail = _detail(stretch, name, start, point)
            return start, _part(stretch, looked, point, along, kind_of(name), start.detail)
    detail = "no orbit of a changed word begins there"
    return None, _part(stretch, looked, point, along, kind_of(name), detail)


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
