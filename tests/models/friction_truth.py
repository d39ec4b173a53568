"""Motions with friction by routes that share nothing with the library.

`followed` integrates modes written by hand, stick among them, by scipy from event to event.
`forced_belt` stitches the closed forms of the belt oscillator with as many digits as asked for.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from mpmath import mp
from scipy.integrate import solve_ivp

SHORT = 0.02  # longest step: dense output of order 7 is then good to rounding


@dataclass(frozen=True)
class Leg:
    """A mode by hand: rates, and guards, positive inside, with what comes behind each."""

    rates: Callable
    guards: list[tuple[Callable, Callable]]


def followed(legs: dict[str, Leg], name: str, start, times):
    """States at some times, and the switches (mode entered, time)."""
    z, t, log, states = np.array(start, float), times[0], [], [np.array(start, float)]
    asked = list(times[1:])
    while asked:
        leg = legs[name]
        found = _leg(leg, t, z, asked)
        states += list(found.y.T[: np.searchsorted(found.t, found.ends_at)])
        asked = [time for time in asked if time >= found.ends_at]
        if found.status != 1:
            states += [found.y[:, -1]] * len(asked)
            break
        (which,) = np.flatnonzero([len(hit) for hit in found.t_events])[:1]
        t, z = found.t_events[which][0], found.y_events[which][0]
        name, z = leg.guards[which][1](t, z)
        log.append((name, t))
    return np.array(states), log


def _leg(leg: Leg, t, z, asked):
    events = []
    for guard, _ in leg.guards:

        def event(time, state, guard=guard):
            return guard(time, state)

        event.terminal, event.direction = True, -1
        events.append(event)
    found = solve_ivp(
        leg.rates, (t, asked[-1]), z, method="DOP853", rtol=1e-13, atol=1e-15, max_step=SHORT,
        events=events, t_eval=asked,
    )  # fmt: skip
    hit = [float(h[0]) for h in found.t_events if len(h)]
    found.ends_at = min(hit) if found.status == 1 else asked[-1]
    return found


# ---------------------------------------------------------------- the forced belt


def forced_belt(v_b, F_s, F_k, F, omega, x, v, periods):
    """States at each period, and the switches (cell entered, time), from a start in slip."""
    v_b, F_s, F_k, F, omega, x, v = (mp.mpf(n) for n in (v_b, F_s, F_k, F, omega, x, v))
    turn = 2 * mp.pi / omega
    t, cell, log, states = mp.mpf(0), "lead" if v > v_b else "lag", [], [(x, v)]
    while len(states) <= periods:
        at = _motion(cell, t, x, v, v_b, F_k, F, omega)

        def leaving(s, at=at, cell=cell):
            place, speed = at(s)
            if cell == "stick":
                return F_s - abs(place - F * mp.cos(omega * s))
            return (speed - v_b) * (1 if cell == "lead" else -1)

        end = _first_root(leaving, t, turn * (periods + 1))
        while len(states) <= periods and turn * len(states) <= end:
            states.append(at(turn * len(states)))
        x, v = at(end)
        t, pull = end, x - F * mp.cos(omega * end)
        if cell == "stick":
            cell, v = ("lag" if pull > 0 else "lead"), v_b
        else:
            v = v_b
            across = {"lag": "lead", "lead": "lag"}[cell]
            cell = "stick" if abs(pull) <= F_s else across
        log.append((cell, t))
    return states, log


def _motion(cell, t0, x0, v0, v_b, F_k, F, omega):
    """Displacement and velocity of a cell from a point on, in closed form."""
    if cell == "stick":
        return lambda t: (x0 + v_b * (t - t0), v_b)
    centre = F_k if cell == "lag" else -F_k
    gain = F / (1 - omega**2)
    a = x0 - centre - gain * mp.cos(omega * t0)
    b = v0 + gain * omega * mp.sin(omega * t0)

    def at(t):
        s = t - t0
        return (
            centre + gain * mp.cos(omega * t) + a * mp.cos(s) + b * mp.sin(s),
            -gain * omega * mp.sin(omega * t) - a * mp.sin(s) + b * mp.cos(s),
        )

    return at


def _first_root(function, began, ended):
    """First root after `began` of a function that is positive just behind it."""
    step = mp.mpf("0.02")
    low = began + step
    while function(low) > 0:
        low += step
        if low > ended:
            return ended
    return mp.findroot(function, (low - step, low), solver="anderson", tol=mp.mpf(10) ** -50)
