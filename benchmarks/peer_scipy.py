"""scipy: solve_ivp with DOP853, rtol 1e-10, terminal events, restarted at each event."""

from math import cos, sin

import numpy as np
import scipy
from problems import CHAIN, MOLE, SOFT_IMPACT
from scipy.integrate import solve_ivp

VERSION = scipy.__version__
TOLERANCES = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12}


def prepare(problem):
    """(run, read) as in `hand`."""
    modes, start = SYSTEMS[problem.name](problem.parameters)

    def run(periods):
        times = np.arange(1, periods + 1) * problem.period
        strobes = np.empty((periods, len(problem.states)))
        t, z, mode = 0.0, np.zeros(len(problem.states)), start
        done = events = 0
        while done < periods:
            flow, guards, transition = modes[mode]
            part = solve_ivp(
                flow, (t, times[-1]), z, events=guards, t_eval=times[done:], **TOLERANCES
            )
            assert part.status >= 0, part.message
            if len(part.t):
                strobes[done : done + len(part.t)] = part.y.T
                done += len(part.t)
            if part.status == 0:
                break
            fired = next(i for i, found in enumerate(part.t_events) if len(found))
            t, z = part.t_events[fired][0], part.y_events[fired][0]
            mode, counted = transition(fired, z)
            events += counted
        return strobes, events

    return run, lambda result: result


def exit_where(function, direction):
    """A terminal event that fires where the function passes zero in the given direction."""

    def event(t, z):
        return function(z)

    event.terminal = True
    event.direction = direction
    return event


def one_sided(flow, state, e):
    """Free and in-contact modes of a mass that meets an elastic stop at e."""

    def meet(mode):
        def transition(_, z):
            z[state] = e
            return mode, 1

        return transition

    def gap(z):
        return z[state] - e

    return {
        "free": (flow(False), [exit_where(gap, 1)], meet("contact")),
        "contact": (flow(True), [exit_where(gap, -1)], meet("free")),
    }, "free"


def soft_impact(p):
    omega, damping, e = p["omega"], 2.0 * p["zeta"], p["e"]
    drive = p["a"] * omega**2

    def flow(contact):
        beta = p["beta"] if contact else 0.0

        def rates(t, z):
            x, v = z
            return v, drive * sin(omega * t) - damping * v - x - beta * (x - e)

        return rates

    return one_sided(flow, 0, e)


def chain(p):
    omega, e = p["omega"], p["e"]
    k, c, drive = p["k"] / p["m"], p["c"] / p["m"], p["A"] / p["m"]

    def flow(contact):
        stop = p["k_stop"] / p["m"] if contact else 0.0

        def rates(t, z):
            x1, x2, x3, v1, v2, v3 = z
            return (
                v1,
                v2,
                v3,
                k * (x2 - 2.0 * x1) + c * (v2 - 2.0 * v1) + drive * cos(omega * t),
                k * (x1 - 2.0 * x2 + x3) + c * (v1 - 2.0 * v2 + v3),
                k * (x2 - x3) + c * (v2 - v3) - stop * (x3 - e),
            )

        return rates

    return one_sided(flow, 2, e)


def mole(p):
    """A flight starts `released`, blind to impacts until F rises to 0: see `peer_heyoka.mole`."""
    omega, a, b, g = p["omega"], p["a"], p["b"], p["g"]
    viscous = 2.0 * p["xi"]
    rate = 1.0 / viscous

    def f(t):
        return b - a * sin(omega * t)

    def F(z):
        return viscous * z[1] + z[2]

    def flight(t, z):
        return z[1], f(t), -rate * z[2], 0.0

    def contact(t, z):
        return z[1], f(t) - F(z), z[1], 0.0

    def progression(t, z):
        slide = rate * (1.0 - z[2])
        return slide, f(t) - 1.0, slide, z[1] - slide

    def impact(_, z):
        z[0] = z[2] + g
        return ("progression" if F(z) > 1.0 else "contact"), 1

    def leave_contact(fired, _):
        return ("released", "progression")[fired], 1

    force_one = exit_where(lambda z: F(z) - 1.0, 1)
    modes = {
        "released": (flight, [exit_where(F, 1)], lambda *_: ("no contact", 0)),
        "no contact": (flight, [exit_where(lambda z: z[0] - z[2] - g, 1)], impact),
        "contact": (contact, [exit_where(F, -1), force_one], leave_contact),
        "progression": (
            progression,
            [exit_where(lambda z: F(z) - 1.0, -1)],
            lambda *_: ("contact", 1),
        ),
    }
    return modes, "no contact"


SYSTEMS = {SOFT_IMPACT.name: soft_impact, MOLE.name: mole, CHAIN.name: chain}
