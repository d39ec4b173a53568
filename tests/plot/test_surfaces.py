import matplotlib.pyplot as plt
import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.models import chua, clearance_rotor, soft_impact, trilinear


def lines(run, x, y) -> list[np.ndarray]:
    """Points of each dashed line of a portrait."""
    _, (ax,) = ns.plot.print_figure()
    limits = ns.plot.phase_portrait(run, x, y).axis()
    assert ns.plot.phase_portrait(run, x, y, ax=ax, surfaces=True).axis() == limits
    plt.close("all")
    return [path.vertices for c in ax.collections for path in c.get_paths() if path.vertices.size]


def test_a_stop_is_one_line():
    (line,) = lines(ns.simulate(soft_impact(e=0.7), periods=10), "x", "v")
    assert line[:, 0] == pytest.approx(0.7, abs=1e-12)
    (line,) = lines(ns.simulate(soft_impact(e=0.7), periods=10), "v", "x")
    assert line[:, 1] == pytest.approx(0.7, abs=1e-12)


def test_two_stops_are_two_lines():
    found = lines(ns.simulate(trilinear(), periods=10), "x", "v")
    assert sorted(line[0, 0] for line in found) == pytest.approx([-0.5, 0.5])


def test_changed_parameters_move_the_stop():
    run = ns.simulate(soft_impact(), periods=20, parameters={"e": 0.9})
    (line,) = lines(run, "x", "v")
    assert line[:, 0] == pytest.approx(0.9, abs=1e-12)


def test_a_polynomial_guard_is_a_circle():
    found = lines(ns.simulate(clearance_rotor(), periods=5), "x", "y")
    for line in found:
        # straight pieces of a hundredth: off the circle by h^2/8
        assert np.hypot(*line.T) == pytest.approx(1.0, abs=1e-4)


def test_surfaces_of_cells():
    text = ns.System(states=["x", "v"], equations={"x": "v", "v": "-abs(x - v) - x**3"})
    (line,) = lines(ns.simulate(text, {"x": 1.0}, t_end=9), "x", "v")
    assert line[:, 0] == pytest.approx(line[:, 1], abs=1e-12)


def test_what_has_no_place_in_the_plane_is_left_out(mole):
    """The gap of the mole depends on q, and x is no state; z of the circuit decides nothing."""
    assert lines(mole, "p", "y") == []
    assert lines(mole, "x", "y") == []
    run = ns.simulate(chua(), t_end=20)
    assert lines(run, "y", "z") == []
    timed = ns.System(states=["x"], equations={"x": "-x + abs(x - sin(t))"})
    assert lines(ns.simulate(timed, {"x": 0.2}, t_end=9), "x", "x") == []
