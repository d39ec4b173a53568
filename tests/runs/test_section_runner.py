"""Many starts on a section beside one motion at a time."""

import threading

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.engine.status import Status
from nonsmooth.runs.crew import Stopped
from nonsmooth.runs.section_runner import NEVER_CROSSES
from nonsmooth.runs.section_search import PATIENCE
from runs.balls import bouncing_ball, damped, rigid_wall

STARTS = np.array([[-0.3, 0.4], [-0.1, 0.0], [-0.7, -0.2]])


@pytest.mark.parametrize("section", ["impact", "v", "x + 0.4 - 0.05*cos(omega*t)"])
@pytest.mark.parametrize("every", [1, 3])
def test_the_points_of_one_motion(section, every):
    cross = ns.PoincareMap(rigid_wall(), section, side="after", every=every)
    runner = cross.runner(1e-12)
    lanes = runner.start(STARTS)
    found = np.concatenate([runner.iterate(lanes, count)[0] for count in (1, 5, 2)], axis=1)
    assert np.all(lanes.status == Status.COMPLETED)
    for start, points in zip(STARTS, found, strict=True):
        expected = cross.iterate({"x": start[0], "v": start[1]}, 8)
        # parts end at other instants; the events are the same bit for bit
        assert np.array_equal(points[:, 0], expected["x"])
        assert np.array_equal(points[:, 1], expected["v"])


def test_lanes_end_one_by_one():
    """A start inside the wall, one that never comes to the section, one that comes to rest."""
    runner = ns.PoincareMap(rigid_wall(), "impact").runner(1e-12)
    lanes = runner.start(np.array([[0.5, 0.0], [-0.3, 0.4]]))
    states, modes = runner.iterate(lanes, 2)
    assert np.isnan(states[0]).all() and modes[0].tolist() == [-1, -1]
    assert np.isfinite(states[1]).all() and modes[1].tolist() == [0, 0]
    assert lanes.status.tolist() == [Status.INADMISSIBLE, Status.COMPLETED]

    runner = ns.PoincareMap(damped(), "x - 0.5").runner(1e-12)
    lanes = runner.start(np.array([[0.2, 0.0], [-5.0, 0.0]]))
    states, _ = runner.iterate(lanes, 1)
    assert np.isnan(states[0]).all() and states[1, 0, 0] == pytest.approx(0.5)
    assert lanes.status.tolist() == [NEVER_CROSSES, Status.COMPLETED]
    assert runner.admits(np.array([[0.2, 0.0]])).tolist() == [True]

    runner = ns.PoincareMap(bouncing_ball(0.8), "impact", side="after").runner(1e-12)
    lanes = runner.start(np.array([[0.0, 1.0]]))
    states, modes = runner.iterate(lanes, 3)
    assert states[0, :, 1] == pytest.approx(0.8 ** np.arange(1, 4))
    assert lanes.status.tolist() == [Status.COMPLETED]  # although the search went on to the end
    states, modes = runner.iterate(lanes, 1000)
    assert lanes.status.tolist() == [Status.EVENT_LIMIT]
    finite = np.isfinite(states[0, :, 1])
    assert 20 < finite.sum() < 1000 and np.array_equal(modes[0] >= 0, finite)


def test_a_motion_at_rest_is_not_waited_for():
    """exp(-t/20) of a swing falls to 2^-40 at t = 555; a swing that lasts is waited for."""
    for damping, lasts in ((0.1, False), (0.0, True)):
        flow = {"x": "v", "v": f"-x - {damping}*v"}
        runner = ns.PoincareMap(ns.System(states=["x", "v"], equations=flow), "x - 2").runner(1e-12)
        lanes = runner.start(np.array([[1.0, 0.0]]))
        runner.iterate(lanes, 1)
        assert lanes.status.tolist() == [NEVER_CROSSES]
        passed = lanes.ways[0].windows
        assert passed >= PATIENCE if lasts else passed < PATIENCE / 10
        assert passed * runner.engine.window > 555


def test_some_lanes_go_on_without_the_others():
    runner = ns.PoincareMap(rigid_wall(), "v").runner(1e-12)
    lanes = runner.start(STARTS)
    runner.iterate(lanes, 3)
    part = lanes.select(np.array([2, 0]))
    some, _ = runner.iterate(part, 4)
    whole, _ = runner.iterate(lanes, 4)
    assert np.array_equal(some, whole[[2, 0]])


def test_modes_of_the_start():
    """Modes are those of the system, whichever side of the section the start is on."""
    runner = ns.PoincareMap(rigid_wall(), "v").runner(1e-12)
    lanes = runner.start(STARTS, np.zeros(3, int))
    free, _ = runner.iterate(runner.start(STARTS), 3)
    assert np.array_equal(runner.iterate(lanes, 3)[0], free)


def test_other_parameters():
    cross = ns.PoincareMap(rigid_wall(), "x - sigma + 0.5", direction=-1)
    runner = cross.runner(1e-12)
    other = cross.with_parameters(sigma=0.1, r=0.6)
    runner.set_up(other)
    found, _ = runner.iterate(runner.start(STARTS), 3)
    expected, _ = (again := other.runner(1e-12)).iterate(again.start(STARTS), 3)
    np.testing.assert_array_equal(found, expected)
    assert found[1, :, 0] == pytest.approx(-0.4)


def test_stopping():
    runner = ns.PoincareMap(rigid_wall(), "v").runner(1e-12)
    stop = threading.Event()
    stop.set()
    with pytest.raises(Stopped):
        runner.iterate(runner.start(STARTS), 1, stop)
