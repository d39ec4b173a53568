"""The Taylor flow and the exact flow on every linear model: the same states and events.

States to 1e-11 times the growth of the tangent over any part of the run so far, times of events
to that over the rate of the guard, as long as the growth stays below 1e4.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from contract.growth import growth
from contract.linear_models import MODELS
from contract.taylor_twin import flow_kinds, taylor_twin

TOLERANCE = 1e-11
LARGEST_GROWTH = 1e4


class Pair(NamedTuple):
    """Both runs, sampled at the ends of the pieces, and the growth up to each of them."""

    exact: object
    taylor: object
    growth: np.ndarray


@cache
def pair(name):
    model = MODELS[name]
    times = np.linspace(0.0, model.t_end, model.pieces + 1)
    exact = ns.simulate(model.system, model.initial, times=times)
    taylor = ns.simulate(taylor_twin(model.system), model.initial, times=times)
    return Pair(exact, taylor, growth(model.system, model.initial, times))


def crossings(run):
    return run.isel(event=run["event_kind"].values != "start")


@pytest.mark.parametrize("name", MODELS)
def test_the_twin_takes_the_other_flow(name):
    system = MODELS[name].system
    (exact,), (taylor,) = flow_kinds(system), flow_kinds(taylor_twin(system))
    assert exact != taylor
    assert "Taylor" in taylor


@pytest.mark.few(6)
@pytest.mark.parametrize("name", MODELS)
def test_states(name):
    exact, taylor, sizes = pair(name)
    assert taylor.attrs["status"] == exact.attrs["status"] == "completed"
    fair = sizes < LARGEST_GROWTH
    assert fair.sum() > 0.5 * fair.size, "the run is too long, or too chaotic"
    assert exact.attrs["n_events"] >= 4
    for state in exact["state"].values:
        one, other = exact[state].values[fair], taylor[state].values[fair]
        error = np.abs(one - other) / np.maximum(1.0, np.abs(one))
        assert (error < TOLERANCE * sizes[fair]).all(), (state, (error / sizes[fair]).max())


@pytest.mark.parametrize("name", MODELS)
def test_events(name):
    exact, taylor, sizes = pair(name)
    until = exact["time"].values[sizes < LARGEST_GROWTH][-1]
    one, other = (
        run.isel(event=run["event_time"].values < until) for run in map(crossings, (exact, taylor))
    )
    assert list(one["event_path"].values) == list(other["event_path"].values)
    for key in ("event_name", "event_kind", "event_from", "event_to"):
        assert np.array_equal(one[key].values, other[key].values), key
    reached = sizes[np.searchsorted(exact["time"].values, one["event_time"].values)]
    rate = np.minimum(1.0, np.abs(one["guard_rate"].values))
    late = np.abs(one["event_time"].values - other["event_time"].values)
    assert (late < TOLERANCE * reached / rate).all(), (late * rate / reached).max()


@pytest.mark.parametrize("name", MODELS)
def test_neither_flow_leaves_an_event_in_doubt(name):
    exact, taylor, sizes = pair(name)
    until = exact["time"].values[sizes < LARGEST_GROWTH][-1]
    for run in map(crossings, (exact, taylor)):
        assert run["certified"].values[run["event_time"].values < until].all()
