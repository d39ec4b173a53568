"""heyoka: Taylor method, compiled per problem, terminal events with Python callbacks.

The right-hand side contains the mode as parameters; a callback changes them and the integration
goes on.  The fastest options found are used: `propagate_grid` for the strobes (a fifth less time
than one `propagate_until` per period) and `fast_math=True` (another fifth, errors alike).
Tolerance: the default, 2.2e-16.
"""

import heyoka as hy
import numpy as np
from problems import CHAIN, MOLE, SOFT_IMPACT

VERSION = hy.__version__


def prepare(problem):
    """(run, read) as in `hand`."""
    names = problem.states
    variables = dict(zip(names, hy.make_vars(*names), strict=True))
    count = [0]
    rates, start, events = SYSTEMS[problem.name](problem.parameters, variables, count)
    integrator = hy.taylor_adaptive(
        [(variables[name], rates[name]) for name in names],
        [0.0] * len(names),
        pars=start,
        t_events=events,
        fast_math=True,
    )

    def run(periods):
        integrator.time = 0.0
        integrator.state[:] = 0.0
        integrator.pars[:] = start
        integrator.reset_cooldowns()
        count[0] = 0
        outcome, *_, strobes = integrator.propagate_grid(np.arange(periods + 1) * problem.period)
        assert outcome == hy.taylor_outcome.time_limit, outcome
        return strobes, count[0]

    return run, lambda result: (result[0][1:], result[1])


def switched_stop(guard, stiffness, count):
    """One event at the stop, and the stiffness behind it as parameter 0."""

    def cross(integrator, direction):
        count[0] += 1
        integrator.pars[0] = stiffness if direction > 0 else 0.0
        return True

    return [hy.t_event(guard, callback=cross)]


def soft_impact(p, z, count):
    x, v = z["x"], z["v"]
    drive = p["a"] * p["omega"] ** 2 * hy.sin(p["omega"] * hy.time)
    rates = {"x": v, "v": drive - 2.0 * p["zeta"] * v - x - hy.par[0] * (x - p["e"])}
    return rates, [0.0], switched_stop(x - p["e"], p["beta"], count)


def chain(p, z, count):
    x1, x2, x3, v1, v2, v3 = z.values()
    k, c = p["k"] / p["m"], p["c"] / p["m"]
    drive = p["A"] / p["m"] * hy.cos(p["omega"] * hy.time)
    rates = {
        "x1": v1,
        "x2": v2,
        "x3": v3,
        "v1": k * (x2 - 2.0 * x1) + c * (v2 - 2.0 * v1) + drive,
        "v2": k * (x1 - 2.0 * x2 + x3) + c * (v1 - 2.0 * v2 + v3),
        "v3": k * (x2 - x3) + c * (v2 - v3) - hy.par[0] * (x3 - p["e"]),
    }
    return rates, [0.0], switched_stop(x3 - p["e"], p["k_stop"] / p["m"], count)


def mole(p, z, count):
    """Parameters: in contact, in progression, armed.

    At release p - q - g and its rate F/(2 xi) are both zero: an impact found there would be false.
    None is possible before that rate is positive again, so it is armed when F has risen to 0.
    """
    contact, progression, armed = hy.par[0], hy.par[1], hy.par[2]
    y, q = z["y"], z["q"]
    rate = 1.0 / (2.0 * p["xi"])
    F = 2.0 * p["xi"] * y + q
    f = p["b"] - p["a"] * hy.sin(p["omega"] * hy.time)
    slide = contact * y + (1.0 - contact) * rate * (progression - q)
    rates = {
        "p": y + progression * (slide - y),
        "y": f - contact * F - progression,
        "q": slide,
        "v": progression * rate * (F - 1.0),
    }

    def enter(integrator, *mode):
        integrator.pars[:] = mode
        return True

    def impact(integrator, _):
        count[0] += 1
        state = integrator.state
        state[0] = state[2] + p["g"]
        progresses = 2.0 * p["xi"] * state[1] + state[2] > 1.0
        return enter(integrator, 0.0, 1.0, 0.0) if progresses else enter(integrator, 1.0, 0.0, 0.0)

    def force_zero(integrator, _):
        if integrator.pars[0] == 1.0:
            count[0] += 1
            return enter(integrator, 0.0, 0.0, 0.0)
        return enter(integrator, 0.0, 0.0, 1.0)

    def force_one(integrator, _):
        count[0] += 1
        if integrator.pars[0] == 1.0:
            return enter(integrator, 0.0, 1.0, 0.0)
        return enter(integrator, 1.0, 0.0, 0.0)

    # An event that does not apply in a mode is a constant there.
    rising = hy.event_direction.positive
    events = [
        hy.t_event(armed * (z["p"] - q - p["g"]) + armed - 1.0, callback=impact, direction=rising),
        hy.t_event(
            (1.0 - armed) * (1.0 - progression) * F + armed + progression, callback=force_zero
        ),
        hy.t_event((contact + progression) * F - 1.0, callback=force_one),
    ]
    return rates, [0.0, 0.0, 1.0], events


SYSTEMS = {SOFT_IMPACT.name: soft_impact, MOLE.name: mole, CHAIN.name: chain}
