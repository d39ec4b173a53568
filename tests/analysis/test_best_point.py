"""The best point along a branch against closed forms and against a sweep of motions."""

import numpy as np
import pytest
from mpmath import findroot, mp, mpf

import nonsmooth as ns
from nonsmooth.analysis.best_point import largest_inside
from periodic_orbits.references.rigid_wall import RigidWall
from periodic_orbits.systems import rigid_wall

WALL = {"zeta": 0.1, "sigma": 0.1, "r": 0.8}


@pytest.fixture(scope="module")
def mole():
    return ns.models.moling(a=0.3, b=0.15, xi=0.05, omega=0.1)


@pytest.fixture(scope="module")
def branch(mole):
    return ns.continue_orbit(mole, "b", (0.1, 0.18))


@pytest.fixture(scope="module")
def wall_branch():
    return ns.continue_orbit(rigid_wall(omega=2.2, **WALL), "omega", (1.6, 2.6))


def impact_speed(orbit) -> float:
    """Speed just before the impact, from that just behind it."""
    return -float(orbit["leg_states"].sel(state="v")[1]) / WALL["r"]


def special_value(branch, kind: str) -> float:
    return float(branch["special_value"].values[list(branch["special_kind"].values).index(kind)])


def test_hardest_impact_at_a_rigid_wall(wall_branch):
    """The speed has a closed form over the frequency; its maximum to 1e-9."""

    def speed(omega):
        return RigidWall.of(omega=omega, **WALL).speeds(1)[0]

    best = ns.best_point(wall_branch, impact_speed)
    with mp.workdps(40):
        h = mpf("1e-12")
        top = findroot(lambda w: (speed(w + h) - speed(w - h)) / (2 * h), (1.93, 1.94), tol=1e-25)
        exact = float(top), float(speed(top))
    assert best["limited_by"].item() == "interior"
    assert abs(best["omega"].item() / exact[0] - 1) < 1e-9
    assert abs(best["best"].item() / exact[1] - 1) < 1e-11
    assert best["stable"].item() and best["admissible"].item()
    assert abs(impact_speed(best) - exact[1]) < 1e-10


@pytest.mark.slow
def test_slowest_impact_is_where_the_stable_part_ends(wall_branch):
    best = ns.best_point(wall_branch, impact_speed, largest=False)
    assert best["limited_by"].item() == "flip"
    flip = special_value(wall_branch, "flip")
    assert best["omega"].item() == flip
    exact = RigidWall.of(omega=flip, **WALL).speeds(1)[0]
    assert abs(best["best"].item() - float(exact)) < 1e-9
    free = ns.best_point(wall_branch, impact_speed, largest=False, unstable=True)
    assert free["limited_by"].item() == "bound" and free["omega"].item() == 2.6


@pytest.mark.slow
def test_fastest_mole_against_motions(mole, branch):
    """Progression of settled motions on both sides of the optimum, and the vertex through them."""
    best = ns.best_point(branch, "v_per_period")
    assert best["limited_by"].item() == "interior" and best.attrs["quantity"] == "v_per_period"
    b = best["b"].item()
    offsets = 1e-4 * np.arange(-4, 5)
    progress = []
    for each in b + offsets:
        points = ns.stroboscopic_map(
            mole, best, parameters={"b": float(each)}, transient=400, record=41
        )
        progress.append(float(points["v"][-1] - points["v"][0]) / 40)
    series = np.polynomial.Chebyshev.fit(offsets, progress, 8)
    roots = series.deriv().roots()
    vertex = roots[np.argmin(np.abs(roots))].real
    assert abs(vertex) < 1e-9
    assert abs(series(vertex) - best["best"].item()) < 1e-9
    # no point of the branch is faster, and the fastest one is next to the optimum
    solid = branch["stable"].values & branch["admissible"].values
    speeds = np.where(solid, branch["v_per_period"].values, -np.inf)
    fastest = int(speeds.argmax())
    assert speeds[fastest] < best["best"].item()
    low, high = sorted(branch["b"].values[[fastest - 1, fastest + 1]])
    assert low < b < high
    assert abs(ns.best_point(branch, "v_per_time")["b"].item() - b) < 1e-9


