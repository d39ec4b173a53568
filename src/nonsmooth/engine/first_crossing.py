"""The first root of the guards of a mode, none skipped.

At each point looked at, the Taylor polynomial of every guard with a bound on what follows
tells how far it is surely positive: step there and repeat (`guard_series`). Once a guard
is known to fall monotonically to its root, Newton's method on that polynomial and one
third-order step on the exact flow finish. What rounding leaves undecided, a tangency whose
depth is below the rounding margin, is decided by the best guess and flagged. See
docs/explanation/certified-events.md.
"""

from __future__ import annotations

import math

from nonsmooth.engine import layout as at
from nonsmooth.engine.flow import advance, advance_little, advance_once, climb, read_guard
from nonsmooth.engine.guard_series import NEARLY_ZERO, REMAINDER, falls_alone, safe_step
from nonsmooth.engine.jit import inlined, kernel
from nonsmooth.engine.zeros import ALWAYS_ZERO, STILL_ZERO

__all__ = ["CERTIFIED", "GRAZE", "NONE", "STUCK", "UNCERTAIN", "first_crossing"]

# what was found
NONE, CERTIFIED, UNCERTAIN, GRAZE, STUCK = 0, 1, 2, 3, 4
_MOST_STEPS = 1_000_000
# Steps of the ladder in a row: each adds up to three roundings, and the margin has 32 units.
_MOST_CLIMBS = 8
_WORTH = 0.6  # a rung shorter than this part of the safe step is not worth taking
_UNIT = 2.220446049250313e-16
_FAR = 1e300
_FADED = 1e-3  # part of a rounding margin
_STILL = 4.0  # margins within which a guard that is identically zero may be found
_UNDER_MARGIN = 1.0 / 32.0  # of a rounding margin: one rounding
_BENT = 1e-2  # part of the rate at take-off; each step of _landing leaves twice that of an error
_LANDING_STEPS = 9
_MOST_SHORTENINGS = 16  # the bound of the sixth coefficient knows nothing of what cancels


