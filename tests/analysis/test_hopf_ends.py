"""Branches of cycles without events that shrink to a point, wherever on the cycle they begin.

Cycles of a Hopf bifurcation grow with the root of the distance from it, so one that is 1e-5 of the
first is 1e-10 away, beside the range of the parameter. The end itself is that of the rest, which is
known to rounding.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import nonsmooth as ns


def van_der_pol() -> ns.System:
    """Its cycles end at a = 0, where they have the amplitude 2 sqrt(a)."""
    return ns.System(
        states=["x", "v"],
        parameters={"mu": 1.0, "a": 1.0},
        initial={"x": 2.0},
        equations={"x": "v", "v": "mu*(a - x**2)*v - x"},
    )


def drill() -> ns.System:
    """A drill string; its bit meets less friction the faster it turns, and sticks where it rests.

    At the steady turn the trace of the linear equations is ((Ts - Tc)/wd exp(-Om/wd) - c)/J.
    """
    return ns.System(
        states=["twist", "w"],
        parameters={
            "J": 374.0, "k": 473.0, "c": 20.0, "Om": 3.0, "Tc": 1500.0, "Ts": 3500.0, "wd": 0.8,
        },
        equations={
            "twist": "Om - w",
            "w": "(k*twist + c*(Om - w) - sign(s)*(Tc + (Ts - Tc)*exp(-abs(s)/wd)))/J",
        },
        surfaces={"s": ns.Surface("w", below="reverse", on="stick", above="turn")},
    )  # fmt: skip


@pytest.mark.few(1)
@pytest.mark.parametrize("transient", [10, 11, 12, 13])
def test_the_place_on_the_cycle_does_not_matter(transient):
    system = van_der_pol()
    orbit = ns.find_orbit(system, transient=transient)
    branch = ns.continue_orbit(system, "a", (-0.5, 1.5), initial=orbit)
    assert list(branch["special_kind"].values) == ["hopf", "bound"]
    assert branch.attrs["end_first"] == "hopf"
    assert float(branch["special_value"][0]) == pytest.approx(0.0, abs=1e-9)
    a = branch["a"].values
    small = (a > 1e-7) & (a < 1e-2)
    assert small.sum() > 10
    # x**2 + v**2 = 4 a (1 + O(a)), as mu (a - x**2) v is of the order a beside x
    squares = (branch["x"] ** 2 + branch["v"] ** 2).values
    assert np.all(np.abs(squares / (4.0 * a) - 1.0)[small] <= 2.0 * a[small])


def test_a_cycle_around_a_point_that_moves():
    """It lies at x = q m + 5, and the cycle has the radius sqrt(m)."""
    system = ns.System(
        states=["x", "y"],
        parameters={"m": 1.0, "q": 3.0},
        definitions={"z": "x - q*m - 5"},
        equations={"x": "m*z - y - z*(z**2 + y**2)", "y": "z + m*y - y*(z**2 + y**2)"},
        initial={"x": 8.9},
    )
    branch = ns.continue_orbit(system, "m", (-0.5, 1.2), initial=ns.find_orbit(system))
    assert list(branch["special_kind"].values) == ["hopf", "bound"]
    assert float(branch["special_value"][0]) == pytest.approx(0.0, abs=1e-9)
    m, x, y = (branch[name].values for name in ("m", "x", "y"))
    # the radius r grows by 2 pi r (m - r**2) in a turn, so that roundings of states of size 8
    # leave 8 * 2e-16 / (2 pi r) of r**2: 1e-11 at the smallest radius, 2e-5
    squares = (x - 3.0 * m - 5.0) ** 2 + y**2
    assert squares == pytest.approx(m, abs=2e-11)
    assert branch["length"].values == pytest.approx(2.0 * np.pi, rel=1e-9)


@pytest.mark.slow
def test_units_of_the_states_do_not_matter():
    """The same oscillator with displacements and speeds in units 1e4 apart."""
    system = ns.System(
        states=["x", "v"],
        parameters={"a": 1.0},
        initial={"x": 2.0, "v": 1e3},
        equations={"x": "1e-4*v", "v": "(a - x**2)*v - 1e4*x"},
    )
    orbit = ns.find_orbit(system, transient=11)
    branch = ns.continue_orbit(system, "a", (-0.5, 1.5), initial=orbit)
    assert list(branch["special_kind"].values) == ["hopf", "bound"]
    assert float(branch["special_value"][0]) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.slow
def test_the_unstable_cycle_of_a_drill_ends_where_its_steady_turn_loses_stability():
    system = drill()
    least = 0.08302497949024326  # speed of the bit on that cycle, by shooting with DOP853
    twist = (1500.0 + 2000.0 * np.exp(-least / 0.8) - 20.0 * (16.0 - least)) / 473.0
    turn = ns.find_orbit(system, {"twist": twist, "w": least}, parameters={"Om": 16.0})
    assert turn["word"].item() == "turn"
    branch = ns.continue_orbit(
        system, "Om", (3.0, 16.5), initial=turn, parameters={"Om": 16.0}, direction="down"
    )
    assert list(branch["special_kind"].values) == ["hopf"]
    assert branch.attrs["end_first"] == "hopf"
    found = float(branch["special_value"][0])
    assert found == pytest.approx(0.8 * np.log(2000.0 / (0.8 * 20.0)), rel=1e-9)
    assert branch["length"].values[0] == pytest.approx(2.0 * np.pi * np.sqrt(374.0 / 473.0))


def least_speed(om: float) -> float:
    """Least speed of the bit a turn after its least speed was zero, by DOP853."""

    def rates(_t, y):
        torque = 1500.0 + 2000.0 * np.exp(-y[1] / 0.8)
        return [om - y[1], (473.0 * y[0] + 20.0 * (om - y[1]) - torque) / 374.0]

    def accelerates(t, y):
        return rates(t, y)[1]

    accelerates.direction = 1
    begin = [(3500.0 - 20.0 * om) / 473.0, 0.0]
    found = solve_ivp(
        rates, (0.0, 10.0), begin, method="DOP853", rtol=1e-13, atol=1e-13, events=accelerates
    )
    later = found.t_events[0] > 1.0
    return float(found.y_events[0][later][0][1])


@pytest.mark.slow
def test_a_cycle_that_stops_sticking_goes_on_without_events():
    """It touches zero speed there, and turns back as the unstable cycle down to its end."""
    branch = ns.continue_orbit(
        drill(), "Om", (3.0, 20.0), initial=ns.find_orbit(drill(), {"twist": 0.0}), direction="up"
    )
    assert list(branch["special_kind"].values) == ["grazing_sliding", "hopf"]
    graze, end = branch["special_value"].values
    # the speed is integrated to 1e-12 or so, and changes with Om at a rate of the order of one
    assert graze == pytest.approx(brentq(least_speed, 17.0, 17.2, xtol=1e-13), rel=1e-10)
    assert end == pytest.approx(0.8 * np.log(2000.0 / (0.8 * 20.0)), rel=1e-9)
    place = int(branch["special_point"].values[0])
    assert set(branch["word"].values[place + 1 :]) == {"turn"}
    assert not branch["stable"].values[place + 1 : -1].any()


@pytest.mark.few(3)
@pytest.mark.parametrize("centre", [0.0, 0.5, 1.0, 3.0, 10.0])
def test_where_the_cycle_lies_does_not_matter(centre):
    """Rayleigh's oscillator about any point: the trace at rest is mu, and its turns last 2 pi."""
    system = ns.System(
        states=["x", "v"],
        parameters={"mu": 0.3},
        initial={"x": centre + 1.0},
        equations={"x": "v", "v": f"-(x - {centre}) + mu*v - v**3"},
    )
    orbit = ns.find_orbit(system, transient=10)
    branch = ns.continue_orbit(system, "mu", (-0.5, 1.0), initial=orbit)
    assert list(branch["special_kind"].values) == ["hopf", "bound"]
    # a flow over a quarter of a turn is known to 1e-15 or so, of which growth is mu/2
    assert float(branch["special_value"][0]) == pytest.approx(0.0, abs=1e-14)
    rest = branch.isel(point=int(branch["special_point"][0]))
    assert float(rest["x"]) == pytest.approx(centre, abs=1e-14 * (1.0 + centre))
    assert float(rest["length"]) == pytest.approx(2.0 * np.pi, rel=1e-14)
    mu = branch["mu"].values
    assert np.all(np.diff(mu) > 0.0)


