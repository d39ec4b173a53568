"""What a record says of the parameters: covariance, intervals, and what it leaves open."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import null_space
from scipy.stats import f as f_distribution

from nonsmooth.fitting.correlated import block_length, correlation_of
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.fitting.solver import Fitted, gap_matrix, minimise

__all__ = [
    "Direction",
    "Interval",
    "Spread",
    "block_bootstrap",
    "open_directions",
    "profile_intervals",
    "spread_of",
]

Floats = npt.NDArray[np.float64]

LEVEL = 0.95
_OPEN = 0.3  # standard deviation, as a part of the range, beyond which a parameter is open
_SMALLEST = 1e-9  # singular value, as a part of the largest, that tells nothing
_CLOSE = 0.01  # of the threshold: how near the end of an interval is found
_STEPS = 6  # for one end of an interval
_LOWER = -0.02  # of the threshold: a profile that goes below has found a better minimum
_PART = 0.25  # of a direction: parameters with less do not belong to it


class Interval(NamedTuple):
    """Ends of a 95 % interval in units of the solver, and whether each was reached."""

    low: float
    high: float
    is_open: tuple[bool, bool]  # where a bound of the parameter cuts it off
    is_followed: bool = True  # whether the profile could be followed to both ends


class Direction(NamedTuple):
    """A combination of parameters that the record does not determine."""

    parts: Floats  # (h,), of length one, in parts of the ranges
    spread: float  # standard deviation along it, in parts of the ranges


class Better(Exception):
    """A profile came to a minimum that lies lower."""

    def __init__(self, found: Fitted) -> None:
        super().__init__("a lower minimum")
        self.found = found


class Spread(NamedTuple):
    """Covariance of all unknowns, and by how much it is larger than with white residuals."""

    covariance: Floats  # (size, size), units of the solver
    white: Floats  # (size, size), as if residuals were white
    is_widened: bool  # whether correlated residuals count in the first one

    @property
    def ratio(self) -> Floats:
        """Variances over those with white residuals; 1 of a state that follows from others."""
        now, white = np.diag(self.covariance), np.diag(self.white)
        return np.divide(now, white, out=np.ones_like(now), where=white > 0.0)


def spread_of(shooting: Shooting, fitted: Fitted, loss: str) -> Spread:
    """Covariance of all unknowns with the gaps closed.

    The unknowns move in the null space of the equations of continuity only. What the data do not
    tell at all has a spread that is huge but finite. Estimates are linear in the residuals where
    these are small, so correlated residuals make a covariance of the form of a sandwich.
    """
    rows = fitted.evaluation.rows
    jacobian = np.zeros((rows.residual.size, shooting.size))
    jacobian[:, : shooting.h] = rows.head
    columns = shooting.h + rows.segment[:, None] * shooting.n + np.arange(shooting.n)
    np.put_along_axis(jacobian, columns, rows.state, axis=1)
    basis = np.eye(shooting.size)
    if shooting.n_gaps:
        basis = null_space(gap_matrix(shooting, fitted.evaluation), rcond=1e-13)
    free = jacobian @ basis
    _, sizes, turned = np.linalg.svd(np.linalg.qr(free, mode="r"))
    sizes = np.maximum(sizes, _SMALLEST * sizes.max(initial=1e-300))
    root = basis @ turned.T / sizes
    white: Floats = root @ root.T
    found = None
    if loss == "linear":  # a robust loss has weights of its own
        found = correlation_of(rows, len(shooting.channels), shooting.times.size, shooting.n_spent)
    if found is None:
        return Spread(white, white, False)
    inner = found.covariance_of(free @ turned.T / sizes)
    return Spread(root @ inner @ root.T, white, True)


def open_directions(shooting: Shooting, covariance: Floats) -> list[Direction]:
    """Combinations of bounded parameters along which the spread is of the size of the range."""
    low, high = shooting.limits
    bounded = np.flatnonzero(np.isfinite(low[: shooting.h]) & np.isfinite(high[: shooting.h]))
    spreads, vectors = np.linalg.eigh(covariance[np.ix_(bounded, bounded)])
    found = []
    for square, vector in zip(spreads[::-1], vectors.T[::-1], strict=True):
        if not square > _OPEN**2:
            break
        parts = np.zeros(shooting.h)
        parts[bounded] = vector * np.sign(vector[np.abs(vector).argmax()])
        parts[np.abs(parts) < _PART] = 0.0
        found.append(Direction(parts, float(np.sqrt(square))))
    return found


def threshold(shooting: Shooting, count: int) -> float:
    """Rise of twice the cost at the ends of a 95 % interval."""
    return float(f_distribution.ppf(LEVEL, 1, max(1, count - shooting.n_spent)))


def profile_intervals(
    shooting: Shooting, fitted: Fitted, spread: Spread, loss: str
) -> list[Interval]:
    """95 % intervals of parameters and nuisances from the profile of the likelihood.

    One of them is held away from its estimate and everything else is found anew, until the cost
    has risen by the threshold. Where residuals are correlated, the threshold is larger by the ratio
    of the variances. `Better` where the cost falls instead.
    """
    rises = spread.ratio * threshold(shooting, fitted.evaluation.rows.residual.size)
    found = []
    for i in range(shooting.h):
        ends = [
            _end(shooting, fitted, spread.white, loss, i, side, float(rises[i])) for side in (-1, 1)
        ]
        (low, low_open, one), (high, high_open, other) = ends
        found.append(Interval(low, high, (low_open, high_open), one and other))
    return found


def _end(
    shooting: Shooting,
    fitted: Fitted,
    covariance: Floats,
    loss: str,
    i: int,
    side: int,
    rise: float,
) -> tuple[float, bool, bool]:
    """One end of an interval, whether a bound cuts it off, and whether the profile leads there.

    Where no point of the profile is found below the threshold, the solver has not come back to the
    valley, and the end is that of the standard error: one near the estimate would say too much.
    """
    low, high = shooting.limits
    bound = (low if side < 0 else high)[i]
    room = abs(bound - fitted.u[i])
    deviation = float(np.sqrt(covariance[i, i]))
    along = covariance[:, i] / covariance[i, i]
    expected = distance = min(deviation * np.sqrt(rise), room)
    best, inside, outside = fitted.u[i], (0.0, 0.0), np.inf
    for _ in range(_STEPS):
        distance = min(distance, room)
        if distance <= 0.0:
            return float(best), True, True
        u = np.clip(fitted.u + side * distance * along, low, high)
        u[i] = fitted.u[i] + side * distance
        held = minimise(
            shooting, u, fitted.noise, fitted.multipliers, loss=loss, held=i, most=25
        )  # fmt: skip
        if held is not None and not held.closed and held.cost - fitted.cost > 0.5 * rise:
            again = minimise(shooting, held.u, fitted.noise, fitted.multipliers, loss=loss, held=i)
            held = again or held
        risen = np.inf if held is None else 2.0 * (held.cost - fitted.cost)
        if held is not None and risen < _LOWER * rise:
            raise Better(held)
        if abs(risen - rise) <= _CLOSE * rise:
            return float(u[i]), False, True
        if risen < rise:
            inside = (distance, max(risen, 0.0))
            if distance >= room:
                return float(bound), True, True
        else:
            outside = distance
        distance = _next_distance(distance, risen, rise, inside[0], outside)
    if inside[0] == 0.0:
        return float(fitted.u[i] + side * expected), expected >= room, False
    return float(fitted.u[i] + side * distance), False, True


def _next_distance(
    distance: float, risen: float, rise: float, inside: float, outside: float
) -> float:
    """Where the root of the rise, which is nearly straight, meets its threshold."""
    if not np.isfinite(risen):
        return 0.5 * (inside + distance)
    guess = distance * np.sqrt(rise / risen) if risen > 1e-3 * rise else 4.0 * distance
    if inside < guess < outside:
        return float(guess)
    return 2.0 * inside if not np.isfinite(outside) else 0.5 * (inside + outside)


def block_bootstrap(
    shooting: Shooting, fitted: Fitted, loss: str, count: int, seed: int
) -> Floats | None:
    """Estimates (count, h) from records with residuals drawn anew, in blocks, with replacement.

    Blocks keep the correlation of residuals that a wrong model or coloured noise leaves.
    """
    rng = np.random.default_rng(seed)
    rows, found = fitted.evaluation.rows, []
    kept = [channel.values.copy() for channel in shooting.channels]
    try:
        for _ in range(count):
            for c, channel in enumerate(shooting.channels):
                own = rows.channel == c
                order = np.argsort(rows.place[own])
                place, residual = rows.place[own][order], rows.residual[own][order]
                size, length = residual.size, block_length(residual)
                first = rng.integers(0, size, -(-size // length))
                drawn = (first[:, None] + np.arange(length)).ravel()[:size] % size
                noise = fitted.noise[c]
                channel.values[place] = kept[c][place] + noise * (
                    residual - residual[drawn]
                )  # the fitted value less a residual of another place
            shooting.forget_plans()
            again = minimise(shooting, fitted.u, fitted.noise, fitted.multipliers, loss=loss)
            if again is not None:
                found.append(again.u[: shooting.h])
    finally:
        for channel, values in zip(shooting.channels, kept, strict=True):
            channel.values[:] = values
        shooting.forget_plans()
    return np.array(found) if found else None
