"""The first root of the guards of a mode, none skipped.

With the third derivative of a guard bounded by M from s on, Taylor's theorem gives

    g(s + h) >= g + g' h + g'' h^2 / 2 - M h^3 / 6,

so no root lies before the first root of the right-hand side: step there and repeat. Once
a guard is known to fall monotonically to its root, Newton's method finishes. What
rounding leaves undecided, a tangency whose depth is below the rounding margin, is
decided by the best guess and flagged. See docs/explanation/certified-events.md.
"""

from __future__ import annotations

import math

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import inlined, kernel
from nonsmooth.engine.linear_flow import advance, advance_little, advance_once
from nonsmooth.engine.zeros import ALWAYS_ZERO

__all__ = ["CERTIFIED", "GRAZE", "NONE", "STUCK", "UNCERTAIN", "first_crossing"]

# what was found
NONE, CERTIFIED, UNCERTAIN, GRAZE, STUCK = 0, 1, 2, 3, 4
_MOST_STEPS = 1_000_000
_UNIT = 2.220446049250313e-16
_FAR = 1e300


@inlined
def first_crossing(tables, segment, m, start, length):
    """Search for the first guard of mode m to fall below zero within (start, length].

    shapes: segment as left by start_segment; its orders are the known orders of zero of
    the guards at s = 0
    returns: s, exit (-1: none), what was found, and where to go on after a GRAZE.
    segment.modal holds the coordinates at s.
    """
    flow, slots, bounds, affine = tables.flow, tables.slots, tables.bounds, tables.affine
    modal, sizes, scan, order, z = (
        segment.modal, segment.sizes, segment.scan, segment.order, segment.z,
    )  # fmt: skip
    n_exits = tables.wiring[m, 0, at.N_EXITS]
    n = tables.sizes[0]
    fastest = tables.spans[m, at.FASTEST]
    s = start
    for _ in range(_MOST_STEPS):
        if s > 0.0:
            advance(flow, slots, m, modal, sizes, s)
            if s >= length:
                return length, -1, NONE, length
        rest = min(length - s, tables.spans[m, at.REACH])
        soonest = rest
        which = -1
        for g in range(n_exits):
            _read_guard(flow, bounds, slots, m, g, n, modal, sizes, scan)
            if s == 0.0 and order[g] > 0:
                _leave(affine, flow, bounds, slots, m, g, order[g], z, sizes, scan, rest)
            else:
                found = _look_ahead(scan, g, rest)
                if found == GRAZE:
                    return s, g, found, s + scan[g, at.SAFE]
                if found == UNCERTAIN:
                    root = min(s + scan[g, at.SAFE], length)
                    advance_once(flow, slots, m, modal, sizes, root)
                    return root, g, found, root
            if scan[g, at.SAFE] < soonest:
                soonest = scan[g, at.SAFE]
                which = g
        if which < 0:
            pass  # all guards are safe as far as they were looked at
        elif scan[which, at.LATEST] < _FAR and _alone(scan, n_exits, which):
            root, found = _finish(flow, bounds, slots, fastest, m, which, n, modal, sizes, scan, s)
            if root <= length:
                return root, which, found, root
            soonest = rest  # the guard falls, but not to zero within the segment
            for g in range(n_exits):
                if g != which:
                    soonest = min(soonest, scan[g, at.SAFE])
        elif s + soonest == s:
            return _nearest(
                flow, bounds, slots, fastest, m, n_exits, n, modal, sizes, scan, s, length
            )
        s = min(s + soonest, length)
    return s, -1, STUCK, s


@inlined
def _read_guard(flow, bounds, slots, m, g, n, modal, sizes, scan):
    """Value, rate and second rate of a guard, bound of the third one, rounding margin."""
    big_n = flow.shape[2]
    row = at.guard_flow_row(big_n, n, g, 0)
    row_size, row_third = at.guard_size_row(big_n, g), at.guard_third_row(big_n, g)
    value, rate, second, third, margin = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(slots[m, at.COUNT]):
        w = modal[at.NOW, j]
        a, b, c = flow[m, row, j], flow[m, row + 1, j], flow[m, row + 2, j]
        value += a.real * w.real - a.imag * w.imag
        rate += b.real * w.real - b.imag * w.imag
        second += c.real * w.real - c.imag * w.imag
        third += bounds[m, row_third, j] * sizes[at.SIZE_NOW, j]
        margin += bounds[m, row_size, j] * sizes[at.NOISE, j]
    scan[g, at.VALUE], scan[g, at.RATE] = value, rate
    scan[g, at.SECOND], scan[g, at.THIRD] = second, third
    scan[g, at.LATEST], scan[g, at.MARGIN] = _FAR, margin


@inlined
def _look_ahead(scan, g, rest):
    """Safe step of a guard; NONE unless rounding makes a tangency here undecidable."""
    value, rate, second = scan[g, at.VALUE], scan[g, at.RATE], scan[g, at.SECOND]
    third, margin = scan[g, at.THIRD], scan[g, at.MARGIN]
    if value <= 1.5 * margin:  # a little above it, so that the step below is never zero
        return _within_margin(scan, g, 1.5 * margin, rest)
    # the margin is taken off, else rounding could carry a step across a tangency
    scan[g, at.SAFE] = _safe_step(value - margin, rate, second, third, rest)
    if rate < 0.0:
        latest = -2.0 * value / rate
        # the rate stays below half of itself up to there: one root, none before it
        if abs(second) * latest + 0.5 * third * latest * latest <= -0.5 * rate:
            scan[g, at.LATEST] = latest
    return NONE


