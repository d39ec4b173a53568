"""Newton's method on the equations of an orbit, for fixed parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.linalg import lapack, matrix_balance

from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.legs import LegError, balanced_units

__all__ = ["AT_ZERO", "Solution", "null_vector", "row_scale", "scale_of", "size_of", "solve_orbit"]

Floats = npt.NDArray[np.float64]

_MOST_STEPS = 40
_MOST_HALVINGS = 12
_LONGEST = 1.0  # step, beside the unknowns: near a fold Newton's steps have no bounds
_SMALL = 1e-7  # step, beside the unknowns, the square of which is rounding
_ROUNDING = 1e-14  # residual that no step makes smaller
_CLOSED = 1e-10  # residual, beside the states, of a solution
_FURTHER = 4  # steps of an orbit that is found already
_BACKWARDS = 0.05  # part of the turn by which a leg may last less than nothing on the way
AT_ZERO = 1e-12  # states below which an orbit is one at rest at zero, and has no size of its own
_PLACES = np.arange(1, 8) / 8.0  # in a turn, at which states are looked at for their sizes
_NOTHING = 1e-6  # of the largest state: one of zero size, or one with another unit
_ALIKE = 1e-3  # of the largest state: what is made is known by its order only
_COUPLED = 1e-12  # of the largest part of the motion's matrix, below which it is rounding
_SINGULAR = 1e-15  # reciprocal condition of the scaled Jacobian


@dataclass(frozen=True)
class Solution:
    """Where Newton's method has come to; the equations hold the results of these unknowns."""

    unknowns: Floats
    residual: float  # largest entry, each beside the size of its state
    iterations: int
    status: str  # "completed", "no_orbit" or "singular"


def solve_orbit(
    equations: OrbitEquations, unknowns: Floats, *, steps: int = _MOST_STEPS
) -> Solution:
    """Solve for the unknowns from a guess; steps are halved where the residual would grow."""
    scale = _scale_along(equations, unknowns)
    try:
        residual, jacobian, _ = equations.evaluate(unknowns)
    except LegError:
        return Solution(unknowns, np.inf, 0, "no_orbit")
    rows = row_scale(equations, scale, jacobian)
    size = size_of(residual, rows)
    if size <= _ROUNDING:  # where branches cross, a step would lead away
        return Solution(unknowns, size, 0, "completed")
    last, further = np.inf, 0  # size of the step before; steps within rounding
    for iteration in range(1, steps + 1):
        step, well = _solve(jacobian * scale / rows[:, None], -residual / rows)
        if not well:
            # at rest no plane lies across the motion, so there a solution is singular too
            solved = "completed" if size <= _ROUNDING else "singular"
            return Solution(unknowns, size, iteration, solved)
        length = float(np.abs(step).max())
        if size <= _CLOSED and min(length, last) <= _SMALL:
            # further steps take what rounding allows
            size_there, found = _try(equations, unknowns + step * scale, rows)
            further += 1
            if found is None or size_there >= size or further > _FURTHER:
                equations.evaluate(unknowns)
                return Solution(unknowns, size, iteration, "completed")
            unknowns, size, last = unknowns + step * scale, size_there, length
            residual, jacobian = found
            continue
        part = _longest_part(equations, unknowns, step * scale)
        part = min(part, _LONGEST / max(length, _LONGEST))
        for _ in range(_MOST_HALVINGS):
            new = unknowns + part * step * scale
            size_there, found = _try(equations, new, rows)
            if size_there < size * (1.0 - 0.25 * part):
                break
            part *= 0.5
        else:
            equations.evaluate(unknowns)
            # of states that have died away rounding is no small part
            closed = "completed" if size <= _CLOSED else "no_orbit"
            return Solution(unknowns, size, iteration, closed)
        assert found is not None
        unknowns, size, last = new, size_there, length
        residual, jacobian = found
        if size == 0.0:
            return Solution(unknowns, size, iteration, "completed")
    return Solution(unknowns, size, steps, "completed" if size <= _ROUNDING else "no_orbit")


def null_vector(equations: OrbitEquations, unknowns: Floats) -> Floats:
    """Direction of the unknowns along which the equations change least."""
    scale = scale_of(equations, unknowns)
    _, jacobian, _ = equations.evaluate(unknowns)
    matrix = jacobian * scale
    weights = np.abs(matrix).max(axis=1, keepdims=True)
    vectors = np.linalg.svd(matrix / np.where(weights > 0.0, weights, 1.0))[2]
    return np.asarray(vectors[-1] * scale)


def _try(
    equations: OrbitEquations, unknowns: Floats, rows: Floats
) -> tuple[float, tuple[Floats, Floats] | None]:
    """Size of the residual somewhere, infinite where legs fail."""
    try:
        residual, jacobian, _ = equations.evaluate(unknowns)
    except LegError:
        return np.inf, None
    return size_of(residual, rows), (residual, jacobian)