@inlined
def first_crossing(tables, segment, m, start, length):
    """Search for the first guard of mode m to fall below zero within (start, length].

    shapes: segment as left by start_segment; its orders are the known orders of zero of
    the guards at s = 0
    returns: s, exit (-1: none) and what was found; after a GRAZE the search goes on at s, where
    scan[:, PASSED] says how far each guard is known. segment.now holds the slots at s.
    """
    scan, order = segment.scan, segment.order
    n_exits = tables.wiring[m, 0, at.N_EXITS]
    top = tables.spans[m, at.RUNG]
    s = start
    climbs = 0
    if s > 0.0:
        advance_once(tables, segment, m, s)
    far = tables.spans[m, at.REACH]
    for _ in range(_MOST_STEPS):
        rest = min(length - s, far)
        soonest = rest
        reach = rest if rest < 1.5 * top else top
        which, unsure, lands = -1, 0, 0
        for g in range(n_exits):
            if s < scan[g, at.PASSED]:  # a tangency there is flagged already
                scan[g, at.SAFE], scan[g, at.LATEST] = scan[g, at.PASSED] - s, _FAR
                if scan[g, at.SAFE] < soonest:
                    soonest, which = scan[g, at.SAFE], g
                    reach = min(reach, soonest)
                continue
            known = order[g] if s == 0.0 and order[g] < at.TERMS else 0
            read_guard(tables, segment, m, g, known)
            scan[g, at.LATEST] = _FAR
            still = _while_zero(scan, g, reach) if order[g] >= STILL_ZERO else 0.0
            if still > 0.0:
                scan[g, at.SAFE] = still
            elif s == 0.0 and 0 < order[g] != STILL_ZERO:
                landing = _landing(scan, g, reach) if order[g] == 1 else 0.0
                if landing > 0.0:
                    lands |= 1 << g
                    scan[g, at.SAFE] = scan[g, at.LATEST] = landing
                else:
                    scan[g, at.SAFE] = _leave(scan, g, order[g], reach)
            else:
                found = _look_ahead(scan, g, reach, far)
                if found == GRAZE:
                    # passed by this guard alone: the others may fall before
                    scan[g, at.PASSED] = s + max(scan[g, at.SAFE], 4.0 * _UNIT * length)
                    return s, g, found
                if found == UNCERTAIN:
                    unsure |= 1 << g
            if order[g] >= STILL_ZERO and still == 0.0:
                order[g] = 0
            if scan[g, at.SAFE] < soonest:
                soonest = scan[g, at.SAFE]
                which = g
                reach = min(reach, soonest if scan[g, at.LATEST] == _FAR else scan[g, at.LATEST])
        if which >= 0:
            if (unsure >> which) & 1:
                s += soonest
                advance_once(tables, segment, m, s)
                return s, which, UNCERTAIN
            if (lands >> which) & 1 and _alone(scan, n_exits, which, length):
                s = scan[which, at.LATEST]
                scan[which, 1] = _rate_of_polynomial(scan, which, s)
                advance_once(tables, segment, m, s)
                return s, which, CERTIFIED
            if scan[which, at.LATEST] < _FAR and _alone(scan, n_exits, which, length - s):
                root, found = _finish(tables, segment, m, which, s)
                if root <= length:
                    return root, which, found
                soonest = rest  # the guard falls, but not to zero within the segment
                for g in range(n_exits):
                    if g != which:
                        soonest = min(soonest, scan[g, at.SAFE])
                climbs = _MOST_CLIMBS
            elif s + soonest == s:
                return _nearest(tables, segment, m, n_exits, s, length)
        rung, step = _rung_below(top, soonest)
        worth = rung < at.RUNGS and step >= _WORTH * soonest and climbs < _MOST_CLIMBS
        if worth and soonest < length - s:
            climbs += 1
            s += step
            climb(tables, segment, m, rung, s)
        else:
            climbs = 0
            s = min(s + soonest, length)
            advance(tables, segment, m, s)
            if s >= length:
                return length, -1, NONE
    return s, -1, STUCK


@inlined
def _rung_below(top, step):
    """The longest rung of the ladder that is not longer than a step, and its length."""
    rung = 0
    length = top
    while length > step and rung < at.RUNGS:
        length *= 0.5
        rung += 1
    return rung, length


@inlined
def _look_ahead(scan, g, reach, far):
    """Safe step of a guard; NONE unless rounding makes a tangency here undecidable."""
    a0, a1, a2, a3, a4, a5 = scan[g, 0], scan[g, 1], scan[g, 2], scan[g, 3], scan[g, 4], scan[g, 5]
    bound, margin, taken = scan[g, at.BOUND], scan[g, at.MARGIN], scan[g, at.TAKEN_OFF]
    if margin == 0.0 and a0 >= 0.0 and a1 == a2 == a3 == a4 == a5 == bound == 0.0:
        scan[g, at.SAFE] = reach  # a constant, or what has faded to nothing
        return NONE
    if a0 <= NEARLY_ZERO * margin:  # above it, so that the step below is never zero
        return _within_margin(scan, g, NEARLY_ZERO * margin, reach)
    # the margin is taken off, else rounding could carry a step across a tangency
    step = safe_step(a0 - margin - taken, a1, a2, a3, a4, a5, bound, reach)
    scan[g, at.SAFE] = step
    if a1 < 0.0 and step < reach and scan[g, at.FADING] <= _FADED * margin:
        latest = -2.0 * (a0 + margin) / a1
        if latest <= far and falls_alone(a1, a2, a3, a4, a5, bound, latest):
            scan[g, at.LATEST] = latest
    return NONE


