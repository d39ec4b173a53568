"""Where the motion parts from an orbit that is no motion: leg, exit and time against closed forms.

All modes have the same linear flow, whose periodic solution is x = sin t, so that the times of all
guards are known.
"""

import re

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.periodic_orbits.admissibility import check_admissible
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.word import Word

TURN = 2.0 * np.pi
FLOW = {"x": "v", "v": "3*sin(t) + 0.5*cos(t) - 4*x - 0.5*v"}
TAYLOR = FLOW | {"v": FLOW["v"] + " - x**3 + sin(t)**3"}


def machine(a, b, flow=FLOW):
    """Two modes with exits of these guards, given as names of modes with guards."""
    modes = {
        name: ns.Mode(flow, exits=[ns.Exit(guard, to=to, name=to) for to, guard in exits])
        for name, exits in {"a": a, "b": b, "c": []}.items()
    }
    return ns.System(states=["x", "v"], period="2*pi", modes=modes)


def turn_of(*instants):
    """The solution x = sin t, cut at these instants."""
    times = np.array([0.0, *instants, TURN])
    return Turn(np.stack([np.sin(times[:-1]), np.cos(times[:-1])], axis=1), times)


def reason_of(system, *instants, by=0):
    """What the engine says of the word a b a, whose events lie at these instants.

    The first one is the exit ``by`` of mode a.
    """
    legs = Legs(system)
    legs.set_values(system.parameter_values)
    equations = OrbitEquations(legs, Word((0, 1, 0), ((by,), (0,), ())), period=1)
    found = check_admissible(equations, turn_of(*instants), 1e-12)
    assert not found.admissible
    return found.reason, found.leg


def times_of(reason):
    """Times in a message."""
    return [float(text) for text in re.findall(r"t = ([-\d.]+)", reason)]


DOWN = 7.0 * np.pi / 6.0  # where sin falls through -0.5


LATE = "cos(t + 0.5) - 0.3", np.arccos(0.3) - 0.5, "0.35 - cos(t + 0.5)"
EARLY = "x + 0.5", DOWN, "-0.2 - x"
LAST_LONG, LAST_SHORT = TURN - 0.5 - np.arccos(0.35), TURN - np.arcsin(0.2)


@pytest.mark.parametrize(
    ("events", "up", "guard", "leg", "instant"),
    [
        # behind the middle of the last leg, which is longer than the first one, or shorter
        (LATE, LAST_LONG, "0.8 - v", 2, TURN - np.arccos(0.8)),
        (EARLY, LAST_SHORT, "0.99 - v", 2, TURN - np.arccos(0.99)),
        # in the first leg, and before its middle, from where the engine begins
        (EARLY, LAST_SHORT, "1 - 1.02*cos(t - 0.3)", 0, 0.3 - np.arccos(1 / 1.02)),
        (EARLY, LAST_SHORT, "0.9 + v", 0, np.arccos(-0.9)),
    ],
)
def test_the_leg_and_its_time_are_those_of_the_orbit(events, up, guard, leg, instant):
    """Also where the engine comes there a turn before or after."""
    falls, first, rises = events
    system = machine([("b", falls), ("c", guard)], [("a", rises)])
    reason, where = reason_of(system, first, up)
    assert where == leg
    assert reason.startswith(f"in leg {leg} (a) the motion leaves by 'c' at t = "), reason
    found, end = times_of(reason)
    assert found == pytest.approx(instant, rel=1e-8)
    if leg == 2:
        assert ", before the turn ends at t = " in reason
        assert end == pytest.approx(TURN, rel=1e-8)
    else:
        assert ", before the leg ends by 'b' at t = " in reason
        assert end == pytest.approx(first, rel=1e-8)


def test_an_exit_that_is_only_touched_is_said_to_be():
    """The turn takes 'b' at pi/2, where x does not reach it; the motion leaves later, by 'c'."""
    system = machine([("b", "1.00000000000001 - x"), ("c", "x + 0.5")], [("a", "0.5 - x")])
    reason, leg = reason_of(system, 0.5 * np.pi, TURN + np.arcsin(-0.9))
    assert leg == 0
    assert reason.startswith("leg 0 (a) does not end by 'b' at t = 1.57079633: its guard is only")
    assert reason.endswith("touched there, and the motion leaves by 'c' at t = 3.66519143"), reason


def test_an_exit_that_is_not_met_where_it_should_be():
    system = machine([("b", "1.1 - x"), ("c", "x + 0.5")], [("a", "0.5 - x")])
    reason, _ = reason_of(system, 0.5 * np.pi, TURN + np.arcsin(-0.9))
    assert "'b' at t = 1.57079633: its guard is not met there, and the motion leaves by" in reason
    alone = machine([("b", "1.1 - x")], [("a", "0.5 - x")])
    reason, _ = reason_of(alone, 0.5 * np.pi, TURN + np.arcsin(-0.9))
    assert reason.endswith("not met there, and the motion goes on in this mode")


def test_an_exit_that_comes_earlier_or_later_than_its_leg_ends():
    system = machine([("b", "0.9 - x")], [("a", "x + 0.2")])
    back = np.pi + np.arcsin(0.2)
    early, _ = reason_of(system, 1.3, back)
    assert early == (
        "in leg 0 (a) the motion leaves by 'b' at t = 1.11976951, before the leg ends at t = 1.3"
    )
    late, _ = reason_of(system, 1.1, back)
    assert late == (
        "leg 0 (a) does not end by 'b' at t = 1.1: its guard is not met there, and the motion"
        " leaves only at t = 1.11976951"
    )


def test_another_exit_at_the_end_of_a_leg():
    system = machine([("b", "0.5 - x"), ("c", "cos(t + pi/3)")], [("a", "x + 0.2")])
    reason, _ = reason_of(system, np.pi / 6, np.pi + np.arcsin(0.2), by=1)
    assert reason == (
        "leg 0 (a) does not end by 'c' at t = 0.523598776: the motion leaves by 'b' there"
    )


@pytest.mark.parametrize("flow", [FLOW, TAYLOR])
def test_an_orbit_that_touches_a_guard_is_a_motion(flow):
    """Also where the series takes several steps from there to the next event."""
    system = machine([("b", "x + 0.5"), ("c", "1 - x")], [("a", "-0.4 - x")], flow)
    orbit = ns.find_orbit(system, {"x": 0.0, "v": 1.0}, word="a b a")
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    run = ns.simulate(system, orbit, periods=1)
    kinds = list(zip(run["event_name"].values, run["event_kind"].values, strict=True))
    assert ("c", "graze") in kinds


def test_legs_of_messages_are_those_of_the_result():
    soft = ns.models.soft_impact(a=0.55)
    through = ns.find_orbit(soft, word="free")
    assert "in leg 0 (free) the motion leaves by 'impact' at t = " in through.attrs["message"]
    leg = ns.simulate(soft, through, t_end=2.0)["event_time"].values[1]
    assert times_of(through.attrs["message"])[0] == pytest.approx(leg, rel=1e-8)
