r"""`CrackCurve`: crack length over time by Eq. (49), and its fit to measured lengths."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nonsmooth.errors import ModelError, OptionError, ResultWarning
from nonsmooth.fatigue.checks import finite_array, finite_number, like
from nonsmooth.fatigue.curve_fit import fitted_curve
from nonsmooth.fatigue.expression_text import expression_text

__all__ = ["CrackCurve"]


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
        fit = fitted_curve(times, lengths, a1)
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
