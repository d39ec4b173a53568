"""A guard is touched by an orbit: where, and the orbit with the contact that begins there.

A contact is an excursion into another mode, whose duration grows from zero, or an event that leads
back to its mode. What is forced by a cosine and has no damping, or rests while walls move past it,
touches just at the strobe. Neither the first leg nor the last one has a lowest value of the guard
between its ends then, and the contact has a part before the strobe and one behind it, or is an
event just behind or just before it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import PATH_LENGTH
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.onto import (
    kind_of_excursion,
    modes_along,
    onto_beyond,
    path_through,
    targets_of_cell,
)
from nonsmooth.periodic_orbits.word import Word, shortest_paths

__all__ = ["GONE", "OPENED", "Change", "lowest_at_section", "with_contact"]

Floats = npt.NDArray[np.float64]

OPENED = 1e-3  # part of the turn that a leg lasts where a branch with it begins
GONE = 1e-7  # part of the turn that a leg lasts which vanishes with a test of the same point
_OPENED_OF_SLIDE = 4e-3  # likewise, from a surface on which motion slides
_BESIDE = 1e-3  # of the first and of the last leg: how far from the strobe guards are higher


@dataclass(frozen=True)
class Change:
    """A word with legs to begin with, and what has to grow from there on."""

    kind: str  # what the special point is called, or "section"
    guess: Guess
    grows: str = ""  # test of the new word that is zero at the change, positive behind it
    opens: int = -1  # leg whose duration is prescribed to begin with, -1 for none
    duration: float = 0.0


def lowest_at_section(equations: OrbitEquations, turn: Turn) -> Floats:
    """Value of each guard at the strobe, where it is lower than on both sides; else nan, (e,)."""
    word, legs = equations.word, equations.legs
    if equations.autonomous or word.closes_at_event or word.modes[0] != word.modes[-1]:
        return np.full(legs.tables.sizes.exits, np.nan)
    begin, end = float(turn.instants[0]), float(turn.instants[-1])
    beside = _BESIDE * float(min(turn.durations[0], turn.durations[-1]))
    begins = np.array([begin, begin, turn.instants[-2]])
    ends = np.array([begin, begin + beside, end - beside])
    states = turn.states[[0, 0, -1]]
    found = legs.follow_each(Word(word.modes[:1] * 3, ((),) * 3), states, begins, ends).others
    here, later, before = found
    return np.where((here < later) & (here < before), here, np.nan)


def with_contact(
    equations: OrbitEquations, turn: Turn, k: int, g: int, also: tuple[int, ...] = ()
) -> list[Change]:
    """Guard g is touched within leg k: its exit is passed there, and the way back is found.

    ``also``: other guards that are touched there, as by equal machines in step, through all of
    which the contact leads.
    """
    word, wiring, legs = equations.word, equations.legs.tables.wiring, equations.legs
    place = legs.minima(word, turn.states, turn.instants).places[k, g]
    if not np.isfinite(place):
        begin, end = turn.instants[k : k + 2]
        place = legs.closer_minima(word.modes[k], turn.states[k], begin, end).places[g]
    instant = float(turn.instants[k] + place)
    mode, target = word.modes[k], int(wiring.exits["target"][word.modes[k], g])
    is_cut = k == 0 and not (equations.autonomous or word.closes_at_event)
    if target >= 0 and is_cut and np.isnan(instant):
        return _at_section(equations, turn, g)
    if target < 0 or np.isnan(instant):
        return []
    changes, onto = [], onto_beyond(wiring, mode, g)
    ways = [(g, onto), (g,)] if onto >= 0 else [(g,)]
    if also:
        through = path_through(wiring, mode, (g, *also))
        ways, onto = [] if through is None else [through], -1
    for path in ways:
        touch = Word((mode,), (path,))
        found = legs.follow_each(
            touch, turn.states[k : k + 1], turn.instants[k : k + 1], np.array([instant])
        )
        ends, behind = found.ends[0].copy(), found.nexts[0].copy()
        if target == mode:
            modes = (*word.modes[: k + 1], mode, *word.modes[k + 1 :])
            paths = (*word.paths[:k], (g,), *word.paths[k:])
            states = np.insert(turn.states, k + 1, behind, axis=0)
            instants = np.insert(turn.instants, k + 1, instant)
            new = Guess(Word(modes, paths), Turn(states, instants))
            return [_begun_at_event(equations, Change("grazing", new, f"rate:{k}"))]
        if onto < 0 and not also:
            path = _to_where_it_is(equations, mode, path, behind, instant)
        away = modes_along(wiring, mode, path)[-1]
        changes += [
            _opened(equations, turn, k, instant, (path, away, back), (behind, ends))
            for back in shortest_paths(wiring, away, mode)
        ]
    return [_begun_at_event(equations, change) for change in changes]


def _at_section(equations: OrbitEquations, turn: Turn, g: int) -> list[Change]:
    """Guard g is touched just at the strobe: its exit is passed around it, behind it or before."""
    word, wiring = equations.word, equations.legs.tables.wiring
    mode = word.modes[0]
    if int(wiring.exits["target"][mode, g]) == mode:
        events = _events_at_section(equations, turn, g)
        return [Change("grazing", guess, grows) for guess, grows in events]
    at = float(turn.instants[0])
    path = _to_where_it_is(equations, mode, (g,), turn.states[0], at)
    away = modes_along(wiring, mode, path)[-1]
    duration = OPENED * float(turn.instants[-1] - turn.instants[0])
    kind = kind_of_excursion(wiring, mode, away)
    found = []
    for back in shortest_paths(wiring, away, mode):
        guess = _around_section(equations, turn, (path, away, back), duration)
        if guess is not None:
            found.append(Change(kind, guess, "", 0, 0.5 * duration))
    return found


def _events_at_section(equations: OrbitEquations, turn: Turn, g: int) -> list[tuple[Guess, str]]:
    """An event that leads back to its mode happens just behind the strobe, or just before it.

    The orbits begun with, and the test that grows with each.
    """
    word, legs = equations.word, equations.legs
    mode, start = word.modes[0], turn.states[:1]
    at = turn.instants[:1]
    behind = legs.follow_each(Word((mode,), ((g,),)), start, at, at).nexts.copy()
    first = Guess(
        Word((mode, *word.modes), ((g,), *word.paths)),
        Turn(
            np.vstack([start, behind, turn.states[1:]]),
            np.insert(turn.instants, 1, turn.instants[0]),
        ),
    )
    ends = legs.follow(word, turn.states, turn.instants).ends[-1:]
    before = legs.follow_each(Word((mode,), ((g,),)), ends, at, at).nexts.copy()
    last = Guess(
        Word((*word.modes, mode), (*word.paths[:-1], (g,), ())),
        Turn(
            np.vstack([turn.states, before]),
            np.insert(turn.instants, -1, turn.instants[-1]),
        ),
    )
    return [(first, "rate:0"), (last, f"rate:{len(word) - 1}")]


def _around_section(
    equations: OrbitEquations, turn: Turn, way: tuple[tuple[int, ...], int, tuple[int, ...]],
    duration: float,
) -> Guess | None:  # fmt: skip
    """The strobe lies within an excursion: its path out, its mode, the path back, and how long."""
    word, (path, away, back) = equations.word, way
    modes = (away, *word.modes, away)
    new = Word(modes, (back, *word.paths[:-1], path, ()))
    if new.last_target(equations.legs.tables.wiring, len(new) - 2) != away:
        return None
    states = np.vstack([turn.states[:1], turn.states, turn.states[:1]])
    cut = turn.instants[[0, -1]] + 0.5 * duration * np.array([1.0, -1.0])
    return Guess(new, Turn(states, np.insert(turn.instants, [1, -1], cut)))


def _to_where_it_is(
    equations: OrbitEquations, mode: int, path: tuple[int, ...], state: Floats, instant: float
) -> tuple[int, ...]:
    """A path with the exits that follow at once: guards of the mode behind that are negative there.

    A cell that does not know the sign of a surface leads to the positive side of it. Between two
    springs that is contact on the other side, from which the motion goes on to the gap.
    """
    wiring = equations.legs.tables.wiring
    while len(path) < PATH_LENGTH:
        *_, before, there = modes_along(wiring, mode, path)
        at = np.array([instant])
        guards = equations.legs.follow_each(Word((there,), ((),)), state[None], at, at).others[0]
        targets = targets_of_cell(wiring, there)
        clear = -GONE * np.nanmax(np.abs(guards), initial=0.0)  # the one that is touched is zero
        passed = [
            g
            for g in range(min(len(targets), len(guards)))
            if guards[g] < clear and targets[g] not in (before, -1) and not wiring.resets(there, g)
        ]
        if len(passed) != 1:
            break
        path = (*path, passed[0])
    return path


def _begun_at_event(equations: OrbitEquations, change: Change) -> Change:
    """A cycle that passed no event, and passes some now: it begins at the first one of them.

    What comes before that goes on where the turn ends.
    """
    if not equations.is_smooth_cycle:
        return change
    word, turn = change.guess
    count = len(word) - 1
    new = Word(word.modes[1:], (*word.paths[1:-1], word.paths[0]))
    instants = turn.instants[1:] - turn.instants[1]
    instants[-1] += turn.durations[0]
    grows = f"rate:{count - 1}" if change.grows else ""  # it ends the leg that began at the plane
    opens = change.opens - 1 if change.opens >= 0 else -1
    return replace(
        change, guess=Guess(new, Turn(turn.states[1:], instants)), grows=grows, opens=opens
    )


def _opened(
    equations: OrbitEquations, turn: Turn, k: int, instant: float,
    excursion: tuple[tuple[int, ...], int, tuple[int, ...]], states_there: tuple[Floats, Floats],
) -> Change:  # fmt: skip
    """Leg k with an excursion at an instant: the path out, the mode there, and the path back."""
    word = equations.word
    path, away, back = excursion
    behind, ends = states_there
    length = float(turn.instants[-1] - turn.instants[0])
    room = min(instant - turn.instants[k], turn.instants[k + 1] - instant)
    kind = kind_of_excursion(equations.legs.tables.wiring, word.modes[k], away)
    share = _OPENED_OF_SLIDE if kind == "adding_sliding" else OPENED
    duration = min(share * length, 0.5 * room)
    modes = (*word.modes[: k + 1], away, *word.modes[k:])
    paths = (*word.paths[:k], path, back, *word.paths[k:])
    states = np.insert(turn.states, [k + 1, k + 1], [behind, behind], axis=0)
    states[k + 2] = ends
    cut = [instant - 0.5 * duration, instant + 0.5 * duration]
    instants = np.insert(turn.instants, [k + 1, k + 1], cut)
    return Change(kind, Guess(Word(modes, paths), Turn(states, instants)), "", k + 1, duration)
