"""What follows from a graze: powers of the depth, and the motions behind it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.normal_forms.directional import Estimate, derivative
from nonsmooth.analysis.normal_forms.family_graze import (
    away_from_touches,
    behind_family,
    direction_of_family,
)
from nonsmooth.analysis.normal_forms.normal_form import UNDECIDED, NormalForm, side_of
from nonsmooth.analysis.normal_forms.touch import NoTouch, Touch, touch_of
from nonsmooth.periodic_orbits.word_map import WordMap

__all__ = ["form_of_grazing", "scenario_behind"]

Floats = npt.NDArray[np.float64]

_ON_CIRCLE = 1e-6  # distance of a multiplier from the unit circle
_LONGEST = 5000  # iterates after which a further impact is looked for
_SETTLED = 1e-6  # of the direction of iterates: they go along one eigenvector from there on
_ZERO = 1e-8  # of its terms: a sign that rounding may make
_PERIODIC, _CHAOTIC = 0.25, 2.0 / 3.0  # multipliers between which the motions behind change
_SHARE = 1e-3  # of the parameter's width: the longest step by which the depth is differentiated


def form_of_grazing(near: WordMap, test: str, width: float, name: str) -> NormalForm:
    """The power law of a graze, and what begins behind it.

    test: what vanishes there, by the name of `BranchTests`
    """
    what, *numbers = test.split(":")
    if what != "graze":
        return NormalForm(
            detail="the graze was located from the side of its contacts: begin the branch with the"
            " orbit that does not touch"
        )
    leg, guard = map(int, numbers)
    elsewhere = away_from_touches(near)
    try:
        along = direction_of_family(elsewhere)
        if along is not None:
            return behind_family(elsewhere, along, name)
        if (near.vanishing | elsewhere.vanishing) - {test}:
            raise NoTouch("the orbit touches something else too: two things happen at once")
        touch = touch_of(near, leg, guard)
        depth = _rate_of_depth(near, leg, guard, width)
    except NoTouch as fault:
        return NormalForm(detail=str(fault))
    jump = touch.jump * near.sizes
    length = float(np.linalg.norm(jump))
    form = NormalForm(
        coefficient=float(touch.gradient @ touch.jump), rate=depth.value, rate_error=depth.error,
        amplitude=length, power=touch.power,
        right=(jump / max(length, 1e-300)).astype(complex),
        left=(touch.gradient / near.sizes).astype(complex),
    )  # fmt: skip
    values = np.abs(np.linalg.eigvals(touch.jacobian))
    form.outside = int(np.count_nonzero(values > 1.0 + _ON_CIRCLE))
    form.error = touch.error * float(np.abs(touch.gradient * touch.jump).sum())
    if depth.decided:
        form.side = side_of(depth.value)
    where = f"{form.side} {name} = {near.value:.10g}" if form.side else "behind the graze"
    if touch.power == 1.0:
        form.criticality, form.detail = _at_a_corner(touch, where)
    elif touch.power > 1.0:
        form.criticality = "continuous"
        form.detail = (
            f"the orbit goes on, with one more contact {where}: the depth to the power of 3/2"
            " leaves multipliers continuous, and they change by its root at first"
        )
    else:
        form.criticality, form.detail = scenario_behind(touch, where)
    return form


def _rate_of_depth(near: WordMap, leg: int, guard: int, width: float) -> Estimate:
    """Rate of the depth by the parameter, along the branch of orbits without the touch."""
    image = near.image(near.start, near.value)
    assert image is not None
    unit = np.eye(near.start.size)
    slope = np.linalg.solve(unit - image.by_start, image.by_parameter)
    size = max(np.abs(slope).max(initial=0.0), 1.0 / width)
    legs, word = near.equations.legs, near.equations.word

    def depth(h: float) -> float:
        there = near.image(near.start + h * slope, near.value + h)
        if there is None:
            raise NoTouch("the orbit has no neighbours over the parameter")
        near.set_parameter(near.value + h)
        turn = near.equations.unpack(there.unknowns)
        lowest = legs.minima(word, turn.states, turn.instants).values[leg, guard]
        near.set_parameter(near.value)
        return -float(lowest)

    (rate,) = derivative(depth, _SHARE / size)
    return rate


def _at_a_corner(touch: Touch, where: str) -> tuple[str, str]:
    """Where the return map is linear on both sides of the graze, with two derivatives.

    The depth y of the orbit with a contact solves (1 - n (I - A)^-1 E) y = y0, y0 being that of the
    orbit without.
    """
    unit = np.eye(touch.jump.size)
    share = 1.0 - float(touch.gradient @ np.linalg.solve(unit - touch.jacobian, touch.jump))
    before = _largest(touch.jacobian)
    behind = _largest(touch.jacobian + np.outer(touch.jump, touch.gradient))
    told = f"the largest multiplier jumps from {before:.6g} to {behind:.6g}"
    if not abs(share) > _ZERO + touch.error:
        return UNDECIDED, f"a multiplier behind the graze may be 1; {told}"
    if share < 0.0:
        return "nonsmooth fold", (
            f"the orbit with one more contact turns back, beside the one without; {told}"
        )
    return "continuous", f"the orbit goes on, with one more contact {where}; {told}"


def _largest(matrix: Floats) -> complex:
    """The largest multiplier, as a real number where it is one."""
    values = np.linalg.eigvals(matrix)
    value = complex(values[np.argmax(np.abs(values))])
    return value if value.imag else value.real


def scenario_behind(touch: Touch, where: str) -> tuple[str, str]:
    """What begins behind a graze with a square root, by one word and in a sentence.

    With the derivative A of the return map without impacts, the gradient n of the depth and the
    jump E, the depth k + 1 turns after an impact of depth d is n A^k E sqrt(d). Where one of these
    is positive another impact follows, and depths grow by roots until they are no longer small.
    Where none is, motions come back along the slowest direction, and the map becomes one of the
    line with the largest multiplier alone.
    """
    values = np.linalg.eigvals(touch.jacobian)
    largest = complex(values[np.argmax(np.abs(values))]) if values.size else 0j
    if not abs(largest) < 1.0 - _ON_CIRCLE:
        return UNDECIDED, "the orbit is unstable before it touches"
    after = _next_impact(touch)
    if after is None:
        return UNDECIDED, "whether another impact follows the first one is within rounding"
    if after >= 0:
        unit = np.eye(touch.jump.size)
        follows = touch.gradient @ np.linalg.solve(unit - touch.jacobian, touch.jump)
        branch = (
            "the orbit with an impact turns back, beside the one without (a nonsmooth fold)"
            if follows > 0.0
            else "the orbit goes on with an impact and is unstable"
        )
        turns = "turn" if after == 0 else "turns"
        return "jump", (
            f"no attractor stays close {where}: a deeper impact follows {after + 1} {turns} after"
            f" the first, and motions go elsewhere; {branch}"
        )
    ratio = largest.real
    word, text = (
        ("period adding", "stable orbits with one impact, of ever higher period near the graze")
        if ratio < _PERIODIC
        else ("period adding and chaos", "stable orbits of ever higher period, chaos between them")
        if ratio < _CHAOTIC
        else ("chaos", "chaos at once")
    )
    return word, (
        f"a small attractor begins {where}: {text}; the largest multiplier without impacts is"
        f" {ratio:.4g}"
    )


def _next_impact(touch: Touch) -> int | None:
    """Turns without an impact before the next one; -1 for none at all, None where in doubt."""
    direction = touch.jump / max(float(np.linalg.norm(touch.jump)), 1e-300)
    for k in range(_LONGEST):
        terms = touch.gradient * direction
        depth, size = float(terms.sum()), float(np.abs(terms).sum())
        if not abs(depth) > _ZERO * size:
            return None
        if depth > 0.0:
            return k
        moved = touch.jacobian @ direction
        length = float(np.linalg.norm(moved))
        if length == 0.0:  # nothing is left of the deviation
            return None
        moved /= length
        if float(np.linalg.norm(moved - direction)) <= _SETTLED:
            return -1
        direction = moved
    return None
