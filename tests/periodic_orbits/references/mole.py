"""Periodic orbits of the ground mole for any word, in 60 digits.

The flows are the closed forms of ``reference.mole_modes``, which the certified reference of the
mole uses too; ``certify`` passes an orbit through that reference, which asks every guard.
"""

from collections.abc import Sequence
from functools import partial
from itertools import pairwise

from mpmath import mp, mpf

from reference.mole import mole_events
from reference.mole_modes import MODES, Mole
from reference.mole_modes import State as Full

from .turn import Course, Leg, State

PARAMETERS = {"a": "0.3", "b": "0.15", "xi": "0.05", "omega": "0.1", "g": "0.02"}


def mole_of(values: dict) -> Mole:
    """Parameters as texts or numbers; phi is pi/2."""
    numbers = {name: mpf(value) for name, value in (PARAMETERS | values).items()}
    return Mole(**numbers, phi=mp.pi / 2)


def mole_course(word: str | Sequence[str], *, periods: int = 1, **values) -> Course:
    """The course of a word, whose last mode is that of the section again."""
    word = word.split() if isinstance(word, str) else list(word)
    mole = mole_of(values)
    legs = [
        Leg(
            mode,
            partial(_flow, mole, mode),
            partial(_guard, mole, mode, word[i + 1]),
            _on(mole, to),
        )
        for i, (mode, to) in enumerate(pairwise(word))
    ]
    legs.append(Leg(word[-1], partial(_flow, mole, word[-1])))
    if word[0] == "no_contact":
        return Course(legs, lambda u: (*u, mpf(0)), lambda z: z[:3], periods * mole.period)
    return Course(
        legs, lambda u: (u[1] + mole.g, *u, mpf(0)), lambda z: z[1:3], periods * mole.period
    )


def _flow(mole: Mole, mode: str, state: State, time: mpf, duration: mpf) -> State:
    return tuple(MODES[mode](mole, Full(*state), mole.omega * time + mole.phi).at(duration))


def _guard(mole: Mole, mode: str, to: str, state: State, time: mpf) -> mpf:
    full = Full(*state)
    if mode == "no_contact":
        return mole.gap(full)
    return mole.force(full) - (1 if "progression" in (mode, to) else 0)


def _on(mole: Mole, to: str):
    """Contact holds p on the slider, without the rounding of an event."""
    if to == "no_contact":
        return None
    return lambda z, time: (z[2] + mole.g, *z[1:])


def certify(case, orbit) -> bool:
    """Whether the certified reference goes through the same modes and comes back."""
    parameters = PARAMETERS | case.parameters | {"phi": mp.pi / 2}
    state = dict(zip(Full._fields, orbit.turn.states[0], strict=True))
    run = mole_events(parameters, state, case.periods)
    modes = [orbit.course.legs[0].mode, *(to for _, _, to in run.events)]
    if modes != [leg.mode for leg in orbit.course.legs]:
        return False
    misses = [abs(a - b) for a, b in zip(run.final[:3], orbit.turn.end[:3], strict=True)]
    return max(misses) < mpf(10) ** -20
