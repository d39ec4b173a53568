"""How an orbit lies to its mirror image: whether it is its own, and what half a turn does then.

Along an orbit that is its own image half a turn later, the motion over half a turn followed by the
symmetry is a map with the orbit as a fixed point, and the map over a turn is its square. Where a
multiplier of that map is -1 the orbit loses its symmetry, where it is 1 the orbit meets a fold; the
multiplier over a turn is 1 in both cases. See J. W. Swift and K. Wiesenfeld, Suppression of period
doubling in symmetric systems, Physical Review Letters 52 (1984).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.orbits import LegResults
from nonsmooth.errors import ModelError
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.multipliers import leg_factors
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.system.symmetry.mirror import Mirror

__all__ = ["Reflection", "half_turn_later", "is_antisymmetric", "mirror_image", "reflection"]

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]

_SHARES = np.array([0.0, 0.137, 0.289, 0.411])  # of the turn, where it is looked at
_SAME_AT_CROSSING = 1e-3  # likewise, where stiff walls leave fewer digits across the branch
_SAME = 1e-6  # of the size of each state: where branches cross, orbits are found to half the digits
_AT_EVENT = 1e-9  # part of the turn: half of it ends at an event


def _mirror_at(legs: Legs) -> Mirror | None:
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
    mirror = _mirror_at(equations.legs)
    assert mirror is not None  # the caller has asked for a system with a symmetry
    if mirror.half_period and not equations.autonomous:
        turn, word = _begun_earlier(equations, turn)
    else:
        word = equations.word
    image = _image_of_word(mirror, word)
    return None if image is None else Guess(image, Turn(mirror.states(turn.states), turn.instants))


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
    between = equations.states_along(turn, np.array([cut]))
    # what drifts has gone on by one turn where the legs before the cut come behind the others
    over = equations.carried(_end(equations, turn) - turn.states[0])
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


class Reflection(NamedTuple):
    """An orbit beside its image under a symmetry.

    ``later`` is the part of the turn after which it is its own image: half a turn, or none where
    all of it lies in the mirror, or less than half where the turn repeats a shorter one. None
    where it is not its own image. ``multipliers`` are those of half a turn followed by the
    symmetry, the largest first, without that of the motion along itself.
    """

    later: float | None
    multipliers: Complexes

    @property
    def symmetric(self) -> bool:
        """Whether the orbit is its own image."""
        return self.later is not None


def reflection(
    equations: OrbitEquations, turn: Turn, *, at_crossing: bool = False
) -> Reflection | None:
    """An orbit beside its image under the declared symmetry; None where none is declared.

    ``at_crossing``: where branches cross, few digits of an orbit are known across its own one.
    """
    mirror = _mirror_at(equations.legs)
    if mirror is None:
        return None
    matrix, offset = mirror.matrix, mirror.states.offset
    possible = _possible(equations, half_period=mirror.half_period)
    within = _SAME_AT_CROSSING if at_crossing else _SAME
    own = (
        each for each in possible if _is_own_image(equations, turn, each, matrix, offset, within)
    )
    later = next(own, None)
    halves = _half_multipliers(equations, turn, matrix) if later == 0.5 else np.zeros(0, complex)
    return Reflection(later, halves)


def half_turn_later(equations: OrbitEquations, name: str) -> str:
    """Test of a word, such as "rate:2", that an own image has half a turn after this one.

    "" where there is none: tests of the leg that the section cuts are those of a part of it.
    """
    word, mirror = equations.word, _mirror_at(equations.legs)
    kind, *numbers = name.split(":")
    events = len(word) - (not word.closes_at_event)
    if mirror is None or not events or events % 2 or not (numbers and numbers[0].isdigit()):
        return ""
    k = int(numbers[0])
    later = (k + events // 2) % events
    is_cut = not word.closes_at_event and 0 in (k, later)
    if k >= events or (is_cut and kind in ("leg", "graze")):
        return ""
    if kind in ("graze", "corner", "over", "enter"):
        # guards of "over" and "enter" are those of the next leg
        mode = word.modes[(k + (kind in ("over", "enter"))) % len(word)]
        image = mirror.path(mode, (int(numbers[1]),))
        return "" if image is None else f"{kind}:{later}:{image[0]}"
    return ":".join([kind, str(later), *numbers[1:]])


def is_antisymmetric(equations: OrbitEquations, turn: Turn, own: Reflection | None) -> bool:
    """Whether the direction with the multiplier nearest to 1 is one that breaks the symmetry.

    Without a declared symmetry this is taken to be so where all states change their signs half a
    turn later.
    """
    if own is None:
        n = equations.legs.n
        return _is_own_image(equations, turn, 0.5, -np.eye(n), np.zeros(n))
    if own.later == 0.0:
        return _is_odd(equations, turn)
    if own.later != 0.5:
        return False
    if not own.multipliers.size or not np.all(np.isfinite(own.multipliers)):
        return True  # at a graze nothing else is known
    nearest = own.multipliers[np.argmin(np.abs(own.multipliers**2 - 1.0))]
    return bool(nearest.real < 0.0)


def _possible(equations: OrbitEquations, *, half_period: bool) -> Iterator[float]:
    """Parts of a turn after which an orbit may be its own image.

    The image of a driven orbit is the same orbit some whole periods later; applied twice, that is
    a whole turn. A turn of an even number of periods may repeat a shorter one, so quarters and so
    on count too.
    """
    steps = 2 * equations.period if equations.autonomous or half_period else equations.period
    if equations.autonomous or not half_period:
        yield 0.0
    later = 0.5
    while steps % 2 == 0:
        whole_periods = half_period and not equations.autonomous and steps % 4 == 0
        if not whole_periods:
            yield later
        steps, later = steps // 2, 0.5 * later


def _is_own_image(
    equations: OrbitEquations, turn: Turn, later: float, matrix: Floats, offset: Floats,
    within: float = _SAME,
) -> bool:  # fmt: skip
    length, shares = float(turn.instants[-1] - turn.instants[0]), _places(equations, turn, later)
    now = equations.states_along(turn, turn.instants[0] + shares * length)
    then = equations.states_along(turn, turn.instants[0] + (shares + later) * length)
    keep = ~equations.drifting
    images = now @ matrix.T + offset
    size = np.abs(np.concatenate([images, then, turn.states])).max(axis=0)[keep]
    return bool(keep.any() and np.all(np.abs(images - then)[:, keep] <= within * (size + 1e-300)))


def _places(equations: OrbitEquations, turn: Turn, later: float) -> Floats:
    """Parts of the turn at which an orbit is compared with itself that much later.

    Rounding decides on which side of a reset a state is that lies at one.
    """
    first, length = turn.instants[0], float(turn.instants[-1] - turn.instants[0])
    events = turn.instants if equations.word.closes_at_event else turn.instants[1:-1]
    events = (events - first) / length
    events = np.concatenate([events, events - later]) % 1.0
    if not events.size:
        return _SHARES
    apart = np.abs((_SHARES[:, None] - events + 0.5) % 1.0 - 0.5).min(axis=1)
    within = np.sort(events[events < 1.0 - later])
    edges = np.concatenate([[0.0], within, [1.0 - later]])
    widest = int(np.argmax(np.diff(edges)))
    middle = 0.5 * (edges[widest] + edges[widest + 1])
    return np.append(_SHARES[apart > _AT_EVENT], middle)


def _half_multipliers(equations: OrbitEquations, turn: Turn, matrix: Floats) -> Complexes:
    """Multipliers of half a turn followed by the symmetry; nan where an event has no rate."""
    stays = ~equations.drifting
    mapped = matrix[stays][:, stays]
    product = _half_tangent(equations, turn)
    if not np.all(np.isfinite(product)):
        return np.full(len(mapped) - equations.autonomous, np.nan, complex)
    values = np.linalg.eigvals(mapped @ product).astype(complex)
    if equations.autonomous and values.size:
        values = np.delete(values, int(np.argmin(np.abs(values - 1.0))))
    return values[np.argsort(-np.abs(values), kind="stable")]


def _half_tangent(equations: OrbitEquations, turn: Turn) -> Floats:
    """What the first half of a turn does to perturbations."""
    length = float(turn.instants[-1] - turn.instants[0])
    half = turn.instants[0] + 0.5 * length
    found = _follow(equations, turn)
    factors = leg_factors(equations, found)
    nearest = int(np.argmin(np.abs(turn.instants - half)))
    ends_at_event = abs(turn.instants[nearest] - half) <= _AT_EVENT * length
    whole = nearest if ends_at_event else int(np.searchsorted(turn.instants, half)) - 1
    events = factors.events[:whole].copy()
    at_section = turn.durations[0] <= _AT_EVENT * length and not equations.word.closes_at_event
    if ends_at_event and at_section:  # that event is in the first half, its image in the second one
        events[-1] = np.eye(events.shape[1])
    product = _carried(factors.flow[:whole], events)
    if not ends_at_event:
        stays, n = ~equations.drifting, equations.legs.n
        part = equations.legs.follow_each(
            Word((equations.word.modes[whole],), ((),)), turn.states[whole : whole + 1],
            turn.instants[whole : whole + 1], np.array([half]),
        )  # fmt: skip
        product = part.flow[0, :n].T[stays][:, stays] @ product
    return product


def _carried(flows: Floats, events: Floats) -> Floats:
    """What legs with the events at their ends do to perturbations; nan where an event has no rate.

    shapes: flows and events (K, n, n); returns (n, n)
    """
    product = np.eye(flows.shape[1])
    if not np.all(np.isfinite(events)):
        return np.full_like(product, np.nan)
    for flow, event in zip(flows, events, strict=True):
        product = event @ flow @ product
    return product


def _is_odd(equations: OrbitEquations, turn: Turn) -> bool:
    """Whether the symmetry reverses the critical direction of an orbit that lies in its mirror."""
    mirror = _mirror_at(equations.legs)
    assert mirror is not None  # or the orbit would have no mirror to lie in
    factors = leg_factors(equations, _follow(equations, turn))
    stays = ~equations.drifting
    product = _carried(factors.flow, factors.events)
    if not np.all(np.isfinite(product)):
        return True
    values, vectors = np.linalg.eig(product)
    mapped = mirror.matrix[stays][:, stays]
    direction = vectors[:, int(np.argmin(np.abs(values - 1.0)))]
    return bool((direction.conj() @ mapped @ direction).real < 0.0)


def _follow(equations: OrbitEquations, turn: Turn) -> LegResults:
    return equations.legs.follow(equations.word, turn.states, turn.instants)
