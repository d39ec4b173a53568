"""How much columns of derivatives grow, by repeated orthonormalisation.

Columns turn towards the direction that grows most and lose what tells them apart, so they are
replaced by an orthonormal basis of what they span before they do (G. Benettin, L. Galgani,
A. Giorgilli and J.-M. Strelcyn, Meccanica 15, 9-20, 1980). With U = Q R the logarithms of the
diagonal of R add up, and the flow takes Q on.

How often is found by the columns themselves. A piece of the run is accepted where the diagonal of
R spans less than `_WIDEST`, and series of columns have converged. Otherwise it is done again:
shorter where the motion is smooth, up to just before an event and the event by itself where there
is one. What an event alone contracts beyond `_LOSS` is no contraction but a loss of rank: a state
becomes slaved, or sticks. That direction is lost for good; its column is dropped and its exponent
is minus infinity.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import Status
from nonsmooth.simulation.clock import Instant
from nonsmooth.simulation.tangent_flow import Saved, TangentFlow

__all__ = ["Growth", "advance"]

_WIDEST = 1e6  # ratio of the diagonal of R in one piece; costs as much of its smallest entry
_NARROW = 1e3  # below it the next piece may be longer
_SUSPICION = 1e-10  # contraction by an event from which its rank is looked at
_LOSS = 1e-13  # of a singular value, beside one
_SHORTEST = 2.0**-20  # part of an interval; a shorter piece is an event by itself

Matrix = npt.NDArray[np.float64]


class Growth:
    """Logarithms of the growth of some columns, and which of them are left."""

    def __init__(self, flow: TangentFlow, count: int, seed: int) -> None:
        self.flow = flow
        self.left = list(range(count))  # columns that are not lost; they stand first in the flow
        self.at_anchor = np.zeros(count)
        self.at_end = np.zeros(count)  # where the last interval ended
        self.length = np.inf  # of a piece, where pieces are needed
        # any directions but the axes, which may belong to invariant subspaces
        generator = np.random.default_rng(seed)
        mixed = np.linalg.qr(generator.standard_normal((flow.n, flow.n)))[0][:count]
        self._take(mixed @ flow.first_columns, rank_of=flow.first_columns)

    def settle(self, columns: Matrix, rank_of: Matrix | None = None) -> None:
        """Put an orthonormal basis of some columns at the anchor and add up their growth.

        ``rank_of``: matrix whose rank tells how many columns are left.
        """
        diagonal = self._take(columns, rank_of)
        self.at_anchor[self.left] += np.log(diagonal)

    def spread(self, columns: Matrix) -> float:
        """Ratio of the largest column to the smallest entry of the diagonal of R."""
        if not self.left:
            return 1.0
        columns = columns[: len(self.left)]
        if not np.all(np.isfinite(columns)):
            return np.inf
        smallest = _orthonormal(columns)[1].min()
        largest = np.sqrt((columns * columns).sum(axis=1)).max()
        return float(largest / smallest) if smallest > 0.0 else np.inf

    def measure(self, columns: Matrix) -> None:
        """Growth up to where an interval ends, from columns there."""
        self.at_end = self.at_anchor.copy()
        with np.errstate(divide="ignore"):  # minus infinity: a direction lost since the anchor
            self.at_end[self.left] += np.log(_orthonormal(columns[: len(self.left)])[1])

    def _take(self, columns: Matrix, rank_of: Matrix | None) -> Matrix:
        columns = columns[: len(self.left)]
        rank = len(columns) if rank_of is None else min(len(columns), _rank(rank_of))
        while True:
            basis, diagonal = _orthonormal(columns)
            if len(columns) <= rank and not np.any(diagonal == 0.0):
                break
            lost = int(np.argmin(diagonal))
            self.at_anchor[self.left.pop(lost)] = -np.inf
            columns = np.delete(columns, lost, axis=0)
        self.flow.set_columns(basis)
        return diagonal


def advance(growth: Growth, end: Instant, interval: float) -> Status:
    """Run to the end of an interval and measure the growth there."""
    flow = growth.flow
    if growth.length < interval:
        return _advance_by_pieces(growth, end, interval)
    reach = flow.probe_series(_SHORTEST * interval)
    saved = flow.save()
    status = flow.run_to(end)
    if status != Status.COMPLETED:
        return status
    moved = flow.n_events > saved.counts[0] or flow.here != _instant(saved)
    spread = growth.spread(flow.columns_at_end)
    if moved:
        spread = max(spread, growth.spread(flow.columns))
    step = flow.between(_instant(saved), end) / flow.n_segments
    if spread > _WIDEST or step > reach:
        flow.restore(saved)
        growth.length = min(interval, reach)
        return _advance_by_pieces(growth, end, interval)
    growth.measure(flow.columns_at_end)
    if moved:
        growth.settle(flow.columns)
    return status


def _advance_by_pieces(growth: Growth, end: Instant, interval: float) -> Status:
    """The same in pieces that end at events, or where columns have grown apart."""
    flow, shortest = growth.flow, _SHORTEST * interval
    before: Instant | None = None  # an event that is to be met by itself
    while True:
        saved = flow.save()
        target = flow.after(flow.here, growth.length)
        limit = end if before is None else before
        if flow.between(target, limit) <= shortest:
            target = limit
        status = flow.run_to(target, one_event=True)
        at_event = status == Status.BUFFER_FULL
        if status != Status.COMPLETED and not at_event:
            return status
        duration = flow.between(_instant(saved), flow.here if at_event else target)
        ratio = growth.spread(flow.columns if at_event else flow.columns_at_end)
        # the piece may have several steps, and only the last of them is known
        longest = duration if at_event else flow.between(flow.here, target)
        unconverged = longest > flow.reach_of_series(saved.anchor.mode)
        if (ratio > _WIDEST or unconverged) and duration > 2.0 * shortest:
            if at_event:
                before = flow.after(flow.here, -shortest)
            else:
                growth.length = 0.5 * duration
            flow.restore(saved)
            continue
        if at_event:
            before = None
            suspect = ratio > 1.0 / _SUSPICION
            growth.settle(flow.columns.copy(), _tested(flow, saved) if suspect else None)
            continue
        if target == before:
            before = None
        if ratio < _NARROW:
            growth.length = 2.0 * max(growth.length, duration)
        if target == end:
            growth.measure(flow.columns_at_end)
        # a zero that a guard has hardly left is known by its order only, so the anchor stays
        if duration > shortest:
            flow.move_to_end()
            growth.settle(flow.columns.copy())
        if target == end:
            return status


def _tested(flow: TangentFlow, saved: Saved) -> Matrix:
    """Columns after an event that began as a basis in which its rank can be read.

    The event takes columns along the guard by its reset alone, and the one across it, however much
    that grows near a graze, to the direction of the motion afterwards. So neither cancels.
    """
    after = flow.save()
    normal = flow.guard_gradient()
    flow.restore(saved)
    left = int(np.count_nonzero(np.any(saved.columns != 0.0, axis=1)))
    columns = saved.columns[:left]
    across = columns @ normal
    if np.any(across != 0.0):
        # reflect so that all but the first column lie along the guard
        mirror = across / np.linalg.norm(across)
        mirror[0] += 1.0 if mirror[0] >= 0.0 else -1.0
        columns = columns - 2.0 * np.outer(mirror, mirror @ columns) / (mirror @ mirror)
    flow.set_columns(columns)
    flow.run_to(_behind(flow, after), one_event=True)
    tested = flow.columns[:left].copy()
    flow.restore(after)
    return tested


def _behind(flow: TangentFlow, after: Saved) -> Instant:
    """An instant surely behind the event at which a piece has ended."""
    return flow.after(_instant(after), flow.window)


def _instant(saved: Saved) -> Instant:
    return Instant(saved.anchor.number, saved.anchor.phase)


def _orthonormal(columns: Matrix) -> tuple[Matrix, Matrix]:
    """Orthonormal basis of what columns span, and the sizes of the diagonal of R.

    Of one column, as for the largest exponent, it is asked so often that a library takes long.
    """
    if len(columns) == 1:
        size = math.hypot(*columns[0])
        return columns / size if size > 0.0 else columns, np.array([size])
    basis, triangle = np.linalg.qr(columns.T)
    return basis.T, np.abs(np.diag(triangle))


def _rank(columns: Matrix) -> int:
    size = np.sqrt((columns * columns).sum(axis=1, keepdims=True))
    values = np.linalg.svd(columns / np.maximum(size, 1.0), compute_uv=False)
    return int(np.count_nonzero(values > _LOSS))
