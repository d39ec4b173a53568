"""Where an orbit touches a guard, and what a slightly deeper touch does to the motion.

Beside an orbit that touches a guard H with no rate and the curvature c = d^2 H/dt^2, a motion that
would reach the depth d behind it comes to it with the rate -sqrt(2 c d), a time sqrt(2 d/c) before
the lowest point. What its excursion leaves behind is a power of the depth times a vector: a
zero-time discontinuity map (A. B. Nordmark, Journal of Sound and Vibration 145, 1991; M. di
Bernardo, C. J. Budd, A. R. Champneys and P. Kowalczyk, Piecewise-smooth Dynamical Systems, 2008,
chapters 6 and 7).

States are in units of their own sizes here, as those of the return map are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.normal_forms.directional import Estimate, derivative
from nonsmooth.engine.orbits import LegResults
from nonsmooth.engine.tables import members
from nonsmooth.periodic_orbits.multipliers import leg_factors
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.periodic_orbits.word_map import WordMap

__all__ = ["NoTouch", "Touch", "touch_of"]

Floats = npt.NDArray[np.float64]

_NEWTON = 8  # steps for the instant of the touch
_PART = 0.05  # of the leg: the longest step in time
_DISPLACED = 0.01  # of the sizes of the states: where rates are compared
_NONE = 1e-6  # part of what it is measured by that counts as none


class NoTouch(ArithmeticError):
    """A touch of which no power law is known; the message says why."""


class Touch(NamedTuple):
    """The return map gains ``jump`` depth^``power``, the depth being ``gradient`` (x - x*) + ..."""

    power: float
    gradient: Floats  # (m,)
    jump: Floats  # (m,)
    jacobian: Floats  # (m, m) of the return map without the excursion
    error: float  # of the jump, beside its size


class _Passed(NamedTuple):
    """Results of one leg; all states."""

    start: Floats
    start_rates: Floats
    end: Floats
    end_rates: Floats
    flow: Floats  # (n, n) derivatives of the end by the start
    next: Floats  # behind the exits
    jump_rate: Floats
    row: Floats  # derivatives of the guard at the end
    guard: float
    rate: float  # of that guard


class _Grazed(NamedTuple):
    """The motion where it touches a guard."""

    near: WordMap
    mode: int
    exit: int
    time: float
    span: float  # in which the motion can be displaced in time
    before: _Passed  # the leg up to the touch
    curvature: Estimate

    @property
    def state(self) -> Floats:
        return self.before.end

    def at(self, mode: int, path: tuple[int, ...], state: Floats, later: float = 0.0) -> _Passed:
        """A short leg from a state at the touch."""
        return _pass(self.near, mode, path, state, self.time, self.time + later)

    def length_of(self, direction: Floats) -> float:
        """How far states may be displaced along a direction."""
        return _DISPLACED / max(float(np.abs(direction).max()), 1e-300)


def touch_of(near: WordMap, leg: int, guard: int) -> Touch:
    """The touch of a guard in a leg of an orbit; `NoTouch` where it has no power law."""
    equations = near.equations
    turn = equations.unpack(near.unknowns)
    contact = _contact(near, leg, guard)
    power, kick, error = _kick(contact)
    left = _pass(near, contact.mode, (), contact.state, contact.time, turn.instants[leg + 1]).flow
    found = equations.legs.follow(equations.word, turn.states, turn.instants)
    factors = leg_factors(equations, found)
    events = _in_sizes(near, [*factors.events[:-1], _closing(near, found, factors.events[-1])])
    flows = _in_sizes(near, factors.flow)
    stays = np.ix_(near.moving, near.moving)
    before = np.eye(near.moving.size)
    for event, flow in zip(events[:leg], flows[:leg], strict=True):
        before = event @ flow @ before
    behind = events[leg]
    for event, flow in zip(events[leg + 1 :], flows[leg + 1 :], strict=True):
        behind = event @ flow @ behind
    moved = left[stays] @ kick[near.moving]
    jump = behind @ moved
    if np.all(np.abs(jump) <= _NONE * (np.abs(behind) @ np.abs(moved))):
        raise NoTouch(
            "nothing of this power is left a turn later, as where the kick is along the motion"
        )
    gradient = -contact.before.row[near.moving] @ contact.before.flow[stays] @ before
    return Touch(power, gradient, jump, behind @ flows[leg] @ before, error)


def _in_sizes(near: WordMap, matrices: Sequence[Floats] | Floats) -> Floats:
    """Matrices (L, m, m) between states that are in units of their sizes."""
    return np.asarray(matrices) * near.sizes / near.sizes[:, None]


def _closing(near: WordMap, found: LegResults, last: Floats) -> Floats:
    """The last event for the return map, which ends on the section and not at an instant."""
    equations, n = near.equations, near.equations.legs.n
    if not equations.autonomous:
        return last
    if equations.word.closes_at_event:
        shift = -found.guard_row[-1, :n] / found.guard_rate[-1]
        whole = found.jump[-1, :n].T + np.outer(found.jump_rate[-1], shift)
    else:
        normal, flow = equations.normal, found.start_rates[0]
        whole = np.eye(n) - np.outer(flow, normal) / float(normal @ flow)
    return np.asarray(whole[np.ix_(near.moving, near.moving)])


def _pass(
    near: WordMap, mode: int, path: tuple[int, ...], state: Floats, begin: float, end: float
) -> _Passed:
    """Pass one leg and keep its results."""
    legs, unit = near.equations.legs, near.sizes_of_all
    word = Word((mode,), (path,))
    found = legs.follow_each(word, (state * unit)[None], np.array([begin]), np.array([end]))
    return _Passed(
        found.starts[0] / unit, found.start_rates[0] / unit, found.ends[0] / unit,
        found.end_rates[0] / unit, found.flow[0, : legs.n].T * unit / unit[:, None],
        found.nexts[0] / unit, found.jump_rate[0] / unit, found.guard_row[0, : legs.n] * unit,
        float(found.guard[0]), float(found.guard_rate[0]),
    )  # fmt: skip


def _contact(near: WordMap, leg: int, guard: int) -> _Grazed:
    """Find the instant within a leg at which the rate of a guard vanishes."""
    equations = near.equations
    turn, mode = equations.unpack(near.unknowns), equations.word.modes[leg]
    found = equations.legs.minima(equations.word, turn.states, turn.instants)
    begin, duration = float(turn.instants[leg]), float(turn.durations[leg])
    time = begin + float(found.places[leg, guard])
    if not np.isfinite(time):
        raise NoTouch("the guard has no lowest value within the leg")
    span = min(_PART * duration, 0.5 * (time - begin), 0.5 * (begin + duration - time))
    start = turn.states[leg] / near.sizes_of_all

    def rate(later: float) -> float:
        return _pass(near, mode, (guard,), start, begin, time + later).rate

    row = _pass(near, mode, (guard,), start, begin, time).row
    if not np.any(row[near.moving]):
        raise NoTouch(
            "the guard depends on time alone, so that neighbours touch it where the orbit does"
        )
    whole = float(turn.instants[-1] - turn.instants[0])
    # as of a guard that is touched for a while, or all along, by rounding
    least = _NONE * float(np.abs(row[near.moving]).sum()) / whole**2
    for _ in range(_NEWTON):
        (curvature,) = derivative(rate, span)
        if not curvature.value > max(least, 2.0 * curvature.error):
            raise NoTouch("the guard is touched without a positive curvature over time")
        step = -rate(0.0) / curvature.value
        time += step
        if abs(step) <= 1e-13 * duration:
            break
    before = _pass(near, mode, (guard,), start, begin, time)
    return _Grazed(near, mode, guard, time, span, before, curvature)


def _kick(contact: _Grazed) -> tuple[float, Floats, float]:
    """Power of the depth, what a state differs by behind the excursion, and its relative error."""
    wiring = contact.near.equations.legs.tables.wiring
    target = int(wiring.exits["target"][contact.mode, contact.exit])
    if wiring.resets(contact.mode, contact.exit):
        if target != contact.mode:
            raise NoTouch("the exit that is touched leads to another mode with a reset")
        return _kick_of_wall(contact)
    if target < 0:
        raise NoTouch("the motion ends at the guard that is touched")
    slaved = members(wiring.modes["slaved"][[contact.mode, target]], contact.state.size)
    if np.any(slaved[1] & ~slaved[0]):
        return _kick_of_relation(contact, target)
    return _kick_of_stop(contact, target)


def _kick_of_wall(contact: _Grazed) -> tuple[float, Floats, float]:
    """Of a reset that is as large as the rate of the impact is, as at a rigid wall."""
    before, curvature = contact.before, contact.curvature
    if np.any(np.abs(before.next - before.end) > _NONE):
        raise NoTouch("the reset moves the state even where the impact has no speed")
    change = before.jump_rate - before.end_rates
    (turned,) = derivative(
        lambda h: contact.at(contact.mode, (contact.exit,), contact.state + h * change).rate,
        contact.length_of(change),
    )
    # rate of the guard behind a slow impact, over its size before it
    rebound = -1.0 - turned.value / curvature.value
    if not rebound > _NONE:
        raise NoTouch("slow impacts do not rebound, so contacts last")
    root = float(np.sqrt(2.0 / curvature.value))
    return 0.5, -root * change, 0.5 * curvature.error / curvature.value


def _kick_of_stop(contact: _Grazed, target: int) -> tuple[float, Floats, float]:
    """Of a mode with other rates behind the guard, as at a stop with a spring."""
    row, own = contact.before.row, contact.before.end_rates

    def apart(h: float) -> Floats:
        state = contact.state + h * row
        inside = contact.at(target, (), state)
        if np.any(np.abs(inside.start - state) > _NONE):
            raise NoTouch("behind the guard the motion is held on a surface")
        return inside.start_rates - contact.at(contact.mode, (), state).start_rates

    jump = apart(0.0)
    large = np.abs(jump) > _NONE * np.maximum(np.abs(own), _NONE / contact.span)
    root, blur = np.sqrt(2.0 / contact.curvature.value), contact.curvature
    if np.any(large):
        if abs(float(row @ jump)) > _NONE * float(np.abs(row) @ (np.abs(own) + np.abs(jump))):
            raise NoTouch("the rate of the guard jumps behind it, as where motion can slide")
        inside = _curvature_inside(contact, target)
        longer = 2.0 * contact.curvature.value / inside.value
        return 0.5, longer * root * jump, inside.error / inside.value + blur.error / blur.value
    # rates differ by a vector times the guard, if they do not differ along the motion too
    grown = derivative(apart, contact.length_of(row))
    growth = np.array([each.value for each in grown]) / float(row @ row)
    doubt = max(each.error for each in grown) / float(row @ row)
    largest = float(np.abs(growth).max())
    if not largest > 2.0 * doubt:
        raise NoTouch("rates on both sides of the guard agree in their first derivatives too")
    along = derivative(lambda later: _apart_along(contact, target, later), contact.span)
    least = _NONE * largest * blur.value * contact.span
    if any(abs(each.value) > least + 2.0 * each.error for each in along):
        raise NoTouch("the force behind the guard depends on the speed too, as that of a damper")
    error = doubt / largest + 0.5 * blur.error / blur.value
    return 1.5, -(4.0 / 3.0) * root * growth, error


def _apart_along(contact: _Grazed, target: int, later: float) -> Floats:
    """By how much the rates of two modes differ along the motion through the touch."""
    state, at = contact.at(contact.mode, (), contact.state, later).end, contact.time + later
    inside, own = (_pass(contact.near, m, (), state, at, at) for m in (target, contact.mode))
    return inside.start_rates - own.start_rates


def _kick_of_relation(contact: _Grazed, target: int) -> tuple[float, Floats, float]:
    """Of a mode in which a relation sets a state, and that is left when another guard is zero.

    That guard F, as the force of a damper, is zero at the touch. A deeper motion comes with an F as
    large as the root of the depth, and F falls at its own rate. So the contact lasts a part
    of the way to the lowest point, and what it leaves behind is as large as the depth itself.
    """
    wiring = contact.near.equations.legs.tables.wiring
    exits = [
        e
        for e in range(int(wiring.modes["n_exits"][target]))
        if int(wiring.exits["target"][target, e]) == contact.mode
    ]
    if len(exits) != 1:
        raise NoTouch("not exactly one exit leads back from the mode behind the guard")
    path = (exits[0],)

    def apart(state: Floats, later: float) -> tuple[Floats, float]:
        at = contact.time + later
        inside = _pass(contact.near, target, path, state, at, at)
        own = _pass(contact.near, contact.mode, (), state, at, at).start_rates
        return inside.start_rates - own, inside.guard

    def outside(later: float) -> Floats:
        return np.append(*apart(contact.at(contact.mode, (), contact.state, later).end, later))

    jump, force = apart(contact.state, 0.0)
    before = derivative(outside, contact.span)
    fall = contact.at(target, path, contact.state).rate
    span = contact.span
    if abs(force) > _NONE * abs(fall) * span or np.any(
        np.abs(jump) > _NONE * np.maximum(np.abs(contact.before.end_rates), 1.0 / span)
    ):
        raise NoTouch("the motion behind the guard begins with other rates, or does not end")
    ratio = before[-1].value / fall  # duration of the contact, over the way to the lowest point
    if not (fall < 0.0 and ratio > _NONE):
        raise NoTouch("behind the guard motions are not let go, so contacts last")
    within = derivative(
        lambda later: apart(contact.at(target, path, contact.state, later).end, later)[0], span
    )
    square = 2.0 / contact.curvature.value
    terms = np.array(
        [
            (-first.value * ratio, 0.5 * second.value * ratio**2)
            for first, second in zip(before[:-1], within, strict=True)
        ]
    )
    doubt = max(each.error for each in (*before[:-1], *within)) * max(ratio, ratio**2)
    # the force has a unit of its own
    blur = contact.curvature.error / contact.curvature.value + before[-1].error / abs(fall * ratio)
    error = doubt / max(float(np.abs(terms).max()), 1e-300) + blur
    return 1.0, square * terms.sum(axis=1), error


def _curvature_inside(contact: _Grazed, target: int) -> Estimate:
    """Curvature of the guard in the mode behind it, by the exit that leads back."""
    wiring, row = contact.near.equations.legs.tables.wiring, contact.before.row
    for e in range(int(wiring.modes["n_exits"][target])):
        if int(wiring.exits["target"][target, e]) != contact.mode:
            continue
        back = contact.at(target, (e,), contact.state).row
        factor = float(back @ row) / float(row @ row)
        if np.abs(back - factor * row).max() > _NONE * np.abs(back).max():
            continue

        def rate(later: float, e: int = e) -> float:
            return contact.at(target, (e,), contact.state, later).rate

        (slope,) = derivative(rate, contact.span)
        inside = Estimate(slope.value / factor, abs(slope.error / factor))
        if not inside.value > inside.error:
            raise NoTouch("behind the guard motions are not pushed back, so contacts last")
        return inside
    raise NoTouch("no exit at the same guard leads back from the mode behind it")
