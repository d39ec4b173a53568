"""The flow along one leg of a given word: enter a mode anywhere, go on for a given time.

Where the closed form serves a limited time only, and in a Taylor mode, a leg is passed in steps.
A negative time is read backwards from the same formula; the steps are then as long as they would
be forwards.
"""

from __future__ import annotations

import math

from nonsmooth.engine import layout as at
from nonsmooth.engine.arrays import copy_matrix, copy_vector
from nonsmooth.engine.flow import advance_once, start_segment, state_at
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.linear_flow import augmented
from nonsmooth.engine.linearisation import linearise_mode
from nonsmooth.engine.solved_relations import settle
from nonsmooth.engine.tangent import carry, complete_columns, relate_columns, start_columns

__all__ = ["enter_leg", "go_on", "step_of_leg"]

_MOST_STEPS = 100_000
# part of a window, or of the leg; a shorter step of a series means that it does not converge
_SHORTEST = 1e-14
_END = 1e-15  # part of a step that is left by rounding


@kernel
def enter_leg(tables, rates, segment, tangent, m, state, number, phase):
    """Put a state into a mode, whether or not its guards hold; False where relations fail.

    Columns begin there: changes of slaved states count for nothing, they follow the others.
    """
    n, n_exits, z = tables.sizes[0], tables.wiring.shape[1] - 1, segment.z
    slaved = tables.wiring[m, 0, at.SLAVED]
    copy_vector(state, z, n)
    augmented(n, tables.sizes[1], tables.clock[0], tables.harmonics, number, phase, z)
    if tables.wiring[m, 0, at.IMPLICIT] != 0 and not settle(tables, rates, segment, m):
        return False
    linearise_mode(tables, rates, segment, m)
    for i in range(n):
        if (slaved >> i) & 1:
            total, row = 0.0, at.relation_row(n_exits, i)
            for j in range(z.size):
                total += tables.affine[m, row, j] * z[j]
            z[i] = total
    start_columns(n, tangent)
    for i in range(n if tangent.columns.shape[0] > 0 else 0):
        if (slaved >> i) & 1:
            tangent.columns[i, i] = 0.0
    complete_columns(tables, rates, tangent, number, phase, z)
    relate_columns(tables, rates, segment, tangent, m)
    for g in range(segment.order.size):
        segment.order[g] = 0
    return True


@kernel
def go_on(tables, rates, scratch, segment, tangent, m, number, phase, duration):
    """Go on in a mode for a time, columns with the state.

    returns: window number and phase there, and whether it was reached
    """
    left = duration
    for _ in range(_MOST_STEPS):
        if left == 0.0 or not math.isfinite(left):
            return number, phase, math.isfinite(left)
        s = step_of_leg(tables, rates, segment, m, left)
        if not abs(s) > _SHORTEST * min(tables.clock[0], abs(duration)) and s != left:
            return number, phase, False
        if tangent.columns.shape[0] > 0:
            carry(tables, rates, scratch, segment, tangent, m, s)
            copy_matrix(tangent.now, tangent.columns)
        advance_once(tables, segment, m, s)
        state_at(tables, segment, m, segment.spare[: tables.sizes[0]])
        copy_vector(segment.spare, segment.z, tables.sizes[0])
        left = 0.0 if abs(left - s) <= _END * abs(s) else left - s
        phase += s
        whole = math.floor(phase / tables.clock[0])
        number, phase = number + int(whole), phase - whole * tables.clock[0]
        augmented(
            tables.sizes[0], tables.sizes[1], tables.clock[0], tables.harmonics, number, phase,
            segment.z,
        )  # fmt: skip
        if tangent.columns.shape[0] > 0:
            complete_columns(tables, rates, tangent, number, phase, segment.z)
        for i in range(tables.sizes[0]):
            if not math.isfinite(segment.z[i]):
                return number, phase, False
    return number, phase, False


@kernel
def step_of_leg(tables, rates, segment, m, left):
    """Start a step at segment.z and give its length, with the sign of what is left."""
    longest = min(abs(left), tables.clock[at.LASTS])
    length = start_segment(tables, rates, segment, m, longest)
    return length if left > 0.0 else -length
