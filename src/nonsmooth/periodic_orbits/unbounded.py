"""Whether the orbits of a branch grow without bound while its parameter comes to a limit.

The steps of a branch are measured by its orbits, so such a branch goes on for ever: at a homoclinic
orbit the period grows by as much with each step, and the parameter by a part of the step before. An
amplitude grows by a factor. A cycle that is born does so too, but its parameter moves away faster
and faster.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from nonsmooth.periodic_orbits.branch_change import SHRINKS
from nonsmooth.periodic_orbits.branch_part import BranchPart, Followed
from nonsmooth.periodic_orbits.cycle_end import end_of_short_cycles
from nonsmooth.periodic_orbits.stretch import BranchOptions

__all__ = ["LastOrbits"]

_WINDOW = 20  # half of the points that are looked at, at most
_KEPT = 80  # orbits as a whole, for the end to which they shrink
_STILL = 1e-3  # of the range, by which the parameter moves at most over them
_NEARER = 0.9  # of its way in the first half of the growth is that in the second one, at most
_LONGER, _LARGER = 1.01, 1.5  # factors by which period and amplitude grow, at least
_WITHIN = 2.0  # growth that is looked at, at most: with long steps fewer points are recent
_FEWEST = 6  # points that tell it, of a growth that is large
_FAR = 1e6  # times the amplitude of the first orbit
_FAR_LONGER = 1e4  # times its period: legs take as much longer to be passed
_ROUNDINGS = 1e3 * float(np.finfo(float).eps)  # of the parameter, as much as orbits leave of it
_CLEAR = 1e3  # times that has it moved over all of them
_STEP = 1e-3  # part of itself by which the period grows in a step while the parameter does not
# of branches that may come to no other end: steps that become too short for what they look for, or
# legs too long to be passed
_ENDS = ("steps", "smallest_step", "singular", "word_change", "domain")
_SHORT = ("smallest_step", "singular", "word_change")  # likewise: steps or cycles become short


class LastOrbits:
    """Parameter, period and amplitude of the last orbits of a branch."""

    def __init__(self, options: BranchOptions) -> None:
        self.options = options
        self._first = 0.0  # amplitude
        self._shortest = np.inf  # period
        self._last: deque[tuple[float, float, float]] = deque(maxlen=2 * _WINDOW + 1)
        self._parts: deque[BranchPart] = deque(maxlen=_KEPT)

    def add(self, part: BranchPart) -> None:
        """The next point of the branch."""
        self._parts.append(part)
        turn = part.looked.turn
        size = float(np.abs(turn.states).max())
        self._first = self._first or size
        period = float(turn.instants[-1] - turn.instants[0])
        self._shortest = min(self._shortest, period)
        self._last.append((part.value, period, size))

    @property
    def are_far(self) -> bool:
        """Whether they have grown so much that nothing else can be expected.

        In amplitude; or in period, or where the parameter has come to its limit to rounding.
        """
        if self._last[-1][2] > _FAR * self._first and self._grows_for_ever(2, _LARGER):
            return True
        if not self._grows_for_ever(1, _LONGER):
            return False
        first, before, last = self._last[0], self._last[-2], self._last[-1]
        if last[1] > _FAR_LONGER * self._shortest:
            return True
        rounding = _ROUNDINGS * max(map(abs, self.options.bounds))
        # else cycles of one value of the parameter, of which rounding tells the way
        moved = abs(last[0] - first[0]) > _CLEAR * rounding
        # else steps that are short for another reason
        grows = last[1] > (1.0 + _STEP) * before[1]
        return moved and grows and abs(last[0] - before[0]) <= rounding

    def end(self, ended: Followed | None = None) -> Followed:
        """The end of the branch: that they grow without bound, or what has been found else."""
        if ended is not None and (ended.ended not in _ENDS or not self._last):
            return ended
        name, (value, period, size) = self.options.parameter, self._last[-1]
        here = f"{name} = {value:.10g}"
        if self._grows_for_ever(2, _LARGER):
            told = f"the amplitude grows without bound: it is {size:.3g} at {here}"
        elif self._grows_for_ever(1, _LONGER):
            told = (
                "the period grows without bound, as at an orbit that comes to rest at a saddle, a"
                " fold of equilibria, or a rest that reaches a surface: it is"
                f" {period:.4g} at {here}"
            )
        else:
            assert ended is not None
            return ended
        return Followed("unbounded", f"{told}, from where {name} moves less and less")

    def shrunk(self, ended: Followed) -> BranchPart | None:
        """The point to which the orbits have shrunk with their periods; None if to none.

        It has the multipliers and the durations of the last cycle.
        """
        options = self.options
        if not options.autonomous or ended.ended not in _SHORT:
            return None
        cycles = [(part.value, part.looked.turn) for part in self._parts]
        if not cycles or not self._parts[-1].word.closes_at_event:
            return None
        drifting = np.array([name in options.system.drift_states for name in options.system.states])
        found = end_of_short_cycles(cycles, drifting, options.bounds)
        if found is None:
            return None
        value, state = found
        part = self._parts[-1]
        values = part.looked.values.copy()
        values[list(options.system.parameters).index(options.parameter)] = value
        turn = replace(part.looked.turn, states=np.tile(state, (len(part.word), 1)))
        return replace(
            part, looked=replace(part.looked, turn=turn, values=values), value=value,
            special="pseudo_hopf", detail=f"{SHRINKS} as its period does", test="shrink",
        )  # fmt: skip

    def _grows_for_ever(self, column: int, factor: float) -> bool:
        """Whether a column goes up over the last points while the parameter comes to a limit.

        By the ways of the parameter over both halves of the growth, whatever the steps were: where
        the limit of the parameter is one of a finite column they are alike.
        """
        values = np.array(self._last)
        if not values[-1, column] > 0.0:  # orbits at rest at zero
            return False
        values = values[values[-1, column] <= _WITHIN * values[:, column]]
        p, growing = values[:, 0], np.log(values[:, column])
        if len(p) < _FEWEST or np.any(np.diff(growing) <= 0.0):
            return False
        if len(p) <= 2 * _WINDOW:  # a branch that turns back goes so for a few short steps
            factor = max(factor, _LARGER)
        if growing[-1] - growing[0] < np.log(factor):
            return False
        middle = np.interp(0.5 * (growing[0] + growing[-1]), growing, p)
        before, after = abs(middle - p[0]), abs(p[-1] - middle)
        low, high = self.options.bounds
        return bool(after <= _NEARER * before and before + after <= _STILL * (high - low))