@kernel
def _leave(scan, g, order, reach):
    """Safe step from a zero of known order; the zero itself is divided out."""
    if order == ALWAYS_ZERO:
        return reach
    a0, a1, a2, a3, a4, a5 = scan[g, 0], scan[g, 1], scan[g, 2], scan[g, 3], scan[g, 4], scan[g, 5]
    last = -scan[g, at.BOUND]
    tail = scan[g, at.BOUND]
    for _ in range(order):
        a0, a1, a2, a3, a4, a5, last = a1, a2, a3, a4, a5, last, 0.0
    a0 -= scan[g, at.TAKEN_OFF]
    for _ in range(at.TERMS - order):
        tail *= reach
    while tail > REMAINDER * (a0 + (abs(a1) + abs(a2) * reach) * reach) and reach > 0.0:
        reach *= 0.5
        tail *= 0.5 ** (at.TERMS - order)
    return safe_step(max(a0, 0.0), a1, a2, a3, a4, a5, -last, reach)


@kernel
def _landing(scan, g, reach):
    """Where a low flight from a zero of first order ends, by its polynomial; 0 for other flights.

    Heights have the rounding of positions, and what is divided by the time of flight has none. A
    start that is off zero by more is where a relation holds it, which is solved to rounding itself.
    """
    off = scan[g, 0] if abs(scan[g, 0]) > scan[g, at.MARGIN] else 0.0
    a1, a2, a3, a4, a5 = scan[g, 1], scan[g, 2], scan[g, 3], scan[g, 4], scan[g, 5]
    if not (a1 > 0.0 and a2 < 0.0) or scan[g, at.TAKEN_OFF] != 0.0 or scan[g, at.FADING] != 0.0:
        return 0.0
    u = -a1 / a2
    if not (1.0 + 4.0 * _BENT) * u <= reach:
        return 0.0
    # so nearly a parabola that there is one root, and what is left out is below rounding
    bent = (abs(a3) + (2.0 * abs(a4) + 4.0 * abs(a5) * u) * u) * u * u
    left_out = 2.0 * scan[g, at.BOUND] * u**6
    bent += abs(off) / u
    if not (bent <= _BENT * a1 and left_out <= _UNDER_MARGIN * scan[g, at.MARGIN]):
        return 0.0
    for _ in range(_LANDING_STEPS):
        u = -(off / u + a1 + u * u * (a3 + u * (a4 + u * a5))) / a2
    return u


@kernel
def _rate_of_polynomial(scan, g, u):
    a1, a2, a3, a4, a5 = scan[g, 1], scan[g, 2], scan[g, 3], scan[g, 4], scan[g, 5]
    return a1 + u * (2.0 * a2 + u * (3.0 * a3 + u * (4.0 * a4 + u * 5.0 * a5)))


@kernel
def _while_zero(scan, g, reach):
    """How long a guard that is identically zero cannot be told from zero; 0 if it can."""
    margin = _STILL * scan[g, at.MARGIN]
    for _ in range(_MOST_SHORTENINGS):
        size = scan[g, at.BOUND]
        for k in range(at.TERMS - 1, -1, -1):
            size = size * reach + abs(scan[g, k])
        if size <= margin:
            return reach
        reach *= 0.5
    return 0.0


@kernel
def _within_margin(scan, g, margin, reach):
    """Tell crossing, leaving and touching apart where the guard is zero up to rounding."""
    value, rate, second = scan[g, 0], scan[g, 1], 2.0 * scan[g, 2]
    near = min(reach, math.sqrt(margin / max(abs(second), 1e-300)))
    third = 120.0 * scan[g, at.BOUND] * near + 60.0 * abs(scan[g, 5])
    third = (third * near + 24.0 * abs(scan[g, 4])) * near + 6.0 * abs(scan[g, 3])
    curvature = abs(second) + third * near
    if rate * rate > 16.0 * margin * curvature:
        if rate < 0.0:
            scan[g, at.SAFE] = 0.0
            scan[g, at.LATEST] = -4.0 * margin / rate
        else:
            scan[g, at.SAFE] = _leave(scan, g, 1, reach)
        return NONE
    scan[g, at.SAFE] = 0.0
    if second < 0.0:
        # rises no higher than the margin and falls: the later root of its parabola
        scan[g, at.SAFE] = (
            rate + math.sqrt(rate * rate - 2.0 * second * max(value, 0.0))
        ) / -second
        return UNCERTAIN
    if second == 0.0:
        return UNCERTAIN
    lowest = value - 0.5 * rate * rate / second
    if lowest < 0.0 and rate < 0.0:
        return UNCERTAIN
    # touches and leaves: go on where it is clear of the margin again
    ahead = max(0.0, -rate / second)
    scan[g, at.SAFE] = ahead + math.sqrt(2.0 * (4.0 * margin + abs(lowest)) / second)
    return GRAZE


