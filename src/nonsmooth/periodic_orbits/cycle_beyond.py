"""What the motion from a cycle does a little beyond a change of its word, as a cycle to go on with.

A driven orbit is looked at from strobe to strobe. A cycle has no such time, so its motion is
followed from a place half way along its longest leg, until it comes back to where its first event
was.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import RunError
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess, cycle_guesses
from nonsmooth.periodic_orbits.stretch import BranchStretch

__all__ = ["apart_from_cycle", "cycles_beyond"]

Floats = npt.NDArray[np.float64]

_PLACES = 200  # along each leg of a cycle, at which it is compared


def cycles_beyond(
    stretch: BranchStretch, turn: Turn, before: float, value: float
) -> Iterator[Guess]:  # fmt: skip
    """Cycles near the motion that begins on a cycle; none where it does not come back.

    ``before`` is the value of the parameter to which the cycle belongs, ``value`` that of the
    motion.
    """
    options, equations = stretch.options, stretch.equations
    low, high = options.bounds
    if not options.autonomous or equations.is_smooth_cycle or not low <= value <= high:
        return
    stretch.set_parameter(before)
    leg = int(np.argmax(turn.durations))
    middle = float(0.5 * (turn.instants[leg] + turn.instants[leg + 1]))
    state = equations.states_along(turn, np.array([middle]))[0]
    values = dict(zip(options.system.parameters, stretch.legs.values.tolist(), strict=True))
    try:
        there = options.system.with_parameters(**values | {options.parameter: value})
        yield from cycle_guesses(
            there,
            dict(zip(options.system.states, state.tolist(), strict=True)),
            period=1,
            transient=0,
            mode=options.system.structure.running[equations.word.modes[leg]].name,
            tolerance=options.tolerance,
        )
    except (RunError, ValueError):  # it ends on the way, or is refused there
        return


def apart_from_cycle(
    stretch: BranchStretch, turn: Turn, before: float, equations: OrbitEquations, unknowns: Floats
) -> float:
    """Largest distance of the states at the events of a cycle from another one, beside its size.

    And the difference of their lengths, beside the length. The other one is taken as a line of
    straight pieces, so less than 1e-4 is nothing.
    """
    new, old = equations.unpack(unknowns), stretch.equations
    stretch.set_parameter(before)
    count, drifting = len(old.word), equations.drifting
    legs = np.repeat(np.arange(count), _PLACES)
    parts = np.tile(np.linspace(0.0, 1.0, _PLACES), count)
    along = old.states_in_legs(turn, legs, turn.instants[legs] + parts * turn.durations[legs])
    along = np.where(drifting, 0.0, along)
    size = np.maximum(np.ptp(along, axis=0), 1e-300)
    points = np.where(drifting, 0.0, new.states) / size
    by_leg = along.reshape(count, _PLACES, -1) / size
    first, step = (
        each.reshape(-1, size.size) for each in (by_leg[:, :-1], np.diff(by_leg, axis=1))
    )
    away = points[:, None] - first
    part = (away * step).sum(axis=2) / np.maximum((step * step).sum(axis=1), 1e-300)
    distance = np.abs(away - np.clip(part, 0.0, 1.0)[..., None] * step).max(axis=2).min(axis=1)
    length = abs(float(np.ptp(new.instants) / np.ptp(turn.instants)) - 1.0)
    return max(float(distance.max()), length)
