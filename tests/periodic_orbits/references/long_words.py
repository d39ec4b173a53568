"""Orbits of a hundred legs at a rigid wall, closed period by period: multiple shooting."""

from collections.abc import Sequence
from functools import partial

from mpmath import matrix, mp, mpf

from .oscillators import identity, oscillation
from .turn import Course, Leg, NoOrbit, State, closed, take_turn, tangent


class WallCourses:
    """x'' + 2 zeta x' + x = F cos(omega t), x <= sigma, v := -r v, one forcing period at a time."""

    def __init__(self, *, F, omega, zeta, sigma, r) -> None:
        self.force, self.omega, self.zeta = mpf(F), mpf(omega), mpf(zeta)
        self.sigma, self.r = mpf(sigma), mpf(r)
        self.period = 2 * mp.pi / self.omega

    def course(self, impacts: int) -> Course:
        """A period with so many impacts."""
        drive = mp.mpc(self.force)
        flow = partial(oscillation, mpf(1), self.zeta, mpf(0), drive, self.omega)
        hit = Leg("free", flow, lambda z, t: z[0] - self.sigma, self._rebound)
        return Course([hit] * impacts + [Leg("free", flow)], identity, identity, self.period)

    def _rebound(self, state: State, time: mpf) -> State:
        return self.sigma, -self.r * state[1]


def close_long(
    courses: Sequence[Course], points: Sequence[State], guesses: Sequence[Sequence]
) -> tuple[list[State], list[tuple], matrix]:
    """Points at the start of each period, durations in each, and the tangent of the whole turn."""
    points = [tuple(map(mpf, each)) for each in points]
    guesses = [tuple(map(mpf, each)) for each in guesses]
    n = len(points[0])
    for _ in range(30):
        turns = [take_turn(*each) for each in zip(courses, points, guesses, strict=True)]
        guesses = [turn.durations for turn in turns]
        slopes = [tangent(*each) for each in zip(courses, points, guesses, strict=True)]
        gaps = [
            matrix([a - b for a, b in zip(turn.end, then, strict=True)])
            for turn, then in zip(turns, points[1:] + points[:1], strict=True)
        ]
        whole, carried = mp.eye(n), mp.zeros(n, 1)
        for slope, gap in zip(slopes, gaps, strict=True):
            whole, carried = slope * whole, slope * carried + gap
        change = mp.lu_solve(mp.eye(n) - whole, carried)
        largest = mpf(0)
        for k, (slope, gap) in enumerate(zip(slopes, gaps, strict=True)):
            points[k] = tuple(x + c for x, c in zip(points[k], change, strict=True))
            largest = max(largest, mp.norm(change))
            change = slope * change + gap
        if largest < closed() * 10**4:
            return points, [tuple(each) for each in guesses], whole
    raise NoOrbit("multiple shooting does not converge")
