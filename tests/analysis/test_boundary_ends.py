"""Branches of impact cycles that shrink onto a boundary equilibrium, in proportion to the distance.

The equations are linear between impacts, x'' = 2 z v - (x - d), and nothing else has a length, so a
cycle at d is d times the one at 1, with the same duration and multiplier. These follow from the
closed form of the flight.
"""

import numpy as np
import pytest
from scipy.optimize import fsolve

import nonsmooth as ns

Z, R, END = 0.1, 0.6, 0.3


def oscillator(force: str) -> ns.System:
    """A self-excited mass that strikes a wall at x = 0; its rest reaches the wall at c = END."""
    return ns.System(
        states=["x", "v"],
        parameters={"c": 1.3, "z": Z, "r": R},
        modes={
            "flight": ns.Mode(
                {"x": "v", "v": f"2*z*v - ({force})"},
                exits=[ns.Exit("x", reset={"v": "-r*v"}, name="impact")],
            )
        },
    )


def flight(time, speed):
    """Place and velocity after a time of flight from the wall, for d = 1."""
    w = np.sqrt(1.0 - Z**2)
    growth, cos, sin = np.exp(Z * time), np.cos(w * time), np.sin(w * time)
    b = (speed + Z) / w  # x - 1 = growth (-cos + b sin)
    return (
        1.0 + growth * (b * sin - cos),
        growth * (Z * (b * sin - cos) + w * (b * cos + sin)),
    )


def cycle():
    """Duration and multiplier: what a change of speed has become behind the next impact."""

    def gaps(unknowns):
        x, v = flight(*unknowns)
        return [x, -R * v - unknowns[1]]

    time, speed = fsolve(gaps, [3.86, 0.4], xtol=1e-12)
    x_by, v_by = (
        np.imag(flight(time, speed + 1e-30j)[k]) / 1e-30 for k in (0, 1)
    )  # by complex steps
    rate, v = 2 * Z * flight(time, speed)[1] + 1.0, flight(time, speed)[1]
    return time, -R * (v_by - rate * x_by / v)


@pytest.mark.parametrize("force", [f"x - c + {END}", f"x + x**3 - c + {END}"])
def test_impact_cycles_end_at_a_boundary_equilibrium(force):
    system = oscillator(force)
    orbit = ns.find_orbit(system, {"x": 0.1, "v": 0.3})
    branch = ns.continue_orbit(system, "c", (-1.0, 2.0), initial=orbit)
    assert branch.attrs["end_first"] == "boundary_equilibrium"
    assert branch["special_kind"].values[0] == "boundary_equilibrium"
    end = branch.isel(point=0)
    assert float(end["c"]) == pytest.approx(END, abs=1e-13)
    assert abs(float(end["x"])) < 1e-13 and abs(float(end["v"])) < 1e-13
    assert "'impact'" in str(branch["special_detail"].values[0])
    assert f"the branch ends at c = {END}" in branch.attrs["message"]
    # a cycle 1e-5 of the first is as far from the limit where a cubic term bends it: its square
    time, multiplier = cycle()
    assert float(end["length"]) == pytest.approx(time, rel=1e-8)
    assert end["multipliers"].values[0].real == pytest.approx(multiplier, rel=1e-8)


def test_a_branch_away_from_the_wall_has_no_such_end():
    system = oscillator(f"x - c + {END}")
    orbit = ns.find_orbit(system, {"x": 0.1, "v": 0.3})
    branch = ns.continue_orbit(system, "c", (0.5, 2.0), initial=orbit)
    assert "boundary_equilibrium" not in branch["special_kind"].values
