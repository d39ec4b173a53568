"""Bifurcation pictures against closed forms of what exists at each value of a parameter."""

from __future__ import annotations

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis import bifurcation_picture as module
from nonsmooth.analysis.pictures import branches
from nonsmooth.analysis.pictures.chunks import Chunks
from nonsmooth.plot.pictures import branches_of
from periodic_orbits.systems import LIFT_OFF, cam_follower

FOLD = 2.0 / (3.0 * np.sqrt(3.0))  # of p = x**3 - x
REGION = {"x": (-2.0, 2.0)}


def hysteresis() -> ns.System:
    """x rests where p = x**3 - x; y is driven, and x does not know of it."""
    return ns.System(
        states=["x", "y"],
        period=1.0,
        parameters={"p": 0.0},
        equations={"x": "p + x - x**3", "y": "cos(2*pi*t) - y"},
    )


def roots(p: float) -> np.ndarray:
    found = np.roots([1.0, 0.0, -1.0, -p])
    return np.sort(found[np.abs(found.imag) < 1e-9].real)


@pytest.fixture(scope="module")
def picture():
    return ns.bifurcation_picture(
        hysteresis(), "p", (-0.6, 0.6), REGION, columns=13, samples=60, searches=3
    )


@pytest.mark.slow
def test_attractors_exist_between_the_folds(picture) -> None:
    """Below -FOLD there is the lower root, above FOLD the upper one, and both between."""
    for column in range(picture.sizes["parameter"]):
        here = picture.isel(parameter=column)
        p = float(here["parameter"])
        known = roots(p)
        stable = known if known.size == 1 else known[[0, 2]]
        there = here["period"].values > 0
        found = here["settled"].sel(state="x").isel(strobe=0).values[there]
        assert np.sort(found) == pytest.approx(stable, abs=1e-9)


def test_an_attractor_keeps_its_number_until_it_ends(picture) -> None:
    p = picture["parameter"].values
    exists = picture["period"].values > 0
    assert picture.sizes["attractor"] == 2
    assert exists[:, 0].tolist() == (p < FOLD).tolist()
    assert exists[:, 1].tolist() == (p > -FOLD).tolist()
    assert np.all(picture["kind"].values[exists] == "periodic")


def test_shares_are_those_of_the_starts_on_either_side_of_the_saddle(picture) -> None:
    for column in range(picture.sizes["parameter"]):
        here = picture.isel(parameter=column)
        known = roots(float(here["parameter"]))
        if known.size == 3:
            lower = (known[1] + 2.0) / 4.0  # of the region, a width of four
            # a Sobol sequence is spread evenly, so a few starts lie on the wrong side
            assert here["fraction"].values == pytest.approx([lower, 1.0 - lower], abs=0.05)
        assert np.nansum(here["fraction"]) == pytest.approx(1.0)


def test_all_orbits_are_one_branch_through_both_folds(picture) -> None:
    """Motions from many columns and unstable orbits of three searches lie on one branch."""
    (branch,) = branches_of(picture)
    assert branch["p"].values == pytest.approx(
        branch["x"].values ** 3 - branch["x"].values, abs=1e-9
    )
    folds = branch["special_value"].values[branch["special_kind"].values == "fold"]
    assert np.sort(folds) == pytest.approx([-FOLD, FOLD], abs=1e-9)
    outside = 3.0 * branch["x"].values ** 2 > 1.0
    clear = np.abs(3.0 * branch["x"].values ** 2 - 1.0) > 1e-6
    assert np.array_equal(branch["stable"].values[clear], outside[clear])


@pytest.mark.slow
def test_branches_beyond_flips_have_all_their_points() -> None:
    """Of x -> -r x + x**3 the orbit of two points is x**2 = r - 1, from the flip at r = 1 on.

    The kick is a reset at a quarter of each period; between kicks x rests.
    """
    kick = ns.Exit("cos(2*pi*t)", to="late", reset={"x": "-r*x + x**3"}, name="kick")
    kicked = ns.System(
        states=["x"],
        period=1.0,
        parameters={"r": 0.9},
        modes={
            "early": ns.Mode({"x": "0"}, exits=[kick]),
            "late": ns.Mode({"x": "0"}, exits=[ns.Exit("-cos(2*pi*t)", to="early")]),
        },
    )
    found = ns.bifurcation_picture(
        kicked, "r", (0.8, 1.3), {"x": (-0.5, 0.5)}, columns=6, samples=6, searches=0
    )
    one, two = branches_of(found)
    assert found["branch_period"].values.tolist() == [1, 2]
    flips = one["special_value"].values[one["special_kind"].values == "flip"]
    assert flips == pytest.approx([1.0], abs=1e-9)
    x = two["strobes"].sel(state="x").values
    assert x[:, 0] == pytest.approx(-x[:, 1], abs=1e-9)
    assert x[:, 0] ** 2 == pytest.approx(two["r"].values - 1.0, abs=1e-9)


