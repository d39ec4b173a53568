"""Branches of impact cycles that shrink onto a boundary equilibrium, in proportion to the distance.

The equations are linear between impacts, x'' = 2 z v - (x - d), and nothing else has a length, so a
cycle at d is d times the one at 1, with the same duration and multiplier. These follow from the
closed form of the flight.
"""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq, fsolve

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


@pytest.mark.parametrize("wall", [0.7, 5.0, 100.0])
def test_where_the_wall_stands_does_not_matter(wall):
    """Cycles of next to nothing at a state that is large beside them, and a force that bends."""
    z = f"(x - {wall})"
    system = ns.System(
        states=["x", "v"],
        parameters={"c": 1.3, "z": Z, "r": R},
        modes={
            "flight": ns.Mode(
                {"x": "v", "v": f"2*z*v - ({z} + 0.2*{z}**2 - c + {END})"},
                exits=[ns.Exit(f"x - {wall}", reset={"v": "-r*v"}, name="impact")],
            )
        },
    )
    orbit = ns.find_orbit(system, {"x": wall + 0.1, "v": 0.3})
    branch = ns.continue_orbit(system, "c", (-1.0, 2.0), initial=orbit)
    assert list(branch["special_kind"].values) == ["boundary_equilibrium", "bound"]
    end = branch.isel(point=0)
    # the rest has z + 0.2 z**2 = c - END, so that c is as far off as roundings of x
    assert float(end["c"]) == pytest.approx(END, abs=4e-16 * (1.0 + wall))
    assert float(end["x"]) == pytest.approx(wall, rel=1e-15)
    # the last cycle is 1e-5 of the first or so, as are changes by the square, or so large that
    # 1e7 roundings of x are less than it
    time, multiplier = cycle()
    assert float(end["length"]) == pytest.approx(time, rel=1e-6 * (10.0 + wall))
    assert end["multipliers"].values[0].real == pytest.approx(multiplier, rel=1e-5 * (10.0 + wall))


def test_a_wall_that_moves_far_with_the_parameter():
    """Cycles move by many times their size before they shrink: steps keep to both."""
    system = ns.System(
        states=["x", "v"],
        parameters={"c": 1.3, "z": Z, "r": R},
        definitions={"wall": "100*c"},
        modes={
            "flight": ns.Mode(
                {"x": "v", "v": f"2*z*v - (x - wall - c + {END})"},
                exits=[ns.Exit("x - wall", reset={"v": "-r*v"}, name="impact")],
            )
        },
    )
    orbit = ns.find_orbit(system, {"x": 130.1, "v": 0.3})
    branch = ns.continue_orbit(system, "c", (0.0, 2.0), initial=orbit)
    assert list(branch["special_kind"].values) == ["boundary_equilibrium", "bound"]
    assert branch.sizes["point"] < 200
    assert float(branch["c"][0]) == pytest.approx(END, abs=1e-13)
    time, multiplier = cycle()
    apart = branch["c"].values > END + 1e-3  # else roundings of x are more of a cycle
    assert branch["length"].values[apart] == pytest.approx(time, rel=1e-9)
    multipliers = branch["multipliers"].values[apart, 0].real
    assert multipliers == pytest.approx(multiplier, rel=1e-8)


CAPACITY, ATTACK, HANDLING, GAIN, DEATH = 5.0, 1.6, 0.7, 0.75, 0.45


def harvest() -> ns.System:
    """Predators are hunted where they are more than Th, and held there for a while in each turn."""
    return ns.System(
        states=["x", "y"],
        parameters={"Th": 1.0},
        equations={
            "x": f"x*(1 - x/{CAPACITY}) - {ATTACK}*x*y/(1 + {HANDLING}*x)",
            "y": f"{GAIN * ATTACK}*x*y/(1 + {HANDLING}*x) - {DEATH}*y - 0.6*y*heaviside(side)",
        },
        surfaces={"side": ns.Surface("y - Th", below="rest", on="slide", above="hunt")},
        initial={"x": 1.0, "y": 0.3},
    )


def rest_of_harvest():
    """Rest without hunting, and the linear equations there."""
    x = DEATH / (GAIN * ATTACK - DEATH * HANDLING)
    y = (1.0 - x / CAPACITY) * (1.0 + HANDLING * x) / ATTACK
    eaten, part = 1.0 + HANDLING * x, ATTACK * y / (1.0 + HANDLING * x) ** 2
    return (
        x,
        y,
        np.array([[1.0 - 2.0 * x / CAPACITY - part, -ATTACK * x / eaten], [GAIN * part, 0.0]]),
    )


