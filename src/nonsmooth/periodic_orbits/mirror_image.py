"""The mirror image of an orbit under the declared symmetry of its system, leg by leg."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.system.symmetry.mirror import Mirror

__all__ = ["mirror_at", "mirror_image", "states_along"]

Floats = npt.NDArray[np.float64]


def mirror_at(legs: Legs) -> Mirror | None:
    """The symmetry for the parameter values of the legs, on which its map of states may depend.

    Where it does not hold at these, the map is that of the system.
    """
    mirror = legs.system.mirror
    if mirror is None or not mirror.states.varies:
        return mirror
    values = dict(zip(legs.system.parameters, legs.values.tolist(), strict=True))
    try:
        return legs.system.with_parameters(**values).mirror
    except ModelError:
        return mirror


def mirror_image(equations: OrbitEquations, turn: Turn) -> Guess | None:
    """Legs of the mirror image; None where the word has an exit or a mode without an image.

    The image of a driven orbit comes an odd number of half periods later, or at the same time, and
    begins at the section all the same. After an odd number of periods that is half a turn, so that
    the image of the image is the orbit from its start. The engine has not looked at the image: it
    is a motion where the orbit is one and the symmetry holds for the parameter values of the legs.
    """
    mirror = mirror_at(equations.legs)
    assert mirror is not None  # the caller has asked for a system with a symmetry
    if mirror.half_period and not equations.autonomous:
        turn, word = _begun_earlier(equations, turn)
    else:
        word = equations.word
    image = _image_of_word(mirror, word)
    return None if image is None else Guess(image, Turn(mirror.states(turn.states), turn.instants))


def states_along(equations: OrbitEquations, turn: Turn, times: Floats) -> Floats:
    """States of an orbit at some times within its turn, (K, n)."""
    legs = np.searchsorted(turn.instants[1:-1], times, side="right")
    word = Word(tuple(equations.word.modes[k] for k in legs), ((),) * times.size)
    found = equations.legs.follow_each(word, turn.states[legs], turn.instants[legs], times)
    return found.ends.copy()


def _image_of_word(mirror: Mirror, word: Word) -> Word | None:
    """Images of modes and exits."""
    modes = tuple(mirror.modes[mode] for mode in word.modes)
    paths = [mirror.path(mode, path) for mode, path in zip(word.modes, word.paths, strict=True)]
    known = tuple(path for path in paths if path is not None)
    return Word(modes, known) if min(modes) >= 0 and len(known) == len(paths) else None


def _begun_earlier(equations: OrbitEquations, turn: Turn) -> tuple[Turn, Word]:
    """The same orbit begun some half periods before the end of its turn, at times of its image."""
    word, period = equations.word, equations.period
    first, last = turn.instants[0], turn.instants[-1]
    halves = period if period % 2 else 1
    cut = last - 0.5 * halves * equations.legs.window
    k = int(np.searchsorted(turn.instants[1:-1], cut, side="right"))
    between = states_along(equations, turn, np.array([cut]))
    # what drifts has gone on by one turn where the legs before the cut come behind the others
    over = np.where(equations.drifting, _end(equations, turn) - turn.states[0], 0.0)
    if len(word) == 1:
        return Turn(between, turn.instants), word
    # the last leg goes on as the first one: the section between them is no event of the image
    states = np.concatenate([between, turn.states[k + 1 :], turn.states[1 : k + 1] + over])
    events = [turn.instants[k + 1 : -1] - cut, turn.instants[1 : k + 1] - first + (last - cut)]
    modes = (*word.modes[k:], *word.modes[1 : k + 1])
    paths = (*word.paths[k:-1], *word.paths[:k], ())
    instants = np.concatenate([[first], *(first + part for part in events), [last]])
    return Turn(states, instants), Word(modes, paths)


def _end(equations: OrbitEquations, turn: Turn) -> Floats:
    found = equations.legs.follow(equations.word, turn.states, turn.instants)
    return found.ends[-1].copy()
