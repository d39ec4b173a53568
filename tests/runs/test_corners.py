"""Two guards at one instant: both are passed, in declared order, and the log says so."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System
from runs.flows import EPS, crossings, on_both_flows

BOX = [Exit("1 - x", reset={"u": "-u"}, name="right"), Exit("1 - y", reset={"v": "-v"}, name="top")]
STRAIGHT = {"x": "u", "y": "v", "u": "0", "v": "0"}


@on_both_flows
@pytest.mark.parametrize("exits", [BOX, BOX[::-1]], ids=["right first", "top first"])
def test_a_corner_of_a_box(flow, exits):
    """Times in binary: both walls are reached at 1.5, and the ball comes back along its line."""
    system = System(states=["x", "y", "u", "v"], modes={"m": Mode(STRAIGHT, exits=exits)})
    start = {"x": 0.25, "y": 0.25, "u": 0.5, "v": 0.5}
    run = ns.simulate(flow(system), start, times=[0.0, 2.0, 3.0])
    log = crossings(run)
    assert log["event_kind"].values.tolist() == ["corner"]
    assert log["event_path"].values.tolist() == [">".join(way.name for way in exits)]
    assert log["event_name"].values.tolist() == [exits[0].name]
    assert log["event_time"].values.tolist() == [1.5]
    assert run["x"].values.tolist() == run["y"].values.tolist() == [0.25, 0.75, 0.25]


@on_both_flows
def test_a_near_corner_is_two_events(flow):
    """The walls are reached 1e-9 apart."""
    system = System(states=["x", "y", "u", "v"], modes={"m": Mode(STRAIGHT, exits=BOX)})
    start = {"x": 0.25, "y": 0.25 + 0.5e-9, "u": 0.5, "v": 0.5}
    log = crossings(ns.simulate(flow(system), start, times=[3.0]))
    assert log["event_name"].values.tolist() == ["top", "right"]
    assert log["event_kind"].values.tolist() == ["impact", "impact"]
    assert bool(log["certified"].all())
    assert np.allclose(log["event_time"], [1.5 - 1e-9, 1.5], rtol=0, atol=4 * EPS)


def balls(*guards):
    """Three equal balls on a line; neighbours swap their speeds when they meet."""
    flow = {"x": "u", "y": "v", "z": "w", "u": "0", "v": "0", "w": "0"}
    ways = {
        "left": Exit("y - x", reset={"u": "v", "v": "u"}, name="left"),
        "right": Exit("z - y", reset={"v": "w", "w": "v"}, name="right"),
    }
    exits = [ways[name] for name in guards]
    return System(states=["x", "y", "z", "u", "v", "w"], modes={"m": Mode(flow, exits=exits)})


@on_both_flows
@pytest.mark.parametrize("guards", [("left", "right"), ("right", "left")])
@pytest.mark.parametrize("speed", [1.0, 2.0**-10])
def test_one_ball_meets_two_that_touch(flow, guards, speed):
    """The last one goes off; y - z stays zero until then, however long that takes."""
    start = {"x": 0.0, "y": 1.0, "z": 1.0, "u": speed}
    run = ns.simulate(flow(balls(*guards)), start, times=[3.0 / speed])
    log = crossings(run)
    assert log["event_kind"].values.tolist() == ["corner"]
    assert log["event_path"].values.tolist() == ["left>right"]
    assert bool(log["certified"].all())
    assert log["event_time"].values.tolist() == [1.0 / speed]
    assert run["end_state"].values[:2].tolist() == [1.0, 1.0]
    # two units of time at the speed, each window with a rounding of at most three
    assert float(run["z"][-1]) == pytest.approx(3.0, abs=50 * EPS * 3)
    assert run["end_state"].values[3:].tolist() == [0.0, 0.0, speed]


@on_both_flows
@pytest.mark.parametrize("guards", [("left", "right"), ("right", "left")])
def test_three_balls_meet_at_one_instant(flow, guards):
    """Equal masses pass their speeds on: in any order 1, 1/2, 0 ends as 0, 1/2, 1."""
    start = {"x": 0.0, "y": 1.0, "z": 2.0, "u": 1.0, "v": 0.5, "w": 0.0}
    run = ns.simulate(flow(balls(*guards)), start, times=[4.0])
    log = crossings(run)
    # which pair is first is a matter of rounding, and flagged; what follows is not
    assert log["event_kind"].values.tolist() == ["corner"]
    assert log["event_time"].values.tolist() == [2.0]
    assert run["end_state"].values[3:].tolist() == [0.0, 0.5, 1.0]
    assert np.allclose(run["end_state"].values[:3], [2.0, 3.0, 4.0], rtol=0, atol=20 * EPS)


@on_both_flows
def test_two_surfaces_of_cells_at_once(flow):
    """x and y reach zero together at 1/2: from rates (1, 1) to (3, 3), by no cell between."""
    mode = Mode({"x": "2 + sign(y)", "y": "2 + sign(x)"})
    run = ns.simulate(
        flow(System(states=["x", "y"], modes={"m": mode})), {"x": -0.5, "y": -0.5}, times=[1.0]
    )
    assert run.attrs["status"] == "completed"
    log = crossings(run)
    assert log["event_time"].values.tolist() == [0.5]
    assert log["event_kind"].values.tolist() == ["corner"]
    assert ns.phase_word(run, 0.0, 1.0) == ("m[--]", "m[++]")
    assert np.allclose(run["end_state"], [1.5, 1.5], rtol=0, atol=8 * EPS)


@on_both_flows
@pytest.mark.parametrize("gap", [1e-6, 1e-12])
@pytest.mark.parametrize("crossings_per_second", [1.0, 1e12])
def test_two_walls_that_nearly_touch(flow, gap, crossings_per_second):
    """Between walls at 0 and at the gap all lengths are resolved relative to the gap."""
    exits = [
        Exit("gap - x", reset={"v": "-v"}, name="right"),
        Exit("x", reset={"v": "-v"}, name="left"),
    ]
    system = System(
        states=["x", "v"],
        parameters={"gap": gap},
        modes={"m": Mode({"x": "v", "v": "0"}, exits=exits)},
    )
    speed = gap * crossings_per_second
    start = {"x": 0.5 * gap, "v": speed}
    log = crossings(ns.simulate(flow(system), start, times=[10.0 / crossings_per_second]))
    assert log["event_name"].values.tolist() == ["right", "left"] * 5
    assert bool(log["certified"].all())
    expected = (0.5 + np.arange(10)) / crossings_per_second
    assert np.allclose(log["event_time"], expected, rtol=1e-14, atol=0)


@on_both_flows
@pytest.mark.parametrize(
    ("width", "names"), [(1e-3, ["b", "c"]), (1e-6, ["b", "c"]), (1e-12, ["b"])]
)
def test_a_narrow_slab_is_not_jumped_over(flow, width, names):
    """Below the tolerance of 1e-12 of the position both sides are one instant, passed in turn."""
    modes = {
        "a": Mode({"x": "1"}, exits=[Exit("1 - x", to="b")]),
        "b": Mode({"x": "3"}, exits=[Exit("1 + width - x", to="c")]),
        "c": Mode({"x": "2"}),
    }
    system = System(states=["x"], parameters={"width": width}, modes=modes)
    run = ns.simulate(flow(system), {"x": 0.0}, times=[2.0])
    log = crossings(run)
    assert log["event_to"].values[-1] == 2
    assert [name for path in log["event_path"].values for name in path.split(">")] == ["b", "c"]
    assert log.sizes["event"] == len(names)
    times = [1.0, 1.0 + width / 3]
    assert np.allclose(log["event_time"], times[: len(names)], rtol=0, atol=4 * EPS)
    assert float(run["x"][-1]) == pytest.approx(1 + width + 2 * (1 - width / 3), abs=2e-12)


@on_both_flows
def test_a_slab_of_cells(flow):
    """Within a layer of 1e-6 an acceleration of 1e6: v^2 grows by 2, from 1 to 3."""
    mode = Mode({"x": "v", "v": "where(x > 1, where(x < 1 + 1e-6, 1e6, 0), 0)"})
    system = System(states=["x", "v"], modes={"m": mode})
    run = ns.simulate(flow(system), {"x": 0.0, "v": 1.0}, times=[2.0])
    log = crossings(run)
    inside = (np.sqrt(3.0) - 1.0) * 1e-6
    assert np.allclose(log["event_time"], [1.0, 1.0 + inside], rtol=0, atol=4 * EPS)
    # the layer is known to an ulp of 1, of 1e-6
    assert float(run["v"][-1]) == pytest.approx(np.sqrt(3.0), abs=1e-9)
    assert bool(log["certified"].all())
