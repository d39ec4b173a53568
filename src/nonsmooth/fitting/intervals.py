"""What a record says of the parameters: covariance, intervals, and what it leaves open."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.stats import f as f_distribution

from nonsmooth.fitting.correlated import block_length, correlation_of
from nonsmooth.fitting.discrepancy import Discrepancy, discrepancies_of
from nonsmooth.fitting.linearised import free_jacobian
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.fitting.solver import Fitted, minimise
from nonsmooth.leading_entry import leading_entry

__all__ = [
    "Allowance",
    "Better",
    "Direction",
    "GivenUp",
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
_UNTOLD = 1e-3  # what it counts as at most, in noise over ranges: a spread of many ranges
_NONE = 1e-30  # largest singular value, in noise over ranges, of residuals that nothing changes
_CLOSE = 0.01  # of the threshold: how near the end of an interval is found
_NEAR = 0.6  # of the distance by the curvature: an end that is nearer is not believed
_STEPS = 6  # for one end of an interval
_LOWER = -0.02  # of the threshold: a profile that goes below has found a better minimum
_MIDDLE = (0.3, 0.7)  # of the way to an end: a point there tells how the profile is bent
_TINY = 1e-300  # in place of zero, to divide by
_PART = 0.25  # of a direction: parameters with less do not belong to it


class Interval(NamedTuple):
    """Ends of a 95 % interval in units of the solver, and whether each was reached."""

    low: float
    high: float
    is_open: tuple[bool, bool]  # where a bound of the parameter cuts it off
    profile: Floats  # (K, 2): values, and how much twice the cost rises there, over the ratio
    is_followed: bool = True  # whether the profile could be followed to both ends


class Direction(NamedTuple):
    """A parameter that the record does not determine, or a combination of several."""

    parts: Floats  # (h,), of length one, in parts of the ranges
    spread: float  # standard deviation along it, in parts of the ranges


class Better(Exception):
    """A profile came to a minimum that lies lower."""

    def __init__(self, found: Fitted) -> None:
        super().__init__("a lower minimum")
        self.found = found


class GivenUp(Exception):
    """Profiles have taken as many motions as they may."""


class Allowance:
    """How many motions through the record profiles may take."""

    def __init__(self, most: float) -> None:
        self.left = most

    def take(self, found: Fitted | None) -> None:
        """Take off what a minimum has needed; `GivenUp` where nothing is left."""
        self.left -= 1 if found is None else found.n_evaluations
        if self.left < 0:
            raise GivenUp


class Spread(NamedTuple):
    """Covariance of all unknowns, and by how much it is larger than with white residuals."""

    root: Floats  # (size, f), units of the solver: its product with itself is the covariance
    white: Floats  # (size, size), as if residuals were white
    freedom: Floats  # (size,) degrees of freedom with which the variances are known
    is_widened: bool  # whether correlated residuals count in the first one
    discrepancies: list[Discrepancy]  # errors that follow the motion and count in it, too

    @property
    def covariance(self) -> Floats:
        """Covariance (size, size) of all unknowns, in units of the solver."""
        covariance: Floats = self.root @ self.root.T
        return covariance

    @property
    def ratio(self) -> Floats:
        """Variances over those with white residuals; 1 of a state that follows from others."""
        now, white = np.diag(self.covariance), np.diag(self.white)
        return np.divide(now, white, out=np.ones_like(now), where=white > 0.0)


def spread_of(shooting: Shooting, fitted: Fitted, loss: str) -> Spread:
    """Covariance of all unknowns with the gaps closed.

    The unknowns move in the null space of the equations of continuity only. What the data do not
    tell at all has a spread that is huge but finite. Estimates are linear in the residuals where
    these are small, so correlated residuals and errors that follow the motion make a covariance of
    the form of a sandwich. What a search that has not converged leaves is no noise.
    """
    free, basis = free_jacobian(shooting, fitted.evaluation)
    _, sizes, turned = np.linalg.svd(np.linalg.qr(free, mode="r"))
    largest = sizes.max(initial=0.0)
    least = _SMALLEST * (largest if largest > _NONE else 1.0)
    untold = np.flatnonzero(sizes <= least)
    sizes[untold] = min(least, _UNTOLD)  # also where the noise is as small as rounding
    root = basis @ turned.T / sizes
    white: Floats = root @ root.T
    freedom = np.full(shooting.size, shooting.n_free_data(fitted.evaluation))
    if loss != "linear" or not fitted.closed:  # a robust loss has weights of its own
        return Spread(root, white, freedom, False, [])
    tangents = free @ turned.T / sizes
    follows = discrepancies_of(shooting, fitted, tangents)
    floor = np.array([channel.least_noise for channel in shooting.channels])
    correlation = correlation_of(
        follows.rows, shooting.record_of_channel, tangents, follows.n_spent,
        fitted.noise <= floor, even_white=bool(follows.found),
    )  # fmt: skip
    if correlation is None:
        return Spread(root, white, freedom, False, [])
    inner = correlation.covariance_of(tangents)
    parts = [each.factor @ root.T for each in follows.found]
    for each in follows.found:
        inner += each.factor.T @ each.factor
    inner += follows.far.T @ follows.far
    inner[untold], inner[:, untold] = 0.0, 0.0  # no residual says anything, however it varies
    inner[untold, untold] = 1.0
    whole = root @ _root_of(inner)
    own = np.array([(part**2).sum(axis=0) for part in parts]).reshape(-1, shooting.size)
    known = np.array([each.freedom for each in follows.found])
    rest = np.minimum(correlation.freedom_of(tangents, root), freedom)
    freedom = _freedom_of_sum((whole**2).sum(axis=1), own, known, rest)
    return Spread(whole, white, freedom, True, follows.found)


def _root_of(covariance: Floats) -> Floats:
    """A matrix whose product with its own transpose is a covariance."""
    variances, vectors = np.linalg.eigh(covariance)
    root: Floats = vectors * np.sqrt(np.maximum(variances, 0.0))
    return root


def _freedom_of_sum(whole: Floats, parts: Floats, freedom: Floats, rest: Floats) -> Floats:
    """Degrees of freedom of sums of variances, by Satterthwaite: parts (J, size) and a rest."""
    left = np.maximum(whole - parts.sum(axis=0), 0.0) ** 2 / rest
    spread = left + (parts**2 / freedom[:, None]).sum(axis=0)
    found = rest.copy()
    np.divide(whole**2, spread, out=found, where=spread > 0.0)
    return np.clip(found, 1.0, rest)


def open_directions(shooting: Shooting, spread: Spread) -> list[Direction]:
    """What of the bounded parameters has a spread of the size of its range.

    First parameters that would be open if all others were known: the residuals hardly depend on
    them. Then combinations of the others: these residuals do depend on each of their members.
    """
    low, high = shooting.limits
    bounded = np.flatnonzero(np.isfinite(low[: shooting.h]) & np.isfinite(high[: shooting.h]))
    # of the root and not of the covariance, in whose entries a large spread drowns the others
    vectors, spreads, _ = np.linalg.svd(spread.root[bounded], full_matrices=False)
    told = vectors.T / np.maximum(spreads, _TINY)[:, None]  # over the spread along each direction
    alone = 1.0 / np.maximum(np.linalg.norm(told, axis=0), _TINY)  # spread, all others held
    found = [(float(alone[i]), np.eye(bounded.size)[i]) for i in np.flatnonzero(alone > _OPEN)]
    rest = np.flatnonzero(alone <= _OPEN)
    if rest.size:
        _, sizes, directions = np.linalg.svd(told[:, rest], full_matrices=False)
        for direction in _plain(directions[sizes < 1.0 / _OPEN]):
            parts = np.zeros(bounded.size)
            parts[rest] = direction
            found.append((1.0 / max(float(np.linalg.norm(told @ parts)), _TINY), parts))
    found.sort(key=lambda each: -each[0])
    return [_direction(shooting, bounded, *each) for each in found]


def _direction(
    shooting: Shooting, bounded: npt.NDArray[np.int64], spread: float, own: Floats
) -> Direction:
    """A direction among the bounded parameters as one of the whole head."""
    parts = np.zeros(shooting.h)
    parts[bounded] = own * np.sign(own[leading_entry(own)])
    parts[np.abs(parts) < _PART] = 0.0
    return Direction(parts, spread)


def _plain(directions: Floats) -> Floats:
    """Combinations (m, b) that span the same as some directions and have few members each.

    Where several are open, any mixture of them is as open. The reduced echelon form, with the
    largest entry as a pivot each time, parts them: a member of one combination alone is in no
    other.
    """
    plain, left = directions.copy(), list(range(len(directions)))
    while left:
        row, column = divmod(int(leading_entry(plain[left].ravel())), plain.shape[1])
        chosen = left.pop(row)
        plain[chosen] /= plain[chosen, column]
        for k in range(len(plain)):
            if k != chosen:
                plain[k] -= plain[k, column] * plain[chosen]
    found: Floats = plain / np.linalg.norm(plain, axis=1, keepdims=True)
    return found


def threshold(freedom: npt.ArrayLike) -> Floats:
    """Rise of twice the cost at the ends of a 95 % interval."""
    found: Floats = f_distribution.ppf(LEVEL, 1, freedom)
    return found


def profile_intervals(
    shooting: Shooting, fitted: Fitted, spread: Spread, loss: str, allowance: Allowance
) -> list[Interval]:
    """95 % intervals of parameters and nuisances from the profile of the likelihood.

    One of them is held away from its estimate and everything else is found anew, until the cost
    has risen by the threshold. Where residuals are correlated, the threshold is larger by the ratio
    of the variances. `Better` where the cost falls instead, `GivenUp` after too many motions.
    """
    plain = threshold(shooting.n_free_data(fitted.evaluation))
    stretch = spread.ratio * threshold(spread.freedom) / plain
    rises = stretch * plain
    found = []
    for i in range(shooting.h):
        profile = _Profile(shooting, fitted, spread.white, loss, i, float(rises[i]), allowance)
        (low, low_open, one), (high, high_open, other) = (profile.end(side) for side in (-1, 1))
        for side in (-1, 1):
            profile.look_between(side)
        opened, followed = (low_open, high_open), one and other
        points = profile.points / [1.0, stretch[i]]  # so that one threshold holds for all
        found.append(Interval(low, high, opened, points, followed))
    return found


class _Profile:
    """The least cost over one unknown: how much twice of it rises away from the estimate."""

    def __init__(
        self,
        shooting: Shooting,
        fitted: Fitted,
        covariance: Floats,
        loss: str,
        i: int,
        rise: float,
        allowance: Allowance,
    ) -> None:
        self.allowance = allowance
        self.shooting, self.fitted, self.loss, self.i, self.rise = shooting, fitted, loss, i, rise
        self.deviation = float(np.sqrt(covariance[i, i]))
        self._along = covariance[:, i] / covariance[i, i]
        self._seen: dict[float, float] = {0.0: 0.0}  # rises by signed distances

    @property
    def points(self) -> Floats:
        """Values that were looked at, in order, with the rises there."""
        distances = np.array(sorted(self._seen))
        rises = np.array([self._seen[each] for each in distances])
        return np.column_stack([self.fitted.u[self.i] + distances, rises])

    def look(self, distance: float) -> float:
        """Rise at a signed distance; infinite where no motion can be computed."""
        low, high = self.shooting.limits
        u = np.clip(self.fitted.u + distance * self._along, low, high)
        u[self.i] = self.fitted.u[self.i] + distance
        held = minimise(
            self.shooting, u, self.fitted.noise, self.fitted.multipliers, loss=self.loss,
            held=self.i, most=25,
        )  # fmt: skip
        self.allowance.take(held)
        if held is not None and not held.closed and held.cost - self.fitted.cost > 0.5 * self.rise:
            held = minimise(
                self.shooting, held.u, self.fitted.noise, self.fitted.multipliers,
                loss=self.loss, held=self.i,
            ) or held  # fmt: skip
            self.allowance.take(held)
        if held is None:
            return np.inf
        risen = 2.0 * (held.cost - self.fitted.cost)
        if risen < _LOWER * self.rise:
            raise Better(held)
        self._seen[distance] = max(risen, 0.0)
        return risen

    def end(self, side: int) -> tuple[float, bool, bool]:
        """One end, whether a bound cuts the interval off, and whether the profile leads there.

        Where the threshold is met much nearer than by the curvature at the minimum, the solver has
        not come back to the valley, and the end is that of the standard error: one near the
        estimate would say too much.
        """
        bound = self.shooting.limits[0 if side < 0 else 1][self.i]
        middle, rise = float(self.fitted.u[self.i]), self.rise
        room = abs(bound - middle)
        expected = distance = min(self.deviation * np.sqrt(rise), room)
        inside, outside = 0.0, np.inf
        for _ in range(_STEPS):
            distance = min(distance, room)
            if distance <= 0.0:
                return middle, True, True
            risen = self.look(side * distance)
            if abs(risen - rise) <= _CLOSE * rise:
                break
            if risen < rise:
                inside = distance
                if distance >= room:
                    return float(bound), True, True
            else:
                outside = distance
            distance = _next_distance(distance, risen, rise, inside, outside)
        if distance < _NEAR * expected:
            return middle + side * expected, expected >= room, False
        return middle + side * distance, False, True

    def look_between(self, side: int) -> None:
        """Look halfway to the farthest point of a side, where nothing near it was looked at."""
        distances = [side * each for each in self._seen if side * each > 0.0]
        if not distances:
            return
        # a point far outside tells little of the curve within the interval
        last = min(max(distances), 2.0 * self.deviation * np.sqrt(self.rise))
        low, high = (part * last for part in _MIDDLE)
        if not any(low < each < high for each in distances):
            self.look(side * 0.5 * last)


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
                own = (rows.channel == c) & rows.matched
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
