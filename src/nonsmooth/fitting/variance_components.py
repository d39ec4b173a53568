"""Variances of families of random errors in residuals, by restricted maximum likelihood.

Residuals are taken as white noise and a sum of known columns with random coefficients. Those of a
family have one variance, and these variances are found. What a fit has taken out of the residuals
along its own derivatives, the tangents, is taken out of the columns too: the likelihood is that of
what no unknown of the fit could have changed. So a family of which the fit has absorbed most is
judged by the rest.

A variance that is not needed is zero. The families are those of a stepwise selection: one after
the other enters with which the likelihood rises most.

A family that residuals surely speak for is named. One that they speak for less surely is counted,
too: to leave a variance out unless it is significant makes intervals far too short where it is
about as large as can just not be seen. Tests before pooling of variances are therefore made at a
level of a quarter (Bozivich, Bancroft and Hartley).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize
from scipy.stats import chi2

__all__ = ["Components", "variance_components"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_STARTS = (2.0, 7.0)  # logarithm of a variance times its columns, over the noise
_BOUNDS = (-12.0, 18.0)  # of the same; the lower one is a variance of zero
_NEAR_ZERO = -10.0
_STEP = 0.05  # of these logarithms, for second derivatives
_ALONG = 1e-9  # singular value, as a part of the largest, of tangents that are the same
_ABSORBED = 1e-6  # part of the columns that tangents leave, below which nothing tells of a family


class Components(NamedTuple):
    """Families of random errors that residuals speak for."""

    families: list[int]  # their numbers
    named: list[bool]  # whether residuals surely speak for each
    variances: Floats  # of their coefficients, in squares of the unit of the residuals
    freedom: Floats  # degrees of freedom with which each variance is known
    coefficients: Floats  # (m,) most likely ones; zero in families that were left out
    noise: float  # variance of the white noise
    n_spent: float  # how many coefficients the residuals have determined


class _Subset(NamedTuple):
    """The best variances of some families."""

    families: list[int]
    logs: Floats  # of variance times columns, over the noise
    height: float  # minus the logarithm of the likelihood


def variance_components(
    residual: Floats,
    columns: Sequence[Floats],
    tangents: Floats,
    level: float,
    counted: float | None = None,
) -> Components | None:
    """Families that white residuals (N,) speak for; None where there are none.

    columns: of each family (N, m), of about the size of one
    tangents: derivatives (N, q) of the residuals by what was fitted
    level: probability with which a family is named in noise
    counted: probability with which one is counted in noise, the same by default
    """
    sizes, vectors = np.linalg.svd(tangents, full_matrices=False)[1::-1]
    along = vectors[:, sizes > _ALONG * sizes.max(initial=1e-300)]
    whole = np.concatenate(columns, axis=1)
    left = whole - along @ (along.T @ whole)
    rest = residual - along @ (along.T @ residual)
    family = np.repeat(np.arange(len(columns)), [each.shape[1] for each in columns])
    number = residual.size - along.shape[1]
    if number <= 0 or not rest @ rest > 0.0:
        return None
    likelihood = _Likelihood(left.T @ left, left.T @ rest, float(rest @ rest), number, family)
    own = np.bincount(family, (whole**2).sum(axis=0), len(columns))
    told = np.flatnonzero(likelihood.trace > _ABSORBED * np.maximum(own, 1e-300)).tolist()
    named = _stepwise(likelihood, told, level, likelihood.best([]))
    kept = named if counted is None else _stepwise(likelihood, told, counted, named)
    return likelihood.components(kept, named.families) if kept.families else None


def _stepwise(
    likelihood: _Likelihood, families: list[int], level: float, found: _Subset
) -> _Subset:
    """Families that are entered one after the other, as long as the likelihood rises by enough.

    One that another one makes needless leaves again, but for those that were found before. Few
    families come first: those of a record are soon so many that together they explain whatever
    repeats.
    """
    # a variance has a bound at zero: half of the ratios of likelihoods are zero without it
    least = 0.5 * float(chi2.isf(2.0 * level, 1))
    before = set(found.families)
    while len(found.families) < len(families):
        more = [
            likelihood.best(sorted([*found.families, each]))
            for each in families
            if each not in found.families
        ]
        best = min(more, key=lambda each: each.height)
        if found.height - best.height < least:
            break
        found = best
        while len(found.families) > max(1, len(before)):
            fewer = [
                likelihood.best([other for other in found.families if other != each])
                for each in found.families
                if each not in before
            ]
            best = min(fewer, key=lambda each: each.height)
            if best.height - found.height >= least:
                break
            found = best
    return found


class _Likelihood:
    """Restricted likelihood of variances, the noise being the most likely one."""

    def __init__(
        self, products: Floats, by_residual: Floats, square: float, number: int, family: Integers
    ) -> None:
        self.products, self.by_residual, self.square = products, by_residual, square
        self.number, self.family = number, family
        # sums of squares of the columns of each family: variances are counted in their means
        self.trace = np.bincount(family, np.diag(products), int(family.max(initial=-1)) + 1)
        self._mean = np.maximum(self.trace, 1e-300) / np.maximum(np.bincount(family), 1)

    def best(self, families: list[int]) -> _Subset:
        """The most likely variances of some families."""
        if not families:
            return _Subset([], np.zeros(0), 0.5 * self.number * np.log(self.square / self.number))
        tries = [
            minimize(
                lambda logs: self.height(families, logs), np.full(len(families), start),
                jac=True, method="L-BFGS-B", bounds=[_BOUNDS] * len(families),
            )
            for start in _STARTS
        ]  # fmt: skip
        found = min(tries, key=lambda each: float(each.fun))
        return _Subset(families, np.asarray(found.x), float(found.fun))

    def height(self, families: list[int], logs: Floats) -> tuple[float, Floats]:
        """Minus the logarithm of the likelihood, and its derivatives by the logarithms."""
        own, weight, place = self._weighted(families, logs)
        factor = cho_factor(self._matrix(own, weight), lower=True)
        drawn = weight * self.by_residual[own]
        likely = cho_solve(factor, drawn)
        rest = self.square - float(drawn @ likely)
        noise = max(rest, 1e-300 + 1e-14 * self.square) / self.number
        height = float(0.5 * self.number * np.log(noise) + np.log(np.diag(factor[0])).sum())
        inverse = np.diag(cho_solve(factor, np.eye(own.size)))
        each = 0.5 * (1.0 - inverse - likely**2 / noise)
        slopes: Floats = np.bincount(place, each, len(families)).astype(float)
        return height, slopes

    def components(self, found: _Subset, named: list[int]) -> Components:
        """What follows from the most likely variances."""
        own, weight, _ = self._weighted(found.families, found.logs)
        matrix = self._matrix(own, weight)
        drawn = weight * self.by_residual[own]
        likely = np.linalg.solve(matrix, drawn)
        noise = (self.square - float(drawn @ likely)) / self.number
        coefficients = np.zeros(self.family.size)
        coefficients[own] = weight * likely
        variances = noise * np.exp(found.logs) / self._mean[found.families]
        spent = own.size - float(np.trace(np.linalg.inv(matrix)))
        return Components(
            found.families, [each in named for each in found.families], variances,
            self._freedom(found), coefficients, float(noise), spent,
        )  # fmt: skip

    def _freedom(self, found: _Subset) -> Floats:
        """Degrees of freedom, by Satterthwaite: two over the variance of a logarithm."""
        steps = _STEP * np.eye(found.logs.size)
        second = np.array(
            [
                self.height(found.families, found.logs + step)[1]
                - self.height(found.families, found.logs - step)[1]
                for step in steps
            ]
        ) / (2.0 * _STEP)
        spread = np.diag(np.linalg.pinv(0.5 * (second + second.T), hermitian=True))
        freedom: Floats = np.maximum(1.0, 2.0 / np.maximum(spread, 1e-9))
        freedom[(spread <= 0.0) | (found.logs < _NEAR_ZERO)] = 1.0  # known hardly at all
        return freedom

    def _weighted(self, families: list[int], logs: Floats) -> tuple[Integers, Floats, Integers]:
        """Columns of some families, their standard deviations over the noise, and of which."""
        place = np.full(self.trace.size, -1)
        place[families] = np.arange(len(families))
        own = np.flatnonzero(place[self.family] >= 0)
        deviations = np.exp(0.5 * np.asarray(logs)) / np.sqrt(self._mean[families])
        of = place[self.family[own]]
        return own, deviations[of], of

    def _matrix(self, own: Integers, weight: Floats) -> Floats:
        inner = weight[:, None] * self.products[np.ix_(own, own)] * weight
        matrix: Floats = np.eye(own.size) + inner
        return matrix
