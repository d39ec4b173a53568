"""How the word of an orbit can go on where it stops being valid.

A point where the field beside a surface is tangent to it bounds the part of the surface on which
motion slides. Beyond it an orbit that crossed there slides for a while, if that field curves away
(crossing-sliding), and one that slid from there on crosses first and comes back, if it curves
towards the surface (switching-sliding). See M. di Bernardo, C. Budd, A. Champneys and P. Kowalczyk,
Piecewise-smooth Dynamical Systems, 2008, chapter 8.

At a graze an excursion into another mode appears or vanishes; a leg may lose its duration, an exit
passed at once may take time, an event may pass the section. Each change is made on the legs of the
orbit at that point; where none is known, the engine is asked what it does a little beyond.

A graze is located from its regular side, on which the lowest value of a guard within a leg is a
smooth function of the orbit. From the other side an excursion of vanishing duration would make the
equations singular. A branch leaves a graze towards an excursion by prescribing its duration first,
the parameter being free.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import PATH_LENGTH, Wiring
from nonsmooth.periodic_orbits.border_collision import beyond_border, equilibrium_beyond
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.excursions import is_graze, path_at_corner
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.onto import (
    is_onto,
    joined,
    jump_over,
    kind_of_excursion,
    kind_of_leg,
    modes_along,
    onto_beyond,
    targets_of_cell,
    with_jump,
    without_jump,
)
from nonsmooth.periodic_orbits.order_of_events import in_other_order
from nonsmooth.periodic_orbits.touches import GONE, OPENED, Change, with_contact
from nonsmooth.periodic_orbits.wall_at_surface import surface_before_wall, wall_before_surface
from nonsmooth.periodic_orbits.word import Word, shortest_paths

__all__ = ["changes_at_once", "changes_of_word", "vanishing_leg", "with_leg"]

_SLOW = 1e-6  # rate of a guard that is touched beside those of all states

Integers = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

# tests of a leg, or of the one behind it, that vanish where that leg does
_OF_LEGS = ("leg", "rate", "short", "gain", "corner", "slide", "enter")


def _onto_surface(equations: OrbitEquations, turn: Turn, k: int) -> list[Change]:
    """The surface behind leg k holds the motion for a while: it slides, and leaves as before."""
    word, wiring = equations.word, equations.legs.tables.wiring
    mode, path = word.modes[k], word.paths[k]
    beyond, onto = word.last_target(wiring, k), onto_beyond(wiring, mode, path[0])
    if onto < 0:
        return []
    entry = (path[0], onto)
    cell = modes_along(wiring, mode, entry)[-1]
    exits = targets_of_cell(wiring, cell)
    if beyond not in exits:
        return []
    guess = with_leg(equations, turn, k, entry, cell, (exits.index(beyond),))
    return [Change("crossing_sliding", guess, f"leg:{k + 1}")]


def _off_surface_first(equations: OrbitEquations, turn: Turn, k: int, g: int) -> list[Change]:
    """The surface behind leg k does not hold the motion: it crosses and comes back onto it."""
    word, wiring = equations.word, equations.legs.tables.wiring
    mode, path = word.modes[k], word.paths[k]
    cell = word.last_target(wiring, k)
    beyond = int(wiring.exits["target"][cell, g])
    if beyond not in modes_along(wiring, mode, path)[1:-1]:
        return []
    # a leg of no duration would solve the equations too, so it begins with one
    length = float(turn.instants[-1] - turn.instants[0])
    duration = min(OPENED * length, 0.5 * float(turn.durations[(k + 1) % len(word)]))
    found = []
    for back in shortest_paths(wiring, beyond, cell):
        guess = with_leg(equations, turn, k, path[:-1], beyond, back)
        guess.turn.instants[k + 2] += duration
        found.append(Change("switching_sliding", guess, "", k + 1, duration))
    return found


def with_leg(
    equations: OrbitEquations, turn: Turn, k: int, path: tuple[int, ...], mode: int,
    behind: tuple[int, ...],
) -> Guess:  # fmt: skip
    """A leg of no duration behind leg k, which is left and entered by other paths."""
    word = equations.word
    cut = Word(word.modes, (*word.paths[:k], path, *word.paths[k + 1 :]))
    found = equations.legs.follow(cut, turn.states, turn.instants)
    modes = (*word.modes[: k + 1], mode, *word.modes[k + 1 :])
    paths = (*word.paths[:k], path, behind, *word.paths[k + 1 :])
    states = np.insert(turn.states, k + 1, found.nexts[k], axis=0)
    instants = np.insert(turn.instants, k + 1, turn.instants[k + 1])
    return Guess(Word(modes, paths), Turn(states, instants))


def changes_at_once(equations: OrbitEquations, turn: Turn, names: list[str]) -> list[Change]:
    """One change for several tests that vanish together, as they do on a symmetric orbit.

    Legs behind others are changed first, and touches that come later in a leg, so that the numbers
    of those before stay what they are.
    """
    found: list[Change] = []
    before = len(equations.word)  # legs from here on have changed
    places = equations.legs.minima(equations.word, turn.states, turn.instants).places
    gone, here = GONE * float(turn.instants[-1] - turn.instants[0]), (-1, 0.0)

    def instant(name: str) -> tuple[int, float]:
        kind, *numbers = name.split(":")
        k = int(numbers[0])
        place = places[k, int(numbers[1])] if kind == "graze" else 0.0
        return k, float(np.nan_to_num(place))

    together = names and np.all(np.ptp([instant(name) for name in names], axis=0) <= gone)
    if together and all(name.startswith("graze:") for name in names):
        k, *guards = int(names[0].split(":")[1]), *(int(name.split(":")[2]) for name in names)
        contacts = with_contact(equations, turn, k, guards[0], tuple(guards[1:]))
        if contacts and all(change.opens >= 0 for change in contacts):
            return contacts
    for name in sorted(names, key=instant, reverse=True):
        if int(name.split(":")[1]) >= before:
            continue  # it went with an excursion of several legs
        there = instant(name)
        at_once = there[0] == here[0] and abs(there[1] - here[1]) <= gone
        change = _touched_too if at_once and name.startswith("graze") else None
        found = change(equations, turn, *map(int, name.split(":")[1:])) if change else []
        found = found or changes_of_word(equations, turn, name)
        if not found:
            return []
        last, here = found[0], there
        if len(last.guess.word) < len(equations.word) - 2:
            before = int(last.grows.split(":")[1])
        turn = last.guess.turn
        equations = equations.of_word(last.guess.word, turn.states[0])
    return found


def _touched_too(equations: OrbitEquations, turn: Turn, k: int, g: int) -> list[Change]:
    """Guard g is touched just where leg k ends in a touch: both of equal machines hit their stops.

    None where an exit of them leads to another mode.
    """
    word, target = equations.word, equations.legs.tables.wiring.exits["target"]
    mode, path = word.modes[k], (*word.paths[k], g)
    if len(path) > PATH_LENGTH or any(int(target[mode, e]) != mode for e in path):
        return []
    new = Word(word.modes, (*word.paths[:k], path, *word.paths[k + 1 :]))
    return [Change("grazing", Guess(new, turn), f"rate:{k}")]


def changes_of_word(equations: OrbitEquations, turn: Turn, name: str) -> list[Change]:
    """Changes that the test of this name calls for; none where only the engine knows.

    The legs of the equations stand for the parameters of the point.
    """
    whole = _without_whole_excursion(equations, turn, name)
    if whole is not None:
        return [whole]
    name = vanishing_leg(equations, turn, name)
    kind, *numbers = name.split(":")
    if name == "leg:last":
        return [_section_before_last(equations, turn)]
    k = int(numbers[0]) if numbers else -1
    if kind == "leg" and k == 0 and not equations.word.closes_at_event:
        return [_section_behind_first(equations, turn)]
    if kind == "leg":
        before = (k - 1) % len(equations.word)
        too_long = len(equations.word.paths[before] + equations.word.paths[k]) > PATH_LENGTH
        first = [] if too_long else [_without_leg(equations, turn, k)]
        return (
            in_other_order(equations, turn, k)
            + first
            + _at_walls(wall_before_surface(equations, turn, k))
        )
    if kind == "gain":
        return [_with_leg_of_path(equations, turn, k, int(numbers[1]))]
    if kind == "over":
        return _over_surface(equations, turn, k, int(numbers[1]))
    if kind == "short":
        return _without_excursion(equations, turn, k) + _at_walls(
            wall_before_surface(equations, turn, k)
        )
    if kind == "rate":
        return _without_event(equations, turn, k)
    if kind == "corner":
        return _with_event_first(equations, turn, k, int(numbers[1]))
    if kind == "graze":
        return with_contact(equations, turn, k, int(numbers[1]))
    if kind == "border":
        return [
            Change("boundary_equilibrium", guess, grows)
            for guess, grows in equilibrium_beyond(equations, turn, int(numbers[1]))
        ]
    if kind == "slide":
        return _onto_surface(equations, turn, k)
    if kind == "enter":
        return _off_surface_first(equations, turn, k, int(numbers[1]))
    return []


def vanishing_leg(equations: OrbitEquations, turn: Turn, name: str) -> str:
    """The leg behind a surface where it vanishes together with what keeps motion on it or off.

    A leg that leaves a surface and comes back to it has a duration, a rate at its end, and a rate
    behind it, that vanish together: rounding decides whose zero is found first.
    """
    kind, *numbers = name.split(":")
    if kind not in ("slide", "enter", "rate"):
        return name
    word, k = equations.word, int(numbers[0])
    if kind == "rate" and word.last_target(equations.legs.tables.wiring, k) == word.modes[k]:
        return name  # an impact that is only touched
    behind = (k + 1) % len(word)
    length = float(turn.instants[-1] - turn.instants[0])
    for leg in {"slide": (behind,), "enter": (behind, k), "rate": (k,)}[kind]:
        if abs(float(turn.durations[leg])) <= GONE * length and word.paths[leg]:
            return f"leg:{leg}"
    return name


def _section_behind_first(equations: OrbitEquations, turn: Turn) -> Change:
    """The first event passes the section backwards: it is then the last one of the turn."""
    word = equations.word
    modes = (*word.modes[1:], word.modes[1])
    paths = (*word.paths[1:-1], word.paths[0], ())
    ends = equations.legs.follow(word, turn.states, turn.instants).nexts[-1]
    last = turn.states[1] + equations.carried(ends - turn.states[0])
    states = np.vstack([turn.states[1:], last])
    instants = np.concatenate([turn.instants[:1], turn.instants[2:], turn.instants[-1:]])
    return Change("section", Guess(Word(modes, paths), Turn(states, instants)), "leg:last")


def _section_before_last(equations: OrbitEquations, turn: Turn) -> Change:
    """The last event passes the section forwards: it is then the first one of the turn."""
    word = equations.word
    modes = (word.modes[-2], *word.modes[:-1])
    paths = (word.paths[-2], *word.paths[:-2], ())
    found = equations.legs.follow(word, turn.states, turn.instants)
    first = found.ends[-2] - equations.carried(found.ends[-2] - turn.states[0])
    states = np.vstack([first, turn.states[:-1]])
    instants = np.concatenate([turn.instants[:1], turn.instants[:-2], turn.instants[-1:]])
    return Change("section", Guess(Word(modes, paths), Turn(states, instants)), "leg:0")


def _without_leg(equations: OrbitEquations, turn: Turn, k: int) -> Change:
    """Leg k lasts no time: its exits are passed together with those before it."""
    word, count, wiring = equations.word, len(equations.word), equations.legs.tables.wiring
    before = (k - 1) % count
    paths, mode = list(word.paths), word.modes[before]
    paths[before] = joined(wiring, mode, paths[before], paths[k])
    keep = [i for i in range(count) if i != k]
    new = Word(tuple(word.modes[i] for i in keep), tuple(paths[i] for i in keep))
    instants = np.delete(turn.instants, k if k else 1)
    place = before if before < k else before - 1
    guess = Guess(new, Turn(turn.states[keep], instants))
    if _lands_again(word, wiring, before, k):
        # the second landing has no speed, and happens to nothing: rest begins at the first one
        paths[before] = word.paths[k]
        new = Word(new.modes, tuple(paths[i] for i in keep))
        grows = _entry_test(wiring, place, mode, paths[before], word.modes[k])
        return Change("switching_sliding", guess._replace(word=new), grows)
    kind = kind_of_leg(wiring, mode, word.paths[before], word.modes[k], word.paths[k])
    grows = f"gain:{place}:{len(word.paths[before])}"
    if len(paths[before]) < len(word.paths[before]):  # the leg was beyond a surface, and is not
        jumped = modes_along(wiring, mode, paths[before])[-1], word.paths[before][-1]
        grows = f"over:{place}:{int(wiring.exits['onto'][jumped])}"
    if kind == "crossing_sliding" and len(paths[before]) == 1:
        grows = f"slide:{place}"
    elif kind == "switching_sliding":
        grows = _entry_test(wiring, place, mode, paths[before], word.modes[k])
    return Change(kind or "lost", guess, grows)


def _lands_again(word: Word, wiring: Wiring, before: int, k: int) -> bool:
    """Whether leg k is a flight from an impact that leaves no speed to one behind which it rests.

    The wall lets go of a body that lands while its force pulls, and holds it a little later.
    """
    first, second = word.paths[before], word.paths[k]
    mode = word.modes[before]
    same = mode == word.modes[k] and len(first) == 1 and len(second) > 1 and first[0] == second[0]
    return same and wiring.resets(mode, first[0])


def _entry_test(wiring: Wiring, place: int, mode: int, path: tuple[int, ...], beyond: int) -> str:
    """Test of the guard through which motion would leave a surface to the cell beyond it."""
    cell = modes_along(wiring, mode, path)[-1]
    targets = targets_of_cell(wiring, cell)
    return f"enter:{place}:{targets.index(beyond)}" if beyond in targets else ""


def _with_leg_of_path(equations: OrbitEquations, turn: Turn, k: int, j: int) -> Change:
    """Exit j of the path behind leg k waits: a leg appears in the mode before it."""
    word = equations.word
    path = word.paths[k]
    wiring = equations.legs.tables.wiring
    mode = modes_along(wiring, word.modes[k], path[:j])[-1]
    guess = with_leg(equations, turn, k, path[:j], mode, path[j:])
    test = "short" if is_graze(guess.word, wiring, k + 1) else "leg"
    kind = kind_of_leg(wiring, word.modes[k], path[:j], mode, path[j:])
    return Change(kind or "gained", guess, f"{test}:{k + 1}")


def _over_surface(equations: OrbitEquations, turn: Turn, k: int, g: int) -> list[Change]:
    """The impact that ends leg k throws the motion over the surface of guard g, and it comes back.

    The surface holds nothing of it, or the motion would stay on it.
    """
    word, wiring = equations.word, equations.legs.tables.wiring
    mode = word.last_target(wiring, k)
    jump = jump_over(wiring, mode, g)
    away = int(wiring.exits["target"][mode, jump])
    path = (*word.paths[k], jump)
    return [
        Change("gained", with_leg(equations, turn, k, path, away, back), f"leg:{k + 1}")
        for back in shortest_paths(wiring, away, mode)
    ]


def _without_excursion(equations: OrbitEquations, turn: Turn, k: int) -> list[Change]:
    """Leg k leaves a mode and comes back at once: the legs around it are one."""
    path = path_at_corner(equations.word, equations.legs.tables.wiring, k)
    if path is not None:
        return [_past_corner(equations, turn, k, path)]
    if k == 0 and not equations.word.closes_at_event:
        return _without_first_and_last(equations, turn)
    if len(equations.word) == 2 and equations.word.closes_at_event:
        return [_without_events(equations, turn, 1 - k)]
    word, turn, k = _away_from_ends(equations, turn, k)
    count = len(word)
    if not 0 < k < count - 1:
        return []
    modes = word.modes[:k] + word.modes[k + 2 :]
    paths = word.paths[: k - 1] + word.paths[k + 1 :]
    keep = [i for i in range(count) if i not in (k, k + 1)]
    instants = np.delete(turn.instants, [k, k + 1])
    grows = f"graze:{k - 1}:{word.paths[k - 1][0]}"
    new = Word(modes[: len(paths)], paths)
    kind = kind_of_excursion(equations.legs.tables.wiring, word.modes[k - 1], word.modes[k])
    return [Change(kind, Guess(new, Turn(turn.states[keep], instants)), grows)]


def _without_whole_excursion(equations: OrbitEquations, turn: Turn, name: str) -> Change | None:
    """Several legs in a row last no time, and what comes behind goes on as what was before them.

    So it is where a contact that may only push is grazed: it pushes first, and lets go before its
    body has left.
    """
    kind, *numbers = name.split(":")
    if kind not in _OF_LEGS or not numbers or numbers[0] == "last":
        return None
    word, count, k = equations.word, len(equations.word), int(numbers[0])
    short = turn.durations <= GONE * float(turn.instants[-1] - turn.instants[0])
    first = k if short[k] else (k + 1) % count
    if not short[first] or np.count_nonzero(short) > count - 2:
        return None
    while short[first - 1] and (first or word.closes_at_event):
        first = (first - 1) % count
    if word.closes_at_event:
        short = np.roll(short, 1 - first)
        (word, turn), first = _begun_at_leg(word, turn, first - 1), 1
    last = first + int(np.argmin(short[first:]))  # the leg behind them
    legs = range(first, last)
    wiring = equations.legs.tables.wiring
    resets = any(wiring.resets(word.modes[i], e) for i in legs for e in word.paths[i][:1])
    if first == 0 or len(legs) < 2 or resets or word.modes[last] != word.modes[first - 1]:
        return None
    gone = [*legs, last]
    keep = [i for i in range(count) if i not in gone]
    paths = (*word.paths[: first - 1], *word.paths[last:])
    new = Word(tuple(word.modes[i] for i in keep), paths)
    there = Turn(turn.states[keep], np.delete(turn.instants, gone))
    grows = f"graze:{first - 1}:{word.paths[first - 1][0]}"
    return Change("grazing", Guess(new, there), grows)


def _past_corner(
    equations: OrbitEquations, turn: Turn, k: int, path: tuple[int, ...]
) -> Change:  # fmt: skip
    """Legs k and k + 1 last no time: their guard is positive where the leg before them ends."""
    word = equations.word
    keep = [i for i in range(len(word)) if i not in (k, k + 1)]
    paths = (*word.paths[: k - 1], path, *word.paths[k + 2 :])
    new = Word(tuple(word.modes[i] for i in keep), paths)
    middle = 0.5 * float(turn.instants[k] + turn.instants[k + 2])
    instants = np.delete(turn.instants, [k + 1, k + 2])
    instants[k] = middle
    grows = f"corner:{k - 1}:{word.paths[k - 1][0]}"
    return Change("corner", Guess(new, Turn(turn.states[keep], instants)), grows)


def _without_events(equations: OrbitEquations, turn: Turn, stays: int) -> Change:
    """A cycle of which one leg stays passes no event any more.

    It begins half way along that leg, so that the guard is touched within the turn.
    """
    word, legs = equations.word, equations.legs
    new = Word((word.modes[stays],), ((),))
    begin, half = turn.instants[stays], 0.5 * float(turn.durations[stays])
    found = legs.follow_each(
        new, turn.states[stays : stays + 1], np.array([begin]), np.array([begin + half])
    )
    kind = kind_of_excursion(legs.tables.wiring, word.modes[stays], word.modes[stays - 1])
    instants = np.array([0.0, float(turn.durations.sum())])
    guess = Guess(new, Turn(found.ends.copy(), instants))
    return Change(kind, guess, f"graze:0:{word.paths[stays][0]}")


def _without_first_and_last(equations: OrbitEquations, turn: Turn) -> list[Change]:
    """The section lies within an excursion of no duration: it is left out on both sides."""
    word, count = equations.word, len(equations.word)
    if count < 3:
        return []
    new = Word(word.modes[1:-1], (*word.paths[1 : count - 2], ()))
    instants = np.delete(turn.instants, [1, count - 1])
    kind = kind_of_excursion(equations.legs.tables.wiring, word.modes[-2], word.modes[-1])
    # the guard is touched on either side of the section
    k = 0 if turn.durations[0] > turn.durations[-1] else len(new) - 1
    grows = f"graze:{k}:{word.paths[-2][0]}"
    return [Change(kind, Guess(new, Turn(turn.states[1:-1], instants)), grows)]


def _away_from_ends(equations: OrbitEquations, turn: Turn, k: int) -> tuple[Word, Turn, int]:
    """The same turn begun at another event, so that leg k has one behind it, and one before.

    Of two legs it is the first one.
    """
    word, count = equations.word, len(equations.word)
    if not word.closes_at_event or 0 < k < count - 1 or count < 2:
        return word, turn, k
    shift = k - 1 if count > 2 else k
    return *_begun_at_leg(word, turn, shift), k - shift


def _begun_at_leg(word: Word, turn: Turn, k: int) -> tuple[Word, Turn]:
    """The same turn of a word that closes at an event, begun with leg k."""
    instants = np.concatenate([[0.0], np.cumsum(np.roll(turn.durations, -k))])
    return word.begun_at(k), Turn(np.roll(turn.states, -k, axis=0), instants)


def _without_event(equations: OrbitEquations, turn: Turn, k: int) -> list[Change]:
    """The exit of leg k is only touched: where it leads back to its mode, it is left out.

    Exits that are passed at the same instant stay, as where a body that slides along another one
    is turned round by an impact: its slip and the rate of the gap vanish together. Those that are
    only touched as well, as by equal machines, are left out with it.
    """
    word, wiring = equations.word, equations.legs.tables.wiring
    mode, path = word.modes[k], word.paths[k]
    if int(wiring.exits["target"][mode, path[0]]) != mode:
        return []
    rest = without_jump(wiring, mode, path[1:])
    if rest and not _are_touched(equations, turn, k, rest):
        if is_onto(wiring, mode, rest[0]):
            return []
        new = Word(word.modes, (*word.paths[:k], rest, *word.paths[k + 1 :]))
        return [Change("grazing", Guess(new, turn), f"corner:{k}:{path[0]}")]
    if len(word) == 1:
        return [_without_events(equations, turn, k)]
    word, turn, k = _away_from_ends(equations, turn, k)
    modes = word.modes[: k + 1] + word.modes[k + 2 :]
    paths = word.paths[:k] + word.paths[k + 1 :]
    states = np.delete(turn.states, k + 1, axis=0)
    instants = np.delete(turn.instants, k + 1)
    grows = f"graze:{k}:{path[0]}"
    return [Change("grazing", Guess(Word(modes, paths), Turn(states, instants)), grows)]


def _are_touched(equations: OrbitEquations, turn: Turn, k: int, exits: tuple[int, ...]) -> bool:
    """Whether all these exits lead back to the mode of leg k, and have no rate at its end."""
    word, legs = equations.word, equations.legs
    mode, target = word.modes[k], legs.tables.wiring.exits["target"]
    if any(int(target[mode, e]) != mode for e in exits):
        return False
    count = len(exits)
    found = legs.follow_each(
        Word((mode,) * count, tuple((e,) for e in exits)), np.tile(turn.states[k], (count, 1)),
        np.full(count, turn.instants[k]), np.full(count, turn.instants[k + 1]),
    )  # fmt: skip
    rows = np.abs(found.guard_row[:, : legs.n])
    speeds = rows.max(axis=1) * np.abs(found.end_rates).max(axis=1)
    return bool(np.all(np.abs(found.guard_rate) <= _SLOW * speeds))


def _with_other_first(equations: OrbitEquations, turn: Turn, k: int, g: int) -> list[Change]:
    """Exits that leg k passes at one instant, as those of equal machines, where g comes first."""
    found = []
    word, wiring = equations.word, equations.legs.tables.wiring
    for j in range(1, len(word.paths[k])):
        first, second = word.paths[k][:j], word.paths[k][j:]
        middle = modes_along(wiring, word.modes[k], first)[-1]
        new, there = with_leg(equations, turn, k, first, middle, second)
        for change in in_other_order(equations.of_word(new, there.states[0]), there, k + 1):
            if change.guess.word.paths[k][0] == g:
                found.append(replace(change, kind="corner"))
    return found


def _with_event_first(equations: OrbitEquations, turn: Turn, k: int, g: int) -> list[Change]:
    """Guard g is touched just where leg k ends: its impact comes first, and the exits behind it."""
    word, wiring = equations.word, equations.legs.tables.wiring
    mode = word.modes[k]
    other_order = _with_other_first(equations, turn, k, g)
    if other_order:
        return other_order
    path = (g, *with_jump(wiring, mode, word.paths[k]))
    leads_back = int(wiring.exits["target"][mode, g]) == mode
    if not leads_back:
        border = [
            Change("border_collision", guess, grows)
            for guess, grows in beyond_border(equations, turn, k, g)
        ]
        around = border or _around_corner(equations, turn, k, g)
        return around or _at_walls(surface_before_wall(equations, turn, k, g))
    if len(path) > PATH_LENGTH:
        return []
    new = Word(word.modes, (*word.paths[:k], path, *word.paths[k + 1 :]))
    return [Change("grazing", Guess(new, turn), f"rate:{k}")]


def _at_walls(found: list[tuple[Guess, str]]) -> list[Change]:
    """Changes at which a wall is met just where motion leaves a surface or comes onto it."""
    return [Change("corner", guess, grows) for guess, grows in found]


def _around_corner(equations: OrbitEquations, turn: Turn, k: int, g: int) -> list[Change]:
    """Guard g is touched just where leg k ends: its exit comes first, then the way around."""
    word, wiring = equations.word, equations.legs.tables.wiring
    if k + 1 >= len(word) or len(word.paths[k]) != 1:
        return []
    inside, after = int(wiring.exits["target"][word.modes[k], g]), word.modes[k + 1]
    length = float(turn.instants[-1] - turn.instants[0])
    duration = min(OPENED * length, 0.25 * float(turn.durations[k : k + 2].min()))
    corner = equations.legs.follow(word, turn.states, turn.instants).ends[k]
    states = np.insert(turn.states, [k + 1, k + 1], [corner, corner], axis=0)
    instants = np.insert(turn.instants, [k + 1, k + 2], turn.instants[k + 1])
    instants[[k + 1, k + 3]] += [-duration, duration]
    found = []
    for out, middle in enumerate(targets_of_cell(wiring, inside) if inside >= 0 else []):
        for back, behind in enumerate(targets_of_cell(wiring, middle) if middle >= 0 else []):
            if behind != after:
                continue
            modes = (*word.modes[: k + 1], inside, middle, *word.modes[k + 1 :])
            paths = (*word.paths[:k], (g,), (out,), (back,), *word.paths[k + 1 :])
            new = Word(modes, paths)
            if path_at_corner(new, wiring, k + 1) == word.paths[k]:
                guess = Guess(new, Turn(states, instants))
                found.append(Change("corner", guess, "", k + 1, duration))
    return found
