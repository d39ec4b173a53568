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


def wing(u: float) -> ns.System:
    """Plunge and pitch of a wing with freeplay d of its pitch, in a wind of speed u."""
    inverse = np.linalg.inv([[1.0, 0.25], [0.25, 0.6]]).tolist()
    lift = "(-(0.02 + 0.3*U)*hd - 0.1*U*ad - h - 0.6*U**2*a)"
    moment = "(0.1*U*hd - (0.02 + 0.2*U)*ad + 0.25*U**2*a - 4*(a - clip(a, -d, d)))"
    first, second = (f"({row[0]})*{lift} + ({row[1]})*{moment}" for row in inverse)
    return ns.System(
        name="wing", states=["h", "a", "hd", "ad"], parameters={"U": u, "d": 0.1},
        equations={"h": "hd", "a": "ad", "hd": first, "ad": second},
    )  # fmt: skip


def rests_by_scipy(u: float, start: list[float]) -> bool:
    """Whether a wing rests at last where 4 (a - d) = 0.25 U^2 a, or at the point across."""

    def rates(t, y):
        h, a, hd, ad = y
        moment = 0.1 * u * hd - (0.02 + 0.2 * u) * ad + 0.25 * u**2 * a
        moment -= 4.0 * (a - np.clip(a, -0.1, 0.1))
        lift = -(0.02 + 0.3 * u) * hd - 0.1 * u * ad - h - 0.6 * u**2 * a
        return [hd, ad, *np.linalg.solve([[1.0, 0.25], [0.25, 0.6]], [lift, moment])]

    end = solve_ivp(rates, (0.0, 400.0), start, rtol=1e-10, atol=1e-12, method="DOP853").y[:, -1]
    a = 4.0 * 0.1 / (4.0 - 0.25 * u**2)
    return bool(np.allclose(np.abs(end), [0.6 * u**2 * a, a, 0.0, 0.0], rtol=0.0, atol=1e-6))


@pytest.mark.slow
@pytest.mark.parametrize("u", [1.3, 1.4, 1.5])
@pytest.mark.filterwarnings("ignore::nonsmooth.ResultWarning")
def test_a_rest_on_the_section_crosses_it_by_rounding_alone(u):
    """Pitch rests where ad = 0. No such motion is one of period one."""
    section = ns.PoincareMap(wing(u), "ad", direction=-1)
    pitch, none = np.array([-0.31, 0.13, 0.15, 0.17, 0.35]), {"hd": 0.0, "ad": 0.0}
    found = ns.basins_of_attraction(
        section, {"a": pitch, "h": [0.0, 0.02]}, completion=none, samples=20
    )
    cycle = found["points"].values[:, 0, 1]
    assert np.all(np.abs(cycle - 0.4 / (4.0 - 0.25 * u**2)) > 0.01)
    rests = [[rests_by_scipy(u, [h, a, 0.0, 0.0]) for a in pitch] for h in (0.0, 0.02)]
    labels = found["label"].transpose("h", "a").values
    assert np.any(rests) and not np.all(rests)
    assert (labels < 0).tolist() == rests


def test_points_of_a_motion_that_comes_to_rest_on_its_section():
    """Rounding leads it across for ever; the list of its points ends."""
    section = ns.PoincareMap(wing(1.4), "ad", direction=-1)
    with pytest.warns(ns.RunWarning, match="comes to rest on the section"):
        at = section.iterate({"a": 0.15}, 300)
    assert at.attrs["status"] == "at_rest" and at.sizes["point"] < 100
