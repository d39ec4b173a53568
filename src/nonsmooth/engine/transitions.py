"""What happens at one instant: exits fire in turn until a mode holds.

An exit that fires applies its reset and enters its target; there the first exit, in
declared order, whose guard is negative fires at the same instant, else the first one whose
guard is zero with its first non-zero derivative negative, and so on.

Some exits have another one beside them that leads onto their surface. It is taken in place of one
that leads back to where the path has come from, for then both sides point at the surface; and
behind a reset once rebounds have accumulated (`rebounds`).
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.arrays import copy_vector
from nonsmooth.engine.guard_values import (
    CLEARLY,
    NOTHING,
    fill_extent,
    guard_holds,
    is_nothing,
    must_fire,
    nearly_zero,
    some_zero,
    sum_of_terms,
)
from nonsmooth.engine.jit import inlined, kernel
from nonsmooth.engine.linearisation import differentiate_mode, linearise_mode
from nonsmooth.engine.placement import (
    apply_reset,
    set_fired_zero,
    settle_slaved,
    states_agree,
)
from nonsmooth.engine.rebounds import NEVER, rate_of_guard, rest_time
from nonsmooth.engine.solved_relations import settle
from nonsmooth.engine.status import Status
from nonsmooth.engine.surfaces import (
    cell_that_holds,
    is_surface,
    meeting,
    onto_surface,
    over_surface,
    visit_only,
)
from nonsmooth.engine.tangent import (
    end_saltation,
    push_columns,
    relate_columns,
    start_saltation,
)
from nonsmooth.engine.taylor_series import fill_series
from nonsmooth.engine.velocity import fill_scale
from nonsmooth.engine.zeros import (
    OPEN,
    push_exit,
    push_relations,
    push_reset,
    start_directions,
    zero_order,
)

__all__ = ["PATH_BITS", "PATH_LENGTH", "has_fallen", "pass_exits"]

_COMPLETED = int(Status.COMPLETED)
_STOPPED = int(Status.STOPPED)
_UNDECIDED = int(Status.UNDECIDED)
_SLIDING = int(Status.SLIDING)
_EVENT_LIMIT = int(Status.EVENT_LIMIT)
_INADMISSIBLE = int(Status.INADMISSIBLE)
_MOST_PASSES = 100
_MOST_REBOUNDS = 1000  # passes, where exits may come to rest: balls between others need many
PATH_BITS = 6  # bits per exit in the recorded path
PATH_LENGTH = 10


@inlined
def pass_exits(tables, rates, segment, tangent, m, e, duration, tolerance):
    """Pass exit e of mode m and whatever must fire after it at the same instant.

    segment.z holds the augmented coordinates and is changed in place, as are the columns of
    derivatives; segment.order is an output
    returns: status, mode that holds, path (exits passed, six bits each, lowest first),
    number of exits passed, whether a reset was applied, whether several guards met in a corner,
    the time from now at which rebounds that end here have accumulated (NEVER where none do).
    EVENT_LIMIT when resets go on and on, as at the end of accumulating impacts; UNDECIDED when
    modes hand over in a circle, SLIDING when they are cells of one mode
    e = -1 stands for a start: nothing fires before mode m is looked at. ``duration`` of the motion
    that has led here tells how far coordinates move
    """
    n, affine, wiring = tables.sizes[0], tables.affine, tables.wiring
    z, basis = segment.z, segment.basis
    # rows of Taylor modes hold at one point only, so there the free directions go along
    curved = tables.sizes[6] > 0
    first_mode, first_exit = m, e
    visited = segment.visited
    visit_only(visited, m)
    path, passes, jumped, corner = 0, 0, False, False
    spell = 1  # numbers the times spent in one mode and its cells
    jumping = 0  # bits of the slaved states that a reset has let jump onto their relations
    stay, first_rate = NEVER, 0.0
    followed = curved  # whether basis holds the directions left free by the path so far
    carrying = tangent.columns.shape[0] > 0
    copy_vector(z, segment.mark, n)
    ready, fired = _prepare(tables, rates, segment, tangent, m, e, duration, curved)
    if not ready:
        return _INADMISSIBLE, m, path, passes, jumped, corner, stay
    while True:
        rests = -1  # the exit onto the surface of one that has rebounded for the last time
        if e >= 0:
            target = wiring[m, 1 + e, at.TARGET]
            onto = wiring[m, 1 + e, at.ONTO]
            rebounds = onto >= 0 and wiring[m, 1 + e, at.RESETTING] != 0
            arrival, push = 0.0, 0.0
            if rebounds:
                if at.has_code(tables.code_rows, m):
                    differentiate_mode(tables, rates, segment, m)
                arrival = rate_of_guard(n, tables.generator, affine, wiring, m, e, z)
                push = sum_of_terms(affine, m, at.guard_row(e, 2), z, segment.extent)[0]
            first_rate = max(first_rate, abs(arrival))
            if passes < PATH_LENGTH:
                path |= (e + 1) << (PATH_BITS * passes)
            passes += 1
            if carrying:
                push_columns(tables, rates, segment, tangent, m, e)
            apply_reset(n, affine, wiring, m, e, z, segment.extent, segment.spare)
            resetting = wiring[m, 1 + e, at.RESETTING]
            if target < 0:
                return _STOPPED, m, path, passes, jumped or resetting != 0, corner, stay
            # what the target slaves is put on its relation anyway: naming it is no jump by itself
            slaved = wiring[target, 0, at.SLAVED]
            if (resetting & ~slaved) != 0:
                visited[:] = 0  # without a jump no mode may return
            jumped = jumped or (resetting & ~(wiring[m, 0, at.SLAVED] & slaved)) != 0
            # cells settle after a reset: what it lets jump goes on until one of them holds
            leaves = tables.families[target] != tables.families[m]
            if resetting != 0 or leaves:
                jumping = resetting
            if leaves:
                spell += 1
            if not _enter(
                tables, rates, segment, tangent, m, e, target, jumping, fired, duration, curved,
                tolerance,
            ):  # fmt: skip
                failed = (jumping & wiring[target, 0, at.IMPLICIT]) != 0
                status = _UNDECIDED if failed else _INADMISSIBLE
                return status, target, path, passes, jumped, corner, stay
            m = target
            if visited[m] != 0:
                # cells of one mode hand over in a circle where several surfaces meet
                slides = visited[m] == spell and jumping == 0
                met = meeting(tables, m, z, segment.extent, visited) if slides else -1
                if met >= 0:
                    e = met
                    continue
                cell = -1
                if slides:
                    cell = cell_that_holds(tables, rates, segment, spell, duration, tolerance)
                if cell >= 0:
                    if carrying:
                        relate_columns(tables, rates, segment, tangent, cell)
                    if carrying and first_exit >= 0:
                        end_saltation(tables, segment, tangent, cell)
                    return _COMPLETED, cell, path, passes, jumped, True, stay
                if slides or not _moved(n, z, segment.mark, segment.extent):
                    status = _SLIDING if slides else _UNDECIDED
                    return status, m, path, passes, jumped, corner, stay
                visited[:] = 0  # slaved states have jumped on the way
                copy_vector(z, segment.mark, n)
            if passes > (_MOST_REBOUNDS if rebounds else _MOST_PASSES):
                return _EVENT_LIMIT, m, path, passes, jumped, corner, stay
            visited[m] = spell
            followed = curved
            if rebounds:
                if at.has_code(tables.code_rows, m):
                    differentiate_mode(tables, rates, segment, m)
                wait = rest_time(
                    affine, tables.clock, m, e, z, segment.extent, arrival, push, first_rate,
                    tolerance,
                )  # fmt: skip
                if wait != NEVER and _is_at(tables, segment, m, e, duration):
                    rests, stay = onto, wait
        if passes != 1 and not curved:
            fill_scale(n, tables.generator, affine, wiring, m, z, duration, segment.scale)
        if (
            curved
            and at.has_code(tables.code_rows, m)
            and some_zero(affine, wiring, m, z, segment.extent, segment.scale)
        ):
            differentiate_mode(tables, rates, segment, m)
        if rests >= 0:
            e = rests
            continue
        e, meets, followed = _next_exit(
            n, tables.generator, affine, wiring, tables.families, z, segment.extent,
            segment.order, basis, segment.scale, first_mode, first_exit, m, path, passes,
            followed, duration, tolerance,
        )  # fmt: skip
        corner = corner or meets
        if e < 0:
            if carrying and first_exit >= 0:
                end_saltation(tables, segment, tangent, m)
            return _COMPLETED, m, path, passes, jumped, corner, stay
        if wiring[m, 1 + e, at.ONTO] == e:
            fill_scale(n, tables.generator, affine, wiring, m, z, duration, segment.scale)
            e = over_surface(affine, wiring, m, e, z, segment.extent, segment.scale)
        if passes == 0 and wiring[m, 1 + e, at.ONTO] == e:
            visited[:] = 0  # a start that is not held goes back to where it was looked for
        e = onto_surface(wiring, m, e, visited, spell)
        if passes > 0 and e < wiring[m, 0, at.N_EXITS]:
            # a second surface at the same instant is met as exactly as the first one
            fill_scale(n, tables.generator, affine, wiring, m, z, duration, segment.scale)
            if is_nothing(affine, m, e, z, segment.scale):
                corner = True
                set_fired_zero(n, tables.generator, affine, wiring, m, e, z, segment.extent)
                if curved:
                    linearise_mode(tables, rates, segment, m)


@inlined
def _prepare(tables, rates, segment, tangent, m, e, duration, curved):
    """Bring all that belongs to mode m up to date before its exit e is passed, or at a start.

    returns: False where states cannot be solved for, and the size of the terms that cancelled in
    the guard that fired
    """
    n, affine, wiring, z = tables.sizes[0], tables.affine, tables.wiring, segment.z
    carrying = tangent.columns.shape[0] > 0
    fired = 0.0
    if e < 0 and wiring[m, 0, at.IMPLICIT] != 0 and not settle(tables, rates, segment, m):
        return False, fired
    if curved:
        linearise_mode(tables, rates, segment, m)
    fill_extent(n, affine, wiring, m, z, segment.extent)
    if e >= 0:
        fired = set_fired_zero(n, tables.generator, affine, wiring, m, e, z, segment.extent)
        if curved and wiring[m, 1 + e, at.RESETTING] != 0:
            linearise_mode(tables, rates, segment, m)  # a reset is exact where it is applied
    if curved:
        fill_scale(n, tables.generator, affine, wiring, m, z, duration, segment.scale)
        start_directions(n, affine, wiring, m, e, segment.scale, segment.basis)
    fill_extent(n, affine, wiring, m, z, segment.extent)
    if e < 0:
        settle_slaved(n, affine, wiring, m, z, segment.extent)
        if carrying:
            relate_columns(tables, rates, segment, tangent, m)
    elif carrying:
        start_saltation(tables, rates, segment, tangent, m, e)
    return True, fired


@inlined
def _enter(
    tables, rates, segment, tangent, m, e, target, jumping, fired, duration, curved, tolerance
):
    """Enter a mode behind the reset of exit e; False where slaved states do not agree with it."""
    n, affine, wiring, z = tables.sizes[0], tables.affine, tables.wiring, segment.z
    copy_vector(z, segment.spare, z.size)
    if curved:
        push_reset(n, affine, wiring, m, e, segment.basis)
        if wiring[target, 0, at.IMPLICIT] != 0 and not settle(tables, rates, segment, target):
            return False
        linearise_mode(tables, rates, segment, target)
        push_relations(n, affine, wiring, target, segment.basis)
    fill_extent(n, affine, wiring, target, z, segment.extent)
    agrees = states_agree(n, affine, wiring, target, segment, jumping, fired, curved, tolerance)
    if not agrees and not curved:  # what is nothing beside what it changes by
        fill_scale(n, tables.generator, affine, wiring, m, z, duration, segment.scale)
        agrees = states_agree(n, affine, wiring, target, segment, jumping, fired, True, tolerance)
    if not agrees:
        return False
    settle_slaved(n, affine, wiring, target, z, segment.extent)
    fill_extent(n, affine, wiring, target, z, segment.extent)
    if tangent.columns.shape[0] > 0:
        relate_columns(tables, rates, segment, tangent, target)
    return True


@inlined
def _next_exit(
    n, generator, affine, wiring, families, z, extent, order, basis, scale, first_mode, first_exit,
    m, path, passes, followed, duration, tolerance,
):  # fmt: skip
    """The exit of mode m that fires at z, -1 for none; fills the orders of its guards.

    returns: exit, whether its guard is zero by coincidence after others, whether the basis follows
    the path now
    """
    e, meets = -1, False
    for g in range(wiring[m, 0, at.N_EXITS]):
        known = OPEN
        if passes == 1 and first_exit >= 0:
            known = wiring[first_mode, 1 + first_exit, at.ORDERS + g]
        elif not nearly_zero(affine, m, g, z, extent, scale):
            known = 0
        if known == OPEN:
            if not followed:
                _follow(n, affine, wiring, first_mode, first_exit, path, passes, scale, basis)
                followed = True
            known = zero_order(affine, m, g, scale, basis)
            # surfaces passed one after the other at one instant are met as exactly as the first one
            if known == 0 and passes > 0:
                value = sum_of_terms(affine, m, at.guard_row(g, 0), z, extent)[0]
                rate = rate_of_guard(n, generator, affine, wiring, m, g, z)
                known = 1 if abs(value) <= NOTHING * abs(rate) * duration else 0
        order[g] = known
        fires = must_fire(affine, m, g, z, extent, order, tolerance)
        # what starts on a surface that holds is held as long as it can be
        held = first_exit < 0 and passes == 0 and wiring[m, 1 + g, at.ONTO] == g
        if not fires and not (held and order[g] > 0):
            continue
        # where a guard is negative, the rates of the mode say nothing about the others
        # cells settle before the exits of the mode are read
        settling = e >= 0 and is_surface(wiring, families, m, e)
        late = settling and not is_surface(wiring, families, m, g)
        if e < 0 or (order[g] == 0 and order[e] > 0 and not late):
            e, meets = g, passes > 0 and order[g] > known
    return e, meets, followed


@kernel
def _moved(n, z, mark, extent):
    """Whether a state is no longer where it was, beyond rounding."""
    for i in range(n):
        if abs(z[i] - mark[i]) > CLEARLY * (extent[i] + abs(mark[i])):
            return True
    return False


@kernel
def has_fallen(tables, rates, segment, m):
    """Whether a guard of mode m is clearly negative at segment.z, where none has crossed zero."""
    z = segment.z
    if at.has_code(tables.code_rows, m):
        _fill_values(tables, segment.series, m, z)
        negative = False
        for g in range(tables.wiring[m, 0, at.N_EXITS]):
            negative = negative or segment.series[tables.outlets[m, tables.sizes[0] + g], 0] < 0.0
        if not negative:
            return False
        linearise_mode(tables, rates, segment, m)
    fill_extent(tables.sizes[0], tables.affine, tables.wiring, m, z, segment.extent)
    for g in range(tables.wiring[m, 0, at.N_EXITS]):
        if not guard_holds(tables.affine, m, g, z, segment.extent, CLEARLY):
            return True
    return False


@kernel
def _fill_values(tables, series, m, z):
    """Values of everything that a curved mode computes."""
    for i in range(z.size):
        series[i, 0] = z[i]
    fill_series(
        tables.code, tables.terms, tables.weights, tables.code_rows[m, 0], tables.code_rows[m, 1],
        tables.values, tables.outlets[m], at.explicit(tables.wiring, m), tables.sizes,
        tables.harmonics, series, 0, 0,
    )  # fmt: skip


@kernel
def _follow(n, affine, wiring, m, e, path, passes, scale, basis):
    """Directions left free along the whole path so far, where all modes are linear."""
    start_directions(n, affine, wiring, m, e, scale, basis)
    for k in range(min(passes, PATH_LENGTH)):
        way = ((path >> (PATH_BITS * k)) & ((1 << PATH_BITS) - 1)) - 1
        push_exit(n, affine, wiring, m, way, basis)
        m = wiring[m, 1 + way, at.TARGET]


@kernel
def _is_at(tables, segment, m, e, duration):
    """Whether a state is at the surface of exit e: what a jump has put behind it never rests."""
    n, affine, wiring, z = tables.sizes[0], tables.affine, tables.wiring, segment.z
    fill_scale(n, tables.generator, affine, wiring, m, z, duration, segment.scale)
    return nearly_zero(affine, m, e, z, segment.extent, segment.scale)
