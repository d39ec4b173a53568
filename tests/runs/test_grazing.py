"""Guards that touch zero, or nearly: right, or flagged, and never with large consequences."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System
from runs.flows import EPS, crossings, on_both_flows

FLOW = {"y": "v", "v": "2"}
IMPACT = System(
    states=["y", "v"], modes={"m": Mode(FLOW, exits=[Exit("y", reset={"v": "-0.9*v"})])}
)
SWITCH = System(
    states=["y", "v"],
    modes={
        "above": Mode(FLOW, exits=[Exit("y", to="below")]),
        "below": Mode(FLOW, exits=[Exit("-y", to="above")]),
    },
)
STOP = System(states=["y", "v"], modes={"m": Mode(FLOW, exits=[Exit("y", to="stop")])})

# y = (t - 1)^2 - eps. The terms of y add up to 4 at t = 1, and the margins of the two flows are
# below 4 * 4 * 32 eps = 1e-13 and 5e-13.
MARGIN = 2e-12


def parabola(system, eps):
    return ns.simulate(system, {"y": 1.0 - eps, "v": -2.0}, times=[3.0])


@on_both_flows
@pytest.mark.parametrize("eps", [1e-8, 1e-9, 1e-10, 1e-11])
def test_a_shallow_dip_is_found_and_certified(flow, eps):
    run = parabola(flow(SWITCH), eps)
    depth = 1.0 - (1.0 - eps)  # as rounded
    expected = 1.0 + np.sqrt(depth) * np.array([-1.0, 1.0])
    assert bool(run["certified"].all())
    assert run["event_to"].values.tolist() == [0, 1, 0]
    # values have errors of some units of 4, the rate is 2 sqrt(depth)
    error = np.abs(run["event_time"].values[1:] - expected)
    assert np.all(error < 20 * EPS / np.sqrt(depth))


@on_both_flows
@pytest.mark.parametrize("eps", [1e-12, 1e-13, 1e-14, 1e-15])
@pytest.mark.parametrize("system", [IMPACT, SWITCH, STOP], ids=["impact", "switch", "stop"])
def test_a_dip_within_rounding_is_found_or_flagged(flow, system, eps):
    run = parabola(flow(system), eps)
    log = crossings(run)
    depth = 1.0 - (1.0 - eps)
    first = float(log["event_time"][0])
    # nothing is decided where |y| is above the margin
    assert abs(first - 1.0) < np.sqrt(depth + MARGIN)
    if bool(log["certified"].all()):
        assert first == pytest.approx(1.0 - np.sqrt(depth), abs=MARGIN / np.sqrt(depth))
    else:
        assert run.attrs["n_uncertain"] > 0


@on_both_flows
@pytest.mark.parametrize("system", [IMPACT, SWITCH, STOP], ids=["impact", "switch", "stop"])
@pytest.mark.parametrize("eps", [0.0, -1e-16, -1e-15])
def test_a_touch_is_a_graze_and_the_run_goes_on(flow, system, eps):
    run = parabola(flow(system), eps)
    assert run.attrs["status"] == "completed"
    log = crossings(run)
    assert log["event_kind"].values.tolist() == ["graze"]
    assert log["certified"].values.tolist() == [False]
    assert log["event_from"].values.tolist() == log["event_to"].values.tolist()
    assert np.array_equal(log["state_before"].values, log["state_after"].values)
    assert run.attrs["n_uncertain"] == 1
    assert float(log["event_time"][0]) == pytest.approx(1.0, abs=np.sqrt(MARGIN))
    # no impact: y(3) = 4 to rounding
    assert float(run["y"][-1]) == pytest.approx(4.0 - eps, abs=20 * EPS)


@on_both_flows
@pytest.mark.parametrize("system", [IMPACT, SWITCH, STOP], ids=["impact", "switch", "stop"])
@pytest.mark.parametrize("eps", [-1e-12, -1e-11, -1e-8])
def test_a_near_miss_is_no_event(flow, system, eps):
    run = parabola(flow(system), eps)
    assert run.attrs["status"] == "completed"
    assert run.attrs["n_events"] == 0
    assert run.attrs["n_uncertain"] == 0


@on_both_flows
def test_a_cubic_tangency_is_a_crossing(flow):
    """x = (1 - t)^3 passes zero at 1 with rate and acceleration zero, and must get through."""
    flow_text = {"x": "v", "v": "a", "a": "-6"}
    system = System(
        states=["x", "v", "a"],
        modes={
            "above": Mode(flow_text, exits=[Exit("x", to="below")]),
            "below": Mode(flow_text, exits=[Exit("-x", to="above")]),
        },
    )
    run = ns.simulate(flow(system), {"x": 1.0, "v": -3.0, "a": 6.0}, times=[3.0])
    assert run.attrs["status"] == "completed"
    assert run["event_to"].values[-1] == 1
    assert run.attrs["n_uncertain"] >= 1
    # |x| is below the margin of terms up to 8 for |t - 1| below (8 MARGIN)^(1/3)
    times = crossings(run)["event_time"].values
    assert np.all(np.abs(times - 1.0) < np.cbrt(8 * MARGIN))
    assert float(run["x"][-1]) == pytest.approx(-8.0, abs=1e-10)


@on_both_flows
@pytest.mark.parametrize(
    ("eps", "falls"), [(1e-6, True), (1e-8, True), (0.0, None), (-1e-6, False), (-1e-8, False)]
)
def test_a_quartic_touch(flow, eps, falls):
    """x = (t - 1)^4 - eps; the terms of x add up to 16 at t = 1."""
    system = System(
        states=["x", "v", "a", "j"],
        modes={"m": Mode({"x": "v", "v": "a", "a": "j", "j": "24"}, exits=[Exit("x", to="stop")])},
    )
    start = {"x": 1.0 - eps, "v": -4.0, "a": 12.0, "j": -24.0}
    run = ns.simulate(flow(system), start, times=[3.0])
    if falls is None:
        assert run.attrs["n_uncertain"] > 0
        assert np.all(np.abs(crossings(run)["event_time"].values - 1.0) < (16 * MARGIN) ** 0.25)
    elif falls:
        assert run.attrs["status"] == "stopped"
        depth = 1.0 - start["x"]
        # errors of x over its rate, 4 depth^(3/4)
        expected = 1.0 - depth**0.25
        assert float(run["event_time"][-1]) == pytest.approx(expected, abs=MARGIN / depth**0.75)
    else:
        assert run.attrs["n_events"] == run.attrs["n_uncertain"] == 0


@on_both_flows
@pytest.mark.parametrize("start", [0.0, 1.0])
@pytest.mark.parametrize("eps", [1e-9, 1e-11, 0.0, -1e-11, -1e-9])
def test_a_moving_wall_touches(flow, start, eps):
    """The wall at 2 - cos t + eps comes to a mass that rests at 1, at every turn."""
    system = System(
        states=["x", "v"],
        parameters={"eps": eps},
        modes={
            "m": Mode({"x": "v", "v": "0"}, exits=[Exit("2 + eps - cos(t) - x", to="stop")]),
        },
    )
    t_start = start + 1.0  # well before the touch at 2 pi
    run = ns.simulate(flow(system), {"x": 1.0}, t_start=t_start, t_end=9.0)
    if eps > 0.0:
        assert run.attrs["n_events"] == run.attrs["n_uncertain"] == 0
    elif eps < 0.0:
        assert run.attrs["status"] == "stopped" and run.attrs["n_uncertain"] == 0
        # 1 - cos u = -eps, and errors of a few eps of the terms over the rate sqrt(-2 eps)
        expected = 2 * np.pi - np.sqrt(-2 * eps) * (1 - eps / 12)
        error = abs(float(run["event_time"][-1]) - expected)
        assert error < 40 * EPS / np.sqrt(-2 * eps)
    else:
        assert run.attrs["n_uncertain"] == 1
        assert float(run["event_time"][-1]) == pytest.approx(2 * np.pi, abs=1e-6)


@pytest.mark.parametrize("off", [1e-6, 1e-9, 1e-11, 0.0, -1e-11, -1e-9, -1e-6])
def test_a_straight_flight_touches_a_circle(off):
    """x = t - 2, y = 1 + off: the distance from the circle is y^2 - 1 + (t - 2)^2."""
    mode = Mode({"x": "1", "y": "0"}, exits=[Exit("x**2 + y**2 - 1", to="stop")])
    run = ns.simulate(
        System(states=["x", "y"], modes={"m": mode}), {"x": -2, "y": 1 + off}, t_end=4
    )
    if off > 0.0:
        assert run.attrs["n_events"] == run.attrs["n_uncertain"] == 0
    elif off < 0.0:
        y = 1 + off
        expected = 2 - np.sqrt(1 - y * y)
        assert run.attrs["status"] == "stopped" and run.attrs["n_uncertain"] == 0
        error = abs(float(run["event_time"][-1]) - expected)
        assert error < 20 * EPS / np.sqrt(1 - y * y)
    else:
        assert run.attrs["n_uncertain"] == 1
        assert float(run["event_time"][-1]) == pytest.approx(2.0, abs=1e-5)


def test_a_circle_touched_from_inside():
    """A pendulum bob on a string of length 1 inside a circle of radius 1 about another centre.

    x = a + (1 - a) cos s, y = (1 - a) sin s touches the unit circle at s = 0 alone:
    1 - x^2 - y^2 = 2 a (1 - a)(1 - cos s).
    """
    mode = Mode({"s": "1", "u": "0"}, exits=[Exit("1 - x**2 - y**2", to="stop")])
    system = System(
        states=["s", "u"],
        parameters={"a": 0.25, "eps": 0.0},
        definitions={"x": "a + (1 - a - eps)*cos(s)", "y": "(1 - a - eps)*sin(s)"},
        modes={"m": mode},
    )
    run = ns.simulate(system, {"s": -1.0}, t_end=3.0)
    assert run.attrs["n_uncertain"] == 1
    assert float(run["event_time"][-1]) == pytest.approx(1.0, abs=1e-5)
    # g = 2 a eps near s = 0
    inside = ns.simulate(system, {"s": -1.0}, t_end=3.0, parameters={"eps": 1e-11})
    assert inside.attrs["n_events"] == inside.attrs["n_uncertain"] == 0
    outside = ns.simulate(system, {"s": -1.0}, t_end=3.0, parameters={"eps": -1e-11})
    assert (outside.attrs["status"], outside.attrs["n_uncertain"]) == ("stopped", 0)


@on_both_flows
@pytest.mark.parametrize(
    ("omega", "zeta", "sigma"), [(0.7, 0.02, 1.0), (2.8, 0.1, 0.3), (0.5, 0.3, 2.0)]
)
@pytest.mark.parametrize("more", [-1e-10, -1e-12, 0.0, 1e-15, 1e-14, 1e-12, 1e-10])
def test_a_forced_oscillator_at_its_grazing_force(flow, omega, zeta, sigma, more):
    """Steady state sigma cos(omega t - phi), at the force for which it just reaches the wall.

    With a share ``more`` of force the impact has a speed of sigma omega sqrt(2 more).
    """
    system = System(
        states=["x", "v"],
        period="2*pi/omega",
        parameters={"F": 1.0, "omega": omega, "zeta": zeta, "sigma": sigma},
        modes={
            "m": Mode(
                {"x": "v", "v": "F*cos(omega*t) - 2*zeta*v - x"},
                exits=[Exit("sigma - x", reset={"v": "-0.8*v"})],
            )
        },
    )
    force = sigma * np.hypot(1 - omega**2, 2 * zeta * omega) * (1 + more)
    lag = np.arctan2(2 * zeta * omega, 1 - omega**2)
    size = sigma * (1 + more)
    start = {"x": size * np.cos(lag), "v": size * omega * np.sin(lag)}
    run = ns.simulate(flow(system), start, periods=3, parameters={"F": force})
    assert run.attrs["status"] == "completed"
    log = crossings(run)
    if more <= -1e-12:
        assert run.attrs["n_events"] == run.attrs["n_uncertain"] == 0
        return
    # the first touch, with the phase within the reach of a margin of 1e-13 sigma
    first = log.isel(event=0)
    turn = lag / omega if lag > 0 else (lag + 2 * np.pi) / omega
    reach = np.sqrt(2 * (max(more, 0.0) + 2e-13)) / omega
    assert float(first["event_time"]) == pytest.approx(turn, abs=reach)
    assert abs(float(first["guard_rate"])) < sigma * omega * np.sqrt(2 * (max(more, 0.0) + 2e-13))
    if more < 1e-12:
        assert not bool(first["certified"])
    else:
        assert bool(log["certified"].all())
        assert log["event_kind"].values.tolist() == ["impact"] * log.sizes["event"]
        # a rate of sigma omega sqrt(2 more), with errors of 1e-15 in x
        speed = sigma * omega * np.sqrt(2 * more)
        assert abs(float(first["guard_rate"])) == pytest.approx(speed, rel=3e-15 / more + 1e-6)