def scale_of(equations: OrbitEquations, unknowns: Floats) -> Floats:
    """What counts as large for each unknown: the largest size of its state along the turn."""
    turn = equations.unpack(unknowns)
    states = turn.states - np.where(equations.drifting, turn.states[0], 0.0)
    size = np.abs(states).max(axis=0)
    largest = float(size.max())
    if not largest > AT_ZERO:
        size = np.ones(len(size))
    elif np.any(size <= _NOTHING * largest):
        try:
            coupling = equations.legs.coupling(equations.word, turn.states, turn.instants)
        except LegError:
            coupling = np.eye(len(size))
        size = _without_zeros(size, coupling)
    length = abs(float(turn.instants[-1] - turn.instants[0]))
    return np.concatenate(
        [np.tile(size, len(equations.word)), np.full(equations.n_instants, length)]
    )


def _without_zeros(size: Floats, coupling: Floats) -> Floats:
    """Sizes, in place of those that are zero or rounding what the motion makes of other states.

    Metres are small beside metres per second where motions are fast, and none the less no zero.
    What no other state makes counts as the largest one, in units that balance the motion.
    """
    largest = size.max()
    units = balanced_units(coupling)
    balanced = coupling * units / units[:, None]
    made = np.where(balanced > _COUPLED * balanced.max(), coupling, 0.0)
    np.fill_diagonal(made, 0.0)
    known, found = size > _NOTHING * largest, size.copy()
    for _ in size:  # what is made of large states makes others in turn
        natural = made[:, known] @ found[known]
        new = ~known & (natural > 0.0)
        natural = np.where(natural > _ALIKE * largest, largest, natural)
        found = np.where(new & (size <= _NOTHING * natural), natural, found)
        known |= new
    return np.where(known, found, (size / units).max() * units)


def _scale_along(equations: OrbitEquations, unknowns: Floats) -> Floats:
    """The same, with states looked at between the starts of legs too, where one may be zero."""
    scale, turn = scale_of(equations, unknowns), equations.unpack(unknowns)
    length = float(turn.instants[-1] - turn.instants[0])
    if not (np.all(turn.durations > 0.0) and np.isfinite(length)):
        return scale
    try:
        states = equations.states_along(turn, turn.instants[0] + length * _PLACES)
    except LegError:
        return scale
    count, n = len(equations.word), equations.legs.n
    size = np.where(equations.drifting, 0.0, np.abs(states)).max(axis=0)
    size = np.where(np.isfinite(size), size, 0.0)
    scale[: count * n] = np.maximum(scale[: count * n], np.tile(size, count))
    return scale


def row_scale(equations: OrbitEquations, scale: Floats, jacobian: Floats) -> Floats:
    """What counts as large for each equation: a state, or what a guard changes by."""
    n_states = equations.legs.n * len(equations.word)
    rows = np.ones(equations.size)
    rows[:n_states] = scale[:n_states]
    rows[n_states:] = np.abs(jacobian[n_states:] * scale).max(axis=1, initial=0.0)
    return np.where(rows > 0.0, rows, 1.0)


def size_of(residual: Floats, rows: Floats) -> float:
    """Largest entry of a residual beside the scale of its equation; infinite for no number."""
    size = float(np.abs(residual / rows).max())
    return size if np.isfinite(size) else np.inf


def _solve(matrix: Floats, right: Floats) -> tuple[Floats, bool]:
    """Solve a linear system; whether it is far enough from singular.

    States that have died away make units that differ by many powers of ten, and with them a regular
    matrix look singular: before it is called so, it is balanced.
    """
    solution, well = _solve_as_it_is(matrix, right)
    if well or not np.all(np.isfinite(matrix)):
        return solution, well
    balanced, (scale, _) = matrix_balance(matrix, permute=False, separate=True)
    solution, well = _solve_as_it_is(balanced, right / scale)
    return solution * scale, well


def _solve_as_it_is(matrix: Floats, right: Floats) -> tuple[Floats, bool]:
    factors, pivots, info = lapack.dgetrf(matrix)
    if info != 0 or not np.all(np.isfinite(factors)):
        return right, False
    norm = float(np.abs(matrix).sum(axis=0).max())
    reciprocal, _ = lapack.dgecon(factors, norm)
    # entries are of order one, so that a matrix of rounding alone is singular too
    if reciprocal * min(norm, 1.0) < _SINGULAR:
        return right, False
    solution, _ = lapack.dgetrs(factors, pivots, right)
    return solution, bool(np.all(np.isfinite(solution)))


def _longest_part(equations: OrbitEquations, unknowns: Floats, step: Floats) -> float:
    """Part of a step with which no leg lasts much less than nothing."""
    before = equations.unpack(unknowns).durations
    after = equations.unpack(unknowns + step).durations
    least = -_BACKWARDS * max(float(before.sum()), 1e-300)
    part = 1.0
    for old, new in zip(before, after, strict=True):
        if new < least < old:
            part = min(part, 0.5 * (old - least) / (old - new))
    return part
