"""Orbits that are equilibria, and meet a surface: they go on beyond it, or turn back there."""

import numpy as np
import pytest

import nonsmooth as ns

STOP = 0.7


def over_gap(force: str, **parameters: float) -> ns.System:
    """A mass on a spring with a stop, under a load; its forcing has no amplitude."""
    return ns.System(
        states=["x", "v"], parameters={"c": 0.1, "s": STOP, "a": 0.0} | parameters, period=1.0,
        modes={
            "gap": ns.Mode(
                {"x": "v", "v": f"-x - c*v + ({force}) + a*cos(2*pi*t)"},
                exits=[ns.Exit("s - x", reset={"v": "-0.3*v"}, sticks="closed", name="snap")],
            )
        },
    )  # fmt: skip


def test_a_switch_opens_at_a_fold_with_the_equilibrium_that_nothing_keeps():
    """x (1 - x)**2 = V**2: the rest at the stop ends where the unstable equilibrium comes to it."""
    switch = over_gap("V**2/(1 - x)**2", V=0.3)
    closed = ns.find_orbit(switch, {"x": STOP, "v": 0.0}, transient=0)
    branch = ns.continue_orbit(switch, "V", (0.2, 0.4), initial=closed)
    assert {branch.attrs["end_first"], branch.attrs["end_last"]} == {"bound"}
    kinds = branch["special_kind"].values
    places = dict(zip(kinds.tolist(), branch["special_value"].values.tolist(), strict=True))
    assert places["boundary_equilibrium"] == pytest.approx(np.sqrt(STOP) * 0.3, abs=1e-13)
    assert places["fold"] == pytest.approx(np.sqrt(4.0 / 27.0), abs=1e-12)
    x, v = branch["x"].values, branch["V"].values
    free = x < STOP - 1e-9
    assert np.count_nonzero(free) > 5
    assert x[free] * (1.0 - x[free]) ** 2 == pytest.approx(v[free] ** 2, abs=1e-12)
    assert x[~free] == pytest.approx(STOP, abs=1e-9)


def test_a_mass_is_pressed_against_its_stop_by_more_than_the_spring_takes():
    pressed = over_gap("F", F=0.5)
    branch = ns.continue_orbit(pressed, "F", (0.3, 1.2))
    assert {branch.attrs["end_first"], branch.attrs["end_last"]} == {"bound"}
    at = branch["special_kind"].values == "boundary_equilibrium"
    assert branch["special_value"].values[at] == pytest.approx([STOP], abs=1e-12)
    assert branch["x"].values == pytest.approx(np.minimum(branch["F"].values, STOP), abs=1e-12)
