"""The solver: least squares with bounds in which continuity of the segments comes to hold.

Continuity is an equation, and `scipy.optimize.least_squares` has none. The method of multipliers
adds it: gaps are residuals with a weight, shifted by multipliers that are brought forward from
round to round, so that the gaps vanish at a weight that is still harmless. The weight grows in
stages. At first the segments follow the data whatever the parameters are, and then they grow
together; that is what makes long and chaotic records converge. The first stages have several short
segments in place of each one: the shorter a motion is, the less often does a step of the solver
make or lose an event in it, at which derivatives change.

Where the loss is linear, the rows of each segment are replaced by the triangular factor of their QR
decomposition. Cost, gradient and Gauss-Newton matrix stay the same, so the solver takes the same
steps, with a few rows per segment in place of hundreds.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from nonsmooth.fitting.beginning import first_states, sizes_of_states
from nonsmooth.fitting.linearised import gap_matrix, spent_on
from nonsmooth.fitting.shooting import Evaluation, Shooting

__all__ = [
    "LOSSES",
    "Fitted",
    "close_gaps",
    "height",
    "minimise",
    "misfit_of_start",
    "prepare",
    "solve_from",
]

Floats = npt.NDArray[np.float64]

LOSSES = ("linear", "soft_l1", "huber", "cauchy", "arctan")
_WEIGHTS = (0.3, 3.0, 30.0, 300.0, 3000.0)
_ROUNDS = 6  # with the last weight
_CLOSED = 1e-4  # largest gap that is none, in units of a fiftieth of the size of a state
_NEARLY = 0.1  # largest gap that hardly moves a motion, in the same units
_SETTLED = 1e-3  # change of the noise from round to round
_EVALUATIONS = (25, 25, 25, 25, 60)
_JOINED = 3  # stage from which on segments that belong together are one
_LOOKS = 3  # at states from the beginning
_APART = 3.0  # a gap after the first stage that is large, in the units of a gap
_LEVEL = 0.01  # change of the logarithm of a likelihood that is none
_BEHIND = 20.0  # logarithm of a likelihood that no start makes up for
# Minus the logarithm of the likelihood of an event that is not matched, above that of one whose
# noise is as large as its wait. One that is matched gains at most 20.7, the logarithm of 1e9, where
# the noise is the smallest that is looked at: no start gains by an event that it loses.
_UNMATCHED = 25.0
_PENALTY = 1e4  # residual in each row of a run that ends early
_MEDIAN = 0.6744897501960817  # of the size of a normal variable


class UnmatchedEvents(NamedTuple):
    """What events count that were picked and that the motion does not have, and the other way."""

    cost: float  # their part of the cost
    height: float  # minus the logarithm of their likelihood


class Fitted(NamedTuple):
    """Unknowns at a minimum, and what holds there."""

    u: Floats
    cost: float  # half the sum of squares of the data, or of their losses
    unmatched: UnmatchedEvents
    noise: Floats  # (C,)
    multipliers: Floats  # (G, n)
    evaluation: Evaluation
    closed: bool  # whether the gaps are closed and the steps have ended
    n_evaluations: int


class _Equations:
    """Residuals and Jacobian for the solver, of the unknowns that are not held fixed."""

    def __init__(
        self,
        shooting: Shooting,
        noise: Floats,
        weight: float,
        shift: Floats,
        loss: str,
        held: tuple[int, Floats] | None = None,
    ) -> None:
        self.shooting, self.noise, self.weight, self.shift = shooting, noise, weight, shift
        self.compress = loss == "linear"
        self.u = np.empty(shooting.size) if held is None else held[1].copy()
        self.open = np.arange(shooting.size)
        if held is not None:
            self.open = np.delete(self.open, held[0])
        self.at: Floats | None = None
        self.evaluation: Evaluation | None = None
        self.n_evaluations = 0
        self.n_data = 0
        self.lowest: tuple[float, Floats] = np.inf, np.zeros(0)  # sum of squares, and where
        self._rows = np.zeros(0)
        self._matrix = np.zeros((0, shooting.size))

    def evaluate(self, x: Floats) -> Evaluation | None:
        if self.at is None or not np.array_equal(x, self.at):
            self.u[self.open] = x
            self.evaluation = self.shooting.evaluate(self.u, self.noise)
            self.at = x.copy()
            self.n_evaluations += 1
            self._assemble()
            square = float(self._rows @ self._rows)
            if self.evaluation is not None and square < self.lowest[0]:
                self.lowest = square, self.at
        return self.evaluation

    def residual(self, x: Floats) -> Floats:
        self.evaluate(x)
        return self._rows.copy()

    def jacobian(self, x: Floats) -> Floats:
        self.evaluate(x)
        matrix: Floats = self._matrix[:, self.open]
        return matrix

    def _assemble(self) -> None:
        shooting, found = self.shooting, self.evaluation
        if found is None:  # a penalty of full length, from which no step leads
            least = np.sqrt(self.lowest[0] / max(1, self._rows.size))
            self._rows = np.full(self._rows.size, max(_PENALTY, 10.0 * least))
            return
        blocks = self._blocks(found)
        n_data, gaps = sum(len(block[0]) for block in blocks), found.gap.size
        surplus = found.rows.surplus  # no step changes it, but a step that adds to it is refused
        rows, h, n = np.zeros(n_data + gaps + surplus.size), shooting.h, shooting.n
        matrix = np.zeros((rows.size, shooting.size))
        first = 0
        for m, (head, state, residual) in enumerate(blocks):
            last = first + len(residual)
            rows[first:last] = residual
            matrix[first:last, :h] = head
            matrix[first:last, h + m * n : h + (m + 1) * n] = state
            first = last
        self.n_data = n_data
        ends = slice(n_data, n_data + gaps)
        rows[ends] = self.weight * (found.gap + self.shift).ravel()
        matrix[ends] = self.weight * gap_matrix(shooting, found)
        rows[n_data + gaps :] = surplus
        self._rows, self._matrix = rows, matrix

    def _blocks(self, found: Evaluation) -> list[tuple[Floats, Floats, Floats]]:
        shooting, rows = self.shooting, found.rows
        ends = np.searchsorted(rows.segment, np.arange(shooting.n_segments + 1))
        blocks, columns = [], shooting.h + shooting.n
        for m in range(shooting.n_segments):
            here = slice(ends[m], ends[m + 1])
            parts = rows.head[here], rows.state[here], rows.residual[here]
            if self.compress:
                factor = np.zeros((columns + 1, columns + 1))
                whole = np.column_stack(parts)
                if len(whole):
                    triangle = np.linalg.qr(whole, mode="r")
                    factor[: len(triangle)] = triangle
                parts = factor[:, : shooting.h], factor[:, shooting.h : -1], factor[:, -1]
            blocks.append(parts)
        return blocks

    def loss(self, name: str) -> Any:
        """Loss for the solver: robust for the data, the plain square for gaps."""
        if name == "linear":
            return name

        def of(z: Floats) -> Floats:
            values = np.array([z, np.ones_like(z), np.zeros_like(z)])
            values[:, : self.n_data] = robust(name, z[: self.n_data])
            return values

        return of


def robust(name: str, z: Floats) -> Floats:
    """A loss of squares, with its first and second derivative, as scipy defines them."""
    if name == "soft_l1":
        t = 1.0 + z
        return np.array([2.0 * (t**0.5 - 1.0), t**-0.5, -0.5 * t**-1.5])
    if name == "huber":
        small, root = z <= 1.0, np.sqrt(np.maximum(z, 1e-300))
        return np.array(
            [
                np.where(small, z, 2.0 * root - 1.0),
                np.where(small, 1.0, 1.0 / root),
                np.where(small, 0.0, -0.5 / root**3),
            ]
        )
    if name == "cauchy":
        t = 1.0 + z
        return np.array([np.log1p(z), 1.0 / t, -1.0 / t**2])
    t = 1.0 + z**2
    return np.array([np.arctan(z), 1.0 / t, -2.0 * z / t**2])


def data_cost(residual: Floats, loss: str) -> float:
    """Half the sum of the losses of the data."""
    z = residual**2
    return 0.5 * float(np.sum(z if loss == "linear" else robust(loss, z)[0]))


def minimise(
    shooting: Shooting,
    u: Floats,
    noise: Floats,
    shift: Floats,
    weight: float = _WEIGHTS[-1],
    *,
    loss: str = "linear",
    held: int | None = None,
    most: int = 60,
) -> Fitted | None:
    """Minimum near some unknowns for given multipliers, one unknown held where it is.

    None where the motion ends early at the start.
    """
    fixed = None if held is None else (held, u)
    equations = _Equations(shooting, noise, weight, shift, loss, fixed)
    low, high = (each[equations.open] for each in shooting.limits)
    start = np.clip(u[equations.open], low, high)
    if equations.evaluate(start) is None:
        return None
    found = least_squares(
        equations.residual, start, equations.jacobian, bounds=(low, high), method="trf",
        loss=equations.loss(loss), max_nfev=most, ftol=1e-10, xtol=1e-9, gtol=1e-10,
    )  # fmt: skip
    evaluation, ended = equations.evaluate(found.x), found.status > 0
    if evaluation is None:  # the solver moves a start at a bound inside before it begins
        evaluation, ended = equations.evaluate(equations.lowest[1]), False
    assert evaluation is not None
    unmatched = _unmatched(shooting, evaluation, loss)
    cost = data_cost(evaluation.rows.residual[evaluation.rows.matched], loss) + unmatched.cost
    added = 0.5 * weight**2 * float(np.sum((evaluation.gap + shift) ** 2) - np.sum(shift**2))
    return Fitted(
        equations.u.copy(), cost + added, unmatched, noise, shift, evaluation, ended,
        equations.n_evaluations,
    )  # fmt: skip


def _unmatched(shooting: Shooting, found: Evaluation, loss: str) -> UnmatchedEvents:
    """Events that are not matched at the end of a minimisation.

    In the cost each is off by its wait, which moves the solver. In units of the noise that is the
    less the larger the noise is, so starts are compared by a likelihood without the noise.
    """
    rows, missed = found.rows, ~found.rows.matched
    cost = data_cost(rows.residual[missed], loss) + 0.5 * float(rows.surplus @ rows.surplus)
    counts = np.bincount(rows.channel[missed], minlength=len(shooting.channels))
    waits = [count * np.log(shooting.channels[c].spread) for c, count in enumerate(counts) if count]
    number = counts.sum() + rows.n_surplus.sum()
    return UnmatchedEvents(cost, float(sum(waits) + _UNMATCHED * number))


def height(fitted: Fitted) -> float:
    """Minus the logarithm of the likelihood, up to a constant, with the noise that was found."""
    rows = fitted.evaluation.rows
    counts = np.bincount(rows.channel[rows.matched], minlength=fitted.noise.size)
    matched = fitted.cost - fitted.unmatched.cost + float(counts @ np.log(fitted.noise))
    return matched + fitted.unmatched.height


def prepare(shooting: Shooting, values: Floats, initial: Floats) -> bool:
    """Take parameters, a limit of work and sizes of states; whether the system admits them."""
    if not shooting.set_up(shooting.head_of(values)):
        return False
    for each in shooting.records:
        each.limit_work(initial)
    largest = np.max([sizes_of_states(each, initial) for each in shooting.records], axis=0)
    shooting.scale_states(np.where(largest > 0.0, largest, 1.0))
    return True


def misfit_of_start(shooting: Shooting, initial: Floats, noise: Floats, seed: int) -> float:
    """Mean square of data and gaps where each segment is fitted by itself, before any search."""
    values = shooting.guess()
    if not prepare(shooting, values, initial):
        return np.inf
    states = _first_states(shooting, values, initial, noise, seed)
    if states is None:
        return np.inf
    found = shooting.evaluate(shooting.join(shooting.head_of(values), states), noise)
    if found is None:
        return np.inf
    return float(np.mean(found.rows.residual**2) + np.mean(found.gap**2 if found.gap.size else 0.0))


def solve_from(
    shooting: Shooting,
    values: Floats,
    initial: Floats,
    noise: Floats,
    loss: str,
    seed: int,
    best: float = np.inf,
) -> Fitted | None:
    """The minimum to which one start leads; None where no motion begins there.

    It is given up where it cannot come to the height of the best one so far.
    """
    states = _first_states(shooting, values, initial, noise, seed)
    if states is None:
        return None
    u, shift = (
        shooting.join(shooting.head_of(values), states), np.zeros((shooting.n_gaps, shooting.n)),
    )  # fmt: skip
    if not shooting.n_gaps:
        return close_gaps(shooting, u, noise, shift, loss)
    first = _first_stage(shooting, u, initial, noise, loss, seed)
    if first is None:
        return None
    return close_gaps(shooting, first.u, noise, shift, loss, first=first, best=best)


def _first_stage(
    shooting: Shooting, u: Floats, initial: Floats, noise: Floats, loss: str, seed: int
) -> Fitted | None:
    """Minimum with the first weight, whose states are found anew where segments are far apart.

    States that are not observed may come to rest far from where the segment before ends, while the
    parameters are still wrong. The first stage brings these near, and a second look begins there.
    """
    shift, best, count = np.zeros((shooting.n_gaps, shooting.n)), None, 0
    for look in range(_LOOKS):
        found = minimise(shooting, u, noise, shift, _WEIGHTS[0], loss=loss, most=_EVALUATIONS[0])
        if found is None:
            break
        count += found.n_evaluations
        if best is None or found.cost < best.cost:
            best = found
        if np.abs(found.evaluation.gap).max(initial=0.0) < _APART:
            break
        values = shooting.head_values(found.u)
        states = _first_states(shooting, values, initial, noise, seed + look + 1)
        if states is None:
            break
        u = shooting.join(found.u[: shooting.h], states)
    if best is None:
        return None
    shooting.begin_as(best.evaluation)
    return best._replace(n_evaluations=count)


def _first_states(
    shooting: Shooting, values: Floats, initial: Floats, noise: Floats, seed: int
) -> Floats | None:
    """States at the starts of the segments of all records; None where no motion begins."""
    states = []
    for r, record in enumerate(shooting.records):
        own, level = shooting.values_in(r, values), shooting.noise_in(r, noise)
        begun = first_states(record, own, initial, level, seed)
        if begun is None:
            return None
        states.append(begun)
    return np.concatenate(states)


def close_gaps(
    shooting: Shooting,
    u: Floats,
    noise: Floats,
    shift: Floats,
    loss: str,
    *,
    first: Fitted | None = None,
    best: float = np.inf,
) -> Fitted | None:
    """Minimum with closed gaps and the noise that belongs to it.

    It begins with the last weight, or with that after a first stage.
    """
    stage = -1 if first is None else 0
    weights, evaluations = _WEIGHTS[stage:], _EVALUATIONS[stage:]
    found, count, before, ended = first, 0, np.inf, False
    for k in range(len(weights) + _ROUNDS):
        now, following = (min(each, len(weights) - 1) for each in (k, k + 1))
        if now >= _JOINED:
            shooting.carry_modes()
        if now >= _JOINED and found is not None:
            u, shift = _with_fewer_segments(shooting, u, shift, found, now == len(weights) - 1)
        if k or first is None:
            found = minimise(
                shooting, u, noise, shift, weights[now], loss=loss, most=evaluations[now]
            )  # fmt: skip
        if found is None:
            return None
        u, count = found.u, count + found.n_evaluations
        gap = float(np.abs(found.evaluation.gap).max(initial=0.0))
        is_last = now == len(weights) - 1
        level = noise_level(shooting, found.evaluation, noise, loss, joined=is_last)
        if loss == "linear" and not is_last:
            # of the data alone, as gaps with multipliers may count below zero
            unmatched = found.unmatched._replace(cost=0.0)
            fair = found._replace(
                noise=level, cost=_cost_at(found, noise, level), unmatched=unmatched
            )
            if height(fair) > best + _BEHIND:  # worse although its segments need not join
                return fair._replace(closed=False, n_evaluations=count)
        settled = bool(np.all(np.abs(level / noise - 1.0) < _SETTLED))
        ended = found.closed or abs(height(found) - before) < _LEVEL
        before = height(found)
        if is_last and settled and gap < _CLOSED and ended:
            break
        # the force of a multiplier stays while weight and noise change what it weighs against
        force = (weights[now] / weights[following]) ** 2 * float(np.mean((noise / level) ** 2))
        shift, noise = (shift + found.evaluation.gap) * force, level
    assert found is not None
    return found._replace(n_evaluations=count, closed=ended and gap < 10.0 * _CLOSED)


def _with_fewer_segments(
    shooting: Shooting, u: Floats, shift: Floats, found: Fitted, is_last: bool
) -> tuple[Floats, Floats]:
    """Unknowns and multipliers without the segments that the search does not need any more.

    First the parts of each segment become one. In the end, where the gaps are nearly closed, so do
    neighbours in which no error grows: a step of the solver costs the third power of their number.
    """
    kept = shooting.whole_segments
    if kept.size < shooting.n_segments:
        u = shooting.join_segments(u, kept)
        return u, np.zeros((shooting.n_gaps, shooting.n))
    if not is_last or np.abs(found.evaluation.gap).max(initial=0.0) > _NEARLY:
        return u, shift
    kept = shooting.calm_segments(found.evaluation)
    left = shift[np.isin(shooting.links[:, 1], kept)]
    return shooting.join_segments(u, kept), left


def _cost_at(found: Fitted, noise: Floats, level: Floats) -> float:
    """Half the sum of squares of the data in units of another noise."""
    rows = found.evaluation.rows
    channel, residual = rows.channel[rows.matched], rows.residual[rows.matched]
    squares = np.bincount(channel, residual**2, noise.size) * (noise / level) ** 2
    return 0.5 * float(squares.sum())


def noise_level(
    shooting: Shooting, found: Evaluation, noise: Floats, loss: str, *, joined: bool
) -> Floats:
    """Standard deviation of the residuals of each channel, within its limits.

    Residuals are smaller than the noise by what the fit has spent on the channel. A channel of few
    samples may have more spent on it than its share, so that is looked at where segments join.
    """
    rows = found.rows
    spent = np.bincount(rows.channel, minlength=noise.size) * (shooting.n_spent / rows.channel.size)
    if joined and loss == "linear" and noise.size > 1:
        spent = spent_on(shooting, found)
    levels = np.empty(len(shooting.channels))
    for c, channel in enumerate(shooting.channels):
        own = rows.residual[(rows.channel == c) & rows.matched] * noise[c]
        if not own.size:
            levels[c] = noise[c]
            continue
        if loss == "linear":
            level = float(np.sqrt(own @ own / max(own.size - spent[c], 0.5 * own.size)))
        else:  # of those that are no outliers
            level = float(np.median(np.abs(own)) / _MEDIAN)
        least = channel.least_noise
        levels[c] = np.clip(level, least, max(least, channel.noise.high))
    return levels
