"""The return map of a word near its orbit: image of a section point, with exact derivatives.

The equations of the orbit without those that close it give the events on the way from a section
point that need not come back. So the map is that of the word wherever its equations have a
solution, whether or not the motion has other events there: `WordMap.margin` tells that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.branch_tests import BranchTests, is_of_word
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.newton import row_scale, scale_of, size_of
from nonsmooth.periodic_orbits.onto import chatters

__all__ = ["Image", "WordMap"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_STEPS = 12  # of Newton's method, from an orbit close by
_SOLVED = 1e-10  # residual, beside the states, above which there is no image
_BESIDE = 1e-4  # of the sizes of the states
_POINTLESS = 1e-9  # a test of the word that is less than this at the orbit itself says nothing


class Image(NamedTuple):
    """Image of a section point, drifts left out; states in units of `WordMap.sizes`."""

    point: Floats  # (m,)
    by_start: Floats  # (m, m) its derivatives by the section point
    by_parameter: Floats  # (m,) and by the parameter
    unknowns: Floats  # of the equations: states at all legs, and instants


class WordMap:
    """The return map of the word of an orbit, in its states without drifts.

    The orbit of a driven system begins at its phase. One of an autonomous system begins behind its
    last event; where there is none, on a plane across its flow. The map leads any state beside it
    to the event or to the plane, so one of its multipliers is 0: that along the motion.

    States of the map are in units of their own sizes, so that none of them drowns in the rounding
    of another, as metres beside metres per second would.
    """

    def __init__(self, equations: OrbitEquations, unknowns: Floats) -> None:
        """``unknowns``: the orbit, for the one chosen parameter of the legs."""
        legs = equations.legs
        assert len(legs.chosen) == 1
        self.equations, self.unknowns = equations, unknowns
        self.moving: Integers = np.flatnonzero(~equations.drifting)
        self._place = list(legs.system.parameters).index(legs.chosen[0])
        self._values = legs.values.copy()
        n, last = legs.n, (len(equations.word) - 1) * legs.n
        self._closing = np.arange(last, last + n)
        self._others = np.setdiff1d(np.arange(equations.size), self._closing)
        self._scale = scale_of(equations, unknowns)
        self.start = unknowns[self.moving] / self.sizes
        self._tests = BranchTests(equations, 1e-12, whole=False)
        kept = self._of_word()
        # what is about to change the word at the orbit itself
        self.vanishing = {name for name, value in kept.items() if abs(value) <= _POINTLESS}
        self._watched = {name: value for name, value in kept.items() if value > _POINTLESS}

    @property
    def value(self) -> float:
        """Value of the parameter at the orbit."""
        return float(self._values[self._place])

    @property
    def sizes(self) -> Floats:
        """The largest size of each state at the events of the orbit, drifts left out."""
        return self._scale[self.moving]

    @property
    def sizes_of_all(self) -> Floats:
        """The same of all states, a drift counting as the largest of all."""
        sizes = np.full(self.equations.legs.n, self.sizes.max(initial=1e-300))
        sizes[self.moving] = self.sizes
        return sizes

    def image(self, point: Floats, value: float) -> Image | None:
        """Image of a section point; None where the word leads nowhere."""
        unknowns = self.unknowns.copy()
        unknowns[self.moving] = point * self.sizes
        try:
            self.set_parameter(value)
            return self._image(unknowns)
        except (LegError, np.linalg.LinAlgError):
            return None
        finally:
            self.set_parameter(self.value)

    def _image(self, unknowns: Floats) -> Image | None:
        """Solve for the events on the way by Newton's method, and follow their derivatives."""
        n, others = self.equations.legs.n, self._others
        residual, jacobian, moved = self._open(unknowns)
        if others.size:
            weights, best = row_scale(self.equations, self._scale, jacobian)[others], np.inf
            for _ in range(_STEPS):
                size = size_of(residual[others], weights)
                if not size < best:  # rounding, or no convergence
                    break
                best, kept = size, (unknowns.copy(), residual, jacobian, moved)
                unknowns[n:] -= np.linalg.solve(jacobian[others, n:], residual[others])
                residual, jacobian, moved = self._open(unknowns)
            if not best <= _SOLVED:
                return None
            unknowns, residual, jacobian, moved = kept
        # the last equations have the image less the start
        rows = self._closing[self.moving]
        point = residual[rows] + unknowns[self.moving]
        by_start = jacobian[rows][:, self.moving] + np.eye(rows.size)
        sizes = self.sizes
        by_parameter = moved[rows, 0].copy()
        if others.size:
            given = np.column_stack([jacobian[others][:, self.moving], moved[others]])
            rest = jacobian[rows, n:] @ np.linalg.solve(jacobian[others, n:], given)
            by_start, by_parameter = by_start - rest[:, :-1], by_parameter - rest[:, -1]
        return Image(
            point / sizes, by_start * sizes / sizes[:, None], by_parameter / sizes, unknowns
        )

    def margin(self, image: Image, value: float) -> float:
        """The lowest test of the word on the way of an image, beside what it is at the orbit.

        It is negative where the motion has another itinerary; nan where the legs fail. The lowest
        value of a guard within a leg is no test where it has none.
        """
        try:
            self.set_parameter(value)
            tests = self._tests.look(image.unknowns).tests
        except LegError:
            return np.nan
        finally:
            self.set_parameter(self.value)
        found = [tests[name] / here for name, here in self._watched.items() if name in tests]
        return min(found, default=1.0)

    def _of_word(self) -> dict[str, float]:
        """Tests of the word at the orbit.

        One that is zero there tells something where it is not so beside the orbit, so motions there
        are looked at first. Rebounds before rest are left out, as they are as short as one likes,
        and an event that passes the section, where nothing happens.
        """
        word, wiring = self.equations.word, self.equations.legs.tables.wiring
        rebounds = {k for each in chatters(word.modes, word.paths, wiring) for k in each}
        for part in (_BESIDE, -_BESIDE):
            image = self.image(self.start + part, self.value)
            if image is not None:
                self._tests.look(image.unknowns)
        found = self._tests.look(self.unknowns).tests
        passing = () if word.closes_at_event else ("leg:0", "leg:last")
        return {
            name: value
            for name, value in found.items()
            if is_of_word(name) and name not in passing and _leg_of(name) not in rebounds
        }

    def set_parameter(self, value: float) -> None:
        """Let the legs stand for a value of the parameter."""
        values = self._values.copy()
        values[self._place] = value
        self.equations.legs.set_values(values)

    def _open(self, unknowns: Floats) -> tuple[Floats, Floats, Floats]:
        """The equations, the last leg of a cycle without events ending on its plane."""
        equations = self.equations
        residual, jacobian, moved = equations.evaluate(unknowns)
        if equations.is_smooth_cycle:
            normal, rows = equations.normal, self._closing
            residual[-1] += normal @ residual[rows]
            jacobian[-1] += normal @ jacobian[rows]
            moved[-1] += normal @ moved[rows]
        return residual, jacobian, moved


def _leg_of(name: str) -> int:
    """The leg that a test is about; -1 for none."""
    numbers = [int(each) for each in name.split(":")[1:] if each.isdigit()]
    return numbers[0] if numbers else -1
