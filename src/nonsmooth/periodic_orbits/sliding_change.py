"""How the word of an orbit goes on where motion begins to slide, or crosses before it slides.

A point where the field beside a surface is tangent to it bounds the part of the surface on which
motion slides. Beyond it an orbit that crossed there slides for a while, if that field curves away
(crossing-sliding), and one that slid from there on crosses first and comes back, if it curves
towards the surface (switching-sliding). See M. di Bernardo, C. Budd, A. Champneys and P. Kowalczyk,
Piecewise-smooth Dynamical Systems, 2008, chapter 8.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.periodic_orbits.change import Change
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.onto import modes_along, onto_beyond, targets_of_cell
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.periodic_orbits.word_names import shortest_paths

__all__ = ["off_surface_first", "onto_surface"]

_OPENED = 1e-3  # part of the turn that a leg lasts where a branch with it begins


def onto_surface(equations: OrbitEquations, turn: Turn, k: int) -> list[Change]:
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
    guess = _with_leg(equations, turn, k, entry, cell, (exits.index(beyond),))
    return [Change("crossing_sliding", guess, f"leg:{k + 1}")]


def off_surface_first(equations: OrbitEquations, turn: Turn, k: int, g: int) -> list[Change]:
    """The surface behind leg k does not hold the motion: it crosses and comes back onto it."""
    word, wiring = equations.word, equations.legs.tables.wiring
    mode, path = word.modes[k], word.paths[k]
    cell = word.last_target(wiring, k)
    beyond = int(wiring.exits["target"][cell, g])
    if beyond not in modes_along(wiring, mode, path)[1:-1]:
        return []
    # a leg of no duration would solve the equations too, so it begins with one
    length = float(turn.instants[-1] - turn.instants[0])
    duration = min(_OPENED * length, 0.5 * float(turn.durations[(k + 1) % len(word)]))
    found = []
    for back in shortest_paths(wiring, beyond, cell):
        guess = _with_leg(equations, turn, k, path[:-1], beyond, back)
        guess.turn.instants[k + 2] += duration
        found.append(Change("switching_sliding", guess, "", k + 1, duration))
    return found


def _with_leg(
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
