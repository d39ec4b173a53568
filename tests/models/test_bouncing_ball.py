"""The bouncing ball: closed forms on a floor and on a table, and chatter in 40 digits."""

import numpy as np
import pytest
from mpmath import mp, mpf

import nonsmooth as ns
from models.rebounds import Instant, first_return, of_rounding, of_the_end, rebounds
from nonsmooth.models import bouncing_ball
from periodic_orbits.references.table_ball import TableBall

EPS = np.finfo(float).eps


def over(run):
    """Times at which rebounds have accumulated."""
    return run["event_time"].values[run["event_kind"].values.astype(str) == "chatter"]


def modes(run):
    names = run["mode"].attrs["flag_meanings"].split()
    return np.array([names[int(m)] for m in run["mode"].values])


@pytest.mark.parametrize("r", [0.3, 0.5, 0.7, 0.8, 0.9])
def test_a_ball_comes_to_rest_on_the_floor(r):
    """Flights from h = 1 last sqrt(2) (1, 2 r, 2 r^2, ...), sqrt(2) (1 + r)/(1 - r) in all."""
    with mp.workdps(40):
        exact = float(mp.sqrt(2) * (1 + mpf(r)) / (1 - mpf(r)))
    run = ns.simulate(bouncing_ball(Gamma=0.0, r=r), t_end=60)
    assert run.attrs["status"] == "completed"
    assert abs(over(run)[0] - exact) < 1e-12 * exact
    assert over(run).size == 1
    assert np.all(run["end_state"].values == 0.0)
    still = run["time"].values > exact
    assert set(modes(run)[still]) == {"rest"} and set(modes(run)[~still]) == {"flight"}
    assert np.all(run["y"].values[still] == 0.0) and np.all(run["v"].values[still] == 0.0)
    assert np.all(run["table_force"].values[still] == 1.0)


@pytest.mark.parametrize("h", [1e-6, 1e-2, 50.0])
def test_the_time_to_rest_goes_with_the_root_of_the_height(h):
    exact = np.sqrt(2 * h) * 3
    run = ns.simulate(bouncing_ball(Gamma=0.0), {"y": h}, t_end=2 * exact)
    assert abs(over(run)[0] - exact) < 1e-12 * exact


@pytest.mark.parametrize("Gamma", [1.001, 1.2, 1.5, 3.0])
def test_lift_off(Gamma):
    system = bouncing_ball(Gamma=Gamma)
    run = ns.simulate(system, {"y": 0.0, "v": Gamma}, t_end=2 * np.pi)
    lifted = run["event_time"].values[run["event_name"].values == "release"]
    assert lifted.size >= 1 and modes(run)[0] == "rest"
    # at a force near its top, the angle of an arc sine has fewer digits
    exact = np.arcsin(1 / Gamma)
    assert abs(lifted[0] - exact) < 16 * EPS / np.cos(exact)
    before = run["time"].values < exact
    assert np.abs(run["height"].values[before]).max() < 4 * EPS * Gamma
    force = 1 - Gamma * np.sin(run["time"].values[before])
    assert np.abs(run["table_force"].values[before] - force).max() < 8 * EPS * Gamma


@pytest.mark.parametrize("Gamma", [0.3, 0.99])
def test_a_weak_table_keeps_the_ball(Gamma):
    run = ns.simulate(bouncing_ball(Gamma=Gamma), t_end=300)
    assert "release" not in run["event_name"].values
    assert over(run).size == 1 and modes(run)[-1] == "rest"
    end = run["end_state"].values
    assert abs(end[0] - Gamma * np.sin(300)) < 300 * 4 * EPS
    assert abs(end[1] - Gamma * np.cos(300)) < 300 * 4 * EPS


def lifted_ball(Gamma):
    """Flights of a ball above the table, by their start and rate of leaving, and the lift-off."""
    Gamma = mpf(Gamma)

    def flight(began, rate):
        def motion(t):
            s = t - began
            speed = rate + Gamma * mp.cos(began)
            table = Gamma * mp.sin(t)
            return Instant(
                Gamma * mp.sin(began) + speed * s - s * s / 2 - table,
                speed - s - Gamma * mp.cos(t),
                table - 1,
            )

        return motion

    return flight, mp.asin(1 / Gamma)