@pytest.mark.slow
def test_branches_beyond_a_broken_symmetry_are_followed() -> None:
    """Of x -> r x - x**3 points at +-sqrt(r - 1) leave 0 at r = 1; no start finds them."""
    kick = ns.Exit("cos(2*pi*t)", to="late", reset={"x": "r*x - x**3"}, name="kick")
    kicked = ns.System(
        states=["x"],
        period=1.0,
        parameters={"r": 0.9},
        modes={
            "early": ns.Mode({"x": "0"}, exits=[kick]),
            "late": ns.Mode({"x": "0"}, exits=[ns.Exit("-cos(2*pi*t)", to="early")]),
        },
    )
    found = ns.bifurcation_picture(
        kicked, "r", (0.8, 1.3), {"x": (-0.5, 0.5)}, columns=2, samples=6, searches=0
    )
    breaking = found["special_kind"].isin(["symmetry_breaking", "branch_point"]).values
    # it is a special point of both branches
    assert found["special_value"].values[breaking] == pytest.approx([1.0, 1.0], abs=1e-9)
    unsymmetric = [each for each in branches_of(found) if np.abs(each["x"].values).max() > 1e-6]
    (pair,) = unsymmetric
    assert pair["x"].values ** 2 == pytest.approx(pair["r"].values - 1.0, abs=1e-9)
    assert pair["x"].values.min() < -0.5 and pair["x"].values.max() > 0.5


def test_an_interruption_keeps_what_was_found(monkeypatch) -> None:
    whole = module.settle_columns

    def interrupted(maps, *options):
        columns, _ = whole(maps[:3], *options)
        return columns, False

    monkeypatch.setattr(module, "settle_columns", interrupted)
    found = ns.bifurcation_picture(hysteresis(), "p", (-0.6, 0.6), REGION, columns=9, samples=8)
    assert found.attrs["status"] == "interrupted" and found.sizes["parameter"] == 3
    assert "interrupted by the user" in found.attrs["message"]


@pytest.mark.parametrize("calls", [3, 9, 14])
def test_attractors_keep_their_numbers_as_far_as_an_interruption_lets_them(calls, monkeypatch):
    """It comes on the way up, after three values, or on the way down after all of nine."""
    told = []

    def report(self, done):
        told.append(done)
        if len(told) == calls:
            raise KeyboardInterrupt

    monkeypatch.setattr(module.Progress, "update", report)
    found = ns.bifurcation_picture(hysteresis(), "p", (-0.2, 0.2), REGION, columns=9, samples=8)
    assert found.attrs["status"] == "interrupted"
    assert found.sizes["parameter"] == min(calls, 9) and found.sizes["attractor"] == 2


def test_branches_that_are_not_followed_are_told(monkeypatch):
    monkeypatch.setattr(branches, "_MOST", 1)
    found = ns.bifurcation_picture(hysteresis(), "p", (-0.2, 0.2), REGION, columns=3, samples=8)
    assert "no more branches than 1 are followed: lower longest=" in found.attrs["message"]


def test_a_picture_survives_a_file(picture, tmp_path) -> None:
    import xarray as xr

    picture.to_netcdf(tmp_path / "picture.nc")
    with xr.open_dataset(tmp_path / "picture.nc") as again:
        (branch,) = branches_of(again)
        ax = ns.plot.bifurcation_picture(again.load(), "x")
    assert branch["x"].values == pytest.approx(branches_of(picture)[0]["x"].values)
    names = {text.get_text() for text in ax.get_legend().get_texts()}
    assert {"attractor 1", "attractor 2", "stable", "unstable", "fold"} <= names


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"parameter": "q"}, "unknown parameter 'q'"),
        ({"between": (1.0, 0.0)}, "the first must be below the second"),
        ({"region": {"z": (0.0, 1.0)}}, "unknown state 'z'"),
        ({"columns": 1}, "columns"),
        ({"searches": -1}, "searches"),
        ({"parameters": {"p": 1.0}}, "p"),
    ],
)
def test_wrong_arguments_are_named(given, said) -> None:
    options = {"parameter": "p", "between": (-1.0, 1.0), "region": REGION} | given
    with pytest.raises(ns.OptionError, match=said):
        ns.bifurcation_picture(hysteresis(), **options)


