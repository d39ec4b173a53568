"""Branches of a body that slides in a box and strikes its walls: slip is the rate of the gap.

Each graze of a wall is then a change of slip as well, and two tests of the branch vanish together.
"""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns

IMPACT = {
    "vx": "vx + (1 + e)*m/(m + M)*(vy - vx)",
    "vy": "vy - (1 + e)*M/(m + M)*(vy - vx)",
}
DAMPER = ns.System(
    name="impact damper with friction",
    states=["x", "vx", "y", "vy"],
    parameters={
        "M": 4.0, "m": 0.6, "k": 3600.0, "c": 6.0, "F": 30.0, "f": 5.2, "d": 0.004, "e": 0.55,
        "mu": 0.08, "g": 9.81,
    },
    period="1/f",
    definitions={"friction": "mu*m*g*sign(slip)"},
    surfaces={"slip": ns.Surface("vy - vx", below="back", on="stick", above="forth")},
    modes={
        "loose": ns.Mode(
            {
                "x": "vx",
                "vx": "(F*cos(2*pi*f*t) - c*vx - k*x + friction)/M",
                "y": "vy",
                "vy": "-friction/m",
            },
            exits=[
                ns.Exit("d - (y - x)", reset=IMPACT, sticks="right", name="hit_right"),
                ns.Exit("d + (y - x)", reset=IMPACT, sticks="left", name="hit_left"),
            ],
        )
    },
)  # fmt: skip


def is_motion(point: xr.Dataset) -> bool:
    """Whether a run from a point of a branch comes back to it."""
    run = ns.simulate(DAMPER, point, periods=1, parameters={"f": float(point["f"])})
    ends = run["end_state"].values
    begins = np.array([float(point[name]) for name in DAMPER.states])
    return bool(np.abs(ends - begins).max() < 1e-8)


def special(branch: xr.Dataset, kind: str, number: int = 0) -> tuple[float, str]:
    """Value and detail of a special point of a kind."""
    where = np.flatnonzero(branch["special_kind"].values == kind)[number]
    row = branch.isel(special=int(where))
    return float(row["special_value"]), row["special_detail"].item()


@pytest.mark.slow
def test_a_leg_that_leaves_a_surface_and_comes_back_vanishes_and_the_branch_goes_on():
    branch = ns.continue_orbit(DAMPER, "f", (5.195, 5.2095), direction="up")
    assert branch.attrs["end_last"] == "bound"
    value, detail = special(branch, "switching_sliding")
    assert value == pytest.approx(5.2074407, abs=1e-6)
    assert "the branch goes on as" in detail
    assert all(is_motion(branch.isel(point=k)) for k in range(branch.sizes["point"]))
    # what a motion settles to beyond is this branch
    settled = ns.find_orbit(DAMPER, branch.isel(point=0), transient=400, parameters={"f": 5.2095})
    assert settled["word"].item() == branch["word"].values[-1]
    assert float(settled["x"]) == pytest.approx(float(branch["x"].values[-1]), abs=1e-9)


@pytest.mark.slow
def test_the_range_of_the_parameter_does_not_decide_whether_a_branch_goes_on():
    """Which of the tests that vanish with a leg is found first depends on rounding."""
    details = []
    for high in (5.3, 5.5, 6.0):
        branch = ns.continue_orbit(DAMPER, "f", (5.0, high), direction="up", steps=20)
        value, detail = special(branch, "switching_sliding")
        assert value == pytest.approx(5.20744075, abs=1e-7)
        assert branch.attrs["end_last"] == "steps"
        details.append(detail)
    assert len(set(details)) == 1


@pytest.mark.slow
def test_what_an_orbit_touches_is_told_as_it_was_written():
    """A surface with its function, an exit with its guard."""
    branch = ns.continue_orbit(DAMPER, "f", (5.1, 5.3), direction="up", steps=40)
    assert "touches the surface 'slip' (vy - vx = 0)" in special(branch, "grazing_sliding", 1)[1]


def test_a_wall_is_touched_just_where_slip_changes():
    system = DAMPER.with_parameters(f=5.34)
    branch = ns.continue_orbit(system, "f", (5.3, 5.345), direction="down", steps=30)
    value, detail = special(branch, "grazing")
    assert value == pytest.approx(5.334728, abs=1e-6)
    assert "reaches 'hit_left' (d + (y - x) = 0) just as it ends" in detail
    graze = int(branch["special_point"].values[branch["special_kind"].values == "grazing"][0])
    assert graze > 3  # the points of a branch that goes down are in the order of the parameter
    assert all(is_motion(branch.isel(point=k)) for k in range(branch.sizes["point"]) if k != graze)
    behind, before = branch.isel(point=graze - 3), branch.isel(point=graze + 1)
    hits = [list(each["leg_exit"].values).count("hit_left>slip") for each in (before, behind)]
    assert hits[1] == hits[0] + 1
    # back over the graze from the side of the impact
    back = ns.continue_orbit(
        DAMPER, "f", (5.3, 5.345), initial=behind, parameters={"f": float(behind["f"])}, steps=30
    )
    assert value == pytest.approx(special(back, "grazing")[0], abs=1e-9)
    assert before["word"].item() in back["word"].values.tolist()
