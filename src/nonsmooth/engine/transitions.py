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
from nonsmooth.engine.jit import inlined, kernel
from nonsmooth.engine.linearisation import linearise, linearise_derivatives
from nonsmooth.engine.rebounds import NEVER, rate_of_guard, rest_time
from nonsmooth.engine.solved_relations import settle
from nonsmooth.engine.status import Status
from nonsmooth.engine.tangent import (
    end_saltation,
    push_columns,
    relate_columns,
    start_saltation,
)
from nonsmooth.engine.taylor_series import fill_series
from nonsmooth.engine.velocity import fill_scale, velocity_of
from nonsmooth.engine.zeros import (
    ALWAYS_ZERO,
    OPEN,
    push_exit,
    push_relations,
    push_reset,
    start_directions,
    zero_order,
)

__all__ = [
    "PATH_BITS",
    "PATH_LENGTH",
    "count_bits",
    "fill_extent",
    "guard_exceeds",
    "guard_holds",
    "has_fallen",
    "in_cell",
    "leaves_both_ways",
    "linearise_mode",
    "pass_exits",
    "slaved_agree",
]

_COMPLETED = int(Status.COMPLETED)
_STOPPED = int(Status.STOPPED)
_UNDECIDED = int(Status.UNDECIDED)
_SLIDING = int(Status.SLIDING)
_EVENT_LIMIT = int(Status.EVENT_LIMIT)
_INADMISSIBLE = int(Status.INADMISSIBLE)
_MOST_PASSES = 100
_MOST_REBOUNDS = 1000  # passes, where exits may come to rest: balls between others need many
_NOTHING = 1e-12  # likewise, of what it changes by in a window
_SHARE = 1e-3  # of a coordinate in the rate of a guard, from which it is moved onto its zero
_CLEARLY = 1e-9  # a guard above this part of its terms is not zero by construction
_ANYWHERE_NEAR = 1e-5  # a guard above this part of its terms is not zero in any sense
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
    _visit_only(visited, m)
    path, passes, jumped, corner = 0, 0, False, False
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
                    _differentiate(tables, rates, segment, m)
                arrival = rate_of_guard(n, tables.generator, affine, wiring, m, e, z)
                push = _sum_of_terms(affine, m, at.guard_row(e, 2), z, segment.extent)[0]
            first_rate = max(first_rate, abs(arrival))
            if passes < PATH_LENGTH:
                path |= (e + 1) << (PATH_BITS * passes)
            passes += 1
            if carrying:
                push_columns(tables, rates, segment, tangent, m, e)
            _reset(n, affine, wiring, m, e, z, segment.extent, segment.spare)
            resetting = wiring[m, 1 + e, at.RESETTING]
            if target < 0:
                return _STOPPED, m, path, passes, jumped or resetting != 0, corner, stay
            # what the target slaves is put on its relation anyway: naming it is no jump by itself
            slaved = wiring[target, 0, at.SLAVED]
            if (resetting & ~slaved) != 0:
                visited[:] = 0  # without a jump no mode may return
            jumped = jumped or (resetting & ~(wiring[m, 0, at.SLAVED] & slaved)) != 0
            # cells settle after a reset: what it lets jump goes on until one of them holds
            if resetting != 0 or tables.families[target] != tables.families[m]:
                jumping = resetting
            if not _enter(
                tables, rates, segment, tangent, m, e, target, jumping, fired, duration, curved,
                tolerance,
            ):  # fmt: skip
                failed = (jumping & wiring[target, 0, at.IMPLICIT]) != 0
                status = _UNDECIDED if failed else _INADMISSIBLE
                return status, target, path, passes, jumped, corner, stay
            before, m = m, target
            if visited[m] != 0:
                # cells of one mode hand over in a circle where several surfaces meet
                slides = tables.families[before] == tables.families[m] and jumping == 0
                meeting = _meeting(tables, m, z, segment.extent, visited) if slides else -1
                if meeting >= 0:
                    e = meeting
                    continue
                cell = -1
                if slides:
                    cell = _cell_that_holds(tables, rates, segment, duration, tolerance)
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
            visited[m] = 1
            followed = curved
            if rebounds:
                if at.has_code(tables.code_rows, m):
                    _differentiate(tables, rates, segment, m)
                wait = rest_time(
                    affine, tables.clock, m, e, z, segment.extent, arrival, push, first_rate,
                    tolerance,
                )  # fmt: skip
                if wait != NEVER:
                    rests, stay = onto, wait
        if passes != 1 and not curved:
            fill_scale(n, tables.generator, affine, wiring, m, z, duration, segment.scale)
        if (
            curved
            and at.has_code(tables.code_rows, m)
            and _some_zero(affine, wiring, m, z, segment.extent, segment.scale)
        ):
            _differentiate(tables, rates, segment, m)
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
            e = _over_surface(affine, wiring, m, e, z, segment.extent, segment.scale)
        if passes == 0 and wiring[m, 1 + e, at.ONTO] == e:
            visited[:] = 0  # a start that is not held goes back to where it was looked for
        e = _onto_surface(wiring, m, e, visited)
        if passes > 0 and e < wiring[m, 0, at.N_EXITS]:
            # a second surface at the same instant is met as exactly as the first one
            fill_scale(n, tables.generator, affine, wiring, m, z, duration, segment.scale)
            if _is_nothing(affine, m, e, z, segment.scale):
                corner = True
                _set_fired_zero(n, tables.generator, affine, wiring, m, e, z, segment.extent)
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
        fired = _set_fired_zero(n, tables.generator, affine, wiring, m, e, z, segment.extent)
        if curved and wiring[m, 1 + e, at.RESETTING] != 0:
            linearise_mode(tables, rates, segment, m)  # a reset is exact where it is applied
    if curved:
        fill_scale(n, tables.generator, affine, wiring, m, z, duration, segment.scale)
        start_directions(n, affine, wiring, m, e, segment.scale, segment.basis)
    fill_extent(n, affine, wiring, m, z, segment.extent)
    if e < 0:
        _settle_slaved(n, affine, wiring, m, z, segment.extent)
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
    agrees = _agrees(n, affine, wiring, target, segment, jumping, fired, curved, tolerance)
    if not agrees and not curved:  # what is nothing beside what it changes by
        fill_scale(n, tables.generator, affine, wiring, m, z, duration, segment.scale)
        agrees = _agrees(n, affine, wiring, target, segment, jumping, fired, True, tolerance)
    if not agrees:
        return False
    _settle_slaved(n, affine, wiring, target, z, segment.extent)
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
        elif not _nearly_zero(affine, m, g, z, extent, scale):
            known = 0
        if known == OPEN:
            if not followed:
                _follow(n, affine, wiring, first_mode, first_exit, path, passes, scale, basis)
                followed = True
            known = zero_order(affine, m, g, scale, basis)
            # surfaces passed one after the other at one instant are met as exactly as the first one
            if known == 0 and passes > 0:
                value = _sum_of_terms(affine, m, at.guard_row(g, 0), z, extent)[0]
                rate = rate_of_guard(n, generator, affine, wiring, m, g, z)
                known = 1 if abs(value) <= _NOTHING * abs(rate) * duration else 0
        order[g] = known
        fires = _must_fire(affine, m, g, z, extent, order, tolerance)
        # what starts on a surface that holds is held as long as it can be
        held = first_exit < 0 and passes == 0 and wiring[m, 1 + g, at.ONTO] == g
        if not fires and not (held and order[g] > 0):
            continue
        # where a guard is negative, the rates of the mode say nothing about the others
        # cells settle before the exits of the mode are read
        settling = e >= 0 and _is_surface(wiring, families, m, e)
        late = settling and not _is_surface(wiring, families, m, g)
        if e < 0 or (order[g] == 0 and order[e] > 0 and not late):
            e, meets = g, passes > 0 and order[g] > known
    return e, meets, followed


