"""Multipliers of a periodic orbit from the derivatives of its legs.

An event shifts with the state before it; the saltation matrix of the event takes that into account
(P. Mueller, 1995). The product over a turn is formed in a frame that turns with the motion
(`engine/graded_product`), so that small multipliers keep their digits beside large ones.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.orbits import LegResults, multiply_graded
from nonsmooth.engine.tables import members
from nonsmooth.periodic_orbits.equations import OrbitEquations

__all__ = ["UNBOUNDED", "Floquet", "Poles", "floquet", "leg_factors"]

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]

UNBOUNDED = 1e8  # a multiplier that is larger at a graze only tells how nearly it was located
_TURNS = 20  # of the frame before the product is formed
_SPLIT = 1e-13  # part of a direction that couples blocks: rounding of orthogonal matrices
_KICK = 1e-9  # change of the flow at an event, beside the flow, below which there is none
_RANK = 1e-13  # part of an event's matrix below which a direction is wiped out


class Floquet(NamedTuple):
    """Multipliers and what else is known of perturbations."""

    multipliers: Complexes  # largest modulus first, drifts and the motion along itself left out
    along: complex  # the multiplier of the motion along itself, which is one; nan of a driven orbit
    log_determinant: float  # of the tangent without drifts: -inf where a direction is wiped out
    poles: Poles


class Poles(NamedTuple):
    """Factors without which multipliers have poles, where an event that kicks is passed slowly.

    The event's matrix has a term of rank one over the rate of its guard, as at the graze of a rigid
    wall. So determinants of the tangent have a simple pole there, and change their sign.
    """

    determinant: float  # product over the events of their rates, each over its kick, 1 at most
    pairs: float  # the same for the product over all pairs of multipliers


class Factors(NamedTuple):
    """What a turn does to perturbations, factor by factor; drifts are left out."""

    flow: Floats  # (L, n, n)
    events: Floats  # (L, n, n)
    shares: Floats  # (L,) rate of the guard at each event over its size together with the kick


def leg_factors(equations: OrbitEquations, found: LegResults) -> Factors:
    """Matrices of legs and of the events at their ends, instants of events free."""
    n, stays = equations.legs.n, ~equations.drifting
    flow = found.flow[:, :n].transpose(0, 2, 1)
    events = found.jump[:, :n].transpose(0, 2, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        shifts = -found.guard_row[:, :n] / found.guard_rate[:, None]
    # jump_rate is the flow before the event, taken through it
    jumps = found.jump_rate - np.roll(found.start_rates, -1, axis=0)
    at_event = np.array([bool(path) for path in equations.word.paths])
    moved = jumps[:, :, None] * np.where(at_event[:, None], shifts, 0.0)[:, None, :]
    events = events + np.where(at_event[:, None, None], moved, 0.0)
    kicks = np.linalg.norm(jumps, axis=1) * np.linalg.norm(found.guard_row[:, :n], axis=1)
    sizes = np.linalg.norm(found.end_rates, axis=1) * np.linalg.norm(found.guard_row[:, :n], axis=1)
    # an event without a kick, as at a soft stop, has no pole whatever rounding leaves of it
    kicking = at_event & (kicks > _KICK * sizes)
    rates = -found.guard_rate
    shares = np.where(kicking, rates / np.hypot(rates, np.where(kicking, kicks, 1.0)), 1.0)
    return Factors(flow[:, stays][:, :, stays], events[:, stays][:, :, stays], shares)


def floquet(equations: OrbitEquations, found: LegResults) -> Floquet:
    """Multipliers of an orbit that solves its equations, from the results of its legs.

    nan where an event is passed without a rate, as at a graze.
    """
    factors = leg_factors(equations, found)
    free = _free_states(equations)
    ends = np.roll(free, -1, axis=0)  # free states behind each event
    events = np.where(ends[:, :, None], factors.events, 0.0)
    n = free.shape[1]
    if not np.all(np.isfinite(events)):
        unknown = np.full(n - equations.autonomous, np.nan, complex)
        return Floquet(unknown, np.nan, np.nan, Poles(np.nan, np.nan))
    # begin where the fewest states are free, the others being given by them
    first = int(np.argmin(free.sum(axis=1)))
    rank = int(_ranks(events).min(initial=n))
    products = np.roll(events @ factors.flow, -first, axis=0)
    values = np.zeros(n, complex)
    size = int(free[first].sum())
    values[:size] = _eigenvalues(np.ascontiguousarray(products), free[first])
    values = values[np.argsort(-np.abs(values), kind="stable")]
    values[min(size, rank) :] = 0.0  # what an event wipes out is gone, whatever rounding says
    along = complex(np.nan)
    if equations.autonomous and n:
        neutral = int(np.argmin(np.abs(values - 1.0)))
        along = complex(values[neutral])
        values = np.delete(values, neutral)
    poles = _poles(equations, factors.shares, len(values))
    return Floquet(values, along, _log_determinant(factors, free, rank), poles)


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


def _log_determinant(factors: Factors, free: npt.NDArray[np.bool_], rank: int) -> float:
    """Sum of logarithms over legs and events; -inf where directions are lost on the way."""
    if not free.all() or rank < free.shape[1]:
        return -np.inf
    return float(
        np.linalg.slogdet(factors.flow)[1].sum() + np.linalg.slogdet(factors.events)[1].sum()
    )
