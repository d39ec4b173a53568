"""Curves of special points over two parameters, beside closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import nonsmooth as ns
from periodic_orbits.references.table_ball import TableBall
from periodic_orbits.systems import ball_on_table


def number_of(branch, kind: str) -> int:
    return branch["special_kind"].values.tolist().index(kind)


@pytest.fixture(scope="module")
def soft():
    return ns.continue_orbit(ns.models.soft_impact(a=0.2), "a", (0.05, 0.6))


@pytest.fixture(scope="module")
def ball():
    """A ball with one bounce in each period of its table, followed over its amplitude."""
    known = TableBall("0.8", 1)
    gamma = 0.5 * (float(known.saddle_node) + float(known.period_doubling))
    start = {name: known.start(gamma)[name] for name in ("h", "w")}
    return ns.continue_orbit(ball_on_table(gamma, 0.8), "Gamma", (0.1, 2.0), initial=start)


@pytest.mark.slow
def test_grazing_of_the_soft_oscillator(soft):
    curve = ns.continue_special(soft, number_of(soft, "grazing"), "omega", (0.8, 0.9))
    a, omega = curve["a"].values, curve["omega"].values
    exact = 1.26 * np.sqrt((1 - omega**2) ** 2 + (0.02 * omega) ** 2) / omega**2
    assert a == pytest.approx(exact, rel=1e-11)
    assert curve.attrs["end_first"] == curve.attrs["end_last"] == "bound"
    # the lower end is where a reaches its own bound, 0.6
    assert a.max() == pytest.approx(0.6, abs=1e-12)
    assert omega.max() == 0.9


@pytest.mark.slow
def test_a_flip_curve_has_the_multiplier_minus_one(soft):
    curve = ns.continue_special(soft, number_of(soft, "flip"), "omega", (0.84, 0.86))
    distance = np.abs(curve["multipliers"].values + 1.0).min(axis=1)
    assert distance.max() < 1e-9
    assert np.all(np.diff(curve["omega"].values) > 0.0)


@pytest.mark.slow
def test_flips_are_those_of_branches_at_other_values(soft):
    curve = ns.continue_special(soft, number_of(soft, "flip"), "omega", (0.84, 0.86))
    other = ns.continue_orbit(ns.models.soft_impact(a=0.2, omega=0.86), "a", (0.05, 0.6))
    there = float(other["special_value"][number_of(other, "flip")])
    assert float(curve["a"][-1]) == pytest.approx(there, rel=1e-10)


def test_folds_of_the_ball_on_a_table(ball):
    """Saddle-node at gamma = pi n (1 - r)/(1 + r), for every r."""
    curve = ns.continue_special(ball, number_of(ball, "fold"), "r", (0.6, 0.9))
    r = curve["r"].values
    assert curve["Gamma"].values == pytest.approx(np.pi * (1 - r) / (1 + r), rel=1e-9)
    assert r.min() == 0.6
    assert r.max() == 0.9


@pytest.mark.slow
def test_period_doublings_of_the_ball_on_a_table(ball):
    curve = ns.continue_special(ball, number_of(ball, "flip"), "r", (0.6, 0.9))
    r = curve["r"].values
    exact = np.hypot(np.pi * (1 - r) / (1 + r), 2 * (1 + r**2) / (1 + r) ** 2)
    assert curve["Gamma"].values == pytest.approx(exact, rel=1e-9)


@pytest.mark.slow
def test_every_point_is_an_orbit(soft):
    curve = ns.continue_special(soft, number_of(soft, "grazing"), "omega", (0.84, 0.86))
    for k in range(0, curve.sizes["point"], 4):
        point = curve.isel(point=k)
        system = ns.models.soft_impact(a=float(point["a"]), omega=float(point["omega"]))
        orbit = ns.find_orbit(system, {"x": float(point["x"]), "v": float(point["v"])})
        assert float(orbit["x"]) == pytest.approx(float(point["x"]), abs=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"special": 99}, "special points, numbered from 0"),
        ({"special": 0}, "is a bound point"),
        ({"parameter": "a"}, "that of the branch, the first one already"),
        ({"parameter": "nope"}, "second parameter"),
        ({"between": (1.0, 2.0)}, "lies outside"),
        ({"between": (0.9, 0.8)}, "must be below"),
        ({"direction": "left"}, "both, up, down"),
        ({"step": -1.0}, "must lie above 0"),
    ],
)
def test_bad_input(soft, change, message):
    given = {"special": number_of(soft, "grazing"), "parameter": "omega", "between": (0.8, 0.9)}
    given |= change
    first = [given.pop(name) for name in ("special", "parameter", "between")]
    with pytest.raises(ns.OptionError, match=message):
        ns.continue_special(soft, *first, **given)


def test_a_point_without_a_number_that_vanishes(soft):
    """As in branches that were kept by versions that did not tell it of all points."""
    number = number_of(soft, "grazing")
    tests = soft["special_test"].values.copy()
    tests[number] = ""
    kept = soft.assign(special_test=("special", tests))
    with pytest.raises(ns.OptionError, match="no number that vanishes there"):
        ns.continue_special(kept, number, "omega", (0.8, 0.9))


def test_no_branch():
    with pytest.raises(ns.OptionError, match="give a result of continue_orbit"):
        ns.continue_special(1.0, 0, "omega", (0.8, 0.9))


@pytest.mark.slow
def test_steps_are_counted_in_all_pieces_of_a_curve():
    # teeth with a gap, in the frequency at which they mesh; fold orbits lift off on the way
    gear = ns.System(
        states=["x", "v"],
        parameters={"k0": 3.8e8, "k1": 9e7, "b": 1e-4, "W": 3e4},
        period="2*pi/W",
        initial={"x": 5.5e-5},
        equations={
            "x": "v",
            "v": "(2200 - 480*v - (k0 + k1*cos(W*t))*(x - clip(x, -b/2, b/2)))/0.23",
        },
    )
    branch = ns.continue_orbit(gear, "W", (25000.0, 46000.0), direction="up")
    fold = number_of(branch, "fold")
    curve = ns.continue_special(branch, fold, "k1", (1e7, 1.8e8), steps=18, direction="down")
    assert len(set(curve["word"].values)) == 2
    assert curve.attrs["message"].startswith("first end: 18 steps were taken")
    assert curve.sizes["point"] == 20  # the start, and the change of the word
