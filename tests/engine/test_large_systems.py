"""Chains of many masses: their motion, and when it meets a stop, by natural modes.

With damping in proportion to the stiffness each natural mode is an oscillator of its own, whose
motion is written down here; scipy's symmetric eigenvalues share nothing with the engine's.
"""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

import nonsmooth as ns

EPS = 2.0**-52
DAMPING = 0.01


def stiffness_of_chain(count):
    return 2.0 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)


def two_planes(count):
    """Two equal chains that do not touch: every frequency twice."""
    return np.kron(stiffness_of_chain(count // 2), np.eye(2))


def system_of(stiffness, exits=()):
    count = len(stiffness)
    places, speeds = [f"x{i}" for i in range(count)], [f"v{i}" for i in range(count)]
    flow = dict(zip(places, speeds, strict=True))
    for i, row in enumerate(stiffness):
        flow[speeds[i]] = " ".join(
            f"+ ({-k!r})*{places[j]} + ({-DAMPING * k!r})*{speeds[j]}"
            for j, k in enumerate(row.tolist())
            if k
        ).removeprefix("+ ")
    return ns.System(states=places + speeds, modes={"chain": ns.Mode(flow, exits=list(exits))})


def motion_of(stiffness, start):
    """Places as a function of time, of a chain that starts at rest."""
    squares, shapes = eigh(stiffness)
    decay, share = 0.5 * DAMPING * squares, shapes.T @ start
    damped = np.sqrt(squares - decay**2)

    def places(t):
        swing = np.cos(damped * t) + decay / damped * np.sin(damped * t)
        return shapes @ (np.exp(-decay * t) * swing * share)

    return places


@pytest.mark.few(2)
@pytest.mark.parametrize("count", [20, 60, 120, pytest.param(250, marks=pytest.mark.slow)])
@pytest.mark.parametrize("structure", [stiffness_of_chain, two_planes])
def test_free_motion(structure, count):
    stiffness = structure(count)
    start = np.cos(np.arange(count) ** 2)
    system = system_of(stiffness)
    times = [0.0, 3.0, 40.0]
    initial = {f"x{i}": float(x) for i, x in enumerate(start)}
    run, truth = ns.simulate(system, initial, times=times), motion_of(stiffness, start)
    for k, t in enumerate(times):
        found = np.array([float(run[f"x{i}"][k]) for i in range(count)])
        # phases up to 2 t; shapes of places and speeds differ by factors of 2 to 1 / count
        allowed = 8.0 * count * EPS * (1.0 + 2.0 * t) * np.abs(start).max()
        assert np.abs(found - truth(t)).max() < allowed


@pytest.mark.parametrize("count", [60, 120])
def test_time_of_contact(count):
    stiffness = stiffness_of_chain(count)
    start = np.zeros(count)
    start[:3] = 1.0
    last, stop = count - 1, 0.02
    exits = [ns.Exit(f"{stop} - x{last}", to="stop", name="stop")]
    initial = {f"x{i}": float(x) for i, x in enumerate(start)}
    run = ns.simulate(system_of(stiffness, exits), initial, t_end=10.0 * count)
    assert run.attrs["status"] == "stopped" and run.attrs["certified"] == 1

    places = motion_of(stiffness, start)

    def gap(t):
        return stop - places(t)[last]

    grid = np.linspace(0.0, 10.0 * count, 100 * count)  # the fastest motion has a period of pi
    k = np.flatnonzero(np.array([gap(t) for t in grid]) < 0.0)[0]
    truth = brentq(gap, grid[k - 1], grid[k], xtol=1e-13, rtol=4 * EPS)
    speed = abs(gap(truth + 1e-4) - gap(truth - 1e-4)) / 2e-4
    assert abs(float(run["event_time"][-1]) - truth) < 64.0 * EPS * (1.0 + 2.0 * truth) / speed
