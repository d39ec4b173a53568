"""Roots beside which guards are flat: high powers, and two roots that are nearly one."""

import mpmath
import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System


@pytest.mark.parametrize(
    ("power", "level", "units"),
    [(4, "1e-16", ""), (4, "1e-16", "1e6*"), (6, "1e-16", ""), (6, "1e-10", "1e-9*")],
)
def test_the_time_at_which_a_power_is_small(power, level, units):
    """x = cos(t) comes down to a level that its power has: the rate there is nearly -1.

    The series of the power about the start of a step has terms of size 1 that cancel down to the
    level. So a root was off by the rounding of 1 over the slope of the power, 7e-11 for the sixth.
    """
    way = Exit(f"{units}(x**{power} - {level})", to="stop")
    flow = {"x": "v", "v": "-x", "y": "-y + sin(x)*v"}
    system = System(states=["x", "v", "y"], modes={"m": Mode(flow, exits=[way])})
    run = ns.simulate(system, {"x": 1.0}, t_end=3.0)
    with mpmath.workdps(30):
        truth = mpmath.acos(mpmath.mpf(level) ** (mpmath.mpf(1) / power))
    assert run.attrs["status"] == "stopped" and run.attrs["certified"] == 1
    # some roundings of a state of size 1
    assert abs(float(run["event_time"][-1]) - truth) < 2e-15


def test_two_roots_of_a_square_that_are_nearly_one():
    """A stiff decay passes 1e-10 and -1e-10 within 3e-15 of a time unit.

    The square was a difference of sums, rounded at 0.6, and steps to its root ended early: the
    modes handed over nine times at one instant.
    """
    flow = {"y": "1e5*(-0.75 - y)"}
    enter = Exit("y**2 - 1e-20", to="near", name="enter")
    leave = Exit("1e-20 - y**2", to="out", name="leave")
    modes = {"out": Mode(flow, exits=[enter]), "near": Mode(flow, exits=[leave])}
    run = ns.simulate(System(states=["y"], modes=modes), {"y": 0.97}, t_end=1.0)
    assert run["event_name"].values.tolist() == ["start", "enter", "leave"]
    assert run["state_before"].values[1:, 0] == pytest.approx([1e-10, -1e-10], abs=1e-14)
    with mpmath.workdps(30):
        far = [mpmath.mpf("0.75") + sign * mpmath.mpf("1e-10") for sign in (1, -1)]
        truth = [mpmath.log(mpmath.mpf("1.72") / each) / 10**5 for each in far]
    # a few roundings of a state of size 1, over its rate of 75,000
    assert np.abs(run["event_time"].values[1:] - np.array(truth, float)).max() < 1e-15 / 75e3


@pytest.mark.parametrize("power", [10, 30, 60, 100])
@pytest.mark.parametrize("integrators", [0, 2, 5, 6])
def test_high_powers_of_chains_that_start_at_zero(integrators, power):
    """The power of t**(k + 1)/(k + 1)! has no term in the order of the series.

    Over a long step its bound overflows; that was zero times infinity, and counted as no error, so
    the root was missed in a run that was certified.
    """
    flow = {f"x{i}": f"x{i + 1}" for i in range(integrators)} | {f"x{integrators}": "1"}
    way = Exit(f"0.5 - x0**{power}", to="stop")
    system = System(states=list(flow), modes={"m": Mode(flow, exits=[way])})
    run = ns.simulate(system, dict.fromkeys(flow, 0.0), t_end=12.0)
    order = integrators + 1
    with mpmath.workdps(30):
        truth = (mpmath.factorial(order) * mpmath.mpf(0.5) ** (1 / mpmath.mpf(power))) ** (
            1 / mpmath.mpf(order)
        )
    assert run.attrs["status"] == "stopped" and run.attrs["certified"] == 1
    assert abs(float(run["event_time"][-1]) - truth) < 1e-14  # some roundings of a time near 3
