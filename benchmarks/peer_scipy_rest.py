"""scipy on the problems of `bench_rest`: solve_ivp with DOP853, rtol 1e-10, terminal events.

Rebounds are followed until the rate after one is below 1e-7; then the mass is put to rest until the
force leads away from the wall. A block that arrives at the belt sticks where friction can bear the
force. Both have to be told to it.
"""

from math import cos, pi

import numpy as np
from scipy.integrate import solve_ivp

TOLERANCES = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12}
_SLOW = 1e-7


def strobes(kind, parameters, start, periods):
    """States at the end of each period and the number of events."""
    modes, mode = (_impacts if kind == "impacts" else _belt)(parameters)
    times = np.arange(1, periods + 1) * 2.0 * pi / parameters["omega"]
    rows, events, done = np.empty((periods, 2)), 0, 0
    t, z = 0.0, np.array([start["x"], start["v"]])
    while done < periods:
        flow, guards, leave = modes[mode]
        part = solve_ivp(flow, (t, times[-1]), z, events=guards, t_eval=times[done:], **TOLERANCES)
        assert part.status >= 0, part.message
        if len(part.t):  # lists without entries where an event comes before all strobes
            rows[done : done + len(part.t)] = part.y.T
            done += len(part.t)
        if part.status == 0:
            break
        fired = next(i for i, found in enumerate(part.t_events) if len(found))
        t, z = part.t_events[fired][0], part.y_events[fired][0].copy()
        mode = leave(fired, t, z)
        events += 1
    return rows, events


def _falls(function):
    """Terminal event where a function falls through zero."""
    function.terminal, function.direction = True, -1
    return function


def _impacts(p):
    F, omega, sigma, r = (p[name] for name in ("F", "omega", "sigma", "r"))

    def flight(t, z):
        return z[1], F * cos(omega * t) - z[0]

    def hit(_, t, z):
        z[:] = sigma, -r * z[1]
        return "rest" if -z[1] < _SLOW and F * cos(omega * t) > sigma else "flight"

    modes = {
        "flight": (flight, [_falls(lambda t, z: sigma - z[0])], hit),
        "rest": (
            lambda t, z: (0.0, 0.0),
            [_falls(lambda t, z: F * cos(omega * t) - sigma)],
            lambda *_: "flight",
        ),
    }
    return modes, "flight"


def _belt(p):
    F_c, v_b, F, omega = (p[name] for name in ("F_c", "v_b", "F", "omega"))

    def slip(side):
        def flow(t, z):
            return z[1], F * cos(omega * t) - z[0] - side * F_c

        def arrive(_, t, z):
            z[1] = v_b
            pull = F * cos(omega * t) - z[0]
            return "stick" if abs(pull) < F_c else ("lag" if side > 0 else "lead")

        return flow, [_falls(lambda t, z: side * (z[1] - v_b))], arrive

    limits = [
        _falls(lambda t, z: F_c - F * cos(omega * t) + z[0]),
        _falls(lambda t, z: F_c + F * cos(omega * t) - z[0]),
    ]
    stick = (lambda t, z: (v_b, 0.0), limits, lambda fired, *_: ("lead", "lag")[fired])
    return {"lead": slip(1), "lag": slip(-1), "stick": stick}, "lag"