@inlined
def _safe_step(value, rate, second, third, rest):
    """First root of a quadratic that lies below the guard on [0, reach]."""
    reach = rest
    step = rest
    for _ in range(2):
        bend = third * reach / 3.0 - second
        inside = rate * rate + 2.0 * bend * value
        if inside < 0.0:
            return reach
        root = math.sqrt(inside)
        if rate > 0.0:
            step = (rate + root) / bend if bend > 0.0 else reach
        else:
            step = 2.0 * value / (root - rate) if root > rate else reach
        if step >= reach:
            return reach
        reach = min(rest, 2.0 * step)  # a shorter reach bends less
    return step


@kernel
def _leave(affine, flow, bounds, slots, m, g, order, z, sizes, scan, rest):
    """Safe step from a zero of known order; the zero itself is divided out."""
    rate, second, third = scan[g, at.RATE], scan[g, at.SECOND], scan[g, at.THIRD]
    if order == ALWAYS_ZERO:
        step = rest
    elif order == 1:
        reach = rest
        step = rest
        for _ in range(2):
            bend = third * reach / 3.0 - second
            if 2.0 * rate >= bend * reach:
                step = reach
                break
            step = 2.0 * rate / bend
            reach = min(rest, 2.0 * step)
    elif order == 2:
        step = rest if third == 0.0 else 3.0 * second / third
    else:
        step = _leave_slowly(affine, flow, bounds, slots, m, g, order, z, sizes)
    scan[g, at.SAFE] = min(step, rest)


@kernel
def _leave_slowly(affine, flow, bounds, slots, m, g, order, z, sizes):
    """Orders above two: the leading derivative against a bound of the one after it."""
    big_n = flow.shape[2]
    leading = 0.0
    for i in range(z.size):
        leading += affine[m, at.guard_row(g, order), i] * z[i]
    rest_row = flow.shape[1] - big_n
    following = 0.0
    for j in range(slots[m, at.COUNT]):
        speed = abs(flow[m, 0, j])
        for a in range(slots[m, at.COUNT]):
            speed += abs(flow[m, rest_row + a, j])
        weight = bounds[m, at.guard_third_row(big_n, g), j]
        following += weight * sizes[at.SIZE_NOW, j] * speed ** (order - 2)
    return _FAR if following == 0.0 else (order + 1.0) * leading / following


@kernel
def _within_margin(scan, g, margin, rest):
    """Tell crossing, leaving and touching apart where the guard is zero up to rounding."""
    value, rate, second = scan[g, at.VALUE], scan[g, at.RATE], scan[g, at.SECOND]
    third = scan[g, at.THIRD]
    reach = math.sqrt(margin / max(third * rest, abs(second), 1e-300))
    curvature = abs(second) + third * min(rest, reach)
    if rate * rate > 16.0 * margin * curvature:
        if rate < 0.0:
            scan[g, at.SAFE] = 0.0
            scan[g, at.LATEST] = -4.0 * margin / rate
        else:
            bend = third * rest / 3.0 - second
            scan[g, at.SAFE] = rest if 2.0 * rate >= bend * rest else 2.0 * rate / bend
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


@kernel
def _alone(scan, n_exits, which):
    """Whether every other guard is safe up to the latest place of this guard's root."""
    for g in range(n_exits):
        if g != which and scan[g, at.SAFE] < scan[which, at.LATEST]:
            return False
    return True


@kernel
def _nearest(flow, bounds, slots, fastest, m, n_exits, n, modal, sizes, scan, s, length):
    """Guards that reach zero together: the earlier root, in declared order when equal."""
    best = -1
    best_root = _FAR
    best_found = CERTIFIED
    for g in range(n_exits):
        if scan[g, at.LATEST] < _FAR:
            root, found = _finish(flow, bounds, slots, fastest, m, g, n, modal, sizes, scan, s)
            if root < best_root - 4.0 * _UNIT * abs(root):
                best, best_root, best_found = g, root, found
    if best < 0:
        return s, -1, STUCK, s
    best_root = min(max(best_root, s), length)
    advance_once(flow, slots, m, modal, sizes, best_root)
    return best_root, best, best_found, best_root


@kernel
def _finish(flow, bounds, slots, fastest, m, g, n, modal, sizes, scan, s):
    """Root of a guard that falls monotonically, by Chebyshev's third-order iteration."""
    latest = s + scan[g, at.LATEST]
    root = s
    settled = False
    for _ in range(20):
        quotient = scan[g, at.VALUE] / scan[g, at.RATE]
        step = -quotient * (1.0 + 0.5 * quotient * scan[g, at.SECOND] / scan[g, at.RATE])
        following = min(max(root + step, s), latest)
        # the last step: within rounding, or its error, (step / span)^3 span, is below it
        settled = abs(scan[g, at.VALUE]) <= scan[g, at.MARGIN]
        settled = settled or abs(step) <= 1e-5 * (latest - s)
        if settled and abs(step) * fastest <= 1e-4:
            advance_little(flow, slots, m, modal, sizes, root, following - root)
            root = following
            break
        root = following
        advance(flow, slots, m, modal, sizes, root)
        _read_guard(flow, bounds, slots, m, g, n, modal, sizes, scan)
    certified = scan[g, at.RATE] ** 2 > 4.0 * scan[g, at.MARGIN] * abs(scan[g, at.SECOND])
    certified = certified and settled
    return root, CERTIFIED if certified else UNCERTAIN
