"""An orbit with as many rebounds as the engine follows before it lets a body rest.

The engine follows them until the time that is left is beyond the last digit (`engine/rebounds`).
Along a branch their number changes, although nothing happens: words that differ in it have the same
orbit, to rounding. The one that the engine runs is put in place of the other.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import EventKind, Status
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.onto import chatters
from nonsmooth.periodic_orbits.word import Word, path_of_bits
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.runner import NoMode, run_plan

__all__ = ["with_rebounds_of_engine"]

Floats = npt.NDArray[np.float64]

_MOST = 2000  # rebounds that are followed


def with_rebounds_of_engine(
    equations: OrbitEquations, turn: Turn, tolerance: float
) -> Guess | None:
    """The orbit with as many rebounds in each chatter as the engine follows from the first of them.

    None where the motion does not come to rest as the orbit does.
    """
    word, wiring = equations.word, equations.legs.tables.wiring
    found = Guess(word, turn)
    for legs in sorted(chatters(word.modes, word.paths, wiring), key=lambda each: -each[-1]):
        # of rebounds on both sides of the section those behind it
        inside = [k for i, k in enumerate(legs) if all(k <= other for other in legs[i:])]
        if inside[-1] + 1 == len(word):  # rest begins where the turn does
            return None
        changed = _followed(equations, found, inside[0], inside[-1], tolerance)
        if changed is None:
            return None
        found = changed
    return found


def _followed(
    equations: OrbitEquations, guess: Guess, first: int, last: int, tolerance: float
) -> Guess | None:
    """The same with the rebounds of the engine in legs ``first`` to ``last``."""
    word, turn = guess
    legs = equations.legs
    mode, path = word.modes[first], word.paths[last]
    begin = float(turn.instants[first] + 0.5 * turn.durations[first])
    end = float(turn.instants[last + 2])  # of rest, before which other rebounds may begin it
    leg = Word((mode,), ((),))
    there = legs.follow_each(
        leg, turn.states[first : first + 1], turn.instants[first : first + 1], np.array([begin])
    )
    window = legs.window
    instants = [Instant(int(t // window), t - (t // window) * window) for t in (begin, end)]
    plan = Plan(instants[1], np.zeros(0, np.int64), np.zeros(0))
    try:
        outcome = run_plan(
            legs.tables, plan, tolerance, state=there.ends[0].copy(), begin=instants[0], mode=mode
        )
    except NoMode:
        return None
    rows, states = outcome.unless_interrupted().events, outcome.event_states[:, 1]
    lasting = ~np.isin(rows["kind"], (EventKind.GRAZE, EventKind.START))
    rows, states = rows[lasting][:_MOST], states[lasting][:_MOST]
    paths = [path_of_bits(int(r["path"]), int(r["passes"])) for r in rows]
    if path in paths:
        paths = paths[: paths.index(path) + 1]
        rows, states = rows[: len(paths)], states[: len(paths)]
    wanted = [path[:1]] * (len(paths) - 1) + [path]
    if outcome.status != Status.COMPLETED or paths != wanted:
        return None
    times = rows["number"] * window + rows["phase"]
    count = len(paths)
    new = Word(
        (*word.modes[:first], *[mode] * count, *word.modes[last + 1 :]),
        (*word.paths[:first], *wanted, *word.paths[last + 1 :]),
    )
    return Guess(
        new,
        Turn(
            np.vstack([turn.states[: first + 1], states[:-1], turn.states[last + 1 :]]),
            np.concatenate([turn.instants[: first + 1], times, turn.instants[last + 2 :]]),
        ),
    )