@kernel
def _onto_surface(wiring, m, e, visited):
    """The exit onto the surface of exit e where both sides point at it, else e."""
    onto, target = wiring[m, 1 + e, at.ONTO], wiring[m, 1 + e, at.TARGET]
    if onto < 0 or target < 0 or wiring[m, 1 + e, at.RESETTING] != 0:
        return e
    return onto if visited[target] != 0 else e


@kernel
def _over_surface(affine, wiring, m, e, z, extent, scale):
    """The exit to the other side, for a state that has jumped over a surface that holds; else e.

    What was never on the surface is not held there: only what arrives at it is.
    """
    if not _nearly_zero(affine, m, e, z, extent, scale):
        for k in range(wiring[m, 0, at.N_EXITS], wiring[m, 0, at.N_WAYS]):
            if wiring[m, 1 + k, at.ONTO] == e:
                return k
    return e


@kernel
def _visit_only(visited, m):
    for k in range(visited.size):
        visited[k] = 0
    visited[m] = 1


@kernel
def _cell_that_holds(tables, rates, segment, duration, tolerance):
    """The visited cell into which the motion leads when guards near zero count as zero, or -1.

    Cells hand over in a circle where surfaces that are the same but for rounding are crossed: each
    guard is a little on the wrong side in the one or the other. Rates tell which cell it is.
    """
    n, affine, wiring, z = tables.sizes[0], tables.affine, tables.wiring, segment.z
    extent, scale, order = segment.extent, segment.scale, segment.order
    for m in range(wiring.shape[0]):
        if segment.visited[m] == 0:
            continue
        if wiring[m, 0, at.IMPLICIT] != 0 and not settle(tables, rates, segment, m):
            continue
        linearise_mode(tables, rates, segment, m)
        if at.has_code(tables.code_rows, m):
            _differentiate(tables, rates, segment, m)
        fill_extent(n, affine, wiring, m, z, extent)
        fill_scale(n, tables.generator, affine, wiring, m, z, duration, scale)
        holds = True
        for g in range(wiring[m, 0, at.N_EXITS]):
            order[g] = 1 if _nearly_zero(affine, m, g, z, extent, scale) else 0
            holds = holds and not _must_fire(affine, m, g, z, extent, order, tolerance)
        if holds:
            return m
    return -1


