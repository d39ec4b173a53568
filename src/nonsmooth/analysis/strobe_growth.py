"""How fast neighbours part from strobe to strobe of a motion that does not repeat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.growth import Growth, advance
from nonsmooth.analysis.tangent_flow import TangentFlow
from nonsmooth.engine import layout
from nonsmooth.engine.layout import Tables
from nonsmooth.engine.status import Status
from nonsmooth.simulation.clock import Instant
from nonsmooth.simulation.runner import Derivatives, NoMode

__all__ = ["Neighbours", "is_autonomous", "is_hidden", "strobe_growth"]

_TOGETHER = 50  # strobes between which columns keep their length within the range of numbers
_TURN = 1e-9  # of a forcing between strobes, within which it is a whole one
_SEED = 0  # of the direction in which the neighbour begins

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Neighbours:
    """From where neighbours are followed, and at which strobes they are looked at.

    The first strobe is the start; ``turn`` more pass until the neighbour has turned to where it
    parts fastest.
    """

    tables: Tables
    derivatives: Derivatives
    tolerance: float
    state: Floats
    mode: int
    numbers: npt.NDArray[np.int64]
    phases: Floats
    turn: int
    drifting: npt.NDArray[np.bool_]

    @property
    def begin(self) -> Instant:
        """Instant of the first strobe."""
        return Instant(int(self.numbers[0]), float(self.phases[0]))


def is_autonomous(tables: Tables) -> bool:
    """Whether nothing drives a system: neither harmonics nor powers of time nor signals."""
    return not (tables.harmonics.shape[1] or tables.sizes[1] or tables.signals.shape[0])


def is_hidden(tables: Tables, length: float) -> bool:
    """Whether strobes see the forcing at different phases, for lack of a common period.

    Those phases neither grow nor die away, and are no states.
    """
    turns = tables.harmonics[0] * length / (2.0 * np.pi)
    return bool(np.any(np.abs(turns - np.rint(turns)) > _TURN * np.maximum(1.0, turns)))


def strobe_growth(neighbours: Neighbours) -> tuple[Status, Floats]:
    """Logarithmic growth of a neighbour in each interval behind the turn, drifts left out.

    returns: status, growth (intervals,); COMPLETED without growth where no mode takes the start
    """
    exact = bool(np.all(neighbours.tables.kinds == layout.EXACT))
    if exact and not is_autonomous(neighbours.tables):
        return _one_column(neighbours)
    return _several_columns(neighbours)


def _one_column(given: Neighbours) -> tuple[Status, Floats]:
    """One neighbour of a motion in closed form: it needs no look on the way.

    Nothing depends on drifting states, so their part of the column is put to zero.
    """
    flow = TangentFlow(given.tables, given.derivatives, 1, given.tolerance)
    try:
        status = flow.start(given.state, given.begin, given.mode)
    except NoMode:
        return Status.COMPLETED, np.zeros(0)
    direction = np.random.default_rng(_SEED).standard_normal(flow.n)
    flow.set_columns((direction @ flow.first_columns)[None])
    sizes: list[Floats] = [np.zeros(1)]
    lost = 0.0  # logarithm of what the column was divided by
    for first in range(1, given.numbers.size, _TOGETHER):
        part = slice(first, first + _TOGETHER)
        if status != Status.COMPLETED:
            return status, np.zeros(0)
        status, _states, columns = flow.run_through(given.numbers[part], given.phases[part])
        moving = columns[:, 0, ~given.drifting]
        with np.errstate(divide="ignore"):  # a column that is lost
            sizes.append(np.log(np.sqrt((moving * moving).sum(axis=1))) + lost)
        column = np.where(given.drifting, 0.0, flow.columns[0])
        size = float(np.sqrt(column @ column))
        if size > 0.0 and np.isfinite(size):
            lost += float(np.log(size))
            flow.set_columns((column / size)[None])
    if status != Status.COMPLETED:
        return status, np.zeros(0)
    with np.errstate(invalid="ignore"):
        return status, np.diff(np.concatenate(sizes))[given.turn :]


def _several_columns(given: Neighbours) -> tuple[Status, Floats]:
    """The largest exponent of several, those nearest zero left out for drifts and for time.

    Columns are made orthonormal, and their series looked after, from interval to interval.
    """
    neutral = int(np.count_nonzero(given.drifting)) + int(is_autonomous(given.tables))
    count = min(given.drifting.size, neutral + 1)
    flow = TangentFlow(given.tables, given.derivatives, count, given.tolerance)
    try:
        status = flow.start(given.state, given.begin, given.mode)
    except NoMode:
        return Status.COMPLETED, np.zeros(0)
    growth = Growth(flow, count, _SEED)
    rows, last = [], given.begin
    for k in range(1, given.numbers.size):
        if status != Status.COMPLETED:
            return status, np.zeros(0)
        end = Instant(int(given.numbers[k]), float(given.phases[k]))
        status = advance(growth, end, flow.between(last, end))
        rows.append(growth.at_end.copy())
        last = end
    if status != Status.COMPLETED:
        return status, np.zeros(0)
    logarithms = np.array(rows)[given.turn - 1 :]
    with np.errstate(invalid="ignore"):  # a column that was lost from the beginning
        order = np.argsort(np.abs(logarithms[-1] - logarithms[0]), kind="stable")
        left = logarithms[:, order[neutral:]]
        if left.shape[1] == 0:  # there is no other direction
            return status, np.full(len(logarithms) - 1, -np.inf)
        return status, np.diff(left[:, 0])
