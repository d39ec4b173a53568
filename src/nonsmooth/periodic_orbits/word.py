"""The word of an orbit: its modes in order, the exits between them, and how a user names it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import PATH_LENGTH, Wiring, bits_of_path, exits_of_path
from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.periodic_orbits.onto import collapsed
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.start import mode_numbers
from nonsmooth.runs.words import names_of_modes
from nonsmooth.system.system import System

__all__ = ["Word", "path_of_bits", "read_word", "shortest_paths", "words_of_names"]

Integers = npt.NDArray[np.int64]

_MOST_EXITS = 3  # passed at one instant
_MOST_WORDS = 64
_LONGEST = 1000


@dataclass(frozen=True)
class Word:
    """Legs in order. A leg ends with a path of exits; the last one may end at the section instead.

    Modes are numbers of running modes (cells of piecewise modes are modes of their own), exits
    numbers within the mode that they leave.
    """

    modes: tuple[int, ...]
    paths: tuple[tuple[int, ...], ...]

    def __post_init__(self) -> None:
        assert len(self.modes) == len(self.paths) > 0

    def __len__(self) -> int:
        return len(self.modes)

    @property
    def closes_at_event(self) -> bool:
        """Whether the orbit begins and ends at an event, and not at a section in time."""
        return bool(self.paths[-1])

    @property
    def n_events(self) -> int:
        """Events in one turn."""
        return len(self) - (not self.closes_at_event)

    @cached_property
    def mode_array(self) -> Integers:
        """Modes as the engine takes them."""
        return np.array(self.modes, np.int64)

    @cached_property
    def path_array(self) -> Integers:
        """Exits as the engine takes them, -1 behind the last one of a path."""
        rows = np.full((len(self), PATH_LENGTH), -1, np.int64)
        for row, path in zip(rows, self.paths, strict=True):
            row[: len(path)] = path
        return rows

    def begun_at(self, leg: int) -> Word:
        """The same turn of a word that closes at an event, begun with another leg."""
        return Word(self.modes[leg:] + self.modes[:leg], self.paths[leg:] + self.paths[:leg])

    def text(self, system: System) -> str:
        """Modes by name, joined by blanks; cells of one name in a row count once.

        Rebounds that end in rest count once too: there are infinitely many, without a first one.
        """
        modes = self.collapsed(system.compiled.program.wiring).modes
        modes = modes if not self.closes_at_event else (*modes, modes[0])
        return " ".join(names_of_modes(system.mode_names, np.array(modes)))

    def collapsed(self, wiring: Wiring) -> Word:
        """The same as if the first impact of each chatter ended in rest."""
        return Word(*collapsed(self.modes, self.paths, wiring))

    def exit_text(self, system: System, leg: int) -> str:
        """Names of the exits that end a leg, joined by '>'; empty at the section."""
        path = self.paths[leg]
        return labels_of(system).path(self.modes[leg], bits_of_path(path), len(path))

    def last_target(self, wiring: Wiring, leg: int) -> int:
        """Mode behind the path of a leg; its own where it ends at the section."""
        mode = self.modes[leg]
        for e in self.paths[leg]:
            mode = int(wiring.exits["target"][mode, e])
        return mode

    @cached_property
    def path_bits(self) -> Integers:
        """Paths as the event log keeps them."""
        return np.array([bits_of_path(path) for path in self.paths], np.int64)


def path_of_bits(bits: int, passes: int) -> tuple[int, ...] | None:
    """Exits of a path as the event log keeps it; None where it is longer than that."""
    return None if passes > PATH_LENGTH else exits_of_path(bits, passes)


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
            f"word = {quote(word)}: give the modes of one turn in order, from the section on, such"
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