@kernel
def _meeting(tables, m, z, extent, visited):
    """Exit of mode m onto a meeting of surfaces on which z lies, -1 for none."""
    n, wiring, found, most = tables.sizes[0], tables.wiring, -1, 1
    for e in range(wiring[m, 0, at.N_EXITS], wiring[m, 0, at.N_WAYS]):
        target = wiring[m, 1 + e, at.TARGET]
        if wiring[m, 1 + e, at.RESETTING] != 0 or visited[target] != 0:
            continue
        more = count_bits(wiring[target, 0, at.SLAVED] & ~wiring[m, 0, at.SLAVED])
        if more > most and slaved_agree(
            n, tables.affine, wiring, target, z, extent, z, 0, _CLEARLY
        ):
            found, most = e, more
    return found


@kernel
def count_bits(bits):
    """Number of bits that are set."""
    count = 0
    while bits > 0:
        count += bits & 1
        bits >>= 1
    return count


@kernel
def _is_surface(wiring, families, m, e):
    """Whether an exit leads through a surface to another cell of the same mode."""
    target = wiring[m, 1 + e, at.TARGET]
    return target >= 0 and families[target] == families[m] and wiring[m, 1 + e, at.RESETTING] == 0


@kernel
def in_cell(tables, m, z, extent, tolerance):
    """Whether a state lies within the surfaces of a cell, whatever the exits of its mode say."""
    for g in range(tables.wiring[m, 0, at.N_EXITS]):
        if _is_surface(tables.wiring, tables.families, m, g) and not guard_holds(
            tables.affine, m, g, z, extent, tolerance
        ):
            return False
    return True


@kernel
def _moved(n, z, mark, extent):
    """Whether a state is no longer where it was, beyond rounding."""
    for i in range(n):
        if abs(z[i] - mark[i]) > _CLEARLY * (extent[i] + abs(mark[i])):
            return True
    return False


@kernel
def linearise_mode(tables, rates, segment, m):
    """Bring the rows of a curved mode up to date at segment.z; linear ones always are.

    The rows of the derivatives of guards stay behind.
    """
    if at.has_code(tables.code_rows, m):
        linearise(
            tables, rates.slot_rates, rates.harmonics, rates.affine, segment.series,
            segment.dual, m, segment.z,
        )  # fmt: skip


