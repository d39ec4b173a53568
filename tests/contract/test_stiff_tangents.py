"""Derivatives along directions that the motion itself no longer shows."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import System

DUFFING = "-0.2*v + x - x**3 + 0.3*cos(t)"


@pytest.mark.parametrize("rate", [30.0, 300.0, 3000.0])
def test_a_relaxed_direction_beside_a_nonlinear_motion(rate):
    """w' = -rate w + x is linear in w: its derivative by itself is exp(-rate t), whatever x does.

    The Taylor steps follow the slow motion, some thousand time constants of w each.
    """
    system = System(
        states=["x", "v", "w"],
        parameters={"k": rate},
        period="2*pi",
        equations={"x": "v", "v": DUFFING, "w": "x - k*w"},
    )
    settled = ns.simulate(system, {"x": 0.5, "w": 0.5 / rate}, periods=2)
    times = np.array([0.5, 2.0, 6.0, 15.0]) / rate
    begin = settled.isel(time=-1)
    late = float(settled["time"][-1])
    run = ns.simulate(system, begin, times=late + times, tangent=[])
    found = run["tangent"].sel(state="w", state_0="w").values
    assert found == pytest.approx(np.exp(-rate * times), rel=1e-9)


def test_a_fast_contraction_of_a_nonlinear_state():
    """y' = -200 (y - sin x) beside x' = cos x: dy/dx0 against a run in many short pieces."""
    system = System(states=["x", "y"], equations={"x": "cos(x)", "y": "-200*(y - sin(x))"})
    start = {"x": 0.3, "y": float(np.sin(0.3))}
    whole = ns.simulate(system, start, times=[0.4], tangent=[])["tangent"].values[-1]
    product, state = np.eye(2), start
    for _ in range(200):
        piece = ns.simulate(system, state, times=[0.002], tangent=[])
        product = piece["tangent"].values[-1] @ product
        state = {name: float(piece[name][-1]) for name in ("x", "y")}
    assert whole == pytest.approx(product, rel=1e-9, abs=1e-13)
