"""What neighbours of a motion do: multipliers where it repeats, growth where it does not."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.exponents.growth import Growth
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import EXACT, Tables
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.crew import Stopped
from nonsmooth.runs.runner import Derivatives, NoMode
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.runs.tangent_flow import TangentFlow

__all__ = [
    "Neighbours",
    "OrbitTangent",
    "is_forgetful",
    "multipliers_of",
    "orbit_map",
    "strobe_growth",
]

_SUSPICION = 1e-6  # modulus of all multipliers from which the rank of the period is looked at

_TOGETHER = 50  # strobes between which columns keep their length within the range of numbers
_SEED = 0  # of the direction in which the neighbour begins

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class OrbitTangent:
    """A point of a motion that repeats, from where its derivatives are taken over a period."""

    tables: Tables
    derivatives: Derivatives
    tolerance: float
    state: Floats
    mode: int
    begin: Instant
    end: Instant
    lent: TangentFlow | None = None  # of the same system, with columns for all states

    def flow(self) -> TangentFlow | None:
        """Flow with the columns of all states; None where the mode does not take the point.

        A point that lies on a guard belongs to a mode only by what came before.
        """
        flow = self.lent
        if flow is None:
            n = self.tables.sizes.states
            flow = TangentFlow(self.tables, self.derivatives, n, self.tolerance)
        flow.set_up(self.tables, self.derivatives)
        try:
            status = flow.start(self.state, self.begin, self.mode)
        except NoMode:
            return None
        return flow if status == Status.COMPLETED else None


def orbit_map(orbit: OrbitTangent, drifting: npt.NDArray[np.bool_]) -> Floats | None:
    """Derivatives of the states at the end of a period by those at its begin, but for drifts.

    Nothing depends on a drifting state, so the others stand in the block without it. None where
    they are not known: a graze, a point that no mode takes.
    """
    flow = orbit.flow()
    if flow is None:
        return None
    flow.set_columns(flow.first_columns)
    if flow.run_to(orbit.end) != Status.COMPLETED:
        return None
    map_of_columns = flow.columns_at_end[~drifting][:, ~drifting]
    return map_of_columns if np.all(np.isfinite(map_of_columns)) else None


def multipliers_of(map_of_columns: Floats, autonomous: bool) -> npt.NDArray[np.complex128]:
    """Multipliers of a period, the largest first.

    A motion without forcing has one along itself, which is one and is left out; no motion has it
    where it does not move.
    """
    values = np.asarray(np.linalg.eigvals(map_of_columns), complex)
    if autonomous and values.size:
        values = np.delete(values, np.argmin(np.abs(values - 1.0)))
    return values[np.argsort(-np.abs(values), kind="stable")]


def is_forgetful(
    orbit: OrbitTangent,
    multipliers: npt.NDArray[np.complex128],
    drifting: npt.NDArray[np.bool_],
) -> bool:
    """Whether no perturbation outlives the period, but those along drifts.

    Found by the rank of what every event does, so that strong contraction does not count.
    """
    if np.abs(multipliers).max(initial=0.0) > _SUSPICION:
        return False
    flow = orbit.flow()
    if flow is None:
        return False
    growth = Growth(flow, flow.n, seed=0)
    status, _rows = growth.through([orbit.end])
    if status != Status.COMPLETED:
        return False
    return growth.n_left <= int(np.count_nonzero(drifting))


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
    stop: threading.Event | None = None

    def attend(self) -> None:
        """End the work where it is no longer wanted."""
        if self.stop is not None and self.stop.is_set():
            raise Stopped

    @property
    def begin(self) -> Instant:
        """Instant of the first strobe."""
        return Instant(int(self.numbers[0]), float(self.phases[0]))

    def ends(self, first: int, last: int) -> list[Instant]:
        """Instants of the strobes first ... last - 1."""
        numbers, phases = self.numbers[first:last].tolist(), self.phases[first:last].tolist()
        return [Instant(number, phase) for number, phase in zip(numbers, phases, strict=True)]


def strobe_growth(neighbours: Neighbours) -> tuple[Status, Floats]:
    """Logarithmic growth of a neighbour in each interval behind the turn, drifts left out.

    returns: status, growth (intervals,); COMPLETED without growth where no mode takes the start
    """
    if not is_driven(neighbours.tables):
        return _several_columns(neighbours)
    found = _one_column(neighbours)
    return _several_columns(neighbours) if found is None else found


def _one_column(given: Neighbours) -> tuple[Status, Floats] | None:
    """One neighbour of a motion that is driven; None where its columns have to be looked after.

    A motion whose modes have series is followed through the turn first, in which its column may be
    lost.
    """
    flow = TangentFlow(given.tables, given.derivatives, 1, given.tolerance)
    try:
        status = flow.start(given.state, given.begin, given.mode)
    except NoMode:
        return Status.COMPLETED, np.zeros(0)
    growth = Growth(flow, 1, _SEED)
    if status == Status.COMPLETED and np.any(given.tables.kinds != EXACT):
        status, _rows = _through(given, growth, given.ends(1, given.turn + 1))
        if growth.n_left == 0:
            return None
    if status != Status.COMPLETED:
        return status, np.zeros(0)
    flow.set_columns(growth.columns)
    here = flow.here
    since = (given.numbers - here.number) * flow.window + (given.phases - here.phase)
    first = int(np.argmax(since >= 0.0))
    return _sizes(given, flow, first)


def _through(given: Neighbours, growth: Growth, ends: list[Instant]) -> tuple[Status, Floats]:
    """Growth through some strobes, which ends where the work is no longer wanted."""
    rows = [np.empty((0, len(growth.columns)))]
    for k in range(0, len(ends), _TOGETHER):
        given.attend()
        status, part = growth.through(ends[k : k + _TOGETHER])
        rows.append(part)
        if status != Status.COMPLETED:
            return status, np.concatenate(rows)
    return Status.COMPLETED, np.concatenate(rows)


def _sizes(given: Neighbours, flow: TangentFlow, first: int) -> tuple[Status, Floats]:
    """Growth of the column from some strobe on, in chunks between which it is divided by its size.

    Nothing depends on drifting states, so their part of the column is put to zero.
    """
    sizes: list[Floats] = []
    lost = 0.0  # logarithm of what the column was divided by
    for k in range(first, given.numbers.size, _TOGETHER):
        given.attend()
        part = slice(k, k + _TOGETHER)
        status, _states, columns = flow.run_through(given.numbers[part], given.phases[part])
        if status != Status.COMPLETED:
            return status, np.zeros(0)
        moving = columns[:, 0, ~given.drifting]
        with np.errstate(divide="ignore"):  # a column that is lost
            sizes.append(np.log(np.sqrt((moving * moving).sum(axis=1))) + lost)
        column = np.where(given.drifting, 0.0, flow.columns[0])
        size = float(np.sqrt(column @ column))
        if size > 0.0 and np.isfinite(size):
            lost += float(np.log(size))
            flow.set_columns((column / size)[None])
    with np.errstate(invalid="ignore"):
        return Status.COMPLETED, np.diff(np.concatenate(sizes)[given.turn - first :])


def _several_columns(given: Neighbours) -> tuple[Status, Floats]:
    """The largest exponent of several, those nearest zero left out for drifts and for time.

    Columns are kept orthonormal.
    """
    neutral = int(np.count_nonzero(given.drifting)) + int(not is_driven(given.tables))
    count = min(given.drifting.size, neutral + 1)
    flow = TangentFlow(given.tables, given.derivatives, count, given.tolerance)
    try:
        status = flow.start(given.state, given.begin, given.mode)
    except NoMode:
        return Status.COMPLETED, np.zeros(0)
    if status != Status.COMPLETED:
        return status, np.zeros(0)
    status, rows = _through(given, Growth(flow, count, _SEED), given.ends(1, given.numbers.size))
    if status != Status.COMPLETED:
        return status, np.zeros(0)
    logarithms = rows[given.turn - 1 :]
    with np.errstate(invalid="ignore"):  # a column that was lost from the beginning
        order = np.argsort(np.abs(logarithms[-1] - logarithms[0]), kind="stable")
        left = logarithms[:, order[neutral:]]
        if left.shape[1] == 0:  # there is no other direction
            return status, np.full(len(logarithms) - 1, -np.inf)
        return status, np.diff(left[:, 0])
