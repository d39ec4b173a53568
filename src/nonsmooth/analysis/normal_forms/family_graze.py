"""Grazes of a family of cycles that all exist at one value of the parameter.

Cycles of a linear mode have any size where the motion about its rest neither grows nor decays; so
have those of a system that keeps its energy. The largest of them that has no contact touches a
guard. The return map has the multiplier 1 along the family, with the right and left eigenvectors v
and w, w v = 1. So no branch of orbits without the touch leads over the parameter, and no depth has
a rate by it. With the sum r v of the family and the jump E d^(3/2) of each touch, d = r n v being
its depth, the part of the return map along w is

    r -> r + (w P) p + sum of w E (n v)^(3/2) r^(3/2),

p being the distance of the parameter and P the derivative of the map by it. Other directions come
back to a distance from the family that is as small as the jump. So orbits with contacts exist on
one side, with depths that grow by the power 2/3 (E. Freire, E. Ponce, F. Rodrigo and F. Torres,
Bifurcation sets of continuous piecewise linear systems with two zones, International Journal of
Bifurcation and Chaos 8, 1998, for cycles in the plane).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.normal_forms.normal_form import NormalForm, side_of
from nonsmooth.analysis.normal_forms.touch import NoTouch, Touch, touch_of
from nonsmooth.periodic_orbits.equations import Turn
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.periodic_orbits.word_map import WordMap

__all__ = ["FamilyDirection", "away_from_touches", "behind_family", "direction_of_family"]

Floats = npt.NDArray[np.float64]

_ONE = 1e-6  # distance of a multiplier from 1 that its rounding may make, and the graze's
_PLACES = 32  # along a cycle, at which it may begin
_BESIDE = 1e-3  # of the sizes of the states: a cycle of the family beside the one that touches
_CLOSED = 1e-5  # of that, by which it may miss itself: at a fold a change of the same order
_ZERO = 1e-8  # of its terms: a sum that rounding may make
_POWER = 1.5
_BOTH_WAYS = "one guard is touched as cycles of a family grow, another one as they become smaller"


class FamilyDirection(NamedTuple):
    """The eigenvectors of the return map at its multiplier 1, with the product 1."""

    right: Floats
    left: Floats
    jacobian: Floats
    by_parameter: Floats


def away_from_touches(near: WordMap) -> WordMap:
    """The map of a cycle without events, begun where it is far from all guards.

    A guard that is touched just where the cycle begins has no lowest value within a leg.
    """
    equations = near.equations
    if not equations.is_smooth_cycle:
        return near
    turn, mode = equations.unpack(near.unknowns), equations.word.modes[0]
    begin, length = float(turn.instants[0]), float(turn.durations[0])
    ends = begin + np.arange(_PLACES) / _PLACES * length
    states = np.tile(turn.states[0], (_PLACES, 1))
    word = Word((mode,) * _PLACES, ((),) * _PLACES)
    found = equations.legs.follow_each(word, states, np.full(_PLACES, begin), ends)
    guards = found.others[:, np.isfinite(found.others).all(axis=0)]
    if not guards.size:
        return near
    share = guards / np.maximum(np.abs(guards).max(axis=0), 1e-300)
    state = found.ends[int(np.argmax(share.min(axis=1)))].copy()
    state[equations.drifting] = turn.states[0][equations.drifting]
    other = equations.of_word(equations.word, state)
    other.origin = equations.origin
    unknowns = other.pack(Turn(state[None], turn.instants))
    other.evaluate(unknowns)  # it gets its plane
    return WordMap(other, unknowns)


def direction_of_family(near: WordMap) -> FamilyDirection | None:
    """Where the orbit has a multiplier 1 besides that of the motion along itself; else None.

    `NoTouch` where it is not one of a family.
    """
    image = near.image(near.start, near.value)
    assert image is not None
    values, vectors = np.linalg.eig(image.by_start)
    close = np.flatnonzero(np.abs(values - 1.0) <= _ONE)
    if not close.size:
        return None
    transposed, covectors = np.linalg.eig(image.by_start.T)
    right = vectors[:, close[0]].real
    left = covectors[:, int(np.argmin(np.abs(transposed - values[close[0]])))].real
    product = float(left @ right)
    if close.size > 1 or abs(product) <= _ONE * np.linalg.norm(left) * np.linalg.norm(right):
        raise NoTouch("several multipliers of the orbit that touches are 1")
    left = left / product
    for way in (_BESIDE, -_BESIDE):
        beside = near.start + way * right
        there = near.image(beside, near.value)
        missed = np.inf if there is None else abs(float(left @ (there.point - beside)))
        if not missed <= _CLOSED * _BESIDE:
            raise NoTouch("a multiplier of the orbit that touches is 1: two things happen at once")
    return FamilyDirection(right, left, image.by_start, image.by_parameter)


def behind_family(near: WordMap, along: FamilyDirection, name: str) -> NormalForm:
    """What exists beside the cycle of a family that touches, with the side of the parameter.

    ``near``: of a cycle that begins away from its touches
    """
    touches = []
    for test in sorted(near.vanishing):
        what, *numbers = test.split(":")
        if what != "graze":
            raise NoTouch("the orbit touches something else too: two things happen at once")
        touches.append(touch_of(near, *map(int, numbers)))
    rates = np.array([float(each.gradient @ along.right) for each in touches])
    if rates.size == 0 or not (np.all(rates > 0.0) or np.all(rates < 0.0)):
        raise NoTouch(_BOTH_WAYS)
    right, left = along.right * np.sign(rates[0]), along.left * np.sign(rates[0])
    rates = np.abs(rates)
    if any(each.power != _POWER for each in touches):
        raise NoTouch(
            "orbits without the touch are a family at one value of the parameter, for which the"
            f" power law {touches[0].power:g} of the touch tells nothing"
        )
    pull, doubt = _pull(touches, rates, left)
    terms = left * along.by_parameter
    push = float(terms.sum())
    if not (abs(pull) > doubt and abs(push) > _ZERO * float(np.abs(terms).sum())):
        raise NoTouch(
            "orbits without the touch are a family at one value of the parameter, and on which side"
            " those with contacts exist is within rounding"
        )
    others = np.abs(np.linalg.eigvals(along.jacobian - np.outer(right, left)))
    outside = int(np.count_nonzero(others > 1.0 + _ONE))
    side = side_of(-pull / push)
    depth = float(rates.max()) * abs(push / pull) ** (1.0 / _POWER)
    kind = "stable" if pull < 0.0 and not outside else "unstable"
    return NormalForm(
        criticality="continuous", side=side, outside=outside, amplitude=depth,
        power=1.0 / _POWER,
        detail=f"{kind} orbits with one more contact in each place that is touched exist {side}"
        f" {name} = {near.value:.10g}, and those without are a family of cycles at that one value;"
        f" the depth is {depth:.4g} times the distance of {name} to the power of 2/3",
    )  # fmt: skip


def _pull(touches: list[Touch], rates: Floats, left: Floats) -> tuple[float, float]:
    """Sum of the jumps along the family for the size 1 of it, and by how much it may be wrong."""
    pull = doubt = 0.0
    for touch, rate in zip(touches, rates, strict=True):
        terms = left * touch.jump * rate**_POWER
        pull += float(terms.sum())
        doubt += (touch.error + _ZERO) * float(np.abs(terms).sum())
    return pull, doubt
