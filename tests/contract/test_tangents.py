"""Tangents and sensitivities against central differences of runs with 40 digits.

1e-10 of the largest entry of the matrix, and of each column where the columns differ in size:
above what rounding leaves (1e-15 times the growth, carried through a handful of events),
far below what a wrong or missing saltation term does. States: 1e-11 times the growth.
"""

import numpy as np
import pytest

import nonsmooth as ns
from contract.tangent_systems import LINEAR, RUNS, start_of, system_of
from contract.taylor_twin import taylor_twin

CASES = [*RUNS, *(f"{name}, Taylor" for name in LINEAR)]
TOLERANCE = 1e-10


def run_of(case, **options):
    """The run of the package; a linear system runs a second time as its Taylor twin."""
    name, _, twin = case.partition(", ")
    system = taylor_twin(system_of(name)) if twin else system_of(name)
    if twin:
        options = {"tangent": list(RUNS[name]["parameters"]), **options}
    return ns.simulate(
        system, start_of(name), **{"times": RUNS[name]["times"], "tangent": True, **options}
    )


@pytest.fixture(scope="module")
def runs():
    """Each run once."""
    found = {}

    def get(case):
        if case not in found:
            found[case] = run_of(case)
        return found[case], RUNS[case.partition(", ")[0]]

    return get


def growth(truth):
    """The largest entry of the tangents up to each sample, 1 at least."""
    sizes = np.abs(np.array(truth["tangent"], float)).max(axis=(1, 2))
    return np.maximum(1.0, np.maximum.accumulate(sizes))


def assert_columns(found, expected):
    """Matrix by matrix, and column by column where a column is not small beside the others."""
    assert found.shape == expected.shape
    for k, (a, b) in enumerate(zip(found, expected, strict=True)):
        whole = np.abs(b).max()
        columns = np.maximum(np.abs(b).max(axis=0), 1e-3 * whole)
        error = np.abs(a - b)
        assert error.max() <= TOLERANCE * whole, k
        assert (error.max(axis=0) <= TOLERANCE * columns).all(), k


@pytest.mark.parametrize("case", CASES)
def test_tangents_by_initial_states(case, runs):
    run, truth = runs(case)
    assert run["tangent"].dims == ("time", "state", "state_0")
    assert list(run["state_0"].values) == truth["states"]
    assert_columns(run["tangent"].values, np.array(truth["tangent"], float))


@pytest.mark.parametrize("case", CASES)
def test_sensitivities_by_parameters(case, runs):
    run, truth = runs(case)
    assert run["sensitivity"].dims == ("time", "state", "parameter_0")
    assert list(run["parameter_0"].values) == list(truth["parameters"])
    assert_columns(run["sensitivity"].values, np.array(truth["sensitivity"], float))


@pytest.mark.parametrize("case", CASES)
def test_states_and_events(case, runs):
    run, truth = runs(case)
    assert run.attrs["status"] == "completed"
    assert run.attrs["n_uncertain"] == 0
    states = np.stack([run[name].values for name in truth["states"]], axis=1)
    expected = np.array(truth["samples"], float)
    allowed = 1e-11 * growth(truth)[:, None] * np.maximum(1.0, np.abs(expected))
    assert (np.abs(states - expected) < allowed).all()
    names = run["event_to"].attrs["flag_meanings"].split()
    events = run.isel(event=run["event_kind"].values != "start")
    assert [names[m] for m in events["event_from"].values] == [e["from"] for e in truth["events"]]
    assert [names[m] for m in events["event_to"].values] == [e["to"] for e in truth["events"]]
    assert [path.count(">") + 1 for path in events["event_path"].values] == [
        e["n_exits"] for e in truth["events"]
    ]
    times, rates = (np.array([float(e[k]) for e in truth["events"]]) for k in ("t", "guard_rate"))
    late = 1e-11 * growth(truth)[-1]
    assert (np.abs(events["event_time"].values - times) < late / np.minimum(1, abs(rates))).all()
    assert np.allclose(events["guard_rate"].values, rates, rtol=0, atol=10 * late)


@pytest.mark.parametrize("case", CASES)
def test_a_tangent_does_not_change_the_run(case, runs):
    run, truth = runs(case)
    bare = run_of(case, tangent=False)
    assert "tangent" not in bare
    for name in (*truth["states"], "event_time", "end_state", "anchor_state"):
        assert np.array_equal(bare[name].values, run[name].values), name


@pytest.mark.parametrize("case", CASES)
def test_choice_of_parameters(case, runs):
    run, truth = runs(case)
    chosen = list(truth["parameters"])[::-2]
    some = run_of(case, tangent=chosen)
    assert list(some["parameter_0"].values) == chosen
    size = np.abs(run["sensitivity"].values).max()
    difference = some["sensitivity"] - run["sensitivity"].sel(parameter_0=chosen)
    assert np.abs(difference.values).max() <= 1e-12 * size
    none = run_of(case, tangent=[])
    assert "sensitivity" not in none
    assert np.allclose(none["tangent"], run["tangent"], rtol=0, atol=1e-12 * growth(truth)[-1])


@pytest.mark.few(1)
@pytest.mark.parametrize("case", CASES)
def test_a_run_with_tangents_is_saved_whole(case, runs, tmp_path):
    import xarray as xr

    run, _ = runs(case)
    run.to_netcdf(tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc") as loaded:
        assert loaded.identical(run)


@pytest.mark.parametrize("curved", ["", " + 0*x**3"])
def test_a_start_on_a_wall_that_throws_it_at_once(curved):
    """Starts beside the wall meet it a little later: differences of the closed form tell.

    A ball at the height h with the speed v < 0 and no gravity, h = 0: thrown up with -r v at once.
    From h > 0 it flies h/|v| first, so x(t) = -r v (t + h/v) and dx/dh = -r, dx/dv = -r t.
    """
    ball = ns.System(
        states=["x", "v"],
        parameters={"r": 0.8},
        modes={
            "flight": ns.Mode(
                {"x": f"v{curved}", "v": "0"},
                exits=[ns.Exit("x", reset={"v": "-r*v"}, name="impact")],
            )
        },
    )
    run = ns.simulate(ball, {"x": 0.0, "v": -1.5}, times=[0.0, 2.0], tangent=True)
    expected = [[-0.8, -0.8 * 2.0], [0.0, -0.8]]
    np.testing.assert_allclose(run["tangent"].values[-1], expected, atol=1e-13)
    np.testing.assert_allclose(run["sensitivity"].values[-1].ravel(), [3.0, 1.5], atol=1e-13)


def test_a_start_at_the_tick_of_a_clock():
    """The flow keeps its own rate: M f(x0) = f(x(t)), here (0, 1) for both."""
    clock = ns.System(
        states=["x", "tau"],
        parameters={"T": 1.0},
        modes={
            "wait": ns.Mode(
                {"x": "0", "tau": "1"},
                exits=[ns.Exit("T - tau", reset={"x": "3*x", "tau": "0"}, name="tick")],
            )
        },
    )
    run = ns.simulate(clock, {"x": 0.3, "tau": 1.0}, times=[1.3], tangent=True)
    np.testing.assert_allclose(run["tangent"].values[-1], [[9.0, 0.0], [0.0, 1.0]], atol=1e-13)
    # tau(1.3) = tau0 + 1.3 - 2 T, of starts below the tick
    np.testing.assert_allclose(run["sensitivity"].values[-1].ravel(), [0.0, -2.0], atol=1e-13)
