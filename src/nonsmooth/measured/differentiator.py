"""`Differentiator`: a filter that takes rates, and what it does to noise and to the signal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.runs.options import finite_number, whole_number

__all__ = ["Differentiator"]

_LONGEST = 20_001  # samples of a window
_GRID = 8  # frequencies at which a band is checked

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Differentiator:
    r"""Rates of change by a Savitzky-Golay filter.

    A polynomial is fitted to the samples in a window about each one by least squares; its slope
    in the middle is the rate. That is one symmetric sum :math:`\sum_k c_k x_{n+k}`, of which
    everything else follows: white noise of standard deviation :math:`\sigma` in the samples
    makes noise of :math:`\sigma\sqrt{\sum c_k^2}` in the rates, and a sine of frequency f comes
    out too large by the factor :math:`\sum c_k \sin(2\pi f k h) / (2\pi f)`, without any lag.

    Parameters
    ----------
    step : float
        Time h between samples.
    window : int
        Samples in a window, odd.
    order : int, optional
        Degree of the polynomial, even (an odd one gives the filter of the one below plus one).

    Raises
    ------
    OptionError
        For a window that is even or does not exceed the order.

    See Also
    --------
    velocities : applies one to a record.

    References
    ----------
    A. Savitzky and M. J. E. Golay, Smoothing and differentiation of data by simplified least
    squares procedures, Analytical Chemistry 36, 1627-1639 (1964).

    Examples
    --------
    >>> import nonsmooth as ns
    >>> five = ns.measured.Differentiator(step=0.001, window=5, order=2)
    >>> five.coefficients * 0.001  # as in the tables
    array([-0.2, -0.1,  0. ,  0.1,  0.2])
    >>> round(five.noise_gain, 1), round(five.bias(50.0), 4)  # 1/s; and 5.5 % too small at 50 Hz
    (316.2, -0.055)
    """

    step: float
    window: int
    order: int = 4

    def __post_init__(self) -> None:
        if finite_number("step", self.step) <= 0.0:
            raise OptionError(f"step = {self.step:g} must be positive")
        order, window = whole_number("order", self.order), whole_number("window", self.window)
        if order % 2 or not 2 <= order <= 8:
            raise OptionError(f"order = {order} must be 2, 4, 6 or 8")
        if window % 2 == 0 or not order < window <= _LONGEST:
            raise OptionError(
                f"window = {window} must be odd, from {order + 1} (order + 1) to {_LONGEST}"
            )
        for name, value in (("step", float(self.step)), ("window", window), ("order", order)):
            object.__setattr__(self, name, value)

    @classmethod
    def for_band(
        cls, step: float, highest: float, *, bias: float = 0.01, order: int = 4
    ) -> Differentiator:
        """Filter with the least noise that keeps a band of frequencies.

        Parameters
        ----------
        step : float
            Time between samples.
        highest : float
            End of the band, in cycles per unit time.
        bias : float, optional
            Largest relative error of a sine in the band.
        order : int, optional
            Degree of the polynomial.

        Returns
        -------
        Differentiator
            That with the longest window that will do, of at most 20001 samples.

        Raises
        ------
        OptionError
            When the samples are too far apart for the band.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> filter = ns.measured.Differentiator.for_band(1 / 5000, 200.0)
        >>> filter.window, round(filter.bias(200.0), 4), round(filter.noise_gain)
        (11, -0.006, 1229)
        """
        top = finite_number("highest", highest)
        allowed = finite_number("bias", bias)
        if top <= 0.0 or not 0.0 < allowed < 1.0:
            raise OptionError(
                f"highest = {top:g} must be positive, and bias = {allowed:g} between 0 and 1"
            )
        shortest = cls(step, whole_number("order", order) + 1, order)
        if not shortest._keeps(top, allowed):
            good = shortest.highest(allowed)
            if good == 0.0:
                raise OptionError(f"bias = {allowed:g} is below rounding; allow more, such as 0.01")
            raise OptionError(
                f"highest = {top:g}: with samples {shortest.step:g} apart rates are right to"
                f" {allowed:g} up to the frequency {good:g} only; sample"
                f" {math.ceil(top / good)} times faster, or ask for a lower highest= or more bias="
            )
        low, high = shortest.window // 2, shortest.window
        while high <= _LONGEST // 2 and cls(step, 2 * high + 1, order)._keeps(top, allowed):
            low, high = high, 2 * high
        high = min(high, _LONGEST // 2 + 1)
        while high - low > 1:
            middle = (low + high) // 2
            if cls(step, 2 * middle + 1, order)._keeps(top, allowed):
                low = middle
            else:
                high = middle
        return cls(step, 2 * low + 1, order)

    @cached_property
    def coefficients(self) -> Floats:
        """Factors of the samples in a window, the earliest first."""
        # Even powers do not count for a slope in the middle. In powers of k alone a long window
        # would lose all digits, with an orthonormal basis it keeps them.
        half = self.window // 2
        k = np.arange(-half, half + 1) / half
        basis, triangle = np.linalg.qr(k[:, None] ** np.arange(1, self.order, 2))
        first = np.zeros(self.order // 2)
        first[0] = 1.0
        found = basis @ np.linalg.solve(triangle.T, first) / (half * self.step)
        result: Floats = 0.5 * (found - found[::-1])  # so that a constant gives zero, exactly
        return result

    @property
    def noise_gain(self) -> float:
        """Standard deviation of the rates' noise for one of 1 in the samples (white noise)."""
        return float(np.sqrt(self.coefficients @ self.coefficients))

    def bias(self, frequency: float) -> float:
        """Relative error of the amplitude of a sine.

        Parameters
        ----------
        frequency : float
            In cycles per unit time.

        Returns
        -------
        float
            Such as -0.01, where the rate comes out one hundredth too small.
        """
        omega = 2.0 * math.pi * finite_number("frequency", frequency)
        if omega == 0.0:
            return 0.0
        k = np.arange(self.window) - self.window // 2
        return float(self.coefficients @ np.sin(omega * self.step * k)) / omega - 1.0

    @checked
    def highest(self, bias: float = 0.01) -> float:
        """End of the band that is kept.

        Parameters
        ----------
        bias : float, optional
            Largest relative error of a sine in the band.

        Returns
        -------
        float
            Highest frequency, in cycles per unit time.
        """
        bias = finite_number("bias", bias)
        if not 0.0 < bias < 1.0:
            raise OptionError(f"bias = {bias:g} must lie between 0 and 1")
        # the bias of these filters only falls, from zero at rest to -1 where they give nothing
        low, high = 0.0, 0.5 / self.step
        for k in range(1, 8 * self.window):
            frequency = k / (16.0 * self.window * self.step)
            if abs(self.bias(frequency)) > bias:
                high = frequency
                break
            low = frequency
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if abs(self.bias(middle)) <= bias else (low, middle)
        return low

    @cached_property
    def bandwidth(self) -> float:
        """Frequency at which a sine comes out smaller by the square root of two (-3 dB)."""
        return self.highest(1.0 - math.sqrt(0.5))

    @checked
    def truncation(self, derivative: int, size: float) -> float:
        r"""Bound of the error of a rate where a derivative of the signal is bounded.

        It holds for any signal whose derivative of that order stays within ``size``, jumps of it
        included (Peano's kernel theorem): with 2 for motions with jumps in acceleration, with 3
        for those that have none.

        Parameters
        ----------
        derivative : {2, 3, 4, 5}
            Order of the derivative, at most that of the polynomial plus one.
        size : float
            Bound of its size within half a window.

        Returns
        -------
        float
            Largest error of a rate.
        """
        q = whole_number("derivative", derivative)
        if not 2 <= q <= self.order + 1:
            raise OptionError(f"derivative = {q} must lie between 2 and {self.order + 1}")
        half = self.window // 2
        k = np.arange(1, half + 1)
        c = self.coefficients[half + 1 :]
        # kernel K(s) = sum over k > s of c_k (k - s)^(q-1) / (q-1)!, in steps, by Gauss's rule
        nodes, weights = np.polynomial.legendre.leggauss(8)
        total = 0.0
        for j in range(half):
            s = j + 0.5 * (nodes + 1.0)
            powers = (k[j:, None] - s) ** (q - 1)
            total += 0.5 * float(weights @ np.abs(c[j:] @ powers))
        return 2.0 * total * self.step**q / math.factorial(q - 1) * abs(float(size))

    def __call__(self, values: npt.ArrayLike) -> Floats:
        """Rates of a series; it is shorter by half a window at either end.

        Parameters
        ----------
        values : array_like
            Samples, as many as a window has at least.

        Returns
        -------
        ndarray
            Rates at all samples but the first and the last ``window // 2``.
        """
        from scipy.signal import convolve

        series = np.asarray(values, dtype=float)
        if series.ndim != 1 or series.size < self.window:
            raise OptionError(f"{series.size} samples are fewer than a window, {self.window}")
        found: Floats = convolve(series - series.mean(), self.coefficients[::-1], mode="valid")
        return found

    def _keeps(self, highest: float, bias: float) -> bool:
        if highest * self.step >= 0.5:
            return False
        band = highest * np.arange(1, _GRID + 1) / _GRID
        return all(abs(self.bias(float(f))) <= bias for f in band)