@kernel
def _differentiate(tables, rates, segment, m):
    """Rows of the derivatives of guards at segment.z, where those of the values are."""
    linearise_derivatives(
        tables, rates.slot_rates, rates.harmonics, segment.series, segment.dual, m, segment.z
    )


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
        if not guard_holds(tables.affine, m, g, z, segment.extent, _CLEARLY):
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
def leaves_both_ways(tables, rates, segment, m, tolerance):
    """Exit of mode m at whose surface a start lies and another cell leaves too, -1 for none.

    segment.order holds the orders of zero that pass_exits has found
    """
    affine, wiring, order = tables.affine, tables.wiring, segment.order
    if wiring[m, 0, at.KIND] != at.FREE:
        return -1
    for g in range(wiring[m, 0, at.N_EXITS]):
        cell = wiring[m, 1 + g, at.TARGET]
        if not 0 < order[g] < at.DERIVATIVES or cell < 0 or cell == m:
            continue
        if tables.families[cell] == tables.families[m]:
            linearise_mode(tables, rates, segment, cell)
            if at.has_code(tables.code_rows, cell):
                _differentiate(tables, rates, segment, cell)
            holds = True
            for h in range(wiring[cell, 0, at.N_EXITS]):
                order[h] = 0
                holds = holds and not _must_fire(
                    affine, cell, h, segment.z, segment.extent, order, tolerance
                )
            return g if holds else -1
    return -1


@kernel
def _follow(n, affine, wiring, m, e, path, passes, scale, basis):
    """Directions left free along the whole path so far, where all modes are linear."""
    start_directions(n, affine, wiring, m, e, scale, basis)
    for k in range(min(passes, PATH_LENGTH)):
        way = ((path >> (PATH_BITS * k)) & ((1 << PATH_BITS) - 1)) - 1
        push_exit(n, affine, wiring, m, way, basis)
        m = wiring[m, 1 + way, at.TARGET]


@kernel
def _sum_of_terms(affine, m, row, z, extent):
    """Value of a row at z, and the sum of the sizes of its terms."""
    total, size = 0.0, 0.0
    for i in range(z.size):
        total += affine[m, row, i] * z[i]
        size += abs(affine[m, row, i]) * extent[i]
    return total, size


@kernel
def fill_extent(n, affine, wiring, m, z, extent):
    """Sizes of the coordinates: of those solved for, the terms that make up the solution.

    A ring that rests at zero on a rotor of size one is known to the rounding of the one.
    """
    n_exits = wiring.shape[1] - 1
    for i in range(z.size):
        extent[i] = abs(z[i])
    for i in range(n):
        if (wiring[m, 0, at.IMPLICIT] >> i) & 1:
            for j in range(z.size):
                extent[i] += abs(affine[m, at.relation_row(n_exits, i), j] * z[j])


@kernel
def guard_holds(affine, m, g, z, extent, tolerance):
    """Whether a guard is not negative, as far as the tolerance tells."""
    value, size = _sum_of_terms(affine, m, at.guard_row(g, 0), z, extent)
    return value >= -tolerance * size


@kernel
def guard_exceeds(affine, m, g, z, extent, share):
    """Whether a guard is above a part of its terms."""
    value, size = _sum_of_terms(affine, m, at.guard_row(g, 0), z, extent)
    return value > share * size


@kernel
def _is_nothing(affine, m, g, z, scale):
    """Whether a guard is nothing beside what it changes by in a while."""
    row, value, change = at.guard_row(g, 0), 0.0, 0.0
    for i in range(z.size):
        value += affine[m, row, i] * z[i]
        change += abs(affine[m, row, i]) * scale[i]
    return abs(value) <= _NOTHING * change


@kernel
def _nearly_zero(affine, m, g, z, extent, scale):
    """Whether a guard is small beside its terms, or beside what it will change by."""
    row = at.guard_row(g, 0)
    value, size = _sum_of_terms(affine, m, row, z, extent)
    change = 0.0
    for i in range(z.size):
        change += abs(affine[m, row, i]) * scale[i]
    return abs(value) <= _CLEARLY * size or abs(value) <= _NOTHING * change


@kernel
def _some_zero(affine, wiring, m, z, extent, scale):
    """Whether a guard of mode m is anywhere near zero, or below: its derivatives may count."""
    for g in range(wiring[m, 0, at.N_EXITS]):
        row, change = at.guard_row(g, 0), 0.0
        value, size = _sum_of_terms(affine, m, row, z, extent)
        for i in range(z.size):
            change += abs(affine[m, row, i]) * scale[i]
        if value <= _ANYWHERE_NEAR * (size + change):
            return True
    return False