def test_ends_of_the_stable_part(branch):
    most, least = ns.best_point(branch, "b"), ns.best_point(branch, "b", largest=False)
    assert most["limited_by"].item() == "fold" and least["limited_by"].item() == "flip"
    assert most["b"].item() == special_value(branch, "fold")
    assert least["b"].item() == special_value(branch, "flip")
    assert "change their word: fold" in most.attrs["message"]


@pytest.mark.slow
def test_the_best_orbit_is_an_orbit_for_other_verbs(mole, branch):
    best = ns.best_point(branch, lambda orbit: float(orbit["v_per_period"]))
    again = ns.find_orbit(mole, best, parameters={"b": best["b"].item()})
    assert abs(float(again["v_per_period"]) - best["best"].item()) < 1e-12
    on = ns.continue_orbit(mole, "b", (0.16, 0.167), initial=best)
    assert 0.0 in on["arclength"].values
    end = ns.best_point(branch, "b")  # a point of the branch as it is
    assert ns.simulate(mole, end, periods=1, parameters={"b": end["b"].item()}).attrs["status"]


@pytest.mark.slow
def test_no_orbit_is_allowed(mole):
    low = ns.orbits(mole, samples=8, guesses=20, parameters={"b": 0.095}).isel(orbit=0)
    part = ns.continue_orbit(mole, "b", (0.09, 0.1), initial=low, parameters={"b": 0.095})
    best = ns.best_point(part, "v_per_period")
    assert best.attrs["status"] == "no_orbit" and np.isnan(best["best"].item())
    assert "unstable=True" in best.attrs["message"] and best["limited_by"].item() == ""
    free = ns.best_point(part, "v_per_period", unstable=True)
    assert free["limited_by"].item() == "bound" and free["b"].item() == 0.1


def test_a_quantity_that_is_no_number(branch):
    best = ns.best_point(branch, lambda orbit: np.nan)
    assert best.attrs["status"] == "no_orbit"
    assert "nowhere a number" in best.attrs["message"]
    best = ns.best_point(branch, lambda orbit: np.nan if orbit["stable"] else 1.0)
    assert "with a quantity that is a number" in best.attrs["message"]


def test_refusals(branch):
    for given, quantity, message in (
        (branch, "v_per_perod", "did you mean 'v_per_period'"),
        (branch, 3, "quantity = 3"),
        (branch, lambda orbit: orbit["leg_states"], "several values"),
        (branch.isel(point=0), "length", "give a branch"),
        ({}, "length", "give a branch"),
        (branch.drop_attrs().assign_attrs(parameter="b"), "length", "of which system"),
    ):
        with pytest.raises(ns.OptionError, match=message):
            ns.best_point(given, quantity)
    with pytest.raises(ns.OptionError, match="largest"):
        ns.best_point(branch, "length", largest="yes")


@pytest.mark.parametrize(
    ("function", "low", "high", "place", "inside"),
    [
        (lambda x: -((x - 0.3) ** 2), 0.0, 1.0, 0.3, True),
        (np.sin, 0.0, 3.0, np.pi / 2, True),
        (lambda x: x * np.exp(-x), 0.0, 40.0, 1.0, True),
        (lambda x: np.exp(x), 0.0, 1.0, 1.0, False),
        (lambda x: np.sqrt(1.0 - x) - x, 0.0, 1.0, 0.0, False),
        (lambda x: np.sqrt(x) - x, 0.0, 1.0, 0.25, True),  # an end as at a fold
        (lambda x: x - x**2 if x < 0.9 else np.nan, 0.0, 1.0, 0.5, True),
        (lambda x: 5.0 - abs(x - 0.6180339887), 0.0, 1.0, 0.6180339887, True),  # a corner
    ],
)
def test_largest_value_of_functions(function, low, high, place, inside):
    found = largest_inside(lambda x: float(function(x)), low, high, (function(low), function(high)))
    assert abs(found.place - place) < 1e-10 * (high - low)
    assert found.inside is inside
