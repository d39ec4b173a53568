"""Where more than one motion begins a run says so; where one does, it runs.

Truths are closed forms. On a surface `sign` is any number between -1 and 1, and `heaviside` one
between 0 and 1: what the rates of either side alone keep on it is a motion of the system too.
"""

import warnings

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, RunWarning, Surface, System


def of(**equations):
    return System(states=list(equations), equations=equations)


def status_of(system, start=None, t_end=2.0):
    """Status of a run and its last state."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)
        run = ns.simulate(system, start or {}, t_end=t_end)
    return run.attrs["status"], run["end_state"].values.tolist(), run


# ---------------------------------------------------------------- one surface

RESTS_AND_LEAVES = {
    "linear, rests above": of(x="v", v="-heaviside(-x)"),  # x = 0, or -t**2/2
    "linear, rests below": of(x="v", v="heaviside(x)"),  # x = 0, or t**2/2
    "curved, rests above": of(x="v", v="-heaviside(-sin(x))"),
    "curved, rests below": of(x="v", v="heaviside(sin(x))"),
    "first order": of(x="-heaviside(-x)"),  # x = 0, or -t
    "third order": of(x="v", v="w", w="-heaviside(-x)"),  # x = 0, or -t**3/6
}


@pytest.mark.parametrize("name", RESTS_AND_LEAVES)
def test_one_side_rests_and_the_other_leaves(name):
    """From rest on the surface the motion may stay, by the one side, or go, by the other."""
    status, end, _ = status_of(RESTS_AND_LEAVES[name])
    assert status == "nonunique"
    assert not any(end)


@pytest.mark.parametrize("side", ["x", "-x", "sin(x)", "-sin(x)"])
def test_one_side_rests_and_the_other_leads_to_it(side):
    """heaviside pushes back to where it is zero: there is no other motion than rest."""
    push = "-" if not side.startswith("-") else ""
    status, end, run = status_of(of(x="v", v=f"{push}heaviside({side})"))
    assert (status, end) == ("completed", [0.0, 0.0])
    assert run.attrs["certified"] == 1


def test_the_side_that_is_declared_for_one_that_rests():
    for choice, x in (("above", 0.0), ("below", -0.5)):
        system = System(
            states=["x", "v"],
            surfaces={"side": Surface("x", on_nonunique=choice)},
            equations={"x": "v", "v": "-heaviside(-side)"},
        )
        status, end, _ = status_of(system, t_end=1.0)
        assert status == "completed"
        assert end == pytest.approx([x, 2 * x], abs=1e-14)


@pytest.mark.parametrize(
    "equations",
    [
        {"x": "0", "y": "sign(x)"},  # y = t or -t
        {"x": "0", "y": "w*sign(x)", "w": "1"},  # t**2/2 or -t**2/2
        {"x": "0", "y": "u*sign(x)", "w": "1", "u": "w"},  # t**3/6 or -t**3/6
        {"x": "0", "y": "cos(y)*sign(x)"},
    ],
)
def test_motions_that_stay_on_a_surface_and_part_along_it(equations):
    assert status_of(of(**equations))[0] == "nonunique"


@pytest.mark.parametrize(
    ("equations", "end"),
    [
        ({"x": "0", "y": "1 + abs(x)"}, [0.0, 2.0]),
        ({"x": "0", "y": "1 + x*sign(x)*cos(y)"}, [0.0, 2.0]),
        ({"x": "0", "y": "1 + 0*sign(x)"}, [0.0, 2.0]),
        ({"x": "0*sign(x)", "y": "1 + sin(0)*sign(y + 1)"}, [0.0, 2.0]),
    ],
)
def test_motions_that_stay_on_a_surface_and_are_the_same(equations, end):
    status, found, run = status_of(of(**equations))
    assert status == "completed"
    assert found == pytest.approx(end, abs=1e-14)
    assert run.attrs["certified"] == 1


def test_slide_to_where_one_side_rests():
    """x slides at 0 until t = 1; then above it rests, and below x = -(t - 1)**2/2."""
    status, end, run = status_of(of(x="where(x < 0, 1 - t, -max(1 - t, 0))"))
    assert status == "nonunique"
    assert end == [0.0]
    assert run["event_time"].values[-1] == pytest.approx(1.0, abs=1e-14)


# ---------------------------------------------------------------- several surfaces


@pytest.mark.parametrize(
    "equations",
    [
        {"x": "2 + sign(x)", "y": "sign(y)"},  # x = 3 t, y = t or -t
        {"x": "2 + sign(x)", "y": "where(x > 0, sign(y), 1)"},  # there is no y = 0 at x < 0
        {"x": "2 + sign(x)", "y": "2 + sign(y)", "z": "sign(z)"},
        {"x": "sign(y)", "y": "sign(x)"},  # both t, or both -t
        {"x": "sign(y)", "y": "sign(z)", "z": "sign(x)"},  # all three
        {"x": "sin(x) + sign(y)", "y": "cos(x)*sign(x)"},
    ],
)
def test_start_where_surfaces_meet_and_two_motions_begin(equations):
    assert status_of(of(**equations))[0] == "nonunique"


@pytest.mark.parametrize(
    ("equations", "end"),
    [
        ({"x": "2 + sign(x)", "y": "2 + sign(y)"}, [6.0, 6.0]),
        ({"x": "-2 + sign(x)", "y": "2 + sign(x)"}, [-6.0, 2.0]),
        ({"x": "2 + sign(y)", "y": "2 + sign(z)", "z": "-2 + sign(x)"}, [6.0, 2.0, -2.0]),
    ],
)
def test_start_where_surfaces_meet_and_one_motion_begins(equations, end):
    status, found, run = status_of(of(**equations))
    assert (status, run.attrs["certified"]) == ("completed", 1)
    assert found == pytest.approx(end, abs=1e-13)


def test_arrival_where_surfaces_meet():
    """x = y = 1 - t; behind t = 1 either x = -y = t - 1, or the opposite."""
    system = of(
        x="where(x > 0, where(y > 0, -1, 1), where(y > 0, -1, 1))",
        y="where(x > 0, where(y > 0, -1, -1), where(y > 0, 1, 1))",
    )
    status, end, _ = status_of(system, {"x": 1.0, "y": 1.0})
    assert status == "nonunique"
    assert end == pytest.approx([0.0, 0.0], abs=1e-14)


# ---------------------------------------------------------------- out of other modes, by jumps

LEAVES = Mode({"x": "sign(x)", "y": "1"})  # x = t or -t from 0
ENTRIES = {
    "stays on the surface": ("0", {}, 0.0),
    "is put onto it": ("1", {"x": "0"}, 0.0),
    "jumps onto it": ("1", {"x": "x - y"}, 0.0),
}


@pytest.mark.parametrize("name", ENTRIES)
def test_entry_into_a_mode_on_its_surface(name):
    rate, reset, start = ENTRIES[name]
    first = Mode({"x": rate, "y": "1"}, exits=[Exit("1 - y", to="second", reset=reset)])
    system = System(states=["x", "y"], modes={"first": first, "second": LEAVES})
    status, end, run = status_of(system, {"x": start})
    assert status == "nonunique"
    assert end == pytest.approx([0.0, 1.0], abs=1e-14)
    assert run["event_time"].values[-1] == pytest.approx(1.0, abs=1e-14)


def test_entry_into_a_mode_at_the_surface_that_was_the_guard():
    """x = 1 - t until 0; the second mode leads away on both sides, the third on one."""
    first = {"x": "-1", "y": "1"}
    for rate, answer in (("sign(x)", "nonunique"), ("-2 + sign(x)", "completed")):
        modes = {
            "first": Mode(first, exits=[Exit("x", to="second")]),
            "second": Mode({"x": rate, "y": "1"}),
        }
        status, end, _ = status_of(System(states=["x", "y"], modes=modes), {"x": 1.0})
        assert status == answer
        assert end == pytest.approx([0.0, 1.0] if answer == "nonunique" else [-3.0, 2.0], abs=1e-13)


@pytest.mark.parametrize("rate", ["sign(x)", "sign(x)*cos(x)"])
def test_impact_that_puts_something_onto_a_surface(rate):
    """y = 1 - t**2/2 lands at t = sqrt(2), and x is put to where both sides lead away."""
    rebound = Exit("y", reset={"x": "0", "u": "-u"})
    flow = {"x": rate, "y": "u", "u": "-1"}
    system = System(states=["x", "y", "u"], modes={"m": Mode(flow, exits=[rebound])})
    status, end, run = status_of(system, {"x": 1.0, "y": 1.0})
    assert status == "nonunique"
    assert run["event_time"].values[-1] == pytest.approx(np.sqrt(2.0), rel=1e-15)
    assert end == pytest.approx([0.0, 0.0, np.sqrt(2.0)], abs=1e-14)


def test_impact_on_a_surface_that_one_motion_leaves():
    """The same with one side that leads across: x = 3 (t - sqrt(2)) behind the impact."""
    rebound = Exit("y", reset={"x": "0", "u": "-u"})
    flow = {"x": "2 + sign(x)", "y": "u", "u": "-1"}
    system = System(states=["x", "y", "u"], modes={"m": Mode(flow, exits=[rebound])})
    status, end, run = status_of(system, {"x": 1.0, "y": 1.0})
    assert (status, run.attrs["certified"]) == ("completed", 1)
    assert end[0] == pytest.approx(3.0 * (2.0 - np.sqrt(2.0)), rel=1e-13)
