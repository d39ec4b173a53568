"""Whether the orbits of a branch grow without bound while its parameter comes to a limit.

The steps of a branch are measured by its orbits, so such a branch goes on for ever: at a homoclinic
orbit the period grows by as much with each step, and the parameter by a part of the step before. An
amplitude grows by a factor. A cycle that is born does so too, but its parameter moves away faster
and faster.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from nonsmooth.periodic_orbits.branch_part import BranchPart, Followed
from nonsmooth.periodic_orbits.stretch import BranchOptions

__all__ = ["LastOrbits"]

_WINDOW = 20  # points of each of the two parts that are compared
_STILL = 1e-3  # of the range, by which the parameter moves at most over both
_NEARER = 0.9  # of its way in the first part is that in the second one, at most
_LONGER, _LARGER = 1.01, 2.0  # factors by which period and amplitude grow over both, at least
_GOES_ON = 0.5  # of the growth in the first part is that in the second one, at least
_FAR = 1e6  # times the amplitude of the first orbit
# of branches that may come to no other end: steps that become too short for what they look for
_ENDS = ("steps", "smallest_step", "singular", "word_change")


class LastOrbits:
    """Parameter, period and amplitude of the last orbits of a branch."""

    def __init__(self, options: BranchOptions) -> None:
        self.options = options
        self._first = 0.0  # amplitude
        self._last: deque[tuple[float, float, float]] = deque(maxlen=2 * _WINDOW + 1)

    def add(self, part: BranchPart) -> None:
        """The next point of the branch."""
        turn = part.looked.turn
        size = float(np.abs(turn.states).max())
        self._first = self._first or size
        self._last.append((part.value, float(turn.instants[-1] - turn.instants[0]), size))

    @property
    def are_far(self) -> bool:
        """Whether the amplitude has grown so much that nothing else can be expected."""
        return self._last[-1][2] > _FAR * self._first and self._grows_for_ever(2, _LARGER)

    def end(self, ended: Followed | None = None) -> Followed:
        """The end of the branch: that they grow without bound, or what has been found else."""
        if ended is not None and ended.ended not in _ENDS:
            return ended
        name, (value, period, size) = self.options.parameter, self._last[-1]
        here = f"{name} = {value:.10g}"
        if self._grows_for_ever(2, _LARGER):
            told = f"the amplitude grows without bound: it is {size:.3g} at {here}"
        elif self._grows_for_ever(1, _LONGER):
            told = (
                f"the period grows without bound, as at an orbit that comes to rest at a saddle or"
                f" a fold of equilibria: it is {period:.4g} at {here}"
            )
        else:
            assert ended is not None
            return ended
        return Followed("unbounded", f"{told}, from where {name} moves less and less")

    def _grows_for_ever(self, column: int, factor: float) -> bool:
        """Whether a column goes up over the last points while the parameter comes to a limit."""
        if len(self._last) <= 2 * _WINDOW:
            return False
        values = np.array(self._last)
        p, growing = values[:, 0], np.log(values[:, column])
        before, after = (abs(part[-1] - part[0]) for part in (p[: _WINDOW + 1], p[_WINDOW:]))
        low, high = self.options.bounds
        comes_to_limit = after <= _NEARER * before and before + after <= _STILL * (high - low)
        first, second = growing[_WINDOW] - growing[0], growing[-1] - growing[_WINDOW]
        grows = bool(np.all(np.diff(growing) > 0.0)) and first + second >= np.log(factor)
        return bool(comes_to_limit and grows and second >= _GOES_ON * first)
