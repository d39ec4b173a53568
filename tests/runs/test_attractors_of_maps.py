"""Attractors of return maps: what the runner of a section tells an analysis."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from runs.balls import logistic_ball, rigid_wall


@pytest.mark.parametrize("side", ["before", "after"])
def test_cycles_of_the_logistic_map(side):
    """The multiplier of the cycle of two is 4 + 2 a - a^2."""
    speeds = (0.1, 0.9) if side == "after" else (-0.9, -0.1)
    hit = ns.PoincareMap(logistic_ball(a=3.2), "impact", side=side)
    found = ns.attractors(hit, {"u": speeds, "h": (0.0, 0.2)}, samples=16)
    assert found["period"].values.tolist() == [2]
    assert found["word"].values.tolist() == ["flight flight"]
    largest = found["multiplier_real"].values[0, 0]
    assert largest == pytest.approx(4.0 + 2.0 * 3.2 - 3.2**2, abs=1e-10)


def test_the_limit_cycle_of_van_der_pol():
    """Liouville: the multiplier is exp of the divergence, integrated around the cycle."""
    m = 0.8
    system = ns.System(
        states=["x", "v"], parameters={"m": m}, equations={"x": "v", "v": "m*(1 - x**2)*v - x"}
    )
    found = ns.attractors(
        ns.PoincareMap(system, "v", direction=-1), {"x": (-2, 2), "v": (-2, 2)}, samples=16
    )
    assert found["period"].values.tolist() == [1]
    start = [*found["points"].values[0, 0], 0.0]

    def rates(t, y):
        return [y[1], m * (1 - y[0] ** 2) * y[1] - y[0], m * (1 - y[0] ** 2)]

    def top(t, y):
        return y[1] if t > 1.0 else -1.0

    top.terminal, top.direction = True, -1
    run = solve_ivp(rates, (0, 20), start, method="DOP853", events=top, rtol=1e-12, atol=1e-13)
    assert run.y[0, -1] == pytest.approx(start[0], abs=1e-9)
    assert found["multiplier_real"].values[0, 0] == pytest.approx(np.exp(run.y[2, -1]), rel=1e-8)


@pytest.mark.parametrize(
    ("section", "side"), [("impact", "before"), ("impact", "after"), ("h - 0.01", "before")]
)
def test_images_of_a_point(section, side):
    """The same as of `iterate` and `tangent`, one point after the other."""
    cross = ns.PoincareMap(logistic_ball(a=3.9), section, side=side, direction=None)
    points = cross.iterate({"u": 0.3}, 6)
    first = points.isel(point=1)
    state = np.array([first["h"].item(), first["u"].item()])
    runner = cross.runner(1e-12)
    states, modes, derivative = runner.images(state, 0, 3)
    assert states[:, 1] == pytest.approx(points["u"].values[2:5], abs=1e-11)
    assert modes.tolist() == [0, 0, 0]
    assert derivative == pytest.approx(cross.tangent(first, 3).values, rel=1e-9, abs=1e-9)
    assert runner.images(np.array([-1.0, 0.0]), 0, 1) is None


def test_points_that_need_their_time():
    with pytest.raises(ns.OptionError, match="it also matters when it comes to section = 'impact'"):
        ns.attractors(ns.PoincareMap(rigid_wall(), "impact"), {"x": (-1, 0), "v": (-1, 1)})
