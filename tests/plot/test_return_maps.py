"""Cobwebs and graphs of return maps."""

import numpy as np
import pytest

import nonsmooth as ns
from runs.balls import logistic_ball

BOUNCE = ns.PoincareMap(logistic_ball(a=3.2), "impact", side="after")
END = ns.PoincareMap(ns.models.moling(), "2*xi*y + q = 1", direction=-1)
RELAXED = {"completion": {"q": 1, "y": 0}, "mode": "contact", "samples": 120}


def labelled(ax):
    return {line.get_label(): line for line in ax.lines if not line.get_label().startswith("_")}


@pytest.fixture(scope="module")
def logistic():
    return ns.return_map(BOUNCE, "u", (0.01, 0.99), samples=40)


@pytest.fixture(scope="module")
def mole():
    return ns.return_map(END, "phase", (0.0, 62.8), **RELAXED)


def test_staircase_is_the_map(logistic):
    """Each step goes up to a u (1 - u) and across to the diagonal."""
    ax = ns.plot.cobweb(logistic, 0.3, steps=20)
    across, up = labelled(ax)["steps"].get_data()
    u = [0.3]
    for _ in range(20):
        u.append(3.2 * u[-1] * (1 - u[-1]))
    assert np.allclose(across[::2], u, atol=1e-12)
    assert np.allclose(up[1::2], u[1:], atol=1e-12)
    assert up[0] == across[0] == 0.3
    assert labelled(ax)["start"].get_xydata().tolist() == [[0.3, 0.3]]
    late = labelled(ns.plot.cobweb(logistic, 0.3, steps=20, transient=18))["steps"].get_data()
    assert np.allclose(late[0], np.repeat(u[18:], 2)[:-1], atol=1e-12)


def test_fixed_points(logistic):
    ax = ns.plot.cobweb(logistic)
    assert "steps" not in labelled(ax)
    point = labelled(ax)["unstable fixed point"]
    assert point.get_xydata()[0] == pytest.approx([1 - 1 / 3.2] * 2)
    assert point.get_markerfacecolor() == "white"
    calm = ns.return_map(BOUNCE, "u", (0.01, 0.99), samples=40, parameters={"a": 2.5})
    stable = labelled(ns.plot.cobweb(calm))["stable fixed point"]
    assert stable.get_xydata()[0] == pytest.approx([0.6, 0.6])
    assert stable.get_markerfacecolor() != "white"


def test_jumps_and_the_end_of_the_circle_are_not_joined(mole):
    ax = ns.plot.cobweb(mole, 30.0)
    curves = [line for line in ax.lines if line.get_color() == "black"]
    assert len(curves) > mole.sizes["border"]
    assert max(np.abs(np.diff(line.get_ydata())).max(initial=0.0) for line in curves) < 10.0
    assert ax.get_xlim() == ax.get_ylim()
    assert ax.get_ylim()[1] > ns.models.moling().period_value
    assert "black" not in {labelled(ax)["steps"].get_color()}
    assert ax.get_ylabel().replace("\n", " ") == "time since the period began, next"
    steps = labelled(ax)["steps"].get_xdata()
    assert steps[-1] == pytest.approx(float(mole["fixed_start"][0]), abs=1e-6)


def test_higher_returns_say_so():
    found = ns.return_map(BOUNCE, "u", (0.1, 0.9), samples=5, order=2)
    assert ns.plot.cobweb(found).get_ylabel() == "u, 2 points on"


def test_points_of_a_motion():
    ball = logistic_ball(a=3.9)
    points = ns.poincare_section(ball, section="impact", side="after", transient=20, record=50)
    found = ns.return_map(ns.PoincareMap(ball, "impact", side="after"), "u", points=points)
    ax = ns.plot.cobweb(found, 3, steps=5)
    across, _ = labelled(ax)["steps"].get_data()
    assert np.array_equal(across[::2], points["u"].values[3:9])
    dots = labelled(ax)["points of the motion"]
    assert np.array_equal(dots.get_ydata(), found["image"].values)
    with pytest.raises(ns.OptionError, match="give the number of one of them, from 0 to 49"):
        ns.plot.cobweb(found, 0.5)


def test_colours_by_exits(mole):
    ax = ns.plot.return_map(mole)
    texts = set(mole["exits"].values.tolist())
    names = set(labelled(ax))
    assert len(names) == len(texts)
    assert "release impact progression contact" in names
    assert "2(release impact) progression contact" in names
    dotted = [line for line in ax.lines if line.get_linestyle() == ":"]
    kinds = mole["border_kind"].values
    assert len(dotted) == int(np.isin(kinds, ("jump", "corner", "root")).sum())
    bare = ns.plot.return_map(mole, borders=False, diagonal=False, legend=False)
    assert bare.get_legend() is None
    assert len(bare.lines) < len(ax.lines)


def test_wrong_input(logistic):
    for draw in (ns.plot.cobweb, ns.plot.return_map):
        with pytest.raises(ns.OptionError, match="give it a result of return_map"):
            draw(ns.simulate(ns.models.moling(), periods=1))
    with pytest.raises(ns.OptionError, match=r"start = 2: .* from 0.01 to 0.99"):
        ns.plot.cobweb(logistic, 2.0)
    for name in ("steps", "transient"):
        with pytest.raises(ns.OptionError, match=f"{name} = -1 must be a whole number"):
            ns.plot.cobweb(logistic, 0.3, **{name: -1})


def test_axes_are_taken(logistic):
    _, (one, other) = ns.plot.print_figure(1, 2)
    assert ns.plot.cobweb(logistic, 0.3, ax=one) is one
    assert ns.plot.return_map(logistic, ax=other) is other
