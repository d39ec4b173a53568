"""Impacts that accumulate: the run ends there, says so, and nothing has gone through the floor."""

import re

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from nonsmooth import Exit, Mode, RunWarning, System
from runs.flows import crossings, on_both_flows


def accumulated(system, start):
    """A run that must end at accumulating impacts, after some hundreds of them."""
    with pytest.warns(RunWarning, match="impacts accumulate"):
        run = ns.simulate(system, start, t_end=100.0)
    assert run.attrs["status"] == "event_limit"
    assert run.attrs["n_events"] < 500
    return run


# Heights have errors of some eps, so flights are lost below a speed of about 1e-7, when what
# is left of the motion takes 1e-6.
CLOSE = 1e-6


@on_both_flows
@pytest.mark.parametrize("r", [0.1, 0.5, 0.8])
def test_a_ball_on_a_flat_floor(flow, r):
    mode = Mode({"x": "v", "v": "-1"}, exits=[Exit("x", reset={"v": "-r*v"})])
    system = System(states=["x", "v"], parameters={"r": r}, modes={"m": mode})
    run = accumulated(flow(system), {"x": 1.0})
    # sqrt(2 h/g) (1 + 2 (r + r^2 + ...))
    end = np.sqrt(2.0) * (1 + 2 * r / (1 - r))
    assert float(run["event_time"][-1]) == pytest.approx(end, abs=CLOSE)
    assert float(run["x"].min()) >= 0.0
    assert float(run["state_after"].sel(state="x").min()) >= 0.0


def bounces_in_air(k, r, height, count):
    """Times of bounces with drag k v^2, in closed form, and of their accumulation."""
    with mp.workdps(30):
        k, r, h, now, times = mp.mpf(k), mp.mpf(r), mp.mpf(height), mp.mpf(0), []
        up = mp.mpf(0)
        for _ in range(count):
            fall = mp.acosh(mp.exp(k * h)) / mp.sqrt(k)
            speed = mp.sqrt(-mp.expm1(-2 * k * h) / k)
            now += up + fall
            times.append(now)
            speed *= r
            up = mp.atan(speed * mp.sqrt(k)) / mp.sqrt(k)
            h = mp.log1p(k * speed**2) / (2 * k)
        return [float(value) for value in times]


@pytest.mark.parametrize(("k", "r"), [(0.1, 0.5), (1.0, 0.7), (1e-6, 0.5)])
def test_a_ball_in_air(k, r):
    """Drag against the square of the speed, written with abs: a cell for each direction."""
    mode = Mode(
        {"x": "v", "v": "-1 - k*v*abs(v)"}, exits=[Exit("x", reset={"v": "-r*v"}, name="b")]
    )
    system = System(states=["x", "v"], parameters={"k": k, "r": r}, modes={"m": mode})
    run = accumulated(system, {"x": 1.0})
    times = bounces_in_air(k, r, 1.0, 200)
    log = crossings(run)
    bounces = log["event_time"].values[log["event_name"].values == "b"]
    # eps over the speed of the tenth bounce, 1e-3 or more
    assert np.allclose(bounces[:10], times[:10], rtol=0, atol=1e-12)
    assert float(run["event_time"][-1]) == pytest.approx(times[-1], abs=CLOSE)
    assert float(run["x"].min()) >= -1e-15
    assert float(run["state_after"].sel(state="x").min()) >= -1e-15


def bounces_in_a_bowl(state, r, count):
    """Bounces of a point mass on y = x^2: flights are parabolas, so roots of quadratics."""
    with mp.workdps(50):
        x, y, u, v = (mp.mpf(value) for value in state)
        now, times = mp.mpf(0), []
        for k in range(count):
            # y + v s - s^2/2 = (x + u s)^2; on the wire its constant term is zero
            a, b, c = mp.mpf(1) / 2 + u * u, 2 * x * u - v, x * x - y
            s = -b / a if k > 0 else (-b + mp.sqrt(b * b - 4 * a * c)) / (2 * a)
            x, now = x + u * s, now + s
            y, v = x * x, v - s
            times.append(now)
            size = 1 + 4 * x * x
            normal = (v - 2 * x * u) / size
            u, v = u + (1 + r) * 2 * x * normal, v - (1 + r) * normal
        return [float(value) for value in times]


