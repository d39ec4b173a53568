"""A driven impact oscillator by scipy's DOP853 with events, for tests of branches."""

import numpy as np
from scipy.integrate import solve_ivp

import nonsmooth as ns


def oscillator(w, *, r=0.3, g=0.5, z=0.1, f=0.0, both=False, hold=None):
    """x'' + 2 z x' + x = cos(w t) - f sign(x') with a rigid wall at g, or one on either side."""
    exits = [ns.Exit("g - x", reset={"v": "-r*v"}, name="hit")]
    if both:
        exits.append(ns.Exit("x + g", reset={"v": "-r*v"}, name="hit_below"))
    sign = "sign(v)" if hold is None else "sign(slip)"
    friction = f" - f*{sign}" if f else ""
    return ns.System(
        states=["x", "v"],
        period="2*pi/w",
        parameters={"w": w, "z": z, "r": r, "g": g, "f": f},
        modes={"m": ns.Mode({"x": "v", "v": f"cos(w*t) - x - 2*z*v{friction}"}, exits=exits)},
        surfaces={} if hold is None else {"slip": ns.Surface("v", hold=hold)},
    )


def period_of_motion(system, w, state):
    """State after a period, and the speeds of the impacts on the way; friction without sticking."""
    z, r, g, f = (system.parameter_values[name] for name in ("z", "r", "g", "f"))
    t, end = 0.0, 2.0 * np.pi / w
    y, speeds = np.array(state, float), []
    while t < end:
        force = np.cos(w * t) - y[0]
        way = np.sign(y[1]) if y[1] != 0.0 else np.sign(force)

        def rates(t, y, way=way):
            return [y[1], np.cos(w * t) - y[0] - 2.0 * z * y[1] - f * way]

        def wall(t, y):
            return g - y[0]

        def turns(t, y):
            return y[1]

        wall.terminal = turns.terminal = True
        wall.direction, turns.direction = -1.0, -way
        run = solve_ivp(
            rates, (t, end), y, method="DOP853", rtol=1e-12, atol=1e-13,
            events=[wall, turns] if f else [wall],
        )  # fmt: skip
        t, y = float(run.t[-1]), run.y[:, -1].copy()
        if run.t_events[0].size:
            speeds.append(float(y[1]))
            y = np.array([g, -r * y[1]])
        elif f and run.t_events[1].size:
            y[1] = 0.0
    return y, np.array(speeds)


def multipliers_of_motion(system, w, state, step=1e-6):
    """Eigenvalues of central differences of the map over a period."""
    columns = [
        (period_of_motion(system, w, state + d)[0] - period_of_motion(system, w, state - d)[0])
        / (2.0 * step)
        for d in step * np.eye(2)
    ]
    return np.linalg.eigvals(np.array(columns).T)
