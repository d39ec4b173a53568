"""Random piecewise-smooth systems against runs with 40 digits, tangents included.

States to 1e-11 times the growth, columns of tangents to 1e-9 of their size: their own growth is
that of second derivatives, which is larger.
"""

import numpy as np
import pytest
from mpmath import mpf

import nonsmooth as ns
from contract.growth import growth
from contract.random_systems import NUMBERS, draw_system
from reference.differences import derivatives
from reference.nonlinear import smooth_run

LARGEST_GROWTH = 1e4
SLOWEST_CROSSING = 1e-3
FEW, MANY = range(8), range(8, 150)
# 25 digits are enough here, and three times as fast
SHORTER = {"order": 30, "tolerance": mpf(10) ** -28}


def seeds():
    return [*FEW, *(pytest.param(k, marks=pytest.mark.slow) for k in MANY)]


@pytest.mark.slow
@pytest.mark.parametrize("seed", seeds())
def test_states_events_and_tangents(seed):
    drawn = draw_system(seed)
    case, system = drawn.case(), drawn.system()
    true = smooth_run(case.model, case.parameters, case.start, case.mode, case.times, **SHORTER)
    start = dict(zip(drawn.states, drawn.start, strict=True))
    run = ns.simulate(system, start, times=drawn.times, tangent=True)
    assert run.attrs["status"] == "completed"
    assert all(abs(event.rate) > SLOWEST_CROSSING for event in true.events), "nearly a graze"
    sizes = growth(system, start, [0.0, *drawn.times])[1:]
    assert sizes[-1] < LARGEST_GROWTH, "the run forgets its start"
    events = run.isel(event=run["event_kind"].values != "start")
    assert [path.count(">") + 1 for path in events["event_path"].values] == [
        len(event.path) for event in true.events
    ]
    late = np.abs(events["event_time"].values - [float(event.time) for event in true.events])
    rates = np.array([min(1.0, abs(float(event.rate))) for event in true.events])
    assert (late < 1e-11 * sizes[-1] / rates).all()
    states = np.stack([run[name].values for name in drawn.states], axis=1)
    expected = np.array([[float(x) for x in row] for row in true.samples])
    assert (np.abs(states - expected) < 1e-11 * sizes[:, None]).all()
    assert_column(run, drawn, seed)


def assert_column(run, drawn, seed):
    """One column, by an initial state or by a parameter in turn."""
    state, name = drawn.states[seed // 2 % len(drawn.states)], NUMBERS[seed // 2 % len(NUMBERS)]
    if seed % 2:
        found = run["tangent"].sel(state_0=state).values
        truth = derivatives(drawn.case(), [drawn.states.index(state)], [], **SHORTER).tangent
    else:
        found = run["sensitivity"].sel(parameter_0=name).values
        truth = derivatives(drawn.case(), [], [name], **SHORTER).sensitivity
    expected = np.array([[float(x[0]) for x in rows] for rows in truth])
    largest = np.abs(run["tangent"].values).max(axis=(1, 2))
    scale = np.maximum(np.abs(expected).max(axis=1), largest)
    assert (np.abs(found - expected).max(axis=1) < 1e-9 * scale).all()


def test_most_runs_have_events():
    counts = []
    for seed in FEW:
        drawn = draw_system(seed)
        start = dict(zip(drawn.states, drawn.start, strict=True))
        counts.append(ns.simulate(drawn.system(), start, times=drawn.times).attrs["n_events"])
    assert sum(count >= 3 for count in counts) >= len(counts) / 2
