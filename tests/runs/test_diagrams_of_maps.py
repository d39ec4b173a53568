"""Bifurcation diagrams of maps."""

import numpy as np
import pytest

import nonsmooth as ns
from runs.balls import bouncing_ball, forced, logistic_ball, rigid_wall


def logistic(section="impact", **options):
    return ns.PoincareMap(logistic_ball(), section, **options)


@pytest.mark.few(4)
@pytest.mark.parametrize("start", ["restart", "follow up", "follow down"])
@pytest.mark.parametrize(
    ("section", "options"),
    [("impact", {}), ("impact", {"side": "after"}), ("u", {"direction": -1})],
)
def test_period_doublings_of_the_logistic_map(start, section, options):
    """They are at 3 and 1 + sqrt(6); period three is stable at 3.83."""
    doubling = 1.0 + np.sqrt(6.0)
    grid = [2.98, 3.02, doubling - 0.02, doubling + 0.02, 3.83, 3.95]
    found = ns.bifurcation_diagram(
        logistic(section, **options), "a", grid, transient=2000, record=60, start=start
    )
    assert found.attrs["message"].startswith("completed; 1 of 6 motions")  # chaos at 3.95
    assert found["period"].values.ravel().tolist() == [1, 2, 2, 4, 3, 0]
    assert np.all(found["impacts"] == 1.0) and np.all(found["events"] == 1.0)


def test_points_of_the_logistic_map():
    grid = np.array([2.8, 3.2])
    found = ns.bifurcation_diagram(logistic(side="after"), "a", grid, transient=500, record=20)
    assert found["u"].values[0, 0] == pytest.approx(1.0 - 1.0 / 2.8, rel=1e-13)
    root = np.sqrt((3.2 - 3.0) * (3.2 + 1.0))
    two = (3.2 + 1.0 + np.array([-root, root])) / (2.0 * 3.2)
    assert np.sort(found["u"].values[1, 0, :2]) == pytest.approx(two, rel=1e-13)
    assert found["word"].values.ravel().tolist() == ["flight", "flight flight"]
    assert found.attrs["section"] == "impact" and found.attrs["side"] == "after"
    assert found["period"].attrs["long_name"] == "period in iterates of the map, 0 for none"


def test_every_second_point():
    found = ns.bifurcation_diagram(logistic() ** 2, "a", [3.2, 3.5], transient=300, record=20)
    assert found["period"].values.ravel().tolist() == [1, 2]
    assert np.all(found["impacts"] == 2.0)


def test_strobes_of_a_given_map():
    """The same as with options of the verb, and a power of it."""
    options = {"transient": 100, "record": 12}
    grid = [2.3, 2.5]
    plain = ns.bifurcation_diagram(rigid_wall(), "omega", grid, phase=0.25, **options)
    strobe = ns.StroboscopicMap(rigid_wall(), phase=0.25)
    same = ns.bifurcation_diagram(strobe, "omega", grid, **options)
    assert np.array_equal(plain["v"], same["v"]) and plain.equals(same)
    options = {"transient": 50, "record": 6}
    half = ns.bifurcation_diagram(strobe**2, "omega", grid, **options)
    assert np.array_equal(half["v"], plain["v"][..., ::2])
    assert half["impacts"].values == pytest.approx(2.0 * plain["impacts"].values)


def test_strobes_of_another_period():
    """At half the period of the forcing a steady state alternates: x(t + T/2) = -x(t)."""
    half = ns.StroboscopicMap(forced(), period="pi/omega")
    found = ns.bifurcation_diagram(half, "omega", [0.8, 1.3], transient=300, record=10)
    assert found["period"].values.ravel().tolist() == [2, 2]
    x = found["x"].values
    assert x[..., 1:] == pytest.approx(-x[..., :-1], abs=1e-9)


def test_drift_per_iterate_and_per_time():
    """A ball that drifts at the speed c: 2 w c farther per flight of length 2 w."""
    system = ns.System(
        states=["h", "u", "s"],
        parameters={"w": 0.7, "c": 0.3},
        drift=["s"],
        modes={
            "flight": ns.Mode(
                {"h": "u", "u": "-1", "s": "c"},
                exits=[ns.Exit("h", reset={"u": "w"}, name="impact")],
            )
        },
        initial={"u": 1.0},
    )
    hit = ns.PoincareMap(system, "impact")
    found = ns.bifurcation_diagram(hit, "w", [0.5, 0.7], transient=5, record=10)
    assert found["s_per_iterate"].values.ravel() == pytest.approx([0.3, 0.42])
    assert found["s_per_time"].values.ravel() == pytest.approx([0.3, 0.3])
    assert np.all(found["period"] == 1)


def test_columns_that_end_early():
    """Below r = 1 the ball comes to rest; with r = 1 it goes on."""
    hit = ns.PoincareMap(bouncing_ball(), "impact")
    found = ns.bifurcation_diagram(
        hit, "r", [0.5, 1.0], initial={"u": 1.0}, transient=200, record=10
    )
    assert found["status"].values.ravel().tolist() == ["event_limit", "completed"]
    assert np.all(np.isnan(found["u"][0]))
    assert found["u"].values[1] == pytest.approx(-1.0)


def test_wrong_use():
    hit = logistic()
    for options in ({"at": "impact"}, {"side": "after"}, {"phase": 0.5}):
        with pytest.raises(ns.OptionError, match="the map says itself where its points lie"):
            ns.bifurcation_diagram(hit, "a", [3.2], **options)
    with pytest.raises(ns.OptionError, match="unknown parameter 'b'"):
        ns.bifurcation_diagram(hit, "b", [3.2])
    with pytest.raises(ns.OptionError, match="neither a System nor a map"):
        ns.bifurcation_diagram("ball", "a", [3.2])
    with pytest.raises(ns.OptionError, match="PoincareMap"):
        ns.bifurcation_diagram(logistic_ball(), "a", [3.2])
