"""Limit cycles without forcing against closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from periodic_orbits.references import cycles
from periodic_orbits.systems import clock, relay, round_cycle


def on_cycle(orbit, of_mode: str) -> np.ndarray:
    """State at the start of the leg in a mode."""
    flags = orbit["leg_mode"].attrs
    number = list(flags["flag_meanings"].split()).index(of_mode)
    leg = int(np.flatnonzero(orbit["leg_mode"].values == flags["flag_values"][number])[0])
    return orbit["leg_states"].values[leg]


@pytest.mark.parametrize(("zeta", "energy"), [(0.05, 0.1), (0.3, 2.0)])
def test_clock(zeta, energy):
    exact = cycles.clock(zeta=zeta, energy=energy)
    orbit = ns.find_orbit(clock(zeta, energy), {"x": 0.1, "v": 0.9 * float(exact.start[1])})
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert abs(float(orbit["length"]) / float(exact.period) - 1) < 1e-10
    expected = [float(x) for x in exact.start]
    assert np.abs(on_cycle(orbit, "right") - expected).max() < 1e-10 * expected[1]
    values = orbit["multipliers"].values
    assert values.shape == (1,)
    assert abs(values[0] / float(exact.multipliers[0]) - 1) < 1e-9
    assert bool(orbit["stable"]) and bool(orbit["admissible"])


@pytest.mark.parametrize(("zeta", "h"), [(0.1, 0.3), (0.05, 0.5)])
def test_relay(zeta, h):
    exact = cycles.relay(zeta=zeta, h=h)
    start = {"x": 0.0, "v": 1.2 * float(exact.start[1])}
    orbit = ns.find_orbit(relay(zeta, h), start, mode="push")
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert abs(float(orbit["length"]) / float(exact.period) - 1) < 1e-10
    expected = np.array([float(x) for x in exact.start])
    assert np.abs(on_cycle(orbit, "push") - expected).max() < 1e-10
    assert np.abs(on_cycle(orbit, "pull") + expected).max() < 1e-10
    values = orbit["multipliers"].values
    assert values.shape == (1,)
    assert abs(values[0] / float(exact.multipliers[0]) - 1) < 1e-9


def test_round_cycle():
    """exp(-4 pi) = 3.5e-6 is below 1e-6 of nothing: it is the largest, and held to 1e-9."""
    exact = cycles.round_cycle()
    orbit = ns.find_orbit(round_cycle())
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert abs(float(orbit["length"]) / (2 * np.pi) - 1) < 1e-10
    assert abs(np.hypot(float(orbit["x"]), float(orbit["y"])) - 1) < 1e-10
    values = orbit["multipliers"].values
    assert values.shape == (1,)
    assert abs(values[0] / float(exact.multipliers[0]) - 1) < 1e-9


@pytest.mark.parametrize("start", [{"x": 1.0, "y": 0.001}, {"x": 0.5, "y": 0.1}])
def test_a_smooth_cycle_without_events(start):
    """Nothing marks a turn there; it is one turn all the same, once around."""
    system = ns.System(
        states=["x", "y"],
        parameters={"k": 1.0},
        equations={"x": "x - y - k*x*(x**2 + y**2)", "y": "x + y - k*y*(x**2 + y**2)"},
    )
    orbit = ns.find_orbit(system, start, transient=5)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert abs(float(orbit["length"]) / (2 * np.pi) - 1) < 1e-10
    assert abs(np.hypot(float(orbit["x"]), float(orbit["y"])) - 1) < 1e-10
    assert abs(orbit["multipliers"].values[0] / np.exp(-4 * np.pi) - 1) < 1e-9


def test_a_cycle_starts_again_where_it_is_reported():
    """`simulate` goes on from the orbit as it stands, mode and all."""
    system = relay(0.1, 0.3)
    orbit = ns.find_orbit(system, {"x": 0.0, "v": -2.0}, mode="push")
    time, length = float(orbit["time"]), float(orbit["length"])
    run = ns.simulate(system, orbit, t_end=time + 3.25 * length, times=None)
    assert run.attrs["n_events"] == 6
    late = run["event_time"].values
    assert abs((late[-1] - late[-3]) / length - 1) < 1e-10


def test_a_valve_that_strikes_its_seat_once_in_a_turn():
    """A turn in which a short stretch looks like a cycle without events, which is no motion.

    One turn from the orbit closes by DOP853 with the impact found between its steps.
    """
    values = {"kap": 1.25, "delta": 10.0, "beta": 20.0, "q": 6.2, "r": 0.8}
    valve = ns.System(
        states=["x", "v", "p"],
        parameters=values,
        initial={"x": 1.0, "v": 0.0, "p": 11.0},
        modes={
            "open": ns.Mode(
                {"x": "v", "v": "p - delta - x - kap*v", "p": "beta*(q - x*sqrt(p))"},
                exits=[ns.Exit("x", reset={"v": "-r*v"}, sticks="seat", name="impact")],
            )
        },
    )
    for options in ({}, {"word": "open open"}):
        orbit = ns.find_orbit(valve, **options)
        assert orbit.attrs["status"] == "completed"
        assert orbit["leg_exit"].values.tolist() == ["impact"]
    start = orbit["leg_states"].values[0]

    def rates(t, y):
        x, v, p = y
        return [v, p - 10.0 - x - 1.25 * v, 20.0 * (6.2 - x * np.sqrt(p))]

    def seat(t, y):
        return y[0]

    seat.direction, seat.terminal = -1.0, True
    turn = solve_ivp(rates, (0.0, 6.0), start, method="DOP853", events=seat, rtol=1e-12, atol=1e-13)
    _, v, p = turn.y[:, -1]
    assert turn.t[-1] == pytest.approx(float(orbit["length"]), abs=1e-9)
    np.testing.assert_allclose([0.0, -0.8 * v, p], start, atol=1e-8)
