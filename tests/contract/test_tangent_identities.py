"""What every tangent must satisfy, whatever the numbers: volumes, ranks and rows."""

import numpy as np
import pytest

import nonsmooth as ns
from contract.tangent_systems import RUNS, start_of, system_of
from contract.taylor_twin import taylor_twin

TWINS = [False, True]
EVERY = np.linspace(0.0, 40.0, 161)


def run_of(name, twin, times=EVERY, **changes):
    system = system_of(name).with_parameters(**changes)
    if twin:
        system = taylor_twin(system)
    return ns.simulate(system, start_of(name), times=times, tangent=[]), system.parameter_values


def impacts_before(run):
    """The number of events before each sample."""
    events = run["event_time"].values[run["event_kind"].values != "start"]
    return np.searchsorted(events, run["time"].values)


def assert_determinant(run, expected):
    found = np.linalg.det(run["tangent"].values)
    sizes = np.linalg.norm(run["tangent"].values, axis=(1, 2)) ** run.sizes["state"]
    assert (np.abs(found - expected) <= 1e-11 * np.maximum(1.0, sizes)).all()


@pytest.mark.parametrize("twin", TWINS)
def test_start_is_the_identity(twin):
    for name in RUNS:
        run, _ = run_of(name, twin and name != "ramp", times=[0.0])
        assert np.array_equal(run["tangent"].values[0], np.eye(run.sizes["state"])), name


@pytest.mark.parametrize("twin", TWINS)
def test_a_switch_of_a_continuous_field_keeps_volumes(twin):
    run, p = run_of("bilinear", twin)
    assert run.attrs["n_events"] >= 5
    assert_determinant(run, np.exp(-2 * p["zeta"] * EVERY))


def test_the_rotor_loses_volume_to_damping_only():
    run, p = run_of("rotor", False)
    assert run.attrs["n_events"] >= 17
    assert_determinant(run, np.exp(-4 * p["zeta"] * EVERY))


@pytest.mark.parametrize("twin", TWINS)
@pytest.mark.parametrize("r", [0.7, 0.8, 1.0])
def test_an_impact_takes_r_squared(twin, r):
    run, p = run_of("rigid impact", twin, r=r)
    assert run.attrs["n_events"] >= 6
    assert_determinant(run, r ** (2 * impacts_before(run)) * np.exp(-2 * p["zeta"] * EVERY))


@pytest.mark.parametrize("twin", TWINS)
def test_an_impact_on_a_moving_table_takes_as_much(twin):
    times = np.linspace(0.0, 16.0, 65)
    run, p = run_of("vibrating table", twin, times)
    assert run.attrs["n_events"] >= 5
    assert_determinant(run, p["r"] ** (2 * impacts_before(run)))


def test_an_impact_with_a_nonlinear_law():
    """In gap and relative speed s: s+/s- times the slope of s+(s-)."""
    run, p = run_of("pendulum", False)
    product, expected, k = 1.0, [], 0
    impacts = run.isel(event=run["event_kind"].values != "start")
    for t in EVERY:
        while k < impacts.sizes["event"] and impacts["event_time"].values[k] < t:
            angle, speed = impacts["state_before"].values[k]
            wall = p["D"] * p["nu"] * np.cos(p["nu"] * impacts["event_time"].values[k])
            s = p["L"] * np.cos(angle) * speed - wall
            product *= p["e0"] ** 2 / (1 + p["e1"] * p["e0"] * s) ** 3
            k += 1
        expected.append(product * np.exp(-p["c"] * t))
    assert k >= 5
    assert_determinant(run, np.array(expected))


@pytest.mark.parametrize("name", RUNS)
@pytest.mark.parametrize("cut", [2, 5])
def test_tangents_multiply_from_run_to_run(name, cut):
    """And a parameter acts in the second run on what it has moved in the first."""
    system, times = system_of(name), RUNS[name]["times"]
    whole = ns.simulate(system, start_of(name), times=times, tangent=True)
    first = ns.simulate(system, start_of(name), times=times[: cut + 1], tangent=True)
    second = ns.simulate(system, first, times=times[cut:], tangent=True)
    before, after = (run["tangent"].values[-1] for run in (first, second))
    moved, since = (run["sensitivity"].values[-1] for run in (first, second))
    size = np.abs(after).max() * np.abs(before).max()
    assert np.abs(after @ before - whole["tangent"].values[-1]).max() < 1e-12 * size
    size = np.abs(after).max() * np.abs(moved).max() + np.abs(since).max()
    assert np.abs(after @ moved + since - whole["sensitivity"].values[-1]).max() < 1e-12 * size


def ranks(matrices):
    """Numbers of singular values above 1e-12 of the largest."""
    values = np.linalg.svd(matrices, compute_uv=False)
    return (values > 1e-12 * values[:, :1]).sum(axis=1)


@pytest.mark.parametrize("twin", TWINS)
@pytest.mark.parametrize(("b", "xi"), [(0.3, 0.2), (0.15, 0.05), (0.15, 1.0)])
def test_contact_takes_the_mole_a_dimension(twin, b, xi):
    """From the first contact on p is bound to q; v only travels, so it keeps its own direction."""
    run, _ = run_of("mole", twin, np.linspace(0.0, 80.0, 161), b=b, xi=xi)
    tangent = run["tangent"]
    names = run["mode"].attrs["flag_meanings"].split()
    modes = np.array([names[m] for m in run["mode"].values])
    first = run["event_time"].values[1]
    assert {"no_contact", "contact", "progression"} <= set(modes[run["time"].values > first])
    after = tangent.isel(time=run["time"].values > first)
    assert (ranks(after.values) <= 3).all()
    relative = after.sel(state=["p", "y", "q"], state_0=["p", "y", "q"])
    assert (ranks(relative.values) <= 2).all()
    bound = (run["time"].values > first) & (modes != "no_contact")
    rows = tangent.isel(time=bound)
    assert np.array_equal(rows.sel(state="p").values, rows.sel(state="q").values)
    drift = tangent.sel(state_0="v").values
    assert np.array_equal(drift, np.broadcast_to([0.0, 0.0, 0.0, 1.0], drift.shape))


@pytest.mark.parametrize("twin", TWINS)
def test_the_gap_moves_the_mole_that_rests_on_its_slider(twin):
    """p = q + g in contact, so p moves by one more than q with g."""
    system = system_of("mole")
    system = taylor_twin(system) if twin else system
    run = ns.simulate(system, start_of("mole"), times=[1.0, 2.0, 13.0], tangent=["g"])
    by_gap = run["sensitivity"].sel(parameter_0="g")
    assert np.allclose(by_gap.sel(state="p") - by_gap.sel(state="q"), 1.0, rtol=0, atol=1e-12)
