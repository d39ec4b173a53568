"""The flow of a mode, whichever kind it is: what the loop and the search ask for.

Two kinds answer the same questions: the closed form of a linear mode (`linear_flow`,
`guard_series`) and the series of a Taylor mode (`taylor_flow`).
"""

from __future__ import annotations

from nonsmooth.engine import guard_series, linear_flow
from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import inlined, kernel
from nonsmooth.engine.taylor_flow import read_guard_of_step, start_step, state_of_step

__all__ = [
    "advance",
    "advance_little",
    "advance_once",
    "climb",
    "read_guard",
    "start_segment",
    "state_at",
]


@inlined
def start_segment(tables, rates, segment, m, longest):
    """Prepare a segment at segment.z; returns its length, at most ``longest``."""
    if tables.kinds[m] == at.TAYLOR:
        return start_step(tables, rates, segment, m, longest)
    length = min(longest, tables.spans[m, at.LONGEST])
    linear_flow.start_segment(tables, segment, m, length)
    return length


@inlined
def advance(tables, segment, m, s):
    """Go to the point s of the segment."""
    if tables.kinds[m] == at.TAYLOR:
        segment.point[0] = s
    else:
        linear_flow.advance(tables, segment, m, s)


@kernel
def advance_once(tables, segment, m, s):
    """`advance` as a call, for the places that are rarely passed: its body is long."""
    advance(tables, segment, m, s)


@inlined
def climb(tables, segment, m, rung, s):
    """Go to s, one step of the ladder of a linear mode after the current point."""
    linear_flow.climb(tables, segment, m, rung, s)


@inlined
def advance_little(tables, segment, m, s, step):
    """Go from s to s + step, which is close."""
    if tables.kinds[m] == at.TAYLOR:
        segment.point[0] = s + step
    else:
        linear_flow.advance_little(tables, segment, m, s, step)


@inlined
def read_guard(tables, segment, m, g, order):
    """Taylor coefficients, bound and margin of a guard at the current point, into scan."""
    if tables.kinds[m] == at.TAYLOR:
        read_guard_of_step(tables, segment, m, g)
    else:
        guard_series.read_guard(tables, segment, m, g, order)


@inlined
def state_at(tables, segment, m, out_state):
    """States at the current point.

    shapes: out_state (n,)
    """
    if tables.kinds[m] == at.TAYLOR:
        state_of_step(segment.series, segment.point[0], out_state)
    else:
        linear_flow.state_at(tables, segment, m, out_state)
