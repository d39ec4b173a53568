"""Records of impact oscillators from another integrator: nothing of the engine computes them."""

import numpy as np
import xarray as xr
from scipy.integrate import solve_ivp

SOFT = {"omega": 0.85, "zeta": 0.01, "beta": 29.0, "e": 1.26, "a": 0.7}
RIGID = {"omega": 1.3, "zeta": 0.05, "F": 1.0, "sigma": 0.4, "r": 0.8}
_ACCURACY = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}


def soft_motion(times, start, **changed):
    """Position, velocity and acceleration of the soft impact oscillator at some times."""
    p = SOFT | changed

    def rate(t, y, contact):
        x, v = y
        spring = p["beta"] * (x - p["e"]) if contact else 0.0
        force = p["a"] * p["omega"] ** 2 * np.sin(p["omega"] * t)
        return [v, force - 2.0 * p["zeta"] * v - x - spring]

    def wall(t, y, contact):
        return y[0] - p["e"]

    wall.terminal = True
    return _piecewise(rate, wall, times, start, lambda t, y: y[0] > p["e"], lambda y: y)


def rigid_motion(times, start, **changed):
    """The same for a mass that rebounds from a rigid wall."""
    p = RIGID | changed

    def rate(t, y, contact):
        force = p["F"] * np.cos(p["omega"] * t)
        return [y[1], force - 2.0 * p["zeta"] * y[1] - y[0]]

    def wall(t, y, contact):
        return y[0] - p["sigma"]

    wall.terminal, wall.direction = True, 1.0

    def rebound(y):
        return np.array([min(y[0], p["sigma"]) - 1e-15, -p["r"] * abs(y[1])])

    return _piecewise(rate, wall, times, start, lambda t, y: False, rebound)


def _piecewise(rate, wall, times, start, side, jump):
    """Motion from event to event; each piece is smooth."""
    t, y = float(times[0]), np.array(start, float)
    states, contacts, done, events = [], [], 0, []
    contact = side(t, y)
    end = float(times[-1])
    while done < len(times):
        piece = solve_ivp(
            rate, (t, end + 1e-9), y, args=(contact,), events=wall, dense_output=True, **_ACCURACY
        )
        last = piece.t[-1]
        here = times[done:][times[done:] <= last]
        if here.size:
            states.append(piece.sol(here).T)
            contacts += [contact] * here.size
            done += here.size
        if piece.status == 1:
            events.append(last)
            y = jump(piece.y[:, -1])
            # beyond the surface by one small smooth step, so that the event is not found again
            step = solve_ivp(rate, (last, last + 1e-7), y, args=(contact,), **_ACCURACY)
            t = last + 1e-7
            y = step.y[:, -1]
            contact = side(t, y)
        else:
            break
    states = np.concatenate(states)
    rates = [rate(t, y, c)[1] for t, y, c in zip(times, states, contacts, strict=True)]
    return states[:, 0], states[:, 1], np.array(rates), np.array(events)


def noisy(values, share, rng):
    """Values with white noise, as a share of their standard deviation."""
    return values + share * np.std(values) * rng.standard_normal(values.size)


def dataset(times, **channels):
    """A record made by hand."""
    return xr.Dataset({name: ("time", each) for name, each in channels.items()}, {"time": times})
