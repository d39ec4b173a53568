"""Whether a multiplier has no bound where an orbit grazes a rigid wall.

Behind an impact of speed v perturbations have moved by k (h y)/v, k being the kick that the reset
gives to the flow, h the derivative of the gap, y the perturbation before. A turn later the gap has
changed by h M k (h y)/v, M being what the turn does between. So a multiplier grows like h M k/v,
unless h M k is zero: where k is along the flow, as in the plane if nothing drives the motion, since
the gap of a graze rests; where sticking or sliding wipes out all but the flow; or where the turn
does not carry the kick to the gap. Then multipliers have limits. See A. Nordmark, Non-periodic
motion caused by grazing incidence in an impact oscillator, J. Sound Vib. 145 (1991) 279-297.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.multipliers import leg_factors
from nonsmooth.periodic_orbits.word_change import changes_of_word

__all__ = ["has_pole"]

_NONE = 1e-6  # of what it could be: a part of a vector that is rounding, as at a speed of 1e-8


def has_pole(equations: OrbitEquations, turn: Turn, name: str) -> bool:
    """Whether a multiplier has no bound where the test of this name is zero, for what it touches.

    The legs of the equations stand for the parameters of the point.
    """
    kind, *numbers = name.split(":")
    if kind not in ("graze", "rate", "corner"):
        return False
    word, k = equations.word, int(numbers[0])
    e = word.paths[k][0] if kind == "rate" else int(numbers[1])
    if not equations.legs.tables.wiring.resets(word.modes[k], e):
        return False
    if kind != "rate":
        changes = changes_of_word(equations, turn, name)
        if not changes:
            return True
        guess = changes[0].guess
        equations, turn = equations.of_word(guess.word, guess.turn.states[0]), guess.turn
        k = int(changes[0].grows.split(":")[1])
    return _comes_back(equations, turn, k)


def _comes_back(equations: OrbitEquations, turn: Turn, k: int) -> bool:
    """Whether the kick at the end of leg k changes the gap there a turn later."""
    found = equations.legs.follow(equations.word, turn.states, turn.instants)
    factors = leg_factors(equations, found, modulo_flow=equations.autonomous)
    kick, guard = factors.kicks[k], factors.guards[k]
    whole = leg_factors(equations, found).kicks[k]
    if not np.linalg.norm(kick) > _NONE * np.linalg.norm(whole):
        return False
    count = len(equations.word)
    for j in [(k + i) % count for i in range(1, count + 1)]:
        matrix = factors.flow[j] if j == k else factors.events[j] @ factors.flow[j]
        moved = matrix @ kick
        size = float(np.linalg.norm(moved))
        if not size > _NONE**2 * np.linalg.norm(matrix) * np.linalg.norm(kick):
            return not np.isfinite(size)
        kick = moved / size
    return bool(abs(guard @ kick) > _NONE * np.linalg.norm(guard))
