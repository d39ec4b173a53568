"""`Signal`: measured input, values at known times and the curve through them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.record import Rows, rows_of
from nonsmooth.engine.tables import CHAIN
from nonsmooth.errors import ModelError, is_known, quote

__all__ = ["LAST_DERIVATIVE", "METHODS", "Signal", "signal_arrays", "values_of"]

Floats = npt.NDArray[np.float64]

LAST_DERIVATIVE = CHAIN - 1  # that is not zero everywhere: pieces are cubics
METHODS = ("cubic", "monotone", "linear")
_LEAST = {"cubic": 4, "monotone": 2, "linear": 2}  # knots
_MOST_KNOTS = 200_000  # a text with more of them would be longer than is read
_LARGEST = 1e15  # of a time, as in the options of a run


@dataclass(frozen=True, eq=False, repr=False)
class Signal:
    """A measured input: values at given times, its knots, and a curve through them.

    In the texts of a system its name stands for the value at the present time, and
    ``rate(name)`` for its rate of change. The motion between knots is exact for the curve:
    runs end a segment at every knot.

    Parameters
    ----------
    times : array_like, shape (k,)
        Times of the knots, strictly increasing.
    values : array_like, shape (k,)
        Values there.
    method : {"cubic", "monotone", "linear"}, optional
        The curve: ``cubic`` is the spline with continuous rate and acceleration (not-a-knot,
        at least four knots); ``monotone`` is a piecewise cubic with continuous rate that
        never leaves the range of neighbouring values (Fritsch and Butland, 1984);
        ``linear`` has straight pieces, and a rate that jumps at the knots.

    Raises
    ------
    ModelError
        When the knots are too few, not finite, not increasing, or of another shape.

    See Also
    --------
    System : takes signals by name.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> base = ns.Signal([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 4.0, 9.0])
    >>> float(base(1.5)), float(base(1.5, derivative=1))
    (2.25, 3.0)
    """

    times: Any
    values: Any
    method: str = "cubic"

    def __post_init__(self) -> None:
        if not is_known(self.method, METHODS):
            raise ModelError(
                f"Signal: method = {quote(self.method)}; known are {', '.join(METHODS)}"
            )
        times, values = _numbers("times", self.times), _numbers("values", self.values)
        _check_knots(times, values, _LEAST[self.method], self.method)
        for name, array in (("times", times), ("values", values)):
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        if not np.all(np.isfinite(self.pieces)):
            raise ModelError(
                "Signal: between knots so close the rate of change is not a finite number; leave"
                " out some of them"
            )

    @property
    def span(self) -> tuple[float, float]:
        """Times of the first and of the last knot."""
        return float(self.times[0]), float(self.times[-1])

    @cached_property
    def pieces(self) -> Floats:
        """Coefficients (k - 1, 4) of the pieces in powers of the time since their beginning."""
        if self.method == "linear":
            pieces = np.zeros((self.times.size - 1, CHAIN))
            pieces[:, 0] = self.values[:-1]
            with np.errstate(all="ignore"):
                pieces[:, 1] = np.diff(self.values) / np.diff(self.times)
            return pieces
        from scipy.interpolate import CubicSpline, PchipInterpolator

        make = CubicSpline if self.method == "cubic" else PchipInterpolator
        with np.errstate(all="ignore"):
            curve = make(self.times, self.values)
        coefficients: Floats = np.array(curve.c[::-1].T, dtype=float)
        coefficients[:, 0] = self.values[:-1]
        return coefficients

    def __call__(self, t: npt.ArrayLike, derivative: int = 0) -> Floats:
        """Values at some times, or of a derivative; nan where there are no knots around."""
        times = np.asarray(t, dtype=float)
        found = values_of(self, times, derivative, lambda start: times - start)
        low, high = self.span
        inside: Floats = np.where((times >= low) & (times <= high), found, np.nan)
        return inside

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Signal) and self._identity == other._identity

    def __hash__(self) -> int:
        return hash(self._identity)

    def __repr__(self) -> str:
        low, high = self.span
        return f"<Signal: {self.method}, {self.times.size} knots from t = {low:g} to {high:g}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return Signal, (self.times, self.values, self.method)

    @property
    def _identity(self) -> tuple[str, bytes, bytes]:
        return self.method, self.times.tobytes(), self.values.tobytes()


def values_of(
    signal: Signal, times: Floats, derivative: int, elapsed: Callable[[Floats], Floats]
) -> Floats:
    """Values of a signal by ``elapsed(start)``, the exact times since its pieces began.

    At a knot, and within rounding before it, the piece after it counts.
    """
    slack = 4.0 * np.finfo(float).eps * np.abs(times)
    k = np.searchsorted(signal.times, times + slack, side="right") - 1
    k = np.clip(k, 0, signal.times.size - 2)
    s = elapsed(signal.times[k])
    rows = signal.pieces[k]
    total = np.zeros_like(s)
    for power in range(CHAIN - 1, derivative - 1, -1):
        factor = float(np.prod(np.arange(power, power - derivative, -1)))
        total = total * s + factor * rows[..., power]
    return total


def signal_arrays(
    signals: Iterable[Signal],
) -> tuple[Rows, Rows, Floats]:
    """Arrays of the engine: rows of each signal, knots with coefficients, shortest and longest."""
    rows, knots, count = [], [], 0
    shortest, longest = np.inf, np.inf
    for signal in signals:
        size = signal.times.size
        rows.append((count, size))
        count += size
        last = np.append(signal.values[-1], np.zeros(CHAIN - 1))
        knots.append(np.column_stack([signal.times, np.vstack([signal.pieces, last])]))
        gaps = np.diff(signal.times)
        shortest, longest = min(shortest, gaps.min()), min(longest, gaps.max())
    return (
        rows_of("SignalRow", rows),
        rows_of("Knot", np.vstack(knots) if knots else []),
        np.array([shortest, longest], dtype=float),
    )


def _numbers(what: str, given: Any) -> Floats:
    """A new array of numbers with one dimension."""
    try:
        array = np.asarray(given)
        if array.dtype.kind not in "iuf":
            raise TypeError
        # adding zero makes one spelling of both zeros, so that equal signals are one
        numbers: Floats = array.astype(float) + 0.0
    except (TypeError, ValueError, OverflowError):
        raise ModelError(f"Signal: {what} = {quote(given)}: give a list of numbers") from None
    if numbers.ndim != 1:
        raise ModelError(
            f"Signal: {what} has the shape {numbers.shape}; give a list of numbers, one signal for"
            " each column of a table"
        )
    return numbers


def _check_knots(times: Floats, values: Floats, least: int, method: str) -> None:
    """Knots that a curve can go through."""
    if times.size != values.size:
        raise ModelError(f"Signal: {times.size} times and {values.size} values; give one for each")
    if times.size < least:
        raise ModelError(
            f"Signal: {times.size} knots; a {method} signal needs at least {least}"
            + ("; give more, or method='linear'" if method == "cubic" else "")
        )
    if times.size > _MOST_KNOTS:
        raise ModelError(
            f"Signal: {times.size:,} knots; at most {_MOST_KNOTS:,} are supported: filter the"
            " measurement and take fewer, or run it in parts"
        )
    for what, array in (("times", times), ("values", values)):
        wrong = np.flatnonzero(~np.isfinite(array))
        if wrong.size:
            raise ModelError(
                f"Signal: {what}[{wrong[0]}] is {array[wrong[0]]}; leave such knots out, the curve"
                " goes on through the others"
            )
    if max(abs(times[0]), abs(times[-1])) > _LARGEST:
        raise ModelError(f"Signal: times are at most {_LARGEST:g} in size")
    wrong = np.flatnonzero(np.diff(times) <= 0.0)
    if wrong.size:
        k = int(wrong[0])
        what = "repeats" if times[k + 1] == times[k] else "lies before"
        raise ModelError(
            f"Signal: times[{k + 1}] = {times[k + 1]:.9g} {what} times[{k}] = {times[k]:.9g}; times"
            " are strictly increasing: sort them, and keep one value for each"
        )
