"""Maps that are defined piece by piece, as resets at a clock: their borders, in closed form."""

import numpy as np
import pytest

import nonsmooth as ns

ROUNDING = 1e-11  # of a border: tests change sign where a guard comes below 500 of its roundings


def clocked(state: str, formula: str, **parameters: float) -> ns.System:
    """A state that a clock sets once in a unit of time."""
    tick = ns.Exit("1 - tau", reset={"tau": "0", state: formula}, name="tick")
    return ns.System(
        states=[state, "tau"],
        parameters=parameters,
        initial={state: 0.1},
        period=1.0,
        modes={"wait": ns.Mode({state: "0", "tau": "1"}, exits=[tick])},
    )


def special(branch, kind="border_collision"):
    return branch["special_value"].values[branch["special_kind"].values == kind]


def test_a_persistent_border_is_passed_with_both_multipliers():
    system = clocked("y", "1 + mu + where(y < 1, a*(y - 1), b*(y - 1))", mu=0.5, a=0.6, b=-0.5)
    branch = ns.continue_orbit(system, "mu", (-1.0, 1.0))
    assert [branch.attrs[f"end_{end}"] for end in ("first", "last")] == ["bound", "bound"]
    assert special(branch) == pytest.approx([0.0], abs=ROUNDING)
    detail = branch["special_detail"].values[branch["special_kind"].values == "border_collision"]
    assert "comes to lie on the surface" in detail[0] and "the branch goes on" in detail[0]
    mu, y = branch["mu"].values, branch["y"].values
    slope = np.where(mu > 0.0, -0.5, 0.6)
    assert y == pytest.approx(1.0 + mu / (1.0 - slope), abs=ROUNDING)
    beside = np.abs(mu) > ROUNDING
    assert branch["multipliers"].values[beside, 0].real == pytest.approx(slope[beside], rel=1e-9)


@pytest.mark.slow
def test_two_orbits_meet_at_a_border_and_the_branch_turns_back():
    """L L R and L R R of x -> a x + 1 (L, below zero) and b x + 1 (R): 1 + a (b + 1) = 0 there."""
    a = 0.3
    system = clocked("x", "where(x < 0, a*x + 1, b*x + 1)", a=a, b=-5.0)
    branch = ns.continue_orbit(system, "b", (-6.0, -4.0), period=3)
    assert special(branch) == pytest.approx([-1.0 / a - 1.0], abs=ROUNDING)
    b, factor = branch["b"].values, branch["multipliers"].values[:, 0].real
    right = np.where(np.abs(factor - a * a * b) < np.abs(factor - a * b * b), 1, 2)
    assert factor == pytest.approx(a ** (3 - right) * b**right, rel=1e-9)
    assert set(right.tolist()) == {1, 2} and bool(branch["admissible"].all())
    at = branch["special_kind"].values.tolist().index("border_collision")
    curve = ns.continue_special(branch, at, "a", (0.1, 0.6), largest_step=0.2)
    assert curve["b"].values == pytest.approx(-1.0 / curve["a"].values - 1.0, rel=1e-9)
    # within the range of b
    assert sorted(curve["a"].values[[0, -1]]) == pytest.approx([1.0 / 5.0, 1.0 / 3.0], rel=1e-9)


def test_a_border_is_passed_by_a_leg_that_the_strobe_cuts():
    """Once in a period of the forcing, between strobes, y is set anew."""
    formula = "1 + mu + where(y < 1, 0.6*(y - 1), -0.5*(y - 1))"
    modes = {
        "wait": ns.Mode({"y": "0"}, exits=[ns.Exit("cos(t)", to="rest", reset={"y": formula})]),
        "rest": ns.Mode({"y": "0"}, exits=[ns.Exit("-cos(t)", to="wait")]),
    }
    system = ns.System(
        states=["y"], parameters={"mu": 0.5}, initial={"y": 1.1}, period="2*pi", modes=modes
    )
    branch = ns.continue_orbit(system, "mu", (-1.0, 1.0), phase=0.1)
    assert special(branch) == pytest.approx([0.0], abs=ROUNDING)
    mu = branch["mu"].values
    slope = np.where(mu > 0.0, -0.5, 0.6)
    assert branch["y"].values == pytest.approx(1.0 + mu / (1.0 - slope), abs=ROUNDING)


@pytest.mark.parametrize("beyond", [-0.5, 1.8])
def test_a_border_at_zero_is_one_like_any_other(beyond):
    """x -> a x + m below zero and b x + m above it: m/(1 - a) and m/(1 - b)."""
    system = clocked("x", "where(x < 0, a*x + m, b*x + m)", a=0.6, b=beyond, m=-0.1)
    start = ns.find_orbit(system, {"x": -0.2}, transient=30)
    branch = ns.continue_orbit(system, "m", (-0.3, 0.4), initial=start)
    assert special(branch) == pytest.approx([0.0], abs=ROUNDING)
    assert {branch.attrs[f"end_{end}"] for end in ("first", "last")} == {"bound"}
    m, x = branch["m"].values, branch["x"].values
    slope = np.where(x < 0.0, 0.6, beyond)
    assert x == pytest.approx(m / (1.0 - slope), abs=ROUNDING)
    # for b > 1 both orbits lie on the side m < 0, where the branch turns back
    assert (m.max() > 0.1) == (beyond < 1.0)