@pytest.mark.parametrize(("Gamma", "r"), [(1.2, 0.5), (1.1, 0.3), (1.05, 0.7)])
def test_chatter_on_the_moving_table(Gamma, r):
    """From lift-off to rest once a period: impacts and their end against 40 digits."""
    with mp.workdps(40):
        flight, start = lifted_ball(Gamma)
        landed = first_return(flight(start, mpf(0)), start)
        rate = -mpf(r) * flight(start, mpf(0))(landed).rate
        times, rest = rebounds(flight, landed, rate, r)
    times = np.array([float(landed), *times])
    run = ns.simulate(bouncing_ball(Gamma=Gamma, r=r), {"y": 0.0, "v": Gamma}, periods=4)
    kinds = run["event_kind"].values.astype(str)
    alone = (kinds == "impact") & (run["event_time"].values < rest)
    hits = run["event_time"].values[alone]
    speeds = -run["guard_rate"].values[alone]
    assert 5 < hits.size < times.size
    assert np.all(np.abs(hits - times[: hits.size]) < of_rounding(speeds))
    assert abs(over(run)[0] - rest) < min(1e-10, of_the_end(speeds, r, 2 * np.pi))
    assert np.abs(np.diff(over(run)) - 2 * np.pi).max() < 1e-10


@pytest.mark.parametrize(("r", "n", "share"), [("0.5", 1, 0.5), ("0.8", 2, 0.5), ("0.8", 1, 1.1)])
@pytest.mark.parametrize("upper", [True, False])
def test_one_bounce_in_n_periods(r, n, share, upper):
    ball = TableBall(r, n)
    Gamma = float(ball.saddle_node + share * (ball.period_doubling - ball.saddle_node))
    start = ball.start(Gamma, upper)
    start = {"y": start["x"], "v": start["u"]}
    orbit = ns.find_orbit(bouncing_ball(Gamma=Gamma, r=float(r)), start, period=n)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    for name, value in start.items():
        assert abs(float(orbit[name]) - value) < 1e-10 * max(1.0, abs(value))
    exact = [complex(m) for m in ball.multipliers(Gamma, upper)]
    found = orbit["multipliers"].values
    # a pair of complex conjugates has either first
    assert min(np.abs(found - exact).max(), np.abs(found - exact[::-1]).max()) < 1e-8
    assert bool(orbit["stable"]) == (upper and share < 1)


@pytest.mark.parametrize(("r", "n"), [("0.8", 1), ("0.5", 1), ("0.8", 2)])
def test_saddle_node_and_period_doubling(r, n):
    ball, restitution = TableBall(r, n), float(r)
    low, high = float(ball.saddle_node), float(ball.period_doubling)
    node = np.pi * n * (1 - restitution) / (1 + restitution)
    assert low == pytest.approx(node, rel=4 * EPS)
    doubling = np.hypot(node, 2 * (1 + restitution**2) / (1 + restitution) ** 2)
    assert high == pytest.approx(doubling, rel=4 * EPS)
    start = ball.start((low + high) / 2)
    system = bouncing_ball(Gamma=(low + high) / 2, r=restitution)
    orbit = ns.find_orbit(system, {"y": start["x"], "v": start["u"]}, period=n)
    branch = ns.continue_orbit(system, "Gamma", (0.5 * low, 1.2 * high), initial=orbit)
    rows = list(zip(branch["special_kind"].values, branch["special_value"].values, strict=True))
    for kind, exact in (("fold", low), ("flip", high)):
        assert min(abs(value - exact) for name, value in rows if str(name) == kind) < 1e-10


@pytest.mark.parametrize(("argument", "value"), [("Gamma", -0.1), ("r", -0.1), ("r", 1.1)])
def test_impossible_parameters_are_refused(argument, value):
    with pytest.raises(ns.ModelError, match=f"{argument} [<>]"):
        bouncing_ball(**{argument: value})
