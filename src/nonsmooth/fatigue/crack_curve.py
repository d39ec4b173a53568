"""`CrackCurve`: crack length over time by Eq. (49), and its fit to measured lengths."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.errors import ModelError, OptionError, ResultWarning
from nonsmooth.fatigue.checks import Array, finite_array, finite_number, like
from nonsmooth.fatigue.expression_text import expression_text
from nonsmooth.fatigue.regression import far_off

__all__ = ["CrackCurve"]


_FEWEST = 6  # for three constants and an error worth the name
_GUESSES = 60
# of a3 over the duration; slower growth cannot be told from a straight line, nor faster from a jump
_SLOWEST, _FASTEST = 20.0, 0.005
_LARGEST_ERROR = 0.5  # of the logarithm of a3
_DOUBTFUL = 0.01  # a record without slips is called faulty this often
_EXACT = 1e-9  # of the growth, to which the search for the constants is good


class _Fit(NamedTuple):
    """Constants of Eq. (49), their standard errors, and the points that lie off the curve."""

    a0: float
    a2: float
    a3: float
    errors: dict[str, float]
    outliers: tuple[int, ...]


def _fitted_curve(times: Any, lengths: Any, a1: float) -> _Fit:
    """Constants a0, a2, a3 of Eq. (49) for a given a1."""
    from scipy.optimize import least_squares

    t, a = _checked(times, lengths)
    duration, last = float(t[-1] - t[0]), float(t[-1])
    s = (t - last) / duration  # from -1 to 0, so that no exponential is large
    # for a given a3 the fit is a straight line in the exponential
    trials = np.geomspace(_FASTEST, _SLOWEST, _GUESSES)
    best = min(trials, key=lambda scale: _line(s, a, scale)[2])
    a0, grown, _ = _line(s, a, best)

    def residuals(p: Array) -> Array:
        return p[0] + p[1] * np.exp(s / math.exp(p[2])) - a

    def rates(p: Array) -> Array:
        scaled = s / math.exp(p[2])
        wave = np.exp(scaled)
        return np.stack([np.ones_like(s), wave, -p[1] * wave * scaled], axis=1)

    start = [a0, grown, math.log(best)]
    free, low, high = np.inf, math.log(_FASTEST) - 1.0, math.log(_SLOWEST) + 1.0
    found = least_squares(
        residuals, start, rates, bounds=([-free, -free, low], [free, free, high]),
        x_scale="jac", xtol=1e-14, ftol=1e-14, gtol=1e-14,
    )  # fmt: skip
    a0, grown, scale = float(found.x[0]), float(found.x[1]), math.exp(float(found.x[2]))
    spread = math.sqrt(2.0 * found.cost / (t.size - 3))
    covariance = _covariance(rates(found.x), spread)
    _check_growth(grown, scale, covariance, duration)
    a3 = duration * scale
    a2 = last - a3 * math.log(grown / a1)
    # a2 by grown and log(a3)
    slope = np.array([0.0, -a3 / grown, a2 - last])
    errors = {
        "a0": math.sqrt(covariance[0, 0]),
        "a2": math.sqrt(float(slope @ covariance @ slope)),
        "a3": a3 * math.sqrt(covariance[2, 2]),
        "residual": spread,
    }
    return _Fit(a0, a2, a3, errors, _outliers(residuals(found.x), rates(found.x), float(np.ptp(a))))


def _outliers(rest: Array, rates: Array, size: float) -> tuple[int, ...]:
    """Points too far off for noise, by the fit as it is linear near its constants."""
    basis, _, _ = np.linalg.svd(rates / np.linalg.norm(rates, axis=0), full_matrices=False)
    leverage = np.sum(basis**2, axis=1)
    return tuple(far_off(rest, leverage, rates.shape[1], _DOUBTFUL, _EXACT * size))


def _checked(times: Any, lengths: Any) -> tuple[Array, Array]:
    t, a = finite_array("times", times), finite_array("lengths", lengths)
    if t.ndim != 1 or t.shape != a.shape:
        raise OptionError(
            f"times and lengths have the shapes {t.shape} and {a.shape}; give one length for each"
            " time"
        )
    if t.size < _FEWEST:
        raise OptionError(
            f"{t.size} points are too few for three constants and their errors; give {_FEWEST} at"
            " least"
        )
    steps = np.diff(t)
    if np.any(steps < 0.0):
        place = int(np.flatnonzero(steps < 0.0)[0])
        raise OptionError(
            f"times[{place + 1}] = {t[place + 1]:g} comes after {t[place]:g}; sort both:"
            " order = np.argsort(times)"
        )
    if np.unique(t).size < 4:
        raise OptionError("there are less than four different times; measure at more of them")
    if a.min() == a.max():
        raise OptionError(f"all lengths are {a[0]:g}: there is no growth to fit a curve to")
    return t, a


def _line(s: Array, a: Array, scale: float) -> tuple[float, float, float]:
    """Constant, growth at the end, and sum of squares of the best line for one a3."""
    wave = np.exp(s / scale)
    x, y = wave - wave.mean(), a - a.mean()
    grown = float(x @ y / (x @ x))
    rest = y - grown * x
    return float(a.mean() - grown * wave.mean()), grown, float(rest @ rest)


def _covariance(rates: Array, spread: float) -> Array:
    # by singular values, since the columns are nearly parallel where the growth is slow
    _, sizes, rows = np.linalg.svd(rates, full_matrices=False)
    inverse = rows.T / sizes
    return np.asarray(spread**2 * inverse @ inverse.T)


def _check_growth(grown: float, scale: float, covariance: Array, duration: float) -> None:
    if not _FASTEST < scale < _SLOWEST or math.sqrt(covariance[2, 2]) > _LARGEST_ERROR:
        raise OptionError(
            f"a3 comes out as {scale * duration:.3g} for a record of {duration:.3g}, and is not"
            " determined by it: a straight line, a jump or noise fits as well; give a record in"
            " which the growth gets some times faster, with several points while it does"
        )
    if grown <= 3.0 * math.sqrt(covariance[1, 1]):
        raise OptionError(
            f"the lengths change by {grown:.3g} mm faster than evenly, which is no growth beyond"
            " their noise; give crack lengths in mm that grow ever faster"
        )


@dataclass(frozen=True)
class CrackCurve:
    r"""Crack length over time, :math:`a = a_0 + a_1 \exp((t - a_2)/a_3)`, Eq. (49).

    :math:`a_1` and :math:`a_2` are one constant and not two: only :math:`a_1 \exp(-a_2/a_3)` has a
    meaning. With :math:`a_1 = 1` mm, :math:`a_2` is the time at which the crack is 1 mm longer than
    :math:`a_0`.

    Parameters
    ----------
    a0 : float
        Length in mm long before.
    a1 : float
        Growth in mm at the time ``a2``, positive.
    a2, a3 : float
        Time of that growth, and the time in which the growth gets e times as large, positive; in
        the unit of the times, such as s or the dimensionless time of a model.
    standard_errors : mapping of str to float, optional
        Standard errors of ``a0``, ``a2``, ``a3`` and the ``residual`` in mm, of a fitted curve.
    outliers : tuple of int, optional
        Points of a fitted record, from 0, that lie too far from the curve for noise.

    Raises
    ------
    ModelError
        When the numbers give no crack that grows.

    Examples
    --------
    The curve of Fig. 30, in dimensionless time:

    >>> import nonsmooth as ns
    >>> curve = ns.fatigue.CrackCurve(5.0, 1e-3, 7.8 * 54734, 54734)
    >>> round(curve.length(900514), 2), round(curve.time(12.0))
    (10.72, 911522)
    >>> system = ns.models.breathing_crack(growth=curve.text())
    """

    a0: float
    a1: float
    a2: float
    a3: float
    standard_errors: Mapping[str, float] = field(default_factory=dict, compare=False)
    outliers: tuple[int, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        for name in ("a0", "a1", "a2", "a3"):
            object.__setattr__(self, name, finite_number(name, getattr(self, name)))
        if self.a0 < 0.0:
            raise ModelError(f"a0 = {self.a0:g} must not be negative: it is a length in mm")
        for name, reason in (("a1", "the crack grows"), ("a3", "the growth gets faster")):
            if getattr(self, name) <= 0.0:
                raise ModelError(f"{name} = {getattr(self, name):g} must be positive: {reason}")

    @classmethod
    def from_measured(cls, times: Any, lengths: Any, *, a1: float = 1.0) -> CrackCurve:
        """Curve that fits measured lengths best, by least squares.

        Since a1 and a2 are one constant, a1 is fixed.

        Parameters
        ----------
        times : array_like
            Times, not decreasing, six at least; several lengths may be of one time.
        lengths : array_like
            Crack lengths in mm at these times, whose errors are taken to be alike and independent.
        a1 : float, optional
            Growth in mm at the time a2.

        Returns
        -------
        CrackCurve
            With ``standard_errors`` of a0, a2 and a3, and the ``residual``: the standard deviation
            of a length from the curve.

        Raises
        ------
        OptionError
            For too few points, times that are not in order, and lengths that do not grow ever
            faster, of which no constants follow.

        Warns
        -----
        ResultWarning
            Where a point lies too far from the curve for noise, at a level of 1 %. Nothing is left
            out of the fit.

        Examples
        --------
        >>> import numpy as np
        >>> import nonsmooth as ns
        >>> t = np.linspace(0.0, 1600.0, 60)
        >>> noise = 0.02 * np.random.default_rng(1).standard_normal(60)
        >>> a = ns.fatigue.CrackCurve(6.4, 1.0, 1000.0, 250.0).length(t) + noise
        >>> curve = ns.fatigue.CrackCurve.from_measured(t, a)
        >>> [round(value) for value in (curve.a2, curve.a3)]
        [1000, 250]
        >>> [round(curve.standard_errors[name], 1) for name in ("a2", "a3")]
        [1.0, 0.5]
        """
        a1 = finite_number("a1", a1)
        if a1 <= 0.0:
            raise ModelError(f"a1 = {a1:g} must be positive: the crack grows")
        fit = _fitted_curve(times, lengths, a1)
        curve = cls(fit.a0, a1, fit.a2, fit.a3, fit.errors, fit.outliers)
        if fit.outliers:
            k = fit.outliers[0]
            others = f" and {len(fit.outliers) - 1} more" if len(fit.outliers) > 1 else ""
            at = float(np.asarray(times)[k])
            warnings.warn(
                f"point {k} (from 0){others} lies off the curve: {float(np.asarray(lengths)[k]):g}"
                f" mm at {at:g}, where the curve has {curve.length(at):.4g} mm; look it up, and fit"
                " without it if it is a slip",
                ResultWarning,
                stacklevel=2,
            )
        return curve

    def length(self, time: Any) -> Any:
        """Crack length at some times.

        Parameters
        ----------
        time : float or array_like
            Times.

        Returns
        -------
        float or numpy.ndarray
            Lengths in mm. Nothing ends the growth: lengths beyond the width of a specimen have no
            meaning, and times far beyond give infinity.
        """
        return like(self.a0 + self._growth(time), time)

    def rate(self, time: Any) -> Any:
        """Rate of growth at some times.

        Parameters
        ----------
        time : float or array_like
            Times.

        Returns
        -------
        float or numpy.ndarray
            Rates in mm per unit of time.
        """
        return like(self._growth(time) / self.a3, time)

    def time(self, length: Any) -> Any:
        """Times at which the crack has some lengths.

        Parameters
        ----------
        length : float or array_like
            Crack lengths in mm, greater than a0.

        Returns
        -------
        float or numpy.ndarray
            Times.

        Raises
        ------
        OptionError
            For a length that the crack never has.
        """
        grown = finite_array("length", length) - self.a0
        if np.any(grown <= 0.0):
            raise OptionError(
                f"length = {float(np.min(grown)) + self.a0:g} mm is never reached: the crack is"
                f" longer than a0 = {self.a0:g} mm at all times"
            )
        return like(self.a2 + self.a3 * np.log(grown / self.a1), length)

    def text(self, time: str = "t") -> str:
        """The curve as a text for equations, such as that of ``growth=`` or ``slow=``.

        Parameters
        ----------
        time : str, optional
            Name of the time, or an expression of it: ``"t/omega"`` where the curve is in s and
            the model has a dimensionless time omega t.

        Returns
        -------
        str
            Length in mm.

        Raises
        ------
        OptionError
            For a time that is no whole expression.
        """
        time = expression_text("time", time)
        name = time if time.isidentifier() else f"({time})"
        return f"{self.a0!r} + {self.a1!r}*exp(({name} - {_bracketed(self.a2)})/{self.a3!r})"

    def _growth(self, time: Any) -> Any:
        exponent = (finite_array("time", time) - self.a2) / self.a3
        with np.errstate(over="ignore"):
            return self.a1 * np.exp(exponent)


def _bracketed(value: float) -> str:
    return f"({value!r})" if math.copysign(1.0, value) < 0.0 else repr(value)
