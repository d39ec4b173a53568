"""Long periods, ties, rest, no gap, stiff contacts: where a search or a split may fail."""

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from nonsmooth import Mode, RunWarning, System
from nonsmooth.runs.runner import build_tables


def test_a_chain_keeps_its_digits_however_long_the_period():
    """Eigenvalues 0.2 to 1 apart, couplings of 300: at t = 1/300 they are all but equal."""
    matrix = np.diag([-1.1, -2e-4, -0.3, -0.03, -0.9, -0.5]) + 300.0 * np.eye(6, k=1)
    for period in (1e2, 1e3, 1e4):
        system = System.from_matrices(matrix, period=period)
        run = ns.simulate(system, dict.fromkeys(system.states, 1.0), times=[1 / 300, 1.0])
        for k, time in enumerate(run["time"].values):
            with mp.workdps(40):
                exact = mp.expm(mp.matrix(matrix.tolist()) * mp.mpf(time)) * mp.ones(6, 1)
            # the entries of the exponential are positive but for decays of at most e^1.1
            assert float(run["x1"][k]) == pytest.approx(float(exact[0]), rel=1e-13)


def test_slow_forcing_over_one_long_period():
    # quasi-static: x = cos(w t) up to damping times speed, 0.04 w, once the start has decayed
    w = 6.283e-7
    flow = {"x": "v", "v": "-x - 0.04*v + cos(w*t)"}
    mode = Mode(flow, exits=[ns.Exit("5 - x", to="stop")])
    system = System(states=["x", "v"], parameters={"w": w}, period="2*pi/w", modes={"m": mode})
    run = ns.simulate(system, {"x": -1.0}, times=[0.0, 1e6, 1e7])
    assert run.attrs["status"] == "completed"
    assert np.allclose(run["x"][1:], np.cos(w * run["time"].values[1:]), rtol=0, atol=0.04 * w)


@pytest.mark.parametrize("apart", [0.0, 1e-16, 5e-16])
def test_crossings_whose_order_rounding_decides_are_flagged(apart):
    """x = sin t reaches 1/2 when y = 3 sin t reaches 3/2, or a rounding before it."""
    still = {k: "0" for k in "xvyu"}
    exits = [ns.Exit("0.5 - x", to="P"), ns.Exit("1.5*(1 - apart) - y", to="Q")]
    flow = {"x": "v", "v": "-x", "y": "u", "u": "-y"}
    system = System(
        states=list("xvyu"),
        parameters={"apart": apart},
        modes={"m": Mode(flow, exits=exits), "P": Mode(still), "Q": Mode(still)},
    )
    run = ns.simulate(system, {"v": 1.0, "u": 3.0}, t_end=2.0)
    assert float(run["event_time"][1]) == pytest.approx(np.pi / 6, abs=1e-14)
    assert run.attrs["n_uncertain"] == 1


def test_a_mass_that_comes_to_rest_on_its_stop_ends_as_accumulating_impacts():
    exits = [ns.Exit("0.1 - x", reset={"v": "-0.2*v"})]
    mode = Mode({"x": "v", "v": "-x - 0.4*v + cos(0.5*t)"}, exits=exits)
    system = System(states=["x", "v"], period="4*pi", modes={"m": mode})
    with pytest.warns(RunWarning, match="impacts accumulate"):
        assert ns.simulate(system, {"x": -1.0}, periods=10).attrs["status"] == "event_limit"


def test_the_mole_may_have_no_gap():
    """Without a gap mass and slider meet where both are at rest, at 1e-200 of a unit."""
    run = ns.simulate(ns.models.moling(g=0.0), periods=20)
    assert run.attrs["status"] == "completed"
    # rest, p = q + g, to rounding of positions of order one
    assert np.all((run["q"] - run["p"]).values > -1e-14)


def test_a_stiff_damped_contact_does_not_shorten_steps():
    """A pair at -3e4 +- 3e4 i is gone at once; what lasts sets the ladder and the segments."""
    flow = {"x": "v", "v": "-x + cos(t)", "y": "u", "u": "-1.8e9*y - 6e4*u + v"}
    system = System(states=list("xvyu"), period="2*pi", modes={"m": Mode(flow)})
    spans = build_tables(system).spans[0]
    assert spans["rung"] > 1.0
    assert spans["longest"] > 4 * np.pi
