"""Points of results that belong to other parameters than those of the system that starts there."""

import numpy as np
import pytest

import nonsmooth as ns

MOLE = ns.models.moling()
B = {"b": 0.1}


def points():
    """A point of each kind of result, at b = 0.1."""
    branch = ns.continue_orbit(MOLE, "b", (0.1, 0.15))
    last = int(np.argmin(np.abs(branch["b"].values - 0.1)))
    diagram = ns.bifurcation_diagram(MOLE, "b", [0.1], record=3)
    lanes = ns.ensemble(MOLE, parameters={"b": [0.1, 0.15]}, record=3)
    return {
        "orbit": ns.find_orbit(MOLE, parameters=B, period=2),
        "run": ns.simulate(MOLE, periods=3, parameters=B),
        "point of a run": ns.simulate(MOLE, periods=3, parameters=B).isel(time=-1),
        "strobe": ns.stroboscopic_map(MOLE, record=3, parameters=B).isel(point=-1),
        "branch": branch.isel(point=last),
        "diagram": diagram.isel(parameter=0, lane=0, point=-1),
        "ensemble": lanes.isel(lane=0, point=-1),
    }


@pytest.mark.slow
def test_points_of_other_parameters_are_refused():
    for name, point in points().items():
        with pytest.raises(
            ns.OptionError, match=r"belongs to parameters=\{'b': .*b = 0\.15"
        ) as fault:
            ns.simulate(MOLE, point, periods=1)
        assert "parameters={}" in str(fault.value), name
        with pytest.raises(ns.OptionError, match="repeat parameters="):
            ns.regime(MOLE, point)


def test_they_start_where_parameters_agree():
    for name, point in points().items():
        value = {"b": float(point["b"])} if name == "branch" else B
        runs = [
            ns.simulate(MOLE, point, periods=1, parameters=value),
            ns.simulate(MOLE.with_parameters(**value), point, periods=1),
        ]
        for run in runs:
            assert run.attrs["status"] == "completed"
        assert np.array_equal(runs[0]["y"].values, runs[1]["y"].values), name
        own = ns.simulate(MOLE, point, periods=1, parameters={})
        assert not np.array_equal(own["y"].values, runs[0]["y"].values), name


def test_an_orbit_is_a_guess_at_other_parameters():
    orbit = ns.find_orbit(MOLE, parameters={"b": 0.14})
    assert ns.find_orbit(MOLE, orbit).attrs["status"] == "completed"
    run = ns.simulate(MOLE, periods=3, parameters=B)
    with pytest.raises(ns.OptionError, match="repeat parameters="):
        ns.find_orbit(MOLE, run)


def test_names_of_results_are_no_parameters():
    """An orbit tells its ``length``, which may be a parameter as well."""
    pendulum = ns.System(
        states=["x", "v"],
        parameters={"length": 1.0},
        period="2*pi",
        equations={"x": "v", "v": "-x/length - 0.2*v + cos(t)/2"},
    )
    orbit = ns.find_orbit(pendulum)
    assert ns.simulate(pendulum, orbit, periods=1).attrs["status"] == "completed"


def test_a_run_from_an_orbit_begins_in_the_mode_of_the_orbit():
    """Behind its kick a pendulum clock is at x = 0, but for rounding on either side of it."""
    flow = {"x": "v", "v": "-x - 2*z*v"}
    kick = ns.Exit("-x", to="right", reset={"v": "v + 0.05"}, name="tick")
    clock = ns.System(
        states=["x", "v"],
        parameters={"z": 0.02},
        modes={
            "left": ns.Mode(flow, exits=[kick]),
            "right": ns.Mode(flow, exits=[ns.Exit("x", to="left", name="down")]),
        },
    )
    for z in (0.01, 0.02, 0.03, 0.04, 0.05):
        orbit = ns.find_orbit(clock, {"x": -0.1, "v": 0.3}, mode="left", parameters={"z": z})
        run = ns.simulate(clock, orbit, t_end=1.0, parameters={"z": z})
        assert run["event_name"].values.tolist() == ["start"]
