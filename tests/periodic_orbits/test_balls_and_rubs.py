"""Bouncing ball, friction without stop and synchronous rub against their closed forms."""

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from periodic_orbits.references.oscillators import DenHartog
from periodic_orbits.references.rub import rubs
from periodic_orbits.references.table_ball import TableBall
from periodic_orbits.systems import (
    assert_multipliers,
    assert_state,
    ball_in_space,
    ball_on_table,
    friction,
    friction_text,
)

# restitution, table periods of a flight, Gamma between saddle-node (0) and period doubling (1)
BALLS = [("0.5", 1, 0.1), ("0.5", 1, 0.9), ("0.8", 2, 0.5), ("0.9", 1, 1.1), ("0.7", 3, 0.5)]


@pytest.mark.parametrize(("r", "n", "share"), BALLS)
@pytest.mark.parametrize("upper", [True, False])
@pytest.mark.parametrize("write", [ball_in_space, ball_on_table])
def test_bouncing_ball(r, n, share, upper, write):
    ball = TableBall(r, n)
    gamma = float(ball.saddle_node + share * (ball.period_doubling - ball.saddle_node))
    assert ball.stays_above(gamma, upper, 300)
    system, start = write(gamma, float(r)), ball.start(gamma, upper)
    start = {name: start[name] for name in system.states}
    orbit = ns.find_orbit(system, start, period=n)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert bool(orbit["admissible"])
    assert_state(orbit, start)
    assert_multipliers(orbit, ball.multipliers(gamma, upper))
    assert bool(orbit["stable"]) == (upper and share < 1)
    assert abs(float(orbit["log_determinant"]) - 2 * np.log(float(r))) < 1e-12


def test_the_ends_of_the_ball_are_where_multipliers_are_one_and_minus_one():
    ball = TableBall("0.8", 1)
    with mp.workdps(40):
        assert abs(ball.multipliers(ball.saddle_node * (1 + mp.mpf(10) ** -30))[0] - 1) < 1e-12
        assert abs(ball.multipliers(ball.period_doubling)[0] + 1) < 1e-30


@pytest.mark.parametrize(
    ("beta", "q"), [(0.7, 0.2), (0.8, 0.3), (1.5, 0.3), (2.0, 0.2), (0.45, 0.1)]
)
@pytest.mark.parametrize("write", [friction, friction_text])
def test_den_hartog(beta, q, write):
    with mp.workdps(40):
        exact = DenHartog(beta=beta, q=q)
        start = dict(zip("xv", map(float, exact.start()), strict=True))
        multipliers = exact.multipliers()
    orbit = ns.find_orbit(write(beta, q), start)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert_state(orbit, start)
    # a double eigenvalue is as exact as the root of rounding
    if beta == 2.0:
        assert abs(orbit["multipliers"].values - complex(multipliers[0])).max() < 1e-7
    else:
        assert_multipliers(orbit, multipliers)
    turns = np.abs(orbit["leg_states"].sel(state="x").values[1:])
    assert np.abs(turns - float(exact.amplitude)).max() < 1e-10


RUBS = [
    {"omega": 0.9, "zeta": 0.06, "kappa": 20.0, "rho": 0.7},
    {"omega": 2.0, "zeta": 0.1, "kappa": 20.0, "rho": 0.7},
    {"omega": 3.0, "zeta": 0.1, "kappa": 20.0, "rho": 0.7},
    {"omega": 1.5, "zeta": 0.05, "kappa": 5.0, "rho": 0.5},
]


@pytest.mark.parametrize("words", RUBS)
def test_synchronous_rub(words):
    found = rubs(**words)
    assert found
    for rub in found:
        orbit = ns.find_orbit(ns.models.clearance_rotor(**words), rub.start)
        assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
        assert orbit["word"].item() == "rub" and bool(orbit["admissible"])
        assert_state(orbit, rub.start)
        assert_multipliers(orbit, rub.multipliers)
        radius = np.hypot(float(orbit["x"]), float(orbit["y"]))
        assert abs(radius - float(rub.radius)) < 1e-10
        log = -8 * np.pi * words["zeta"] / words["omega"]
        assert abs(float(orbit["log_determinant"]) - log) < 1e-10
        assert bool(orbit["stable"]) == bool(abs(rub.multipliers[0]) < 1)


@pytest.mark.slow
@pytest.mark.parametrize("begin", [3.5e-4, 4.0e-4, 4.05e-4, 4.1e-4, 4.3e-4])
def test_the_lift_off_of_a_ball_is_the_same_from_either_side(begin):
    """It rests until the table falls faster than gravity and tether pull: A w**2 = g + k A/m.

    Quadratic drag is nothing there, as the speed is zero where the table turns. Behind the lift-off
    flights rebound without end, with words that change without end.
    """
    system = ns.System(
        states=["h", "u"],
        parameters={"g": 9.81, "m": 5e-3, "c": 2e-4, "k": 0.02, "A": 5e-4, "f": 25.0, "r": 0.7},
        period="1/f",
        definitions={"s": "A*sin(2*pi*f*t)", "sv": "2*pi*f*A*cos(2*pi*f*t)"},
        initial={"h": 0.002, "u": 0.0},
        modes={
            "flight": ns.Mode(
                {"h": "u", "u": "-g - c/m*u*abs(u) - k/m*h"},
                exits=[
                    ns.Exit(
                        "h - s", reset={"u": "-r*u + (1 + r)*sv"}, sticks="rides", name="bounce"
                    )
                ],
            )
        },
    )
    orbit = ns.find_orbit(system, parameters={"A": begin})
    branch = ns.continue_orbit(
        system, "A", (3e-4, 4.4e-4), initial=orbit, parameters={"A": begin},
        direction="up" if begin < 3.9e-4 else "down",
    )  # fmt: skip
    (place,) = np.flatnonzero(branch["special_kind"].values == "corner")
    lift_off = 9.81 / ((50.0 * np.pi) ** 2 - 0.02 / 5e-3)
    # guards count as zero within 500 roundings of their terms
    assert float(branch["special_value"][place]) == pytest.approx(lift_off, rel=500 * 2.3e-16 * 3)
