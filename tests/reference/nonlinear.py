"""Runs of small piecewise-smooth systems, not linear ones, to about 40 digits.

A mode is a right-hand side as in `power_series.py`, a list of exits in declared order, and
relations for slaved states (their rates are not looked at). A guard is positive inside its mode,
a reset gives the whole state after the event. All are functions of t, z and p; ``p.zeta`` is
the parameter zeta.

    free = SmoothMode(
        rates=lambda t, z, p: [z[1], -p.g],
        exits=[SmoothExit(lambda t, z, p: z[0], "free", lambda t, z, p: [z[0], -p.r * z[1]])],
    )
    model = SmoothModel(["height", "speed"], {"free": free})
    run = smooth_run(model, {"g": 1, "r": 0.5}, [1, 0], "free", times=[0.5, 2.5])

One instant is as in `hybrid.py`: after an exit, the first exit in declared order that must fire,
fires, until none must. Zero means coefficients below 1e-28; a guard that is zero throughout is
an error here.

Steps are as long as their last terms allow, 1e-44; nothing is proven about what the series leave
out, but `test_nonlinear.py` repeats runs with other orders and tolerances. Within a step a guard
is a polynomial, whose first root is isolated by ball arithmetic: none is skipped.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, NamedTuple

from flint import arb, ctx
from mpmath import mp, mpf

from .balls import FlintBalls
from .power_series import (
    Function,
    as_series,
    coefficients,
    expand,
    rate_of,
    safe_step,
    value_at,
)
from .roots import Undecidable, bracketed_root
from .taylor import Polynomial

DIGITS = 60
ORDER = 48
TOLERANCE = mpf(10) ** -44
ZERO = mpf(10) ** -28
LONGEST_STEP = mpf(2)
LONGEST_INSTANT = 100


class SmoothExit(NamedTuple):
    guard: Function
    to: str
    reset: Function | None = None


class SmoothMode(NamedTuple):
    rates: Function
    exits: Sequence[SmoothExit] = ()
    slaved: Mapping[int, Function] = {}


class SmoothModel(NamedTuple):
    states: Sequence[str]
    modes: Mapping[str, SmoothMode]


class SmoothEvent(NamedTuple):
    """One instant. ``path`` numbers the exits passed; ``rate`` is that of the first guard."""

    time: mpf
    mode_from: str
    mode_to: str
    path: list[tuple[str, int]]
    rate: mpf
    before: list[mpf]
    after: list[mpf]


@dataclass
class SmoothRun:
    """States and modes at the times asked for, and events."""

    events: list[SmoothEvent] = field(default_factory=list)
    samples: list[list[mpf]] = field(default_factory=list)
    modes: list[str] = field(default_factory=list)


def smooth_run(
    model: SmoothModel,
    parameters: Mapping[str, Any],
    start: Sequence[Any],
    mode: str,
    times: Sequence[Any],
    *,
    order: int = ORDER,
    tolerance: mpf = TOLERANCE,
    route: "type[_Route] | None" = None,
) -> SmoothRun:
    """The run from ``start`` at time 0, inside ``mode``, sampled at increasing ``times``.

    ``route`` may be that of `resting.py`, for rebounds that come to rest.
    """
    arith, cap = FlintBalls(DIGITS), ctx.cap
    try:
        with mp.workdps(DIGITS), arith.working():
            p = SimpleNamespace(**{k: arith.exact(mpf(v)) for k, v in parameters.items()})
            made = (route or _Route)(model, p, arith, order, tolerance)
            return made.follow([mpf(x) for x in start], mode, [mpf(x) for x in times])
    finally:
        ctx.cap = cap


class _Step(NamedTuple):
    """States and guards from a time on, as rows of coefficients, good up to ``length``."""

    mode: str
    time: mpf
    states: list[list[arb]]
    guards: list[list[arb]]
    length: mpf

    def order_and_sign(self, number: int) -> tuple[int, int]:
        """How many leading coefficients of a guard are zero, and the sign of the next one."""
        row = self.guards[number]
        for k, c in enumerate(row):
            term = mpf(float(c.mid())) * self.length**k
            if abs(term) > ZERO:
                return k, int(mp.sign(term))
        raise RuntimeError(f"guard {number} of {self.mode} is zero throughout")


@dataclass
class _Route:
    model: SmoothModel
    p: SimpleNamespace
    arith: FlintBalls
    order: int
    tolerance: mpf

    def follow(self, z: list[mpf], mode: str, times: list[mpf]) -> SmoothRun:
        run, pending = SmoothRun(), list(times)
        step = self.step(mode, mpf(0), z)
        zeros = self.leading_zeros(step)
        while pending:
            fired, end = self.first_exit(step, zeros, min(step.length, times[-1] - step.time))
            while pending and pending[0] <= step.time + end:
                run.samples.append(self.state(step, pending.pop(0) - step.time))
                run.modes.append(step.mode)
            if fired is None:
                step = self.step(step.mode, step.time + end, self.state(step, end))
                zeros = [0] * len(step.guards)
            else:
                step = self.instant(run, step, fired, end)
                zeros = self.leading_zeros(step)
        return run

    def step(self, mode: str, time: mpf, z: Sequence[mpf]) -> _Step:
        """The series from here on in ``mode``."""
        words, t = self.model.modes[mode], self.arith.exact(time)
        start = [self.arith.exact(x) for x in z]
        clock, states = expand(words.rates, words.slaved, t, start, self.p, self.order)
        guards = [as_series(e.guard(clock, states, self.p), self.order) for e in words.exits]
        rows = [coefficients(series) for series in (*states, *guards)]
        tolerance = self.tolerance * max(mpf(1), *(abs(x) for x in z))
        length = safe_step(rows, tolerance, LONGEST_STEP)
        return _Step(mode, time, rows[: len(states)], rows[len(states) :], length)

    def state(self, step: _Step, s: mpf) -> list[mpf]:
        ball = self.arith.exact(s)
        return [self.arith.middle(value_at(row, ball)) for row in step.states]

    def leading_zeros(self, step: _Step) -> list[int]:
        return [step.order_and_sign(i)[0] for i in range(len(step.guards))]

    def first_exit(self, step: _Step, zeros: list[int], end: mpf) -> tuple[int | None, mpf]:
        """The exit that fires first up to ``end``, and when; ``end`` if none does."""
        fired = None
        for number, row in enumerate(step.guards):
            root = first_root(self.arith, row, end, zeros[number])
            if root is not None and (fired is None or root < end):
                fired, end = number, root
        return fired, end

    def instant(self, run: SmoothRun, step: _Step, fired: int | None, end: mpf) -> _Step:
        """Pass exits until a mode holds."""
        z = before = self.state(step, end)
        time, mode, path = step.time + end, step.mode, []
        rate = self.arith.middle(value_at(rate_of(step.guards[fired]), self.arith.exact(end)))
        while fired is not None:
            path.append((mode, fired))
            if len(path) > LONGEST_INSTANT:
                raise RuntimeError(f"no end of exits at t = {mp.nstr(time, 12)}: {path[:5]}")
            passed = self.model.modes[mode].exits[fired]
            mode, z = passed.to, self.enter(passed, time, z)
            new = self.step(mode, time, z)
            signs = [new.order_and_sign(i)[1] for i in range(len(new.guards))]
            fired = next((i for i, sign in enumerate(signs) if sign < 0), None)
        run.events.append(SmoothEvent(time, step.mode, mode, path, rate, before, z))
        return new

    def enter(self, passed: SmoothExit, time: mpf, z: list[mpf]) -> list[mpf]:
        """The state after an exit: reset, then put onto the relations of the mode entered."""
        t, balls = self.arith.exact(time), [self.arith.exact(x) for x in z]
        if passed.reset is not None:
            balls = list(passed.reset(t, balls, self.p))
        for number, relation in self.model.modes[passed.to].slaved.items():
            balls[number] = relation(t, balls, self.p)
        return [self.arith.middle(arb(x)) for x in balls]


def first_root(arith: FlintBalls, row: list[arb], end: mpf, zeros: int) -> mpf | None:
    """Where the polynomial first turns negative in (0, end], its first ``zeros`` terms being 0."""
    sign, rate = Polynomial(row[zeros:]), Polynomial(rate_of(row))
    stretches = [(mpf(0), end)]
    while stretches:
        low, high = stretches.pop()
        stretch = arith.interval(low, high)
        if arith.positive(sign(stretch)):
            continue
        slope = rate(stretch)
        if arith.positive(slope) or arith.negative(slope):
            if arith.negative(sign(arith.exact(high))):
                plain = Polynomial([arith.middle(c) for c in sign.coefficients])
                return bracketed_root(plain, low, high) if plain(low) > 0 else low
        elif high - low < ZERO * end:
            raise Undecidable(f"a graze at {mp.nstr(low, 12)} of a step")
        else:
            middle = (low + high) / 2
            stretches += [(middle, high), (low, middle)]
    return None
