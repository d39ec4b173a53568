"""Contacts of the settled rotor that the guide shows, by a route that shares no code.

At eta = 3 the ring stays within its preloads, where its springs are alike in every direction: in
contact it stands at (|r| - 1) n with n = r/|r|, and free it fades as exp(-K t/(2 nu2)). So the
motion needs no slaved states: scipy's DOP853 integrates x, y and their rates, and its events end
the pieces.

Its error is some hundred steps of 1e-12 per period, and old errors fade by 0.76 in two periods;
1e-9 is asked for. `SETTLED` is where the motion from rest is after 300 periods of this same route.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns

ETA, NU1, NU2, K, UNBALANCE, ECCENTRICITY = 3.0, 0.125, 0.002, 30.0, 0.0017 * 70.0, 0.9
PERIOD = 2 * np.pi / ETA
RELATIVE, ABSOLUTE = 1e-12, 1e-13
SETTLED = (0.027853994734, 0.054606827396, 0.112169002292, -0.402734550134)
NOT_YET = 2e-5  # the gap opens as the square of the time: at once it is below rounding


def push(state):
    """Force on the ring in contact, and its part along the normal."""
    r, v = state[:2], state[2:]
    reach = np.hypot(*r)
    normal = r / reach
    outward = normal @ v
    turning = (v - outward * normal) / reach
    force = 2 * K * (reach - 1) * normal + 4 * NU2 * (outward * normal + (reach - 1) * turning)
    return force, normal @ force


def rates(time, state, touching):
    """Rates of x, y, x' and y'."""
    drive = UNBALANCE * ETA**2 * np.array([np.cos(ETA * time), np.sin(ETA * time)])
    spring = state[:2] - np.array([ECCENTRICITY, 0.0])
    force = push(state)[0] if touching else 0.0
    return np.concatenate([state[2:], drive - 2 * NU1 * state[2:] - spring - force])


def piece(start, state, stop, touching, end=None):
    """Motion until an event, or until the time is over."""
    if end is not None:
        end.terminal, end.direction = True, -1.0
    # Steps of a hundredth of a period: the event is the root of an interpolant of order 7.
    return solve_ivp(
        rates, (start, stop), state, "DOP853", args=(touching,), events=end, rtol=RELATIVE,
        atol=ABSOLUTE, max_step=PERIOD / 100,
    )  # fmt: skip


def gap(time, state, ring, released):
    """Distance to a ring that fades from its place at a release."""
    return 1 - np.hypot(*(state[:2] - ring * np.exp(-K / (2 * NU2) * (time - released))))


def contacts(state, periods):
    """Begin, end and states in contact, one after the other."""
    time, ring, released, found = 0.0, np.zeros(2), 0.0, []
    while True:
        if found:
            short = piece(time, state, time + NOT_YET, touching=False)
            time, state = short.t[-1], short.y[:, -1]
            assert gap(time, state, ring, released) > 0

        def touches(t, u, touching, ring=ring, released=released):
            return gap(t, u, ring, released)

        flight = piece(time, state, periods * PERIOD, touching=False, end=touches)
        if flight.t[-1] >= periods * PERIOD:
            return found
        touch = piece(
            flight.t[-1], flight.y[:, -1], flight.t[-1] + PERIOD, touching=True,
            end=lambda t, u, touching: push(u)[1],
        )  # fmt: skip
        time, state = touch.t[-1], touch.y[:, -1]
        ring, released = state[:2] * (1 - 1 / np.hypot(*state[:2])), time
        assert np.all(np.abs(touch.y[:2] * (1 - 1 / np.hypot(*touch.y[:2]))) < 0.1)
        found.append((touch.t[0], time, touch.y))


def test_contacts_at_a_speed_of_three():
    begins, ends, states = zip(*contacts(SETTLED, 20)[-3:], strict=True)
    assert np.diff(begins) == pytest.approx(2 * PERIOD, abs=1e-9)  # every second period
    duration = ends[-1] - begins[-1]
    force = max(np.hypot(*push(state)[0]) for state in states[-1].T)

    found = ns.contact_statistics(ns.models.rotor(), parameters={"eta": ETA}, of="force")
    assert float(found["contacts"]) == 0.5
    assert float(found["longest_contact"]) == pytest.approx(duration, abs=1e-9)
    assert float(found["shortest_contact"]) == pytest.approx(duration, abs=1e-9)
    assert float(found["contact_share"]) == pytest.approx(duration / (2 * PERIOD), abs=1e-9)
    # The largest of the steps: below the maximum by F'' h^2/8, with steps of a hundredth.
    assert force <= float(found["force_max"]) + 1e-9
    assert float(found["force_max"]) == pytest.approx(force, rel=2e-3)
