"""How far rebounds before rest are from never ending before the release.

Just before a release the acceleration is -b s with the time s until then. A rebound that leaves
with the rate u of its guard lasts x s, with q = u/(b s^2) = x/2 - x^2/6, and the next one leaves
with q' = r (x/2 - x^2/3)/(1 - x)^2 of what is left. There is one q* = q': below it q falls and
rebounds end before the release, beyond it one lasts until then. At it there are infinitely many
until the release itself, where rest and release meet. Derivatives there multiply q - q* by a
number m > 1 in each rebound, so that (q* - q)/m^n of the n-th one, as long as it is small, vanishes
with a finite slope where rest does, whatever the acceleration is farther away.

See A. Nordmark and P. Piiroinen, Nonlinear Dynamics 58, 2009.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.onto import chatters
from nonsmooth.periodic_orbits.word import Word

__all__ = ["RestMargins"]

Floats = npt.NDArray[np.float64]

_NEAR = 0.05  # of q*: farther from it rebounds are not followed
_FAR = 0.1  # of q*: rates below may be rounding, and need not be known
_LEAST = 1e-9  # of the time until the release: what is left of it is known no better
_MOST = 60  # rebounds
_STEPS = 6  # of Newton's method for a flight: from 2 q* of what is left, which is near
_HALF = 0.5  # of a flight: where its height tells how the rate damps it
_ALIKE = 0.1  # of the acceleration: a guard that differs by more from it is no release


class _Critical(NamedTuple):
    """Of rebounds of one ratio: q*, and by what a rebound multiplies a small distance from it."""

    q: float
    growth: float


class _Push(NamedTuple):
    """The acceleration -(b s + c s^2 + d s^3 + damping g') at the time s until the release."""

    b: float
    c: float
    d: float
    damping: float

    def at(self, s: float, rate: float) -> tuple[float, float, float]:
        """It, without its sign, and what changes by it in time, and that again."""
        push = s * (self.b + s * (self.c + s * self.d)) + self.damping * rate
        drift = -(self.b + s * (2.0 * self.c + 3.0 * s * self.d)) - self.damping * push
        bend = 2.0 * self.c + 6.0 * self.d * s - self.damping * drift
        return push, drift, bend

    def until(self, s: float) -> float:
        """What it adds up to from there until the release, without the part of the rate."""
        return s * s * (0.5 * self.b + s * (self.c / 3.0 + 0.25 * s * self.d))


class _Chatter(NamedTuple):
    last: int  # leg that ends with the last rebound
    rest: int  # leg of rest behind it
    end: int  # leg with which rest ends: another one where it passes the section
    release: int  # exit


class RestMargins:
    """Margins of all rebounds of an orbit before a rest that ends by their release.

    One that is far below its critical rate has the margin 1.
    """

    def __init__(self, equations: OrbitEquations) -> None:
        self._legs, word = equations.legs, equations.word
        self._word = word
        wiring, self._found = equations.legs.tables.wiring, []
        for legs in chatters(word.modes, word.paths, wiring):
            last = legs[-1]
            rest = (last + 1) % len(word)
            end = rest if word.paths[rest] else 0  # rest goes on behind the section
            if word.paths[end] and word.last_target(wiring, end) == word.modes[last]:
                self._found.append(_Chatter(last, rest, end, word.paths[end][0]))

    def values(self, turn: Turn) -> dict[int, float]:
        """Margin of each, by the leg that ends with its last rebound.

        Results that the legs hold are overwritten where there are as many of them.
        """
        found = {each.last: self._margin(each, turn) for each in self._found}
        return {k: value for k, value in found.items() if value is not None}

    def _margin(self, chatter: _Chatter, turn: Turn) -> float | None:
        k, instants = chatter.last, turn.instants
        mode, impact = self._word.modes[k], self._word.paths[k][:1]
        hit = Word((mode,), (impact,))
        found = self._legs.follow_each(hit, turn.states[[k]], instants[[k]], instants[[k + 1]])
        arrival, behind = -float(found.guard_rate[0]), found.nexts.copy()
        now = instants[[k + 1]]
        rate = float(self._legs.follow_each(hit, behind, now, now).guard_rate[0])
        left = float(turn.durations[chatter.rest])
        if chatter.end != chatter.rest:
            left += float(turn.durations[chatter.end])
        if not (0.0 < rate < arrival and left > 0.0):
            return None  # it does not rebound, or rests no time: other tests tell
        push = self._push(chatter, turn, left)
        if push is None:
            return None
        share = rate / (push.at(left, 0.0)[0] * left) / _critical(rate / arrival).q
        if share <= _FAR:
            return 1.0 - share
        # half way through a flight the rate shows that the guard of rest is what presses, and how
        # much of it comes of the rate
        first, drift, _ = push.at(left, 0.0)
        part = _HALF * min(2.0 * rate / first, left)
        there = self._legs.follow_each(hit, behind, now, now + part).guard_rate[0]
        pressed = push.until(left) - push.until(left - part)
        height = part * (rate - part * (0.5 * first + part * drift / 6.0))
        damped = rate - float(there) - pressed
        if not (abs(damped) <= _ALIKE * pressed and height > 0.0):
            return None
        push = push._replace(damping=damped / height)
        return _followed(rate, left, rate / arrival, push)

    def _push(self, chatter: _Chatter, turn: Turn, left: float) -> _Push | None:
        """What presses between the last rebound and the release, as the guard of that tells."""
        ends = [chatter.rest, chatter.end]
        word = Word(tuple(self._word.modes[j] for j in ends), ((chatter.release,),) * 2)
        begins = turn.instants[ends]
        stops = np.array([begins[0], turn.instants[chatter.end + 1]])
        found = self._legs.follow_each(word, turn.states[ends], begins, stops)
        first, drift = float(found.guard[0]), float(found.guard_rate[0])
        b = -float(found.guard_rate[1])
        if not (first > 0.0 and b > 0.0):
            return None
        over, slope = first - b * left, -drift - b
        d = (slope * left - 2.0 * over) / left**3
        return _Push(b, over / left**2 - d * left, d, 0.0)


def _critical(ratio: float) -> _Critical:
    """Those of rebounds with that ratio of the rates after and before an impact."""
    low, high = 0.0, 1.0  # of the time until the release, for the flight
    while (x := 0.5 * (low + high)) not in (low, high):
        if (3.0 - x) * (1.0 - x) ** 2 > ratio * (3.0 - 2.0 * x):
            low = x
        else:
            high = x
    q = x / 2.0 - x * x / 6.0
    slope = (0.5 - 2.0 * x / 3.0) * (1.0 - x) + x - 2.0 * x * x / 3.0
    return _Critical(q, ratio * slope / (1.0 - x) ** 3 / (0.5 - x / 3.0))


def _followed(rate: float, left: float, ratio: float, push: _Push) -> float:
    """The margin of rebounds with a rate and the time that is left until the release."""
    critical, weight, least = _critical(ratio), 1.0, _LEAST * left
    for _ in range(_MOST):
        now, jerk, snap = push.at(left, rate)
        margin = weight * (1.0 - rate / (push.at(left, 0.0)[0] * left * critical.q))
        if abs(margin) > _NEAR * weight or left <= least:
            break
        flight = 2.0 * rate / now
        for _ in range(_STEPS):
            fall = flight * (0.5 * now + flight * (jerk / 6.0 + flight * snap / 24.0))
            flight -= (fall - rate) / (0.5 * now + flight * (jerk / 3.0 + flight * snap / 8.0))
        arrival = rate - flight * (now + flight * (0.5 * jerk + flight * snap / 6.0))
        rate, left, weight = -ratio * arrival, left - flight, weight / critical.growth
        if not (rate > 0.0 and left > 0.0):
            break
    return margin
