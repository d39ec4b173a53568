"""Two events change places where the leg between them lasts no time.

Both orders have to lead to the same state, as where two surfaces are crossed, two bodies hit their
stops, or two clocks tick. Where both events lead back to their mode, and both orders lead
perturbations to the same place, nothing happens to the orbit. Else its branch has a corner there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import Wiring
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.multipliers import leg_factors
from nonsmooth.periodic_orbits.onto import modes_along, onto_beyond, targets_of_cell
from nonsmooth.periodic_orbits.touches import GONE, Change
from nonsmooth.periodic_orbits.word import Word

__all__ = ["in_other_order"]

Floats = npt.NDArray[np.float64]
Path = tuple[int, ...]

_ALIKE = 1e-6  # part by which derivatives differ that both orders share


@dataclass(frozen=True)
class _Order:
    """Exits of the event that comes first, the mode between both, and exits of the second one."""

    first: Path
    middle: int
    second: Path
    between: Floats  # state there


def in_other_order(equations: OrbitEquations, turn: Turn, k: int) -> list[Change]:
    """The events before and behind leg k, which lasts no time, change places."""
    word, count, legs = equations.word, len(equations.word), equations.legs
    if count < 2 or not (word.closes_at_event or 0 < k < count - 1):
        return []
    before, length = (k - 1) % count, float(turn.durations.sum())
    found = legs.follow(word, turn.states, turn.instants)
    # of drifts and angles, where the turn ends between the events
    left_open = found.nexts[before] - turn.states[k]
    # states may be zero at all events
    sizes = np.abs(turn.states).max(axis=0) + np.abs(found.start_rates).max(axis=0) * length
    behind, derivative = _behind_both(equations, turn, k)
    changes = []
    for order in _orders(equations, turn, k):
        modes, paths, states = list(word.modes), list(word.paths), turn.states.copy()
        modes[k], paths[before], paths[k] = order.middle, order.first, order.second
        states[k] = order.between - left_open
        guess = Guess(Word(tuple(modes), tuple(paths)), Turn(states, turn.instants))
        there, other = _behind_both(equations.of_word(guess.word, states[0]), guess.turn, k)
        if np.any(np.abs(there - behind) > GONE * sizes):
            continue
        alike = guess.word.modes == word.modes and np.allclose(
            other, derivative, rtol=0.0, atol=_ALIKE * np.abs(derivative).max(initial=1.0)
        )
        changes.append(Change("section" if alike else "corner", guess, f"leg:{k}"))
    return changes


def _behind_both(equations: OrbitEquations, turn: Turn, k: int) -> tuple[Floats, Floats]:
    """The state behind both events, and its derivative by that before them."""
    found = equations.legs.follow(equations.word, turn.states, turn.instants)
    factors = leg_factors(equations, found)
    both = factors.events[k] @ factors.flow[k] @ factors.events[k - 1]
    return found.nexts[k].copy(), both


def _orders(equations: OrbitEquations, turn: Turn, k: int) -> Iterator[_Order]:
    """Other ways than that of the word from the mode before both events to the mode behind them."""
    word, legs = equations.word, equations.legs
    wiring, before = legs.tables.wiring, (k - 1) % len(word)
    mode, behind = word.modes[before], word.last_target(wiring, k)
    begin, end = turn.instants[before], turn.instants[before + 1]
    still = GONE * float(turn.durations.sum())
    for first in _paths(wiring, mode):
        if first[0] == word.paths[before][0]:
            continue
        between = _met(legs, mode, first, turn.states[before], (begin, end), still)
        if between is None:
            continue
        middle = modes_along(wiring, mode, first)[-1]
        for second in _paths(wiring, middle):
            leads_there = modes_along(wiring, middle, second)[-1] == behind
            if leads_there and _met(legs, middle, second, between, (end, end), still) is not None:
                yield _Order(first, middle, second, between)


def _met(
    legs: Legs, mode: int, path: Path, start: Floats, span: tuple[float, float], still: float
) -> Floats | None:
    """The state behind a path whose guard is zero at the end of a leg; None where it is not."""
    try:
        found = legs.follow_each(Word((mode,), (path,)), start[None], *map(np.atleast_1d, span))
    except LegError:
        return None
    met = abs(float(found.guard[0])) <= still * abs(float(found.guard_rate[0]))
    return found.nexts[0].copy() if met else None


def _paths(wiring: Wiring, mode: int) -> Iterator[Path]:
    """Exits of a mode, alone and onto their surface."""
    for e, target in enumerate(targets_of_cell(wiring, mode)):
        if target < 0:
            continue
        yield (e,)
        rests = int(wiring.exits["onto"][mode, e]) if wiring.resets(mode, e) else -1
        onto = rests if rests >= 0 else onto_beyond(wiring, mode, e)
        if onto >= 0:
            yield (e, onto)