@pytest.mark.parametrize("start", [(0.3, 1.0, 0.0, 0.0), (-0.5, 0.6, 0.4, 0.2)])
def test_a_ball_on_a_curved_floor(start):
    """Impacts accumulate on the slope, where the ball would begin to slide."""
    r = 0.5
    normal = "(v - 2*x*u)/(1 + 4*x**2)"
    bounce = Exit(
        "y - x**2",
        reset={"u": f"u + (1 + r)*2*x*{normal}", "v": f"v - (1 + r)*{normal}"},
        name="bounce",
    )
    mode = Mode({"x": "u", "y": "v", "u": "0", "v": "-1"}, exits=[bounce])
    system = System(states=["x", "y", "u", "v"], parameters={"r": r}, modes={"m": mode})
    run = accumulated(system, dict(zip("xyuv", start, strict=True)))
    times = bounces_in_a_bowl(start, r, 300)
    log = crossings(run)
    count = 12
    assert bool(log["certified"][:count].all())
    assert np.allclose(log["event_time"][:count], times[:count], rtol=0, atol=1e-11)
    assert float(log["event_time"][-1]) == pytest.approx(times[-1], abs=1e-5)
    assert float((run["y"] - run["x"] ** 2).min()) >= -1e-15
    after = log["state_after"]
    assert float((after.sel(state="y") - after.sel(state="x") ** 2).min()) >= -1e-15


@pytest.mark.parametrize("before", [1e-5, 3e-6, 1e-6])
def test_what_comes_before_rebounds_are_over(before):
    """A clock that puts the weight off shortly before the last rebound: the ball rises from there.

    The row of all rebounds to come had a time behind that of the clock.
    """
    r, over = 0.5, float(3.0 * np.sqrt(2.0))  # sqrt(2 h/g) (1 + 2 r/(1 - r))
    floor = Exit("x - 1", reset={"v": "-r*v"}, sticks="rest", name="floor")
    clock = Exit(f"{over - before!r} - y", to="off", name="clock")
    on = Mode({"x": "v", "v": "-1", "y": "1"}, exits=[floor, clock])
    modes = {"on": on, "off": Mode({"x": "v", "v": "0", "y": "1"})}
    system = System(states=["x", "v", "y"], parameters={"r": r}, modes=modes)
    run = ns.simulate(system, {"x": 2.0}, t_end=5.0)
    assert run.attrs["status"] == "completed"
    times = run["event_time"].values
    assert (np.diff(times) >= 0.0).all()
    assert run["event_name"].values[-1] == "clock"
    assert times[-1] == pytest.approx(over - before, abs=1e-15 * over)
    # flights before the clock: each one half as long as that before it
    flights = int(np.floor(np.log2(2.0 * np.sqrt(2.0) / before)))
    assert int(run["event_count"].values[1:-1].sum()) >= flights


def test_a_reset_without_its_sign_is_told():
    """Each of the resets at one instant leaves a part r of the speed, until rounding is left."""

    def system(reset):
        wall = Exit("1 - x", reset={"v": reset}, name="impact", sticks="rest")
        return System(states=["x", "v"], modes={"free": Mode({"x": "v", "v": "1"}, exits=[wall])})

    with pytest.warns(RunWarning, match="the exit 'impact' fired .* times .* is a sign missing"):
        run = ns.simulate(system("0.5*v"), {"x": 0.0, "v": 2.0}, t_end=1.0)
    assert "is a sign missing" in run.attrs["message"]
    run = ns.simulate(system("-0.5*v"), {"x": 0.0, "v": 2.0}, t_end=10.0)
    assert run.attrs["message"] == "completed"


