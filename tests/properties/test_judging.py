"""The judge of random systems sees what is wrong: runs are held against other words."""

import copy

import numpy as np
import pytest

import nonsmooth as ns
from properties.fields import deviation
from properties.judging import complaints, dip_times, flight_times, flights
from properties.own_texts import Texts
from properties.words import Drawn, Switch, make_system

WALL = {
    "states": ["x", "v"],
    "parameters": {"r": 0.4, "a": 0.1},
    "modes": {
        "m": {
            "flow": {"x": "v", "v": "2 - 3*x - 0.2*v"},
            "exits": [
                {
                    "guard": "0.3 + a*sin(2*t) - x",
                    "reset": {"v": "-r*v + (1 + r)*2*a*cos(2*t)"},
                    "sticks": "rest",
                    "name": "e0",
                }
            ],
        }
    },
}
BELT = {
    "states": ["x", "v"],
    "surfaces": {"slip": {"function": "v - 0.3", "below": "lag", "on": "stick", "above": "lead"}},
    "equations": {"x": "v", "v": "-x - 0.4*sign(slip)"},
}
START = {"x": -0.5, "v": 0.4}


def judged(words, other=None):
    """Complaints about a run of some words, held against others."""
    run = ns.simulate(make_system(words), START, t_end=12.0)
    dense = ns.simulate(make_system(words), START, times=flight_times(run))
    switches = [Switch("v - 0.3")] if words is BELT else []
    drawn = Drawn(0, other or words, START, {}, switches)
    texts = Texts(drawn.words)
    found = complaints(drawn, texts, dense)
    for flight in flights(drawn, texts, dense):
        found += deviation(drawn, texts, flight, 2.0)
    return found


def changed(words, place, value):
    """Words with one of them changed."""
    other = copy.deepcopy(words)
    *path, last = place
    inner = other
    for key in path:
        inner = inner[key]
    inner[last] = value
    return other


@pytest.mark.parametrize("words", [WALL, BELT])
def test_a_right_run_is_right(words):
    assert judged(words) == []


EXIT = ("modes", "m", "exits", 0)
WRONG = [
    (WALL, (*EXIT, "guard"), "0.29999999 + a*sin(2*t) - x", "guard e0"),
    (WALL, (*EXIT, "reset"), {"v": "-r*v + 2*a*cos(2*t)"}, "state behind e0"),
    (WALL, ("modes", "m", "flow", "v"), "2 - 3*x - 0.2001*v", "integrated motion"),
    (WALL, ("parameters", "a"), 0.11, "guard e0 at rest"),
    (BELT, ("surfaces", "slip", "function"), "v - 0.3000001", "stick"),
    (BELT, ("equations", "v"), "-x - 0.38*sign(slip)", "u = "),
    (BELT, ("equations", "v"), "-x - 0.4*sign(slip) - 0.001*v", "integrated motion"),
]


@pytest.mark.few(1)
@pytest.mark.parametrize(("words", "place", "value", "says"), WRONG)
def test_a_wrong_run_is_seen(words, place, value, says):
    assert any(says in text for text in judged(words, changed(words, place, value)))


def one_way(guard):
    """Words of a clock with a guard that changes from one mode to another."""
    flow = {"x": "1"}
    way = {"guard": guard, "to": "b", "name": "e0"}
    return {"states": ["x"], "modes": {"a": {"flow": flow, "exits": [way]}, "b": {"flow": flow}}}


def judged_clock(guard, other):
    """Complaints about a run with a guard, held against another guard; with dips and without."""
    drawn, texts = Drawn(0, one_way(other), {}, {}), Texts(one_way(other))
    system = make_system(one_way(guard))
    times = flight_times(ns.simulate(system, {"x": 0.0}, t_end=4.0))
    dense = ns.simulate(system, {"x": 0.0}, times=times)
    dips = dip_times(drawn, texts, dense)
    found = complaints(drawn, texts, dense)
    if len(dips):
        found += complaints(drawn, texts, ns.simulate(system, {"x": 0.0}, times=dips))
    return found


@pytest.mark.parametrize("scale", ["1e-12", "1", "1e12"])
def test_a_guard_that_fires_where_it_is_not_zero_is_seen(scale):
    right, wrong = f"{scale}*(2.5 - x)", f"{scale}*(2.50000001 - x)"
    assert judged_clock(right, right) == []
    assert any("where it is passed" in text for text in judged_clock(right, wrong))


@pytest.mark.parametrize("scale", ["1e-12", "1", "1e12"])
@pytest.mark.parametrize("power", [2, 4, 10])
def test_a_dip_between_samples_is_seen(power, scale):
    """Negative for 0.002 on both sides of 1.2345, with samples 0.08 apart."""
    dip = f"{scale}*((x - 1.2345)**{power} - 0.002**{power})"
    miss = f"{scale}*((x - 1.2345)**{power} + 0.002**{power})"
    assert judged_clock(miss, miss) == []
    assert any("guard e0 is -" in text for text in judged_clock(miss, dip))


def test_texts_have_values_of_their_own():
    texts = Texts(
        {"states": ["x", "y"], "equations": {"x": "y", "y": "-x"}, "parameters": {"k": 2}}
    )
    z = np.array([[0.5, -1.0], [-0.5, 3.0]])
    joined = texts.value("where((x > 0) and not (y > 0) or (y > 2), 1, 2)", z, 0.0)
    assert joined.tolist() == [1.0, 1.0]
    value = texts.value(
        "where(x > 0, k*abs(y), min(x, y)) + heaviside(-x) + clip(y, -2, 2)", z, 0.0
    )
    assert value.tolist() == [2.0 + 0.0 - 1.0, -0.5 + 1.0 + 2.0]
    assert texts.field("flow", z, 0.0).tolist() == [[-1.0, -0.5], [3.0, 0.5]]
    assert texts.along("x*y", z, 0.0, texts.field("flow", z, 0.0)) == pytest.approx(
        [1.0 - 0.25, 9.0 - 0.25], abs=1e-9
    )


def test_states_given_by_equations_have_rates():
    """z + z^3/9 = y gives z' = y'/(1 + z^2/3), and v = 2 w, w + v = x gives v' = 2 x'/3."""
    slaved = {"z": "z + z**3/9 = y", "v": "v = 2*w", "w": "w + v = x"}
    mode = {"flow": {"x": "3", "y": "x"}, "slaved": slaved}
    texts = Texts({"states": ["x", "y", "z", "v", "w"], "modes": {"m": mode}})
    z = np.array([[1.5, 1.0 + 1.0 / 9.0, 1.0, 1.0, 0.5], [0.0, 0.0, 0.0, 0.0, 0.0]])
    rates = [[3.0, 1.5, 1.5 / (4.0 / 3.0), 2.0, 1.0], [3.0, 0.0, 0.0, 2.0, 1.0]]
    assert texts.field("m", z, 0.0) == pytest.approx(np.array(rates), abs=1e-9)