@inlined
def _alone(scan, n_exits, which, rest):
    """Whether every other guard is safe up to the latest place of this guard's root, or the end.

    One that is the same function, as two surfaces that have become one, comes after it.
    """
    latest = min(scan[which, at.LATEST], rest)
    for g in range(n_exits):
        if g != which and scan[g, at.SAFE] < latest and not (g > which and _same(scan, g, which)):
            return False
    return True


@kernel
def _same(scan, g, other):
    """Whether two guards are the same function, as far as their coefficients tell."""
    for k in range(at.TERMS):
        if scan[g, k] != scan[other, k]:
            return False
    return True


@kernel
def _nearest(tables, segment, m, n_exits, s, length):
    """Guards that reach zero together: the earlier root, in declared order when equal.

    Rounding leaves open which of them is first, so the event is uncertain.
    """
    best = -1
    best_root = _FAR
    for g in range(n_exits):
        if segment.scan[g, at.LATEST] < _FAR:
            root, _ = _finish(tables, segment, m, g, s)
            if root < best_root - 4.0 * _UNIT * abs(root):
                best, best_root = g, root
    if best < 0:
        return s, -1, STUCK
    best_root = min(max(best_root, s), length)
    advance_once(tables, segment, m, best_root)
    return best_root, best, UNCERTAIN


@inlined
def _finish(tables, segment, m, g, s):
    """Root of a guard that falls monotonically, by Chebyshev's third-order iteration."""
    scan = segment.scan
    fastest = tables.spans[m, at.FASTEST]
    span = scan[g, at.LATEST]
    root = s + _polynomial_root(scan, g, span)
    settled = False
    for _ in range(20):
        advance(tables, segment, m, root)
        read_guard(tables, segment, m, g, 0)
        value, rate = scan[g, 0], scan[g, 1]
        quotient = value / rate
        step = -quotient * (1.0 + quotient * scan[g, 2] / rate)
        following = min(max(root + step, s), s + span)
        # the last step: within rounding, or its error, (step / span)^3 span, is below it
        settled = abs(value) <= scan[g, at.MARGIN] or abs(step) <= 1e-5 * span
        if settled and abs(step) * fastest <= 1e-4:
            step = following - root
            advance_little(tables, segment, m, root, step)
            scan[g, 1] = rate + step * (2.0 * scan[g, 2] + 3.0 * step * scan[g, 3])
            root = following
            break
        root = following
    certified = scan[g, 1] ** 2 > 8.0 * scan[g, at.MARGIN] * abs(scan[g, 2])
    certified = certified and settled
    return root, CERTIFIED if certified else UNCERTAIN


@inlined
def _polynomial_root(scan, g, span):
    """Root of the Taylor polynomial of a falling guard within [0, span], by Newton's method."""
    a0, a1, a2, a3, a4, a5 = scan[g, 0], scan[g, 1], scan[g, 2], scan[g, 3], scan[g, 4], scan[g, 5]
    u = -a0 / a1
    for _ in range(8):
        value = a0 + u * (a1 + u * (a2 + u * (a3 + u * (a4 + u * a5))))
        rate = a1 + u * (2.0 * a2 + u * (3.0 * a3 + u * (4.0 * a4 + u * (5.0 * a5))))
        step = -value / rate
        u = min(max(u + step, 0.0), span)
        if abs(step) <= 1e-6 * span:
            break
    return u
