"""The fatigue rig of `examples/fatigue_rig.toml` against 50 digits and against scipy.

Tolerance 1e-12: some hundred operations of 1e-16 per segment and at most a few dozen segments
of a motion that contracts.
"""

import tomllib

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.integrate import solve_ivp

import nonsmooth as ns
from contract.rig import DIGITS, FILE, automaton, rig
from reference.hybrid import hybrid_run
from reference.modal import first_crossing

STATES = [f"X{i}" for i in range(1, 6)]
FIGURE_25 = {"eta": 2.5, "lambda_1": 4.36, "lambda_2": 4.36, "f1": 5.44, "f2": 3.52}


def names(run):
    return run["event_to"].attrs["flag_meanings"].split()


def crossings(run):
    return run.isel(event=run["event_kind"].values != "start")


def compare(system, periods):
    """Events and final state of a run from rest against the automaton at 50 digits."""
    p = system.parameter_values
    with mp.workdps(DIGITS):
        end = 2 * mp.pi / mpf(p["eta"]) * periods
        true = hybrid_run(automaton(p), [0] * 5 + [1, 0, 1], "both", end, search=first_crossing)
    run = ns.simulate(system, periods=periods, samples_per_period=1)
    assert run.attrs["status"] == "completed"
    assert run.attrs["n_uncertain"] == 0
    events = crossings(run)
    assert [names(run)[int(m)] for m in events["event_to"]] == [e.mode_to for e in true.events]
    assert len(true.events) >= 2 * periods
    times = np.array([float(e.time) for e in true.events])
    assert np.max(np.abs(events["event_time"].values - times)) < 1e-12
    found = np.array([float(run[name][-1]) for name in STATES])
    assert np.max(np.abs(found - [float(x) for x in true.state[:5]])) < 1e-12
    return true


@pytest.mark.slow
def test_first_period_from_rest_has_all_four_phases():
    true = compare(rig(), 1)
    assert {e.mode_to for e in true.events} == {"both", "mass_1", "mass_2", "none"}


@pytest.mark.slow
def test_other_loads_and_frequency():
    compare(rig(**FIGURE_25), 1)


@pytest.mark.slow
def test_five_periods():
    compare(rig(), 5)


@pytest.mark.parametrize("changes", [{}, FIGURE_25])
def test_rest_is_an_equilibrium_of_the_unforced_rig(changes):
    system = rig(**changes)
    start = ns.simulate(system, times=[0.0])
    sizes = max(system.parameter_values["f1"], system.parameter_values["f2"])
    for output in ("acceleration_1", "acceleration_2"):
        assert abs(float(start[output][0])) < 1e-14 * sizes
    assert float(start["force_1"][0]) > 0
    assert float(start["force_2"][0]) > 0
    with mp.workdps(DIGITS):
        rows = automaton(system.parameter_values)["both"].matrix
        for row in rows[:5]:
            assert abs(row[5] + row[7]) < mpf(10) ** -50 * max(map(abs, row))


def test_contact_forces_vanish_and_nothing_jumps_at_events():
    run = ns.simulate(rig(), periods=30)
    events = crossings(run)
    before, after = events["state_before"].values, events["state_after"].values
    # the state is put onto the guard, whose value is zero up to rounding
    assert np.max(np.abs(before - after)) < 1e-14
    assert run.attrs["n_uncertain"] == 0


def test_scipy_agrees():
    """Radau with the switch functions inside the field: stiff, unaware of events."""
    system = rig()
    p = system.parameter_values
    with mp.workdps(DIGITS):
        modes = automaton(p)
        matrices = {
            name: np.array([[float(x) for x in row] for row in mode.matrix])
            for name, mode in modes.items()
        }
        h1 = np.array([float(x) for x in modes["both"].exits[0].guard])
        h2 = np.array([float(x) for x in modes["both"].exits[1].guard])
    words = {(True, True): "both", (True, False): "mass_1", (False, True): "mass_2"}

    def field(_, z):
        return matrices[words.get((h1 @ z > 0, h2 @ z > 0), "none")] @ z

    end = 2 * np.pi / p["eta"]
    start = np.array([0.0] * 5 + [1, 0, 1])
    other = solve_ivp(field, (0, end), start, method="Radau", rtol=1e-8, atol=1e-11)
    run = ns.simulate(system, times=[0.0, end])
    found = np.array([float(run[name][-1]) for name in STATES])
    # Radau takes the kinks of the field in small steps; 100 times its tolerance is left over
    assert np.max(np.abs(found - other.y[:5, -1])) < 1e-6


def test_file_and_system_say_the_same():
    words = tomllib.loads(FILE.read_text(encoding="utf-8"))
    assert tomllib.loads(rig().to_toml()) == words
    if hasattr(ns.System, "from_toml"):
        assert ns.System.from_toml(FILE.read_text(encoding="utf-8")) == rig()