def test_a_section_is_refused() -> None:
    section = ns.PoincareMap(hysteresis(), "y")
    with pytest.raises(ns.OptionError):
        ns.bifurcation_picture(section, "p", (-1.0, 1.0), REGION)


@pytest.mark.slow
def test_a_cycle_lies_on_a_branch_between_points_that_are_far_from_it() -> None:
    """Behind rebounds the ball rests on the table, lifts off at arcsin(1/Gamma) and comes back.

    The rebounds pass the phase of the map one by one, so the state there goes up and down many
    times, also between two points of the branch. At 1.58 the branch has an orbit of its own.
    """
    ball = ns.models.bouncing_ball(r=0.5)
    branch = ns.continue_orbit(
        ball, "Gamma", (0.9, 1.62), period=1, initial={"y": 0.0, "v": 1.26},
        parameters={"Gamma": 1.26},
    )  # fmt: skip
    collector = branches.BranchCollector(
        ns.StroboscopicMap(ball),
        "Gamma",
        (0.9, 1.62),
        1,
        np.array([5.0, 6.0]),
        1000,
        1e-12,
        Chunks(),
        [branch],
    )
    run = ns.simulate(ball.with_parameters(Gamma=1.58), {"y": 0.0, "v": 1.58}, periods=5)
    assert run.attrs["status"] == "completed" and "rest" in ns.phase_word(run)
    settled = np.array([[float(run["y"][-1]), float(run["v"][-1])]])
    assert collector.holds(branches.OrbitPoints(1.58, settled))
    # the ball that never rests, with a fall of pi between its bounces, is another one
    bounce = ns.find_orbit(ball, {"y": 2.5, "v": -2.3}, parameters={"Gamma": 1.58})
    other = np.array([[float(bounce["y"]), float(bounce["v"])]])
    assert "rest" not in bounce["word"].item()
    assert not collector.holds(branches.OrbitPoints(1.58, other))


@pytest.mark.few(1)
@pytest.mark.parametrize("phase", [0.0, 0.3])
def test_an_orbit_at_rest_at_the_strobe_is_one_branch(phase) -> None:
    """A follower that rides its cam is where the cam is, at rest at every strobe of phase 0.

    Below its lift-off every start settles to that.
    """
    assert LIFT_OFF > 3.0
    found = ns.bifurcation_picture(
        cam_follower(phase),
        "w",
        (2.0, 3.0),
        {"y": (1.1, 2.0), "v": (-1.0, 1.0)},
        columns=9,
        samples=10,
    )
    assert found.sizes["branch"] == 1
    assert (found["w"].values.min(), found["w"].values.max()) == (2.0, 3.0)


@pytest.mark.slow
def test_a_ball_on_a_table_has_two_branches() -> None:
    """One rests on the table in each turn, the other bounces, from A = pi (1 - r)/(1 + r) on."""
    table = ns.System(
        states=["y", "v"],
        period="2*pi",
        parameters={"A": 0.8, "r": 0.4},
        definitions={"s": "A*sin(t)", "w": "A*cos(t)"},
        modes={
            "flight": ns.Mode(
                {"y": "v", "v": "-1"},
                exits=[
                    ns.Exit("y - s", reset={"v": "-r*v + (1 + r)*w"}, sticks="rides", name="impact")
                ],
            )
        },
    )
    found = ns.bifurcation_picture(
        table, "A", (1.1, 1.5), {"y": (1.6, 2.0), "v": (-1.0, 1.0)}, columns=9, samples=10
    )
    least = found["A"].groupby(found["branch_of_point"]).min().values
    assert np.sort(least) == pytest.approx([1.1, np.pi * 0.6 / 1.4], abs=1e-9)
