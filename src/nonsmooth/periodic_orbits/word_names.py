"""Words that a user gives: names of modes to legs, by the exits that lead from one to the next."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise, product
from typing import Any

from nonsmooth.engine.tables import Wiring
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.runs.start import mode_numbers
from nonsmooth.system.system import System

__all__ = ["read_word", "shortest_paths", "words_of_names"]

_MOST_EXITS = 3  # passed at one instant
_MOST_WORDS = 64
_LONGEST = 1000


def read_word(system: System, word: Any) -> tuple[str, ...]:
    """Names of a word given as text or as a sequence; `OptionError` for what is none."""
    if isinstance(word, str):
        names = tuple(word.split())
    elif isinstance(word, Sequence) and all(isinstance(name, str) for name in word):
        names = tuple(word)
    else:
        names = ()
    if not 0 < len(names) <= _LONGEST:
        raise OptionError(
            f"word = {word!r:.80}: give the modes of one turn in order, from the section on, such"
            f" as {' '.join(system.mode_names[:2])!r}, or as a list of names; at most {_LONGEST}"
        )
    for name in names:
        try:
            mode_numbers(system, name)
        except OptionError:
            known = dict.fromkeys([*system.modes, *system.mode_names])
            raise OptionError(f"word: {unknown_name('mode', name, known)}") from None
    return names


def words_of_names(system: System, names: Sequence[str], *, autonomous: bool) -> list[Word]:
    """Words that names can stand for; several where exits or cells leave a choice.

    The word of an autonomous system ends in the mode in which it begins, at the event that leads
    there. `OptionError` where no exits lead from a mode to the next one.
    """
    wiring = system.compiled.program.wiring
    choices = [mode_numbers(system, name) for name in names]
    if names[0] != names[-1]:
        raise OptionError(
            f"word: it begins in {names[0]!r} and ends in {names[-1]!r}; a turn ends in the mode in"
            " which it begins, so name that once more at the end"
        )
    found: list[Word] = []
    for modes in product(*choices):
        if modes[0] != modes[-1]:
            continue
        steps = [shortest_paths(wiring, a, b) for a, b in pairwise(modes)]
        for paths in product(*steps):
            if autonomous:
                found.append(Word(modes[:-1] or modes, paths or ((),)))
            else:
                found.append(Word(modes, (*paths, ())))
            if len(found) >= _MOST_WORDS:
                return found
    if not found:
        for a, b in pairwise(names):
            if not any(
                shortest_paths(wiring, i, k)
                for i in mode_numbers(system, a)
                for k in mode_numbers(system, b)
            ):
                raise OptionError(f"word: no exit leads from {a!r} to {b!r} in {system.name!r}")
        raise OptionError(f"word: its modes cannot follow one another in {system.name!r}")
    return found


def shortest_paths(wiring: Wiring, a: int, b: int) -> list[tuple[int, ...]]:
    """The shortest ways from mode a to mode b, by exits passed at one instant."""
    ways: list[tuple[tuple[int, ...], int, int]] = [((), a, -1)]
    for _ in range(_MOST_EXITS):
        ways = [
            ((*path, e), int(wiring.exits["target"][m, e]), m)
            for path, m, before in ways
            for e in _ways(wiring, path, m, before)
            if wiring.exits["target"][m, e] >= 0
        ]
        there = [path for path, m, _ in ways if m == b]
        if there:
            return there
    return []


def _ways(wiring: Wiring, path: tuple[int, ...], m: int, before: int) -> Iterator[int]:
    """Exits that can be passed in a mode behind a path, those onto a surface included."""
    yield from range(int(wiring.modes["n_exits"][m]))
    if not path:
        return
    for e in range(int(wiring.modes["n_exits"][m])):
        onto = int(wiring.exits["onto"][m, e])
        rebounds = wiring.resets(m, e)
        back = int(wiring.exits["target"][m, e]) == before
        if onto not in (-1, e) and (before == m and path[-1] == e if rebounds else back):
            yield onto
    if wiring.resets(before, path[-1]):  # it may jump over a surface that holds
        for e in range(int(wiring.modes["n_exits"][m]), int(wiring.modes["n_ways"][m])):
            if int(wiring.exits["onto"][m, e]) >= 0:
                yield e