def block(*more: Exit) -> System:
    """A rocking block, which hands over from corner to corner."""
    right = Exit("q", to="left", reset={"w": "0.9*w"})
    left = Exit("-q", to="right", reset={"w": "0.9*w"})
    modes = {
        "right": Mode({"q": "w", "w": "-4*sin(0.2 - q)"}, exits=[*more, right]),
        "left": Mode({"q": "w", "w": "4*sin(0.2 + q)"}, exits=[*more, left]),
        "rest": Mode({"q": "0", "w": "0"}),
    }
    return System(states=["q", "w"], initial={"q": 0.05}, modes=modes)


@pytest.mark.filterwarnings("ignore::nonsmooth.RunWarning")
def test_impacts_that_hand_over_get_a_cure_that_applies():
    """The cure of the message, taken by its words, lets the block rest."""
    message = ns.simulate(block(), t_end=20.0).attrs["message"]
    assert message.startswith("event_limit") and "hand over from mode to mode" in message
    cure = re.search(r"Exit\('(.*?)', to='rest'\)", message)
    assert cure is not None
    guard = cure.group(1).replace("x", "q").replace("v", "w")
    run = ns.simulate(block(Exit(guard, to="rest")), t_end=20.0)
    assert run.attrs["status"] == "completed" and run["event_to"].values[-1] == 2
    assert np.hypot(*run["end_state"].values) <= 1.0001e-4


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::nonsmooth.RunWarning")
def test_switches_that_wind_themselves_onto_a_point_of_one_surface():
    """A fused focus: x = -+a at y = 0 lasts a turn of 4a or so, and shrinks by a part of a in it.

    So turns are without end in any finite number, and nothing has come to rest. In half a turn
    x' = 1 - 0.3 x takes 0.2 a^2 off a, so a = 5/n after n of them, up to a part of log(n)/n.
    """
    focus = System(
        states=["x", "y"], equations={"x": "-1 + 2*heaviside(-y) - 0.3*x", "y": "x"},
        initial={"x": 1.0, "y": 0.5},
    )  # fmt: skip
    run = ns.simulate(focus, t_end=500.0)
    assert run.attrs["status"] == "event_limit"
    assert abs(run["end_state"].values[0]) * run.attrs["n_events"] == pytest.approx(5.0, rel=1e-3)
    message = run.attrs["message"]
    assert "switches of one surface follow each other ever faster" in message
    assert "impacts" not in message and "two surfaces" not in message
    earlier = ns.simulate(focus, t_end=0.5 * float(run["time"][-1]))  # the cure
    assert earlier.attrs["status"] == "completed"
    assert ns.regime(focus, period=5.0)["regime"].item() == "event_limit"


@pytest.mark.filterwarnings("ignore::nonsmooth.RunWarning")
def test_switches_of_two_surfaces_are_told_to_meet():
    focus = System(states=["x", "v"], equations={"x": "v", "v": "-x - 0.1*sign(v + x) - sign(x)"})
    message = ns.simulate(focus, {"x": 1.0, "v": 0.5}, t_end=50.0).attrs["message"]
    assert message.startswith("event_limit") and "meeting of two surfaces" in message


def firing(rate: str, reset: dict[str, str], **more) -> System:
    """A neuron that fires where v comes to one."""
    fires = Mode({"v": rate}, exits=[Exit("1 - v", reset=reset, name="spike")])
    return System(name="fires", states=["v"], modes={"sub": fires}, initial={"v": 0.0}, **more)


@on_both_flows
def test_events_at_steady_intervals_do_not_accumulate_however_many_there_are(flow):
    """A spike every log(I/(I - 1)): 9995 of them in 20 units of time, 49949 in a hundred."""
    system = flow(firing("I - v", {"v": "0"}, parameters={"I": 500.0}))
    run = ns.simulate(system, t_end=100.0, events=False)
    assert run.attrs["message"] == "completed" or run.attrs["n_estimated"]
    assert run.attrs["n_events"] == int(100.0 / np.log(500.0 / 499.0))


