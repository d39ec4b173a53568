"""Rebounds that accumulate under an acceleration that varies, against a 40-digit automaton.

`reference.resting` follows every rebound down to a speed of 1e-25: for r = 0.99 some 5000.
"""

import numpy as np
import pytest

import nonsmooth as ns
from contract.contact_systems import ACCUMULATIONS, TANGENTS, start_of, system_of
from contract.taylor_twin import taylor_twin

RUNS = {**ACCUMULATIONS, **{name: TANGENTS[name] for name in ("wall", "platform", "table")}}
CUBIC = ["wall, cubic"]  # Taylor by itself
CASES = [*RUNS, *CUBIC, *(f"{name} by Taylor series" for name in RUNS)]
ALL = {**RUNS, **{name: TANGENTS[name] for name in CUBIC}}


def name_of(case):
    return case.removesuffix(" by Taylor series")


@pytest.fixture(scope="module")
def run_of():
    """Each run once."""
    found = {}

    def get(case):
        if case not in found:
            name = name_of(case)
            system = system_of(name) if case == name else taylor_twin(system_of(name), -1)
            found[case] = ns.simulate(system, start_of(name), times=ALL[name]["times"])
        return found[case], ALL[name_of(case)]

    return get


def rows_of(run, kind):
    return run.isel(event=run["event_kind"].values == kind)


def expected(truth, kind):
    """Changes of mode onto the contact, or off it."""
    starts = truth["mode"]
    return [c for c in truth["changes"] if (c["from"] == starts) == (kind == "chatter")]


@pytest.mark.parametrize("case", CASES)
def test_rest_and_release_are_those_of_all_rebounds(case, run_of):
    """Which stays there are, when they end, and the states at the samples, in rest and behind it.

    1e-12: roundings of a few hundred impacts, which impacts take back by r as often.
    """
    run, truth = run_of(case)
    assert run.attrs["status"] == "completed"
    for kind in ("chatter", "release"):
        assert rows_of(run, kind).sizes["event"] == len(expected(truth, kind))
    ends = [float(change["t"]) for change in expected(truth, "release")]
    assert np.allclose(rows_of(run, "release")["event_time"], ends, rtol=1e-12, atol=0)
    samples = np.array(truth["samples"], float)
    found = np.array([run[name].values for name in truth["states"]]).T
    assert np.allclose(found, samples, rtol=0, atol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_accumulation_time_to_twelve_digits(case, run_of):
    run, truth = run_of(case)
    found = rows_of(run, "chatter")["event_time"].values
    ends = [float(change["t"]) for change in expected(truth, "chatter")]
    assert np.allclose(found, ends, rtol=1e-12, atol=0)


MOVING = [name for name in RUNS if name in ("wall", "platform") or "table" in name]


@pytest.mark.parametrize("case", MOVING)
def test_states_at_the_accumulation(case, run_of):
    run, truth = run_of(case)
    after = [[float(x) for x in change["after"]] for change in expected(truth, "chatter")]
    assert np.allclose(rows_of(run, "chatter")["state_after"], after, rtol=0, atol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_states_in_contact_are_on_it(case, run_of):
    """Whatever moves, the contact is closed to the last digit from the accumulation on."""
    run, truth = run_of(case)
    rows = rows_of(run, "chatter")
    after = dict(zip(truth["states"], rows["state_after"].values.T, strict=True))
    p, name = truth["parameters"], name_of(case)
    if "table" in name:
        angle = p["omega"] * (rows["event_time"].values - 2e-6)
        assert np.allclose(after["x"], p["A"] * np.sin(angle), rtol=0, atol=2e-4 * p["A"])
    elif name == "platform":
        assert after["x"].tolist() == after["y"].tolist()
        assert after["v"].tolist() == after["w"].tolist()
        assert np.all(after["v"] != 0.0)
    else:
        assert np.all(after["x"] == p["sigma"])
        assert np.all(after["v"] == 0.0)


@pytest.mark.parametrize("case", CASES)
def test_the_count_is_that_of_rebounds_in_the_log(case, run_of):
    run, _ = run_of(case)
    kinds = run["event_kind"].values.tolist()
    for k, kind in enumerate(kinds):
        if kind == "chatter":
            first = k
            while kinds[first - 1] == "impact":
                first -= 1
            assert int(run["event_count"].values[k]) == k - first + 1


def test_a_ball_that_is_quick_still_bounces():
    """From 1e-12 under 1 it lands after 1.4e-6 and bounces up to r^2 of that; then it rests."""
    impact = ns.Exit("x", reset={"v": "-r*v"}, sticks="rest")
    mode = ns.Mode({"x": "v", "v": "-1"}, exits=[impact])
    ball = ns.System(states=["x", "v"], parameters={"r": 0.5}, modes={"flight": mode})
    fall = np.sqrt(2e-12)
    run = ns.simulate(ball, {"x": 1e-12}, times=[fall, 1.5 * fall, 4 * fall])
    assert run["event_kind"].values.tolist()[:2] == ["start", "impact"]
    assert run["x"].values[1] == pytest.approx(0.25e-12, rel=1e-10)
