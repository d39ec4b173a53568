"""A change of the word of an orbit, and what it is called."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import SLIDES, Wiring
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.onto import kind_of_mode, modes_along

__all__ = ["Change", "kind_of_excursion", "kind_of_leg"]

Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Change:
    """A word with legs to begin with, and what has to grow from there on."""

    kind: str  # what the special point is called, or "section"
    guess: Guess
    grows: str = ""  # test of the new word that is zero at the change, positive behind it
    opens: int = -1  # leg whose duration is prescribed to begin with, -1 for none
    duration: float = 0.0


def kind_of_excursion(wiring: Wiring, mode: int, away: int) -> str:
    """What it is called where an excursion out of a mode and back into it begins.

    Names are those of M. di Bernardo, C. Budd, A. Champneys and P. Kowalczyk, Piecewise-smooth
    Dynamical Systems, 2008: a guard that is touched is a tangency of the field beside a surface,
    or, while motion slides, one at which it would leave.
    """
    if kind_of_mode(wiring, away) == SLIDES and kind_of_mode(wiring, mode) != SLIDES:
        return "grazing_sliding"
    if kind_of_mode(wiring, mode) == SLIDES and kind_of_mode(wiring, away) != SLIDES:
        return "adding_sliding"
    return "grazing"


def kind_of_leg(
    wiring: Wiring, before: int, path: tuple[int, ...], mode: int, behind: tuple[int, ...]
) -> str:
    """What it is called where a leg between two events vanishes; "" where it has no name.

    ``path`` leads from the mode before to that of the leg, ``behind`` away from it.
    """
    slaved = wiring.modes["slaved"]["words"]  # states that follow from what a mode rests on
    after = modes_along(wiring, mode, behind)[-1]
    slides = [kind_of_mode(wiring, m) == SLIDES for m in (before, mode, after)]
    same = bool((slaved[after] == slaved[before]).all())
    if slides == [False, True, False] and same and after != before:
        return "crossing_sliding"
    if (
        slides == [False, False, True]
        and len(path) == 1
        and before in modes_along(wiring, mode, behind)
    ):
        return "switching_sliding"
    return ""