@pytest.mark.parametrize("stop", [9.0, 1.35])
def test_the_cycle_of_a_belt_ends_where_its_steady_slip_loses_stability(stop):
    """Friction falls with the slip by (Fs - Fk)/vs exp(-vb/vs), which damping 2 z balances there.

    The rest lies at 0.55, so that cycles of 1e-5 are known to few digits. None of
    them comes to the stop at 1.35.
    """
    system = ns.System(
        states=["x", "v"],
        parameters={"z": 0.02, "Fk": 0.5, "Fs": 1.0, "vs": 0.25, "vb": 1.1, "g": stop, "r": 0.6},
        modes={
            "run": ns.Mode(
                {"x": "v", "v": "-x - 2*z*v - sign(s)*(Fk + (Fs - Fk)*exp(-abs(s)/vs))"},
                exits=[ns.Exit("g - x", reset={"v": "-r*v"}, name="stop")],
            )
        },
        surfaces={"s": ns.Surface("v - vb", below="lag", on="stick", above="lead")},
    )
    orbit = ns.find_orbit(system, {"x": 0.0, "v": 0.0}, transient=0)
    assert orbit["word"].item() == "run[lag]"
    branch = ns.continue_orbit(system, "vb", (0.9, 1.2), initial=orbit)
    assert list(branch["special_kind"].values) == ["hopf", "bound"]
    end = float(branch["special_value"][0])
    assert end == pytest.approx(0.25 * np.log(0.5 / (0.25 * 0.04)), rel=1e-13)
