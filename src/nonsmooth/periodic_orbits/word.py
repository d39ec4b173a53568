"""The word of an orbit: its modes in order, and the exits that are passed between them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import PATH_LENGTH, Wiring, bits_of_path, exits_of_path
from nonsmooth.periodic_orbits.chatter import collapsed
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.words import names_of_modes
from nonsmooth.system.system import System

__all__ = ["Word", "path_of_bits"]

Integers = npt.NDArray[np.int64]


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

    def text(self, system: System) -> str:
        """Modes by name, joined by blanks; cells of one name in a row count once.

        Rebounds that accumulate count once too: there are infinitely many.
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