@kernel
def _must_fire(affine, m, g, z, extent, order, tolerance):
    """Whether a guard is negative in the sense of its first derivative that is not zero.

    order[g] counts the zeros known by construction on entry; those that the tolerance
    declares to be zero are added.
    """
    if order[g] == ALWAYS_ZERO:
        return False
    for r in range(order[g], at.DERIVATIVES):
        value, size = _sum_of_terms(affine, m, at.guard_row(g, r), z, extent)
        if abs(value) > tolerance * size:
            order[g] = r
            return value < 0.0
    order[g] = ALWAYS_ZERO
    return False


@kernel
def _set_fired_zero(n, generator, affine, wiring, m, e, z, extent):
    """Put the state exactly on the fired guard, by the coordinate whose motion has led there.

    Where time has led there, as in cos(w t) + 1e-12 x, the state stays as it is: x would have
    to go far for what a rounding of time does.

    returns: the sum of the sizes of the terms before
    """
    row = at.guard_row(e, 0)
    value, size = _sum_of_terms(affine, m, row, z, extent)
    pivot, several = -1, False
    for i in range(z.size):
        if i != n and affine[m, row, i] != 0.0:
            several = pivot >= 0
            pivot = i
            if several:
                break
    if several:
        pivot = _largest_share(n, generator, affine, wiring, m, row, z)
    if 0 <= pivot < n:
        z[pivot] -= value / affine[m, row, pivot]
    return size


@kernel
def _largest_share(n, generator, affine, wiring, m, row, z):
    """State with the largest share in the rate of a guard; -1 where it has next to none."""
    pivot = -1
    largest, total = 0.0, 0.0
    for i in range(z.size):
        if i != n and affine[m, row, i] != 0.0:
            share = abs(affine[m, row, i] * velocity_of(n, generator, affine, wiring, m, z, i))
            total += share
            if i < n and share > largest:
                pivot, largest = i, share
    return pivot if largest >= _SHARE * total else -1


@kernel
def _reset(n, affine, wiring, m, e, z, extent, spare):
    """Apply the reset of an exit, all new values from the state before."""
    bits = wiring[m, 1 + e, at.RESETTING]
    if bits == 0:
        return
    n_exits = wiring.shape[1] - 1
    for i in range(n):
        spare[i] = z[i]
        if (bits >> i) & 1:
            spare[i] = _sum_of_terms(affine, m, at.reset_row(n_exits, n, e, i), z, extent)[0]
    copy_vector(spare, z, n)


@kernel
def _agrees(n, affine, wiring, target, segment, jumping, fired, scaled, tolerance):
    """Whether the slaved states of the target, in segment.spare, agree with their relations at z.

    jumping: bits of those that may jump; scaled: whether segment.scale is known
    """
    n_exits = wiring.shape[1] - 1
    for i in range(n):
        if (wiring[target, 0, at.SLAVED] >> i) & 1 and not (jumping >> i) & 1:
            row, before = at.relation_row(n_exits, i), segment.spare[i]
            value, size = _sum_of_terms(affine, target, row, segment.z, segment.extent)
            # the root of the fired guard leaves a little more than the tolerance
            allowed = max(tolerance, _CLEARLY) * (size + abs(before) + fired)
            for j in range(segment.z.size if scaled else 0):
                allowed += _CLEARLY * abs(affine[target, row, j]) * segment.scale[j]
            if abs(value - before) > allowed:
                return False
    return True


@kernel
def _settle_slaved(n, affine, wiring, m, z, extent):
    """Put the slaved states of a mode on their relations."""
    n_exits = wiring.shape[1] - 1
    for i in range(n):
        if (wiring[m, 0, at.SLAVED] >> i) & 1:
            z[i] = _sum_of_terms(affine, m, at.relation_row(n_exits, i), z, extent)[0]


@kernel
def slaved_agree(n, affine, wiring, m, z, extent, given, left_out, tolerance):
    """Whether the slaved states of a mode, as they were given, agree with their relations.

    left_out: bits of those that were not given, which agree in any case
    """
    n_exits = wiring.shape[1] - 1
    for i in range(n):
        if (wiring[m, 0, at.SLAVED] >> i) & 1 and not (left_out >> i) & 1:
            value, size = _sum_of_terms(affine, m, at.relation_row(n_exits, i), z, extent)
            if abs(value - given[i]) > tolerance * (size + abs(given[i])):
                return False
    return True
