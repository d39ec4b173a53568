"""Whether both sides of a surface can point at it, for any state and any parameters.

A field may jump where motion only changes its speed: a spring that meets a second damper. There
the rates of the switching function on both sides have one sign, so their zeros are the same.
Where one rate has a zero that the other does not share, both signs come beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import numpy.typing as npt

from nonsmooth.system.algebra.points import COUNT, Points
from nonsmooth.system.algebra.value_tape import Array, ValueTape, table
from nonsmooth.system.text.expressions import Expression

__all__ = ["may_attract"]

_STARTS = 2  # points from which zeros are looked for
_STEPS = 30  # of the secant method
_ROOT = 1e-11  # of the size of a rate
# What is no zero of the other rate: so many times what is left of the first one where it vanishes,
# or what rounding leaves of it. Beside a stiff spring the jump of a dry friction is small.
_MORE = 1e3
_ROUNDING = 1e-14
_SAME = 1e-12  # in which the ratios of two rates agree where one is the other times a number


def may_attract(rates: Sequence[Expression]) -> bool:
    """Whether the first of some rates and another one may have different signs.

    Yes where in doubt. The surface is put into the rates: any values of what stands in them are a
    point of it.
    """
    tape, points = ValueTape(rates), Points()
    values = table(tape.values(points), COUNT)
    with np.errstate(all="ignore"):  # what is no number has no sign and no zero
        same_sign = values[0] * values[1:]
        if (same_sign < 0.0).any() or not (same_sign[:, :_STARTS] > 0.0).all():
            return True
        ratios = values[1:] / values[0]
        in_proportion = np.abs(ratios - ratios[:, :1]) <= _SAME * ratios[:, :1]
        pairs = 1 + np.flatnonzero(~in_proportion.all(axis=1))
        return len(pairs) > 0 and _Search(tape, points, values[:, :_STARTS], pairs).finds_signs()


class _Search:
    """Zeros of both rates of some pairs, each by a change of one coordinate.

    By the secant method, from each start along each coordinate, side by side.
    """

    def __init__(
        self, tape: ValueTape, points: Points, starts: Array, pairs: npt.NDArray[np.int64]
    ) -> None:
        self.tape, self.names = tape, list(tape.names)
        ways = product(range(_STARTS), range(len(self.names)), pairs, (True, False))
        start, self.coordinate, self.pair, is_first = (
            np.array(part) for part in zip(*ways, strict=True)
        )
        self.own = np.where(is_first, 0, self.pair)  # the rate that is to vanish
        self.other = np.where(is_first, self.pair, 0)
        self.every = np.arange(len(start))
        self.at = np.array([points[name][start] for name in self.names])
        self.size = np.maximum(np.abs(starts[0, start]), np.abs(starts[self.pair, start]))

    def finds_signs(self) -> bool:
        """Whether one of two rates is not zero where the other is, or neither has a zero."""
        found = np.zeros(len(self.every), dtype=bool)
        step = 0.1 * self.at[self.coordinate, self.every] + 0.01
        value, _ = self._rates()
        going = np.isfinite(value)
        for _ in range(_STEPS):
            self.at[self.coordinate, self.every] += step
            new, beside = self._rates()
            there = going & (np.abs(new) <= _ROOT * self.size)
            left = np.maximum(np.abs(new), _ROUNDING * self.size)
            if (there & (np.abs(beside) > _MORE * left)).any():
                return True
            found |= there & np.isfinite(beside)
            change = new - value
            going &= ~there & (np.abs(change) > 0.0)
            if not going.any():
                break
            step = np.divide(-step * new, change, out=np.zeros_like(step), where=going)
            value = new
        return set(self.pair[found]) != set(self.pair)

    def _rates(self) -> tuple[Array, Array]:
        """The rate that is to vanish and the other one, for each search."""
        point = dict(zip(self.names, self.at, strict=True))
        values = table(self.tape.values(point), len(self.every))
        return values[self.own, self.every], values[self.other, self.every]