def test_many_events_in_a_declared_period_do_not_accumulate_either():
    system = firing("I - v", {"v": "0"}, parameters={"I": 500.0}, period=64.0)
    run = ns.simulate(system, periods=2, events=False)
    assert run.attrs["n_events"] == int(128.0 / np.log(500.0 / 499.0))


def test_spiking_that_gets_a_thousand_times_faster_at_once_is_no_accumulation():
    """v' = 2000 from t = 20 on, and 2 before: 40 spikes, and then 2000 a unit of time."""
    system = firing("2 + 1998*heaviside(t - 20)", {"v": "0"})
    run = ns.simulate(system, t_end=70.0, events=False)
    assert run.attrs["status"] == "completed"
    assert abs(run.attrs["n_events"] - (40 + 50 * 2000)) <= 1


def test_spiking_that_gets_faster_as_e_to_the_t_is_followed_for_long():
    """w' = w with w = 1 at first: exp(t) - 1 turns until t, 59873 until t = 11."""
    fires = Mode({"w": "w", "v": "w"}, exits=[Exit("1 - v", reset={"v": "v - 1"}, name="spike")])
    system = System(states=["w", "v"], modes={"m": fires}, initial={"w": 1.0, "v": 0.0})
    run = ns.simulate(system, t_end=11.0, events=False)
    assert run.attrs["status"] == "completed"
    assert run.attrs["n_events"] == int(np.exp(11.0) - 1.0)


@pytest.mark.filterwarnings("ignore::nonsmooth.RunWarning")
@pytest.mark.parametrize("more", [{}, {"period": 1.0}, {"period": 1e6}])
def test_rebounds_that_lose_little_end_soon_before_their_instant_of_rest(more):
    """A ball with r = 0.999 rests at sqrt(2) (1 + r)/(1 - r), after infinitely many rebounds.

    After n of them r^n of the time is left: 5e-5 of it after 10000.
    """
    mode = Mode({"x": "v", "v": "-1"}, exits=[Exit("x", reset={"v": "-0.999*v"})])
    system = System(states=["x", "v"], modes={"m": mode}, initial={"x": 1.0}, **more)
    run = ns.simulate(system, t_end=1e4, events=False)
    assert run.attrs["status"] == "event_limit" and "period" not in run.attrs["message"]
    end = run.attrs["end_number"] * run.attrs["window"] + run.attrs["end_phase"]
    rest = np.sqrt(2.0) * 1.999 / 0.001
    assert run.attrs["n_events"] <= 20_000
    assert rest * (1.0 - 2.0 * 0.999 ** run.attrs["n_events"]) < end < rest


@pytest.mark.filterwarnings("ignore::nonsmooth.RunWarning")
def test_intervals_like_one_over_k_squared_accumulate():
    """w = 1/(1 - t) makes v' = w^2 turn over for the k-th time at t = k/(k + 1).

    A million turns take 0.999999 units of time, and there is no end of them before t = 1.
    """
    fires = Mode({"w": "w**2", "v": "w**2"}, exits=[Exit("1 - v", reset={"v": "v - 1"})])
    system = System(states=["w", "v"], modes={"m": fires}, initial={"w": 1.0, "v": 0.0})
    run = ns.simulate(system, t_end=0.9999999, events=False)
    assert run.attrs["status"] == "event_limit"
    assert run.attrs["n_events"] <= 20_000


def test_switches_of_two_surfaces_wind_into_their_meeting():
    """No reset is passed, so none is spoken of: a loop of genes that comes to its thresholds."""
    system = System(
        states=["x", "y"],
        equations={"x": "-x - sign(x)*sign(y) - 2*sign(y)", "y": "-y + 2*sign(x)"},
    )
    with pytest.warns(RunWarning, match="switches accumulate.* into the meeting") as told:
        run = ns.simulate(system, {"x": 0.4, "y": 0.3}, t_end=30.0)
    assert run.attrs["status"] == "event_limit"
    assert "impact" not in str(told[0].message)
