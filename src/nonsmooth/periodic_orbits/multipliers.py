"""Multipliers of a periodic orbit from the derivatives of its legs.

An event shifts with the state before it; the saltation matrix of the event takes that into account
(P. Mueller, 1995). The product over a turn is formed in a frame that turns with the motion
(`engine/graded_product`), so that small multipliers keep their digits beside large ones.

Where nothing drives a system, perturbations are taken modulo the flow: its part of them is left out
at each event, before it is divided by the rate of the guard. An event that is passed slowly shifts
by much, and moves perturbations along its kick by as much. Where the kick is along the flow, as at
a rigid wall that one body touches, that is a shift in time and nothing else.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.orbits import LegResults, multiply_graded
from nonsmooth.engine.tables import members
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.legs import balanced_units
from nonsmooth.periodic_orbits.word import Word

__all__ = [
    "UNBOUNDED",
    "Factors",
    "Floquet",
    "Poles",
    "floquet",
    "leg_factors",
    "multipliers_at_touch",
]

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]
Integers = npt.NDArray[np.int64]

UNBOUNDED = 1e8  # a multiplier that is larger at a graze only tells how nearly it was located
_TURNS = 20  # of the frame before the product is formed
_SPLIT = 1e-13  # part of a direction that couples blocks: rounding of orthogonal matrices
_KICK = 1e-9  # change of the flow at an event, beside the flow, below which there is none
_EARLIER = 1e-9  # part of the shortest leg: the limit is approached like that
_CARRIED = 1e-3  # part of the rates by which the flow may miss them a turn later
_RANK = 1e-13  # part of an event's matrix below which a direction is wiped out


class Floquet(NamedTuple):
    """Multipliers and what else is known of perturbations."""

    multipliers: Complexes  # largest modulus first, drifts and the motion along itself left out
    log_determinant: float  # of the tangent without drifts: -inf where a direction is wiped out
    poles: Poles


class Poles(NamedTuple):
    """Factors without which multipliers have poles, where an event that kicks is passed slowly.

    The event's matrix has a term of rank one over the rate of its guard, as at the graze of a rigid
    wall. So determinants of the tangent have a simple pole there, and change their sign. Where
    nothing drives the system, a kick along the flow does not count.
    """

    determinant: float  # product over the events of their rates, each over its kick, 1 at most
    pairs: float  # the same for the product over all pairs of multipliers


class Factors(NamedTuple):
    """What a turn does to perturbations, factor by factor; drifts are left out."""

    flow: Floats  # (L, n, n)
    events: Floats  # (L, n, n)
    shares: Floats  # (L,) rate of the guard at each event over its size together with the kick;
    # the product of these where several guards are met at one instant
    kicks: Floats  # (L, n) change of the flow at each event
    guards: Floats  # (L, n) derivatives of its guard by the state


def leg_factors(
    equations: OrbitEquations, found: LegResults, *, modulo_flow: bool = False
) -> Factors:
    """Matrices of legs and of the events at their ends, instants of events free.

    ``modulo_flow``: perturbations behind each event without their part along the flow there, the
    state that changes fastest being zero.
    """
    n, stays = equations.legs.n, ~equations.drifting
    flow = found.flow[:, :n].transpose(0, 2, 1)
    events = found.jump[:, :n].transpose(0, 2, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        shifts = -found.guard_row[:, :n] / found.guard_rate[:, None]
    # jump_rate is the flow before the event, taken through it
    jumps = found.jump_rate - np.roll(found.start_rates, -1, axis=0)
    at_event = np.array([bool(path) for path in equations.word.paths])
    if modulo_flow:
        fastest = _fastest(equations, found)
        events, jumps = (_without_flow(each, found, fastest) for each in (events, jumps))
    with np.errstate(invalid="ignore"):  # a guard without a rate
        moved = jumps[:, :, None] * np.where(at_event[:, None], shifts, 0.0)[:, None, :]
    events = events + np.where(at_event[:, None, None], moved, 0.0)
    kicks = np.linalg.norm(jumps, axis=1) * np.linalg.norm(found.guard_row[:, :n], axis=1)
    sizes = np.linalg.norm(found.end_rates, axis=1) * np.linalg.norm(found.guard_row[:, :n], axis=1)
    # an event without a kick, as at a soft stop, has no pole whatever rounding leaves of it
    kicking = at_event & (kicks > _KICK * sizes)
    rates = -found.guard_rate
    shares = np.where(kicking, rates / np.hypot(rates, np.where(kicking, kicks, 1.0)), 1.0)
    shares *= _shares_of_later(found, np.where(kicking, kicks, 0.0))
    return Factors(
        flow[:, stays][:, :, stays], events[:, stays][:, :, stays], shares,
        np.where(kicking[:, None], jumps, 0.0)[:, stays], found.guard_row[:, :n][:, stays],
    )  # fmt: skip


def _shares_of_later(found: LegResults, kicks: Floats) -> Floats:
    """The shares of further exits of one instant that are met by themselves; kicks as the first."""
    met = (found.passed_rate != 0.0) & (kicks[:, None] > 0.0)
    rates = np.where(met, -found.passed_rate, 1.0)
    each = np.where(met, rates / np.hypot(rates, np.where(met, kicks[:, None], 1.0)), 1.0)
    return np.asarray(each.prod(axis=1))


def _fastest(equations: OrbitEquations, found: LegResults) -> Integers:
    """Number of the state that changes fastest behind each event, of those that are free; (L,)."""
    slaved = equations.legs.tables.wiring.modes["slaved"][equations.word.mode_array]
    free = ~members(slaved, equations.legs.n) & ~equations.drifting
    rates = np.where(free, np.abs(found.start_rates), -1.0)
    return np.argmax(np.roll(rates, -1, axis=0), axis=1)


def _without_flow(vectors: Floats, found: LegResults, fastest: Integers) -> Floats:
    """Vectors, or columns of matrices, behind each event without their part along the flow."""
    flow = np.roll(found.start_rates, -1, axis=0)
    legs = np.arange(len(flow))
    speed = flow[legs, fastest]
    share = flow / np.where(speed == 0.0, 1.0, speed)[:, None]
    share[legs, fastest] = 1.0
    part = vectors[legs, fastest]
    if vectors.ndim == 2:
        return vectors - share * part[:, None]
    return vectors - share[:, :, None] * part[:, None, :]


def _has_flow(equations: OrbitEquations, found: LegResults) -> bool:
    """Whether perturbations along the flow are known: not at rest, where its rates are rounding.

    Those of a cycle are carried to the ones at its end, which are those at its start.
    """
    if not equations.is_smooth_cycle:
        return equations.autonomous
    stays, n = ~equations.drifting, equations.legs.n
    flow = found.flow[0, :n].T[np.ix_(stays, stays)]
    begin, end = found.start_rates[0, stays], found.end_rates[0, stays]
    gap = np.maximum(np.abs(flow @ begin - end), np.abs(end - begin))
    return bool(np.linalg.norm(gap) < _CARRIED * np.linalg.norm(end))


def floquet(equations: OrbitEquations, found: LegResults) -> Floquet:
    """Multipliers of an orbit that solves its equations, from the results of its legs.

    nan where an event is passed without a rate, as at a graze.
    """
    modulo_flow = _has_flow(equations, found)
    factors = leg_factors(equations, found, modulo_flow=modulo_flow)
    free = _free_states(equations)
    if modulo_flow:  # the state that changes fastest follows from the others
        number = np.cumsum(~equations.drifting) - 1  # of a state among those that do not drift
        legs = np.arange(1, len(free) + 1) % len(free)
        free[legs, number[_fastest(equations, found)]] = False
    ends = np.roll(free, -1, axis=0)  # free states behind each event
    events = np.where(ends[:, :, None], factors.events, 0.0)
    n = free.shape[1]
    if not np.all(np.isfinite(events)):
        unknown = np.full(n - equations.autonomous, np.nan, complex)
        return Floquet(unknown, np.nan, Poles(np.nan, np.nan))
    # a frame that turns mixes the states: rounding of metres would be left in volts
    units = balanced_units(np.abs(factors.flow).sum(axis=0))
    events, flow = (_in_units(each, units) for each in (events, factors.flow))
    # begin where the fewest states are free, the others being given by them
    first = int(np.argmin(free.sum(axis=1)))
    rank = int(_ranks(events).min(initial=n))
    products = np.roll(events @ flow, -first, axis=0)
    values = np.zeros(n, complex)
    size = int(free[first].sum())
    values[:size] = _eigenvalues(np.ascontiguousarray(products), free[first])
    values = values[np.argsort(-np.abs(values), kind="stable")]
    values[min(size, rank) :] = 0.0  # what an event wipes out is gone, whatever rounding says
    if equations.autonomous and n:
        # the motion along itself, which is left out already or has a multiplier of one
        values = np.delete(values, -1 if modulo_flow else int(np.argmin(np.abs(values - 1.0))))
    # where all perturbations are lost within a turn, no slow event makes any of them large
    lost = values.size > 0 and not values.any()
    poles = Poles(1.0, 1.0) if lost else _poles(equations, factors.shares, len(values))
    whole = leg_factors(equations, found) if modulo_flow else factors
    return Floquet(values, _log_determinant(equations, whole), poles)


def _in_units(matrices: Floats, units: Floats) -> Floats:
    """Matrices (L, n, n) between states in other units, which changes no digit.

    Events that are passed slowly have large parts in any units.
    """
    return matrices * units / units[:, None]


def multipliers_at_touch(equations: OrbitEquations, turn: Turn) -> Floquet:
    """Multipliers of an orbit that passes an impact with hardly any speed, where they have limits.

    The speeds before and behind the impact belong to each other to rounding of the equations only,
    which is not little beside them. So rates behind each event are those of the state to which it
    leads. Where the speed is zero, the events are passed a little earlier.
    """
    legs, word = equations.legs, equations.word
    open_word = Word(word.modes[1:] + word.modes[:1], ((),) * len(word))
    for earlier in (0.0, _EARLIER * float(turn.durations.min())):
        ends = turn.instants[1:] - earlier
        nexts = legs.follow_each(word, turn.states, turn.instants[:-1], ends).nexts.copy()
        rates = legs.follow_each(open_word, nexts, ends, ends).start_rates.copy()
        found = legs.follow_each(word, turn.states, turn.instants[:-1], ends)
        found.start_rates[:] = np.roll(rates, 1, axis=0)
        multipliers = floquet(equations, found)
        if np.all(np.isfinite(multipliers.multipliers)):
            break
    return multipliers


def _poles(equations: OrbitEquations, shares: Floats, count: int) -> Poles:
    """The factors for all events.

    Of n multipliers n - 1 pairs have the one with the pole; at an impact, whose determinant stays
    finite, another one vanishes with it.
    """
    wiring, word = equations.legs.tables.wiring, equations.word
    resets = np.array(
        [
            bool(path) and wiring.resets(mode, path[0])
            for mode, path in zip(word.modes, word.paths, strict=True)
        ]
    )
    powers = np.maximum(count - 1 - resets, 0)
    return Poles(float(np.prod(shares)), float(np.prod(shares**powers)))


def _free_states(equations: OrbitEquations) -> npt.NDArray[np.bool_]:
    """Which states are free at the start of each leg: those not slaved; without drifts."""
    wiring = equations.legs.tables.wiring
    slaved = wiring.modes["slaved"][equations.word.mode_array]
    free = ~members(slaved, equations.legs.n)
    return np.asarray(free[:, ~equations.drifting])


def _ranks(events: Floats) -> npt.NDArray[np.int64]:
    """Directions that each event leaves, strong contraction along the legs being no loss."""
    if events.shape[1] == 0:
        return np.zeros(len(events), np.int64)
    values = np.linalg.svd(events, compute_uv=False)
    return np.count_nonzero(values > _RANK * values[:, :1], axis=1)


def _eigenvalues(products: Floats, free: npt.NDArray[np.bool_]) -> Complexes:
    """Eigenvalues of a product of matrices, the first one applied first, on the free states."""
    n, size = free.size, int(free.sum())
    frame = np.ascontiguousarray(np.eye(n)[:, free])
    start, triangle = np.zeros_like(frame), np.zeros((size, size))
    if size == 0:
        return np.zeros(0, complex)
    exponent = multiply_graded(products, _TURNS, frame, start, triangle)
    if np.isnan(exponent):
        return np.zeros(size, complex)
    turned = start.T @ frame  # by how much the frame has not come back: blocks on the diagonal
    borders = [k for k in range(1, size) if np.abs(turned[k:, :k]).max() <= _SPLIT]
    values = []
    with np.errstate(over="ignore"):
        scale = np.exp(exponent)
        for i, k in zip([0, *borders], [*borders, size], strict=True):
            # block by block, each in its own size: rounding of the largest drowns no other
            values.append(np.linalg.eigvals(turned[i:k, i:k] @ triangle[i:k, i:k]) * scale)
    return np.concatenate(values).astype(complex)


def _log_determinant(equations: OrbitEquations, factors: Factors) -> float:
    """Sum of logarithms over legs and events; -inf where directions are lost on the way."""
    free = _free_states(equations)
    ends = np.roll(free, -1, axis=0)
    events = np.where(ends[:, :, None], factors.events, 0.0)
    n = free.shape[1]
    units = balanced_units(np.abs(factors.flow).sum(axis=0))
    if not free.all() or int(_ranks(_in_units(events, units)).min(initial=n)) < n:
        return -np.inf
    return float(
        np.linalg.slogdet(factors.flow)[1].sum() + np.linalg.slogdet(factors.events)[1].sum()
    )