def length_of_small_harvest() -> float:
    """Duration of the cycle of the linear equations that leaves the surface at (0, 1)."""
    matrix = rest_of_harvest()[2]

    def flow(time: float) -> np.ndarray:
        return expm(matrix * time) @ np.array([0.0, 1.0])

    back = brentq(lambda time: flow(time)[1] - 1.0, 5.0, 12.0, xtol=1e-14)
    # on the surface x' = a x + b with y = 1 kept, down to x = 0, where y' is zero below it
    a, b = matrix[0]
    return float(back + np.log(b / (a * flow(back)[0] + b)) / a)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("threshold", "step", "largest"),
    [(1.0, 0.05, 0.2), (1.0, 1.0, 1.0), (1.1, 0.7, 0.7), (1.3, 0.5, 0.5)],
)
def test_cycles_that_slide_end_where_their_rest_is_on_the_surface(threshold, step, largest):
    """However long the steps are: some come to the end itself, and no cycle there says anything."""
    x, y, _ = rest_of_harvest()
    system = harvest().with_parameters(Th=threshold)
    branch = ns.continue_orbit(
        system, "Th", (0.3, 2.0), direction="down", step=step, largest_step=largest
    )
    assert branch.attrs["end_first"] == "boundary_equilibrium"
    assert list(branch["special_kind"].values) == ["boundary_equilibrium"]
    assert "'side'" in str(branch["special_detail"].values[0])
    end = branch.isel(point=0)
    assert float(end["Th"]) == pytest.approx(y, rel=4e-15)
    assert float(end["x"]) == pytest.approx(x, rel=1e-14)
    assert float(end["y"]) == pytest.approx(y, rel=4e-15)
    assert float(end["length"]) == pytest.approx(length_of_small_harvest(), rel=1e-6)
    assert end["multipliers"].values == pytest.approx([0.0], abs=1e-12)


def relayed(p: float, c: float) -> ns.System:
    """A relay around (1 + c s) K/((s + 1) (s + 5) (s + p)), without hysteresis."""
    return ns.System(
        states=["x", "y", "z"],
        parameters={"K": 3.0, "p": p, "c": c},
        initial={"x": 0.5},
        equations={
            "x": "y",
            "y": "z",
            "z": "-5*p*x - (5 + 6*p)*y - (6 + p)*z - K*sign(e)",
        },
        surfaces={"e": ns.Surface("x + c*y")},
    )


@pytest.mark.parametrize(
    ("p", "between"), [(2.0, (0.0, 0.3)), pytest.param(4.0, (-0.3, 1.5), marks=pytest.mark.slow)]
)
def test_a_cycle_that_shrinks_with_its_period(p, between):
    """At high frequencies the loop is c/s**2 (1 + (1/c - 6 - p)/s): it turns round for ever at 1/c.

    Fast switches are damped or driven by the sign of what is in brackets; the parameter is where it
    vanishes. The point is the origin, on either side of which the relay pushes to the other one.
    """
    system = relayed(p, 0.05)
    orbit = ns.find_orbit(system, transient=5)
    branch = ns.continue_orbit(system, "c", between, initial=orbit, direction="up")
    assert branch.attrs["end_last"] == branch["special_kind"].values[-1] == "pseudo_hopf"
    assert "shrinks to a point as its period does" in branch.attrs["message"]
    last = branch.isel(point=-1)
    # periods of 1e-2 fix the parameter by terms of their sixth power, 1e-12, beside what rounding
    # leaves of cycles: states of 1e-8 to 1e-6 over rates of 1, in a fit that makes ten times of it
    assert float(last["c"]) == pytest.approx(1.0 / (6.0 + p), abs=1e-8)
    assert [float(last[name]) for name in "xyz"] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    with pytest.raises(ns.OptionError, match="is a pseudo_hopf point"):
        ns.continue_special(branch, branch.sizes["special"] - 1, "p", (1.0, 5.0))


def test_cycles_of_a_third_order_relay_shrink_onto_the_rest_at_its_threshold():
    """The rest of y < b is y = 1.25, q = 0.5, so it lies on the surface at b = 1.25.

    A multiplier grows as one over the distance from there, so equations lose their digits before
    the cycle is next to nothing.
    """
    relay = ns.System(
        states=["y", "z", "q"], parameters={"b": 1.2}, initial={"y": 1.0},
        equations={"y": "z", "z": "q - z - 0.4*y", "q": "-2*q - sign(y - b)"},
    )  # fmt: skip
    branch = ns.continue_orbit(
        relay, "b", (1.1, 1.3), initial=ns.find_orbit(relay, transient=10), direction="up"
    )
    assert branch.attrs["end_last"] == "boundary_equilibrium"
    assert list(branch["special_kind"].values[-2:]) == ["fold", "boundary_equilibrium"]
    assert float(branch["special_value"][-1]) == pytest.approx(1.25, abs=1e-12)
    end = branch.isel(point=-1)
    assert [float(end[name]) for name in "yzq"] == pytest.approx([1.25, 0.0, 0.5], abs=1e-11)
