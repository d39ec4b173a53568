"""heyoka on the problems of `bench_rest`: Taylor method, terminal events with Python callbacks.

Modes are parameters of the equations, which callbacks change. As for scipy, rebounds are followed
until the rate after one is below 1e-7, and rest and stick have to be told to it. An event that
does not apply in a mode is a constant there. A block that leaves the belt does so with a relative
velocity and acceleration of zero, where an event would be false: its return is looked for once
the acceleration has turned.
"""

import heyoka as hy
import numpy as np

VERSION = hy.__version__
_SLOW = 1e-7
_FALLING = hy.event_direction.negative


def prepare(kind, p, start):
    """A function of the number of periods: states at their ends, and the number of events."""
    x, v = hy.make_vars("x", "v")
    drive = p["F"] * hy.cos(p["omega"] * hy.time)
    count = [0]
    make = _impacts if kind == "impacts" else _belt
    acceleration, pars, events = make(p, x, v, drive, count)
    integrator = hy.taylor_adaptive(
        [(x, v), (v, acceleration)], [start["x"], start["v"]], pars=pars, t_events=events,
        fast_math=True,
    )  # fmt: skip

    def run(periods):
        integrator.time = 0.0
        integrator.state[:] = start["x"], start["v"]
        integrator.pars[:] = pars
        integrator.reset_cooldowns()
        count[0] = 0
        times = np.arange(periods + 1) * 2.0 * np.pi / p["omega"]
        outcome, *_, strobes = integrator.propagate_grid(times)
        assert outcome == hy.taylor_outcome.time_limit, outcome
        return strobes[1:], count[0]

    return run


def _pull(p, integrator):
    """Force of the drive less that of the spring."""
    return p["F"] * np.cos(p["omega"] * integrator.time) - integrator.state[0]


def _impacts(p, x, v, drive, count):
    """Parameter: 1 in flight, 0 at rest at the wall."""
    flies = hy.par[0]

    def hit(integrator, _):
        count[0] += 1
        state = integrator.state
        state[:] = p["sigma"], -p["r"] * state[1]
        if -state[1] < _SLOW and _pull(p, integrator) > 0.0:
            state[1] = 0.0
            integrator.pars[0] = 0.0
        return True

    def release(integrator, _):
        count[0] += 1
        integrator.pars[0] = 1.0
        return True

    events = [
        hy.t_event(flies * (p["sigma"] - x) + 1.0 - flies, callback=hit, direction=_FALLING),
        hy.t_event(
            (1.0 - flies) * (drive - p["sigma"]) + flies, callback=release, direction=_FALLING
        ),
    ]
    return flies * (drive - x), [1.0], events


def _belt(p, x, v, drive, count):
    """Parameters: 1 in slip and 0 in stick, side of the belt's velocity, armed."""
    slips, side, armed = hy.par[0], hy.par[1], hy.par[2]
    F_c, v_b = p["F_c"], p["v_b"]
    push = drive - x

    def enter(integrator, *mode):
        integrator.pars[:] = mode
        return True

    def arrive(integrator, _):
        count[0] += 1
        integrator.state[1] = v_b
        if abs(_pull(p, integrator)) < F_c:
            return enter(integrator, 0.0, 1.0, 0.0)
        return enter(integrator, 1.0, -integrator.pars[1], 1.0)

    def turn(integrator, _):
        return enter(integrator, 1.0, integrator.pars[1], 1.0)

    def leave(side_of):
        def callback(integrator, _):
            count[0] += 1
            return enter(integrator, 1.0, side_of, 0.0)

        return callback

    waiting = slips * (1.0 - armed)
    events = [
        hy.t_event(armed * side * (v - v_b) + 1.0 - armed, callback=arrive, direction=_FALLING),
        hy.t_event(
            waiting * side * (push - side * F_c) + 1.0 - waiting, callback=turn, direction=_FALLING
        ),
        hy.t_event((1.0 - slips) * (F_c - push) + slips, callback=leave(1.0), direction=_FALLING),
        hy.t_event((1.0 - slips) * (F_c + push) + slips, callback=leave(-1.0), direction=_FALLING),
    ]
    return slips * (push - side * F_c), [1.0, -1.0, 1.0], events
