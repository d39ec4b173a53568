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


def bell(**options: object) -> ns.System:
    """A clapper that hangs at rest in a bell which swings; both walls reach it at B = 0.4."""
    hit = {"w": "speed - 0.5*(w - speed)"}
    sticks = options.pop("sticks", {"right": None, "left": None})
    return ns.System(
        states=["c", "w"], parameters={"B": 0.1}, period="2*pi/1.3",
        definitions={"wall": "B*cos(1.3*t)", "speed": "-1.3*B*sin(1.3*t)"},
        modes={
            "swing": ns.Mode(
                {"c": "w", "w": "-c - 0.04*w"},
                exits=[
                    ns.Exit("0.4 - (c - wall)", reset=hit, name="right", sticks=sticks["right"]),
                    ns.Exit("0.4 + (c - wall)", reset=hit, name="left", sticks=sticks["left"]),
                ],
            )
        },
        **options,
    )  # fmt: skip


@pytest.mark.parametrize("sticks", [None, {"right": "at_right", "left": "at_left"}])
def test_walls_that_move_are_touched_by_what_is_at_rest(sticks):
    """What does not move lies on no wall that does: it grazes it."""
    hung = bell() if sticks is None else bell(sticks=sticks)
    branch = ns.continue_orbit(hung, "B", (0.0, 1.2), direction="up")
    assert branch["special_kind"].values[0] == "grazing"
    assert branch["special_value"].values[0] == pytest.approx(0.4, abs=1e-12)
    # both impacts begin at once, one of them at the strobe, and the branch turns back with them
    assert branch["special_kind"].values[1] == "fold" and branch["special_value"].values[1] < 0.1
    assert branch.attrs["end_last"] == "bound"


def test_impacts_without_speed_at_the_strobe_are_left_out():
    """Both impacts lose their speed where the walls turn, one of them at the strobe."""
    hung = bell(symmetry={"c": "-c", "w": "-w"})
    clangs = ns.find_orbit(hung, {"c": 0.5}, parameters={"B": 0.5}, transient=300)
    branch = ns.continue_orbit(hung, "B", (0.0, 0.5), initial=clangs, direction="down")
    assert branch["special_kind"].values.tolist() == ["bound", "grazing", "fold"]
    assert branch["special_value"].values[1] == pytest.approx(0.4, abs=1e-12)
    rest = branch["B"].values < 0.4
    assert np.count_nonzero(rest & (np.abs(branch["c"].values) < 1e-12)) > 3
