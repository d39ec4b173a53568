"""Two routes that share no code: the integrators of synthetic records, and the engine."""

import numpy as np
import pytest
import synthetic_motions as other

import nonsmooth as ns

FIG24 = {"eta": 3.0, "lambda1": 2.0, "lambda2": 2.0, "f1": 3.75, "f2": 3.75}
SLOW = {"eta": 1.8, "delta_x": 0.05, "delta_y": 0.05}
CASES = {
    "soft_impact": ({}, [0.3, 0.1], ("x", "v"), 10),
    "impact_oscillator": ({}, [0.1, 0.2], ("x", "v"), 10),
    "breathing_crack": ({}, [0.3, 0.0], ("u", "v"), 10),
    "fatigue_rig": (FIG24, [0.0] * 5, ("X1", "X2", "X3", "X4", "X5"), 4),
    "moling": ({}, [0.0, 0.0, 0.0, 0.0], ("p", "y", "q", "v"), 10),
    "rotor": (SLOW, [0.0] * 4, ("x", "y", "vx", "vy"), 10),
}  # fmt: skip


@pytest.mark.few(2)
@pytest.mark.parametrize("name", CASES)
def test_the_engine_comes_to_the_same_motion(name):
    """To 1e-8, over a stretch in which an error of a step at 1e-11 does not grow beyond that."""
    changed, start, states, periods = CASES[name]
    parameters = getattr(other, name.upper()) | changed
    machine = getattr(other, name)(**changed)
    times = np.linspace(0.0, periods * machine.period, 30 * periods)
    found = other.motion(machine, times, start)
    assert found.event_times.size >= 10
    system = getattr(ns.models, name)(**parameters)
    run = ns.simulate(system, dict(zip(states, start, strict=True)), times=times)
    known = np.column_stack([run[state].values for state in states])
    size = np.abs(known).max(axis=0)
    assert (np.abs(found.states - known) / size).max() < 1e-8
