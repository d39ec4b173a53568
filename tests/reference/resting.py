"""Runs whose rebounds come to rest, for `nonlinear.py`: every rebound is followed down to 1e-25.

A `RestingExit` is an exit that rebounds. Once the rate of its guard behind an impact is below
``SLOW``, what is left of the rebounds takes 2 w/(A (1 - r)), some 1e-24, with the rate w behind
the impact, the ratio r of the rates behind and before it, and the acceleration A back onto the
guard. That is the only use of the formula: what it leaves out is below 1e-47.
Then the run goes on in the mode ``rest``, in the state that ``arrival`` makes.

Sliding needs nothing of the kind: the mode on a surface is written down by hand, with the rates
of motion that stays there, and is entered by an exit of the mode before.
"""

from typing import Any, NamedTuple

from mpmath import mpf

from .nonlinear import SmoothEvent, SmoothRun, _Route, _Step
from .power_series import Function, rate_of, value_at

SLOW = mpf(10) ** -25


class RestingExit(NamedTuple):
    guard: Function
    to: str
    reset: Function
    rest: str
    arrival: Function


class RestingRoute(_Route):
    """A route for ``smooth_run`` on which `RestingExit` may end in rest."""

    def instant(self, run: SmoothRun, step: _Step, fired: int, end: mpf) -> _Step:
        passed = self.model.modes[step.mode].exits[fired]
        if not isinstance(passed, RestingExit):
            return super().instant(run, step, fired, end)
        before, time = self.state(step, end), step.time + end
        t, balls = self.arith.exact(time), [self.arith.exact(x) for x in before]
        behind = [self.arith.middle(self.ball(x)) for x in passed.reset(t, balls, self.p)]
        rate_in = self.arith.middle(value_at(rate_of(step.guards[fired]), self.arith.exact(end)))
        rebound = self.step(passed.to, time, behind)
        row = [self.arith.middle(c) for c in rebound.guards[self.number(rebound, passed)]]
        rate_out, push = row[1], -2 * row[2]
        if abs(rate_out) > SLOW or push <= 0:
            return super().instant(run, step, fired, end)
        wait = 2 * rate_out / (push * (1 + rate_out / rate_in)) if rate_out else mpf(0)
        still = [self.ball(x) for x in passed.arrival(t, balls, self.p)]
        state = [self.arith.middle(x) for x in still]
        path = [(step.mode, fired)]
        run.events.append(
            SmoothEvent(time + wait, step.mode, passed.rest, path, rate_in, before, state)
        )
        return self.step(passed.rest, time + wait, state)

    def number(self, step: _Step, passed: RestingExit) -> int:
        """Where the same guard is among those of the mode behind the impact."""
        return [e.guard for e in self.model.modes[step.mode].exits].index(passed.guard)

    def ball(self, x: Any) -> Any:
        return x if hasattr(x, "mid") else self.arith.exact(mpf(x))
