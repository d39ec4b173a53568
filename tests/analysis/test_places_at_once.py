"""Branches where an orbit changes at several places at once, as symmetric and twin machines do.

Between stops the motion is that of a linear oscillator, of amplitude F/|1 - w^2 + i c w|, so both
stops are touched at F = g |1 - w^2 + i c w|. Beyond, one mass and two equal ones that move as one
have the same orbits, whatever couples them.
"""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.structures import Force, GapSpring, machine

GAP, SPEED, DAMPING = 0.6, 1.3, 0.1
TOUCH = GAP * abs(1.0 - SPEED**2 + 1j * DAMPING * SPEED)
FLOW = "F*cos(w*t) - 0.1*v - x"


def between_stops():
    """A mass between two springs, with a mode for each."""
    return ns.System(
        states=["x", "v"], parameters={"k": 0.8, "g": GAP, "F": 0.3, "w": SPEED}, period="2*pi/w",
        modes={
            "free": ns.Mode({"x": "v", "v": FLOW}, exits=[
                ns.Exit("g - x", to="above", name="up"), ns.Exit("x + g", to="below", name="down"),
            ]),
            "above": ns.Mode({"x": "v", "v": f"{FLOW} - k*(x - g)"},
                             exits=[ns.Exit("x - g", to="free", name="left_above")]),
            "below": ns.Mode({"x": "v", "v": f"{FLOW} - k*(x + g)"},
                             exits=[ns.Exit("-x - g", to="free", name="left_below")]),
        },
    )  # fmt: skip


def as_machine():
    """The same, made of its parts."""
    structure = ns.Structure(np.eye(1), np.eye(1), damping=[[DAMPING]], coordinates=["1x"])
    return machine(
        structure, contacts=[GapSpring("1x", gap=GAP, stiffness=0.8, side="both")],
        loads=[Force("1x", "F*cos(omega*t)")], parameters={"F": 0.3, "omega": SPEED},
        period="2*pi/omega",
    )  # fmt: skip


@pytest.mark.few(1)
@pytest.mark.parametrize("make", [between_stops, as_machine])
def test_a_branch_goes_on_where_both_stops_are_touched(make):
    branch = ns.continue_orbit(make(), "F", (0.3, 0.46), largest_step=0.2)
    assert list(branch["special_kind"].values) == ["bound", "grazing", "bound"]
    assert float(branch["special_value"][1]) == pytest.approx(TOUCH, rel=1e-9)
    last = branch.isel(point=-1)
    assert bool(last["admissible"]) and len(str(last["word"].values).split()) == 5
    # volumes shrink by exp(-c T), and pairs of multipliers share that
    root = np.exp(-0.5 * DAMPING * 2.0 * np.pi / SPEED)
    assert np.abs(last["multipliers"].values) == pytest.approx([root, root], rel=1e-9)


def masses(count, coupling):
    """Equal masses with equal springs above, which one force drives."""
    states, equations = [], {}
    for i in range(count):
        states += [f"x{i}", f"v{i}"]
        pull = f" + c*(x{1 - i} - x{i})" if count > 1 else ""
        equations |= {
            f"x{i}": f"v{i}",
            f"v{i}": f"F*cos(w*t) - 0.1*v{i} - x{i} - k*max(x{i} - g, 0){pull}",
        }
    values = {"k": 0.8, "g": GAP, "F": 0.5, "w": SPEED} | ({"c": coupling} if count > 1 else {})
    return ns.System(states=states, parameters=values, period="2*pi/w", equations=equations)


@pytest.mark.few(1)
@pytest.mark.parametrize("coupling", [0.1, 0.0, 0.3])
def test_masses_that_move_as_one_have_the_orbits_of_one(coupling):
    one, two = masses(1, 0.0), masses(2, coupling)
    for force in (0.44, 0.54, 0.84):
        alone = ns.find_orbit(one, parameters={"F": force}, transient=800)
        both = ns.find_orbit(two, parameters={"F": force}, transient=800)
        assert both.attrs["status"] == "completed", both.attrs["message"]
        for name in ("x0", "x1"):
            assert float(both[name]) == pytest.approx(float(alone["x0"]), rel=1e-10)
    branch = ns.continue_orbit(two, "F", (0.4, 0.6), largest_step=0.2)
    assert list(branch["special_kind"].values) == ["bound", "grazing", "bound"]
    assert float(branch["special_value"][1]) == pytest.approx(TOUCH, rel=1e-9)
