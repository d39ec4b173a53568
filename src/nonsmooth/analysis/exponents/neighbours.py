"""What neighbours of motions do: multipliers where these repeat, growth where they do not.

All motions of a group are followed side by side, in as many calls of the engine as for one.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.exponents.growth import begin_columns
from nonsmooth.engine.sweeps import Division
from nonsmooth.engine.tables import EXACT
from nonsmooth.runs.sweep_runner import SweepRunner, SweepStarts, Times
from nonsmooth.runs.sweep_tangents import SweepTangents

__all__ = [
    "Neighbours",
    "StrobeGrowth",
    "is_forgetful",
    "may_forget",
    "multipliers_of",
    "orbit_maps",
    "strobe_growth",
]

_SUSPICION = 1e-6  # modulus of all multipliers from which the rank of the period is looked at

_TOGETHER = 50  # strobes between which columns keep their length within the range of numbers
_AT_ONCE = 1000  # strobes that are kept with columns which are not needed
_SEED = 0  # of the direction in which the neighbour begins

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Neighbours:
    """From where neighbours of K motions are followed, and at which instants they are looked at.

    The first instant is the start. Those motions that are not ``chosen`` are left out.
    """

    runner: SweepRunner
    starts: SweepStarts
    chosen: Bools  # (K,)
    times: Times  # (K, s)
    drifting: Bools  # (n,)
    stop: threading.Event | None = None

    def begin(self, chosen: Bools) -> SweepTangents:
        """Some of the motions at their starts, with the columns of all states."""
        return SweepTangents(self.runner, self.starts, chosen, self.stop)


def orbit_maps(given: Neighbours) -> tuple[Bools, Floats]:
    """Derivatives of the states at all instants by those at the starts, but for drifts.

    Nothing depends on a drifting state, so the others stand in the block without it.

    returns: where they are known (K, s), as neither behind a graze nor for a start that no mode
    takes; blocks (K, s, k, k), with one state each in their rows
    """
    flow = SweepTangents(given.runner, given.starts, given.chosen, given.stop, given.times)
    still = ~given.drifting
    # what is recorded has the derivatives by one state each in its rows
    blocks = flow.samples[:, :, still][..., still].swapaxes(2, 3).copy()
    known = given.chosen[:, None] & flow.reached & np.all(np.isfinite(blocks), axis=(2, 3))
    return known, blocks


def multipliers_of(blocks: Floats, along: Bools) -> list[npt.NDArray[np.complex128]]:
    """Multipliers of K period maps, (K, k, k), the largest first.

    A motion without forcing has one ``along`` itself, (K,), which is one and is left out; no motion
    has it where it does not move.
    """
    found = np.asarray(np.linalg.eigvals(blocks), complex)
    return [_largest_first(*each) for each in zip(found, along.tolist(), strict=True)]


def _largest_first(values: npt.NDArray[np.complex128], along: bool) -> npt.NDArray[np.complex128]:
    if along and values.size:
        values = np.delete(values, np.argmin(np.abs(values - 1.0)))
    return values[np.argsort(-np.abs(values), kind="stable")]


def may_forget(multipliers: npt.NDArray[np.complex128]) -> bool:
    """Whether multipliers are so small that `is_forgetful` has to tell what they are."""
    return bool(np.abs(multipliers).max(initial=0.0) <= _SUSPICION)


def is_forgetful(given: Neighbours) -> Bools:
    """Whether no perturbation outlives the last instants, but those along drifts, (K,).

    Found by the rank of what every event does, so that strong contraction does not count.
    """
    flow = given.begin(given.chosen)
    columns, growth = _begun(flow, given.chosen & flow.goes_on, given.drifting.size)
    flow.run(given.times.at(slice(-1, None)), columns, growth)
    left = np.count_nonzero(~np.isneginf(flow.growth), axis=1)
    return given.chosen & flow.goes_on & (left <= np.count_nonzero(given.drifting))


class StrobeGrowth(NamedTuple):
    """Growth of a neighbour of each of K motions."""

    statuses: Integers  # (K,): how each motion ended, or COMPLETED
    has_mode: Bools  # (K,): whether a mode takes the start; there is no growth where none does
    growth: Floats  # (K, intervals): logarithms
    areas: Floats  # (K, intervals): of what all columns span; nan where they fill all states


def strobe_growth(given: Neighbours, turn: int) -> StrobeGrowth:
    """Logarithmic growth of a neighbour in each interval behind the turn, drifts left out.

    In ``turn`` intervals the neighbour turns to where it parts fastest.
    """
    if not given.runner.is_driven:
        return _several_columns(given, given.chosen, turn)
    found, lost = _one_column(given, turn)
    if np.any(lost):
        again = _several_columns(given, lost, turn)
        for each, other in zip(found, again, strict=True):
            each[lost] = other[lost]
    return found


def _begun(flow: SweepTangents, going: Bools, count: int) -> tuple[Floats, Floats]:
    """Some orthonormal columns of the motions that go on, and their growth; zero for the others.

    shapes: going (K,); returns (K, count, n) and (K, count)
    """
    columns, growth = np.zeros_like(flow.columns[:, :count]), np.zeros((going.size, count))
    generator = np.random.default_rng(_SEED)
    columns[going], growth[going] = begin_columns(flow.columns[going], count, generator)
    return columns, growth


def _one_column(given: Neighbours, turn: int) -> tuple[StrobeGrowth, Bools]:
    """One neighbour of motions that are driven, and whose columns have to be looked after, (K,).

    Motions whose modes have series are followed through the turn first, in which a column may be
    lost.
    """
    flow = given.begin(given.chosen)
    has_mode = flow.has_mode
    columns, growth = _begun(flow, given.chosen & flow.goes_on, 1)
    lost = np.zeros(given.chosen.size, bool)
    if np.any(given.runner.kinds != EXACT):
        flow.run(given.times.at(slice(turn, turn + 1)), columns, growth)
        columns = flow.columns
        lost = given.chosen & flow.goes_on & np.isneginf(flow.growth[:, 0])
    sizes = _sizes(given, flow, columns, given.chosen & ~lost)
    with np.errstate(invalid="ignore"):
        found = np.diff(sizes[:, turn:], axis=1)
        return StrobeGrowth(flow.statuses, has_mode, found, found), lost


def _sizes(given: Neighbours, flow: SweepTangents, columns: Floats, chosen: Bools) -> Floats:
    """Logarithms of the size of one column (K, 1, n) at each instant from the anchors on, (K, s).

    It is divided by its size at times, within the one call of the engine.
    """
    numbers, phases = given.times
    here, phase = (each[:, None] for each in flow.anchors)
    since = (numbers - here) * given.runner.windows[:, None] + (phases - phase)
    first, count = np.argmax(since >= 0.0, axis=1), numbers.shape[1]
    # those that have fewer instants left stay at the last one
    places = first[:, None] + np.arange(count - int(first[chosen].min(initial=count - 1)))
    inside = np.minimum(places, count - 1)
    parts = -(-inside.shape[1] // _TOGETHER)
    division = Division(np.ones((chosen.size, parts)), given.drifting, _TOGETHER)
    samples, _ = flow.run(given.times.along(inside), columns, division=division, chosen=chosen)
    moving = samples[:, :, 0][..., ~given.drifting]
    divided = np.zeros((chosen.size, parts))  # logarithm of what each was divided by before
    divided[:, 1:] = np.cumsum(np.log(division.sizes[:, :-1]), axis=1)
    with np.errstate(divide="ignore"):  # a column that is lost
        found = np.log(np.sqrt((moving * moving).sum(axis=2)))
    found += np.repeat(divided, _TOGETHER, axis=1)[:, : inside.shape[1]]
    sizes, (row, place) = np.full(numbers.shape, np.nan), np.nonzero(places < count)
    sizes[row, places[row, place]] = found[row, place]
    return sizes


def _several_columns(given: Neighbours, chosen: Bools, turn: int) -> StrobeGrowth:
    """The largest exponent of several, those nearest zero left out for drifts and for time.

    Columns are kept orthonormal.
    """
    neutral = int(np.count_nonzero(given.drifting)) + int(not given.runner.is_driven)
    flow = given.begin(chosen)
    has_mode = flow.has_mode
    count = min(given.drifting.size, neutral + 1)
    columns, growth = _begun(flow, chosen & flow.goes_on, count)
    rows = [np.empty((chosen.size, 0, count))]
    for k in range(1, given.times.numbers.shape[1], _AT_ONCE):
        _, more = flow.run(given.times.at(slice(k, k + _AT_ONCE)), columns, growth)
        columns, growth = flow.columns, flow.growth
        rows.append(more)
    logarithms = np.concatenate(rows, axis=1)[:, turn - 1 :]
    if count == neutral:  # there is no other direction
        found = np.full((chosen.size, logarithms.shape[1] - 1), -np.inf)
        return StrobeGrowth(flow.statuses, has_mode, found, np.full_like(found, np.nan))
    with np.errstate(invalid="ignore"):  # a column that was lost from the beginning
        moved = np.abs(logarithms[:, -1] - logarithms[:, 0])
        order = np.argsort(moved, axis=1, kind="stable")[:, None, neutral, None]
        left = np.take_along_axis(logarithms, order, axis=2)[..., 0]
        areas = np.diff(logarithms.sum(axis=2), axis=1)
        return StrobeGrowth(flow.statuses, has_mode, np.diff(left, axis=1), areas)
