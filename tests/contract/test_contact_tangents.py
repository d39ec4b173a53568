"""Tangents and sensitivities through stick, slides and rest, against differences of 40-digit runs.

The reference steps by 1e-12 at 60 digits: its truncation is 1e-24 times a third derivative.
1e-8 is asked for; 1e-11 of the largest entry so far is what roundings of 1e-15 leave behind a
dozen events, and what is asserted. A missing or wrong saltation is off by parts of one.
"""

import numpy as np
import pytest

import nonsmooth as ns
from contract.contact_systems import TANGENTS, start_of, system_of
from contract.taylor_twin import taylor_twin

# The relay and the cubic wall are Taylor systems by themselves.
TWINS = [name for name in TANGENTS if name not in ("relay", "wall, cubic")]
CASES = [*TANGENTS, *(f"{name} by Taylor series" for name in TWINS)]
TOLERANCE = 1e-11


@pytest.fixture(scope="module")
def run_of():
    """Each run once."""
    found = {}

    def get(case):
        name = case.removesuffix(" by Taylor series")
        if case not in found:
            system = system_of(name) if case == name else taylor_twin(system_of(name), -1)
            words = {"times": TANGENTS[name]["times"], "tangent": TANGENTS[name]["moved"]}
            found[case] = ns.simulate(system, start_of(name), **words)
        return found[case], TANGENTS[name]

    return get


def close(found, expected):
    largest = np.maximum(1.0, np.maximum.accumulate(np.abs(expected).max(axis=(1, 2))))
    return np.abs(found - expected).max(axis=(1, 2)) < TOLERANCE * largest


@pytest.mark.parametrize("case", CASES)
def test_states_and_changes_of_mode(case, run_of):
    """Times and states at entry, exit, stick and release; accumulations are in `test_chatter`."""
    run, truth = run_of(case)
    assert (run.attrs["status"], run.attrs["n_uncertain"]) == ("completed", 0)
    found = np.array([run[name].values for name in truth["states"]]).T
    assert np.allclose(found, np.array(truth["samples"], float), rtol=0, atol=1e-12)
    log = run.isel(event=~np.isin(run["event_kind"].values, ["start", "impact"]))
    followed = log["event_kind"].values != "chatter"
    times = np.array([float(change["t"]) for change in truth["changes"]])
    after = np.array([[float(x) for x in change["after"]] for change in truth["changes"]])
    assert log.sizes["event"] == len(times)
    assert np.allclose(log["event_time"].values[followed], times[followed], rtol=0, atol=1e-12)
    assert np.allclose(log["state_after"].values[followed], after[followed], rtol=0, atol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_tangents_by_initial_states(case, run_of):
    run, truth = run_of(case)
    assert close(run["tangent"].values, np.array(truth["tangent"], float)).all()


@pytest.mark.parametrize("case", CASES)
def test_sensitivities_by_parameters(case, run_of):
    run, truth = run_of(case)
    assert close(run["sensitivity"].values, np.array(truth["sensitivity"], float)).all()


@pytest.mark.parametrize("case", CASES)
def test_a_tangent_does_not_change_the_run(case, run_of):
    run, truth = run_of(case)
    name = case.removesuffix(" by Taylor series")
    system = system_of(name) if case == name else taylor_twin(system_of(name), -1)
    plain = ns.simulate(system, start_of(name), times=truth["times"])
    assert plain["event_time"].values.tobytes() == run["event_time"].values.tobytes()
    assert plain["end_state"].values.tobytes() == run["end_state"].values.tobytes()


def lost(run, k):
    """Dimensions that a tangent has lost: exact zeros, seen by the rank of an exact matrix."""
    values = np.linalg.svd(run["tangent"].values[k], compute_uv=False)
    return int(np.sum(values <= 1e-15 * max(values[0], 1e-300)))


# Times in stick or rest, and behind it, with the dimensions that are lost then.
CONTRACTIONS = {
    "belt": [(2.0, 1), (6.0, 1), (20.0, 1)],
    "two brakes": [(2.0, 1)],
    "plastic wall": [(5.0, 2), (22.0, 2), (30.0, 2)],
    "wall": [(5.0, 0), (22.0, 2), (30.0, 2)],
    "platform": [(2.0, 0), (5.0, 2), (12.0, 2)],
    "table": [(2.0, 0), (9.0, 2), (12.0, 2), (16.0, 2)],
}


@pytest.mark.parametrize("name", CONTRACTIONS)
def test_contracted_directions_have_rank_zero(name, run_of):
    """A slide takes one dimension, rest two; what is behind them does not give them back.

    Multipliers there are zero: to rounding of the last digit of the others where columns are
    combined, exactly where they are columns of the states that are held.
    """
    run, truth = run_of(name)
    for time, expected in CONTRACTIONS[name]:
        assert lost(run, truth["times"].index(time)) == expected, time


def test_single_contacts_forget_their_start_exactly(run_of):
    """A ball at rest on its table has no memory: its tangent is zero, not small, and stays zero."""
    for case in ("table", "table by Taylor series"):
        run, truth = run_of(case)
        rest = [k for k, time in enumerate(truth["times"]) if time > 7.0]
        assert np.all(run["tangent"].values[rest] == 0.0)
    for name in ("oscillator", "damped oscillator"):
        run = ns.simulate(system_of(name), start_of(name), times=[24.0, 30.0], tangent=[])
        assert np.all(run["tangent"].values == 0.0)


def test_held_states_have_zero_rows_exactly(run_of):
    """In stick the speed of the block is that of the belt; in rest position and speed are held."""
    run, truth = run_of("belt")
    stick = truth["modes"].index("stick")
    assert np.all(run["tangent"].values[stick, 1] == 0.0)
    run, truth = run_of("wall")
    stuck = truth["modes"].index("stuck")
    assert np.all(run["tangent"].values[stuck, :2] == 0.0)
    run, truth = run_of("platform")
    riding = truth["modes"].index("riding")
    rows = run["tangent"].values[riding]
    assert np.array_equal(rows[0], rows[2])
    assert np.array_equal(rows[1], rows[3])
