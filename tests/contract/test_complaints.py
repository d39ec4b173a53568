"""What users of other event solvers suffered, one test each, where motion sticks, slides or rests.

The same twelve in free flight, with impacts and switches, are in `simulation/test_complaints.py`.
"""

import numpy as np
import pytest

import nonsmooth as ns
from contract.taylor_twin import taylor_twin
from nonsmooth import Exit, Mode, Surface, System
from runs.flows import EPS, crossings

on_both_flows = pytest.mark.parametrize(
    "flow",
    [lambda system: system, lambda system: taylor_twin(system, -1)],
    ids=["exact", "Taylor"],
)


def belt(function="v - v_b", scale=1.0):
    """A block on a belt; in stick x grows at the speed of the belt until the spring wins."""
    return System(
        states=["x", "v"],
        parameters={"v_b": 0.3, "F_k": 0.4, "F_s": 0.6, "scale": scale},
        equations={"x": "v", "v": "-x - F_k*sign(slip)"},
        surfaces={"slip": Surface(function, "lag", "stick", "lead", hold="F_s/F_k")},
    )


# A stick of 2 D/v_b from x = F_k - D to F_k + D, then a turn about F_k of all but 2 atan(D/v_b).
D = 0.2
STICK = 2 * D / 0.3
SLIP = 2 * np.pi - 2 * np.arctan(D / 0.3)


def floor(r="r", **words):
    mode = Mode({"x": "v", "v": "-1"}, exits=[Exit("x", reset={"v": f"-{r}*v"}, sticks="rest")])
    return System(states=["x", "v"], parameters={"r": 0.5}, modes={"flight": mode}, **words)


@on_both_flows
@pytest.mark.parametrize("depth", [1e-2, 1e-6, 1e-10])
def test_1_missed_double_root_in_a_step(flow, depth):
    """A block at rest by friction, and a switch by cos t that dips below -1 + depth in passing.

    Each dip lasts 2 acos(1 - depth) about an odd multiple of pi; n adds them up.
    """
    system = System(
        states=["v", "y", "w", "n"],
        parameters={"level": -1 + depth},
        equations={
            "v": "0.5 - 2*sign(v)",
            "y": "w",
            "w": "-y",
            "n": "where(y < level, 1, 0)",
        },
    )
    run = ns.simulate(flow(system), {"v": 0.5, "y": 1.0}, times=[40.0])
    level = -1.0 + depth  # as rounded
    half = 2 * np.arcsin(np.sqrt((1 + level) / 2))
    centres = np.pi * np.arange(1, 13, 2)
    expected = np.sort(np.concatenate([centres - half, centres + half]))
    times = crossings(run)["event_time"].values
    assert times[0] == pytest.approx(1 / 3, abs=EPS)
    assert len(times) == 13
    # values of the guard have errors of some 40 eps after six turns, over a rate of sin(half)
    assert np.allclose(times[1:], expected, rtol=0, atol=100 * EPS / half)
    assert float(run["n"][-1]) == pytest.approx(12 * half, abs=1200 * EPS / half)
    assert float(run["v"][-1]) == 0.0


@on_both_flows
@pytest.mark.parametrize("r", [0.3, 0.5, 0.7, 0.8, 0.9])
def test_2_falls_through_the_floor_after_a_few_bounces(flow, r):
    """Not by a hair, in 60 units of time, and in no row of the log; it lies there at the end."""
    run = ns.simulate(flow(floor()), {"x": 1.0}, t_end=60.0, parameters={"r": r})
    assert run.attrs["status"] == "completed"
    assert float(run["x"].min()) == 0.0
    log = crossings(run)
    assert np.all(log["state_after"].sel(state="x") == 0.0)
    assert np.all(log["state_after"].sel(state="v") >= 0.0)
    rest = run["time"] > float(log["event_time"][-1])
    assert rest.sum() > 500
    assert np.all(run["x"].values[rest] == 0.0)
    assert np.all(run["v"].values[rest] == 0.0)


@on_both_flows
def test_3_retriggers(flow):
    """A thousand units of stick-slip: each surface event once, and the next when it is due."""
    run = ns.simulate(flow(belt()), {"x": 0.2, "v": 0.3}, times=[1000.0])
    log = crossings(run)
    assert log["event_kind"].values.tolist()[:4] == ["slide_exit", "slide_entry"] * 2
    gaps = np.diff(log["event_time"].values)
    assert len(gaps) == 2 * int((1000.0 - STICK) / (STICK + SLIP))
    # no error grows: entry is at the same x each time, to the ulp of a time of 1000
    assert np.allclose(gaps[0::2], SLIP, rtol=0, atol=4 * 1000 * EPS)
    assert np.allclose(gaps[1::2], STICK, rtol=0, atol=4 * 1000 * EPS)
    assert run.attrs["n_uncertain"] == 0


@on_both_flows
@pytest.mark.parametrize("start", [0.0, 1e6, 1e9, 1e12])
def test_4_rounded_times_fire_an_event_twice(flow, start):
    """At 1e12, where an ulp of the time is 1e-4, the belt and the ball do what they do at 0."""
    words = {"t_start": start, "t_end": start + 26.0}
    run = ns.simulate(flow(belt()), {"x": 0.2, "v": 0.3}, **words)
    due = np.cumsum([STICK, SLIP] * 4)
    ulp = max(start, 26.0) * EPS
    assert np.allclose(crossings(run)["event_time"] - start, due, rtol=0, atol=2 * ulp + 1e-13)
    fallen = ns.simulate(flow(floor()), {"x": 1.0}, **words)
    plain = ns.simulate(flow(floor()), {"x": 1.0}, t_end=26.0)
    assert fallen["event_kind"].values.tolist() == plain["event_kind"].values.tolist()
    last = float(fallen["event_time"][-1]) - start
    assert last == pytest.approx(3 * np.sqrt(2.0), abs=2 * ulp + 1e-12)


@on_both_flows
@pytest.mark.parametrize("size", [0.75, 0.3, 1.7])
def test_5_two_guards_at_one_instant(flow, size):
    """Two blocks of one speed stop at once, at size/0.75: both stick, and stay."""
    system = System(states=["a", "b"], equations={"a": "0.25 - sign(a)", "b": "0.25 - sign(b)"})
    run = ns.simulate(flow(system), {"a": size, "b": size}, times=[5.0])
    log = crossings(run)
    assert ns.phase_word(run)[-1] == "flow[00]"
    assert np.allclose(log["event_time"], size / 0.75, rtol=4 * EPS, atol=0)
    assert run["end_state"].values.tolist() == [0.0, 0.0]
    path = ">".join(log["event_path"].values).split(">")
    assert path == ["s1", "s1", "s2", "s2"]


@on_both_flows
@pytest.mark.parametrize("scale", [1e-100, 1e-6, 1e6, 1e100])
def test_6_event_accuracy_depends_on_the_scale_of_the_guard(flow, scale):
    """The surface, and a guard at which a ball comes to rest, times any factor.

    A power of ten changes roundings only, by an ulp of the terms, over the rates 0.3 and 1.
    """
    plain = ns.simulate(flow(belt()), {"x": 0.2, "v": 0.3}, times=[100.0])
    scaled = ns.simulate(flow(belt("scale*(v - v_b)", scale)), {"x": 0.2, "v": 0.3}, times=[100.0])
    assert scaled["event_kind"].values.tolist() == plain["event_kind"].values.tolist()
    assert np.allclose(scaled["event_time"], plain["event_time"], rtol=0, atol=1e-13)
    reset = {"v": "-0.8*v"}
    mode = Mode({"x": "v", "v": "-1"}, exits=[Exit("scale*x", reset=reset, sticks="rest")])
    ball = System(states=["x", "v"], parameters={"scale": scale}, modes={"flight": mode})
    run = ns.simulate(flow(ball), {"x": 1.0}, times=[60.0])
    assert str(run["event_kind"].values[-1]) == "chatter"
    assert float(run["event_time"][-1]) == pytest.approx(9 * np.sqrt(2.0), rel=1e-12)


def test_6_a_guard_that_is_flat_at_its_zero_is_found_and_flagged():
    """x^3 in place of x: rounding hides the cube root of 1e-12 of the place; the log says so."""
    mode = Mode({"x": "v", "v": "-1"}, exits=[Exit("x**3", reset={"v": "-v/2"})])
    run = ns.simulate(System(states=["x", "v"], modes={"m": mode}), {"x": 0.5}, times=[1.9])
    log = crossings(run)
    hits = log["event_kind"].values == "impact"
    assert np.allclose(log["event_time"].values[hits], [1.0], rtol=0, atol=1e-4)
    assert not log["certified"].values[hits].any()


@on_both_flows
def test_7_something_stale_after_a_reset(flow):
    """Behind each entry, exit and rest, the motion is bit for bit that of a fresh start there."""
    runs = [
        (flow(belt()), {"x": 0.2, "v": 0.3}, 30.0),
        (flow(floor("0")), {"x": 1.0}, 3.0),
    ]
    for system, start, end in runs:
        run = ns.simulate(system, start, times=[end])
        names = run["state"].values.tolist()
        for k in range(1, run.sizes["event"]):
            event = run.isel(event=k)
            state = dict(zip(names, event["state_after"].values.tolist(), strict=True))
            fresh = ns.simulate(system, state, t_start=float(event["event_time"]), times=[end])
            assert ns.phase_word(fresh, float(event["event_time"]), end)[0] == _mode(run, k)
            later = run["event_time"].values[k + 1 :]
            assert np.allclose(fresh["event_time"].values[1:], later, rtol=0, atol=1e-14)
            assert np.allclose(fresh["end_state"], run["end_state"], rtol=0, atol=1e-14)


@pytest.mark.parametrize(("x", "word"), [(-0.6, "stick"), (-0.61, "lead"), (-2.0, "lead")])
def test_7_a_start_at_which_the_belt_holds_just_so_or_no_more(x, word):
    """At the speed of the belt: -0.6 is just held, and from there on it is held with less."""
    run = ns.simulate(belt(), {"x": x, "v": 0.3}, times=[0.1])
    assert ns.phase_word(run) == (word,)


@pytest.mark.parametrize(("x", "word"), [(0.6, "lag"), (0.61, "lag"), (2.0, "lag"), (0.5, "stick")])
def test_7_a_start_at_which_the_belt_leaves_the_block_behind(x, word):
    """The same below: 0.6 is just held, and from there on it would take more."""
    run = ns.simulate(belt(), {"x": x, "v": 0.3}, times=[0.1])
    assert ns.phase_word(run) == (word,)


def _mode(run, k):
    names = run["event_to"].attrs["flag_meanings"].split()
    values = np.atleast_1d(run["event_to"].attrs["flag_values"]).tolist()
    return names[values.index(int(run["event_to"].values[k]))]


def test_8_event_of_a_step_that_is_not_taken():
    """A slide towards x = 1, where it is sent back, with a pole of the rates at 1.01 behind it.

    On y = 0 between (1, -1) and (3, 1) the speed is 2/(1.01 - x): 1 - x = 0.01 after
    (1.01^2 - 0.01^2)/4 = 0.255.
    """
    rates = {"x": "where(y > 0, 1, 3)/(1.01 - x)", "y": "where(y > 0, -1, 1)"}
    exits = [
        Exit("1.005 - x", to="stop", name="second"),
        Exit("1 - x", reset={"x": "0"}, name="first"),
    ]
    system = System(states=["x", "y"], modes={"m": Mode(rates, exits=exits)})
    run = ns.simulate(system, {}, times=[1.0])
    log = crossings(run)
    assert (run.attrs["status"], run.attrs["n_uncertain"]) == ("completed", 0)
    assert log["event_name"].values.tolist() == ["first"] * 3
    assert np.allclose(log["event_time"], [0.255, 0.51, 0.765], rtol=0, atol=1e-14)
    # x (2.02 - x) = 4 t
    x = 1.01 - np.sqrt(1.01**2 - 4 * 0.235)
    assert float(run["x"][-1]) == pytest.approx(x, abs=1e-13)
    assert float(run["y"][-1]) == 0.0


@on_both_flows
def test_9_the_output_grid_loses_the_event_point(flow):
    """The log has entry, exit and rest whatever the samples; a sample there has the state there."""
    entry, exit_ = STICK + SLIP, 2 * STICK + SLIP
    due = [STICK, entry, exit_]
    for times in ([8.0], [0.0, 8.0], [0.0, STICK, entry, exit_, 8.0], np.linspace(0.0, 8.0, 999)):
        run = ns.simulate(flow(belt()), {"x": 0.2, "v": 0.3}, times=times)
        assert run["time"].values.tolist() == list(times)
        assert np.allclose(crossings(run)["event_time"], due, rtol=0, atol=20 * EPS)
        for k, time in enumerate(times):
            if time in due:
                x = [0.6, 0.2, 0.6][due.index(time)]
                assert np.allclose([run["x"][k], run["v"][k]], [x, 0.3], rtol=0, atol=20 * EPS)
    # from 1/2 the ball lands at 1 and rests at 3
    run = ns.simulate(flow(floor()), {"x": 0.5}, times=[0.0, 1.0, 3.0, 4.0])
    assert run["time"].values.tolist() == [0.0, 1.0, 3.0, 4.0]
    assert run["x"].values.tolist() == [0.5, 0.0, 0.0, 0.0]
    assert run["v"].values[1:].tolist() == [-1.0, 0.0, 0.0]


@on_both_flows
def test_10_duplicate_times(flow):
    """Times asked for twice come twice, at an entry as anywhere; the log has each event once."""
    times = [0.0, 0.0, STICK, STICK, STICK + SLIP, STICK + SLIP, 7.0, 7.0]
    run = ns.simulate(flow(belt()), {"x": 0.2, "v": 0.3}, times=times)
    assert run["time"].values.tolist() == times
    assert run["x"].values[::2].tolist() == run["x"].values[1::2].tolist()
    assert run["v"].values[::2].tolist() == run["v"].values[1::2].tolist()
    assert run.attrs["n_events"] == 2
    assert len(set(run["event_time"].values.tolist())) == 3


def test_11_a_section_on_top_of_events():
    """Points of a section in slip, of a motion that sticks in between: one per turn, all the same.

    x = F_k is passed downwards a quarter of a turn behind v = v_b, at v = -sqrt(D^2 + v_b^2).
    """
    points = ns.poincare_section(
        belt(), {"x": 0.2, "v": 0.3}, section="x - F_k", direction=-1, record=8
    )
    assert np.allclose(points["v"], -np.hypot(D, 0.3), rtol=0, atol=8 * EPS)
    assert np.allclose(np.diff(points["time"]), STICK + SLIP, rtol=0, atol=400 * EPS)


@on_both_flows
def test_12_left_and_right_limits_at_a_jump(flow):
    """Both sides of a plastic impact are in the log; a sample there has the side before it.

    From 1/2 it lands at 1 with the speed 1. An entry into a slide has no jump: equal sides.
    """
    run = ns.simulate(flow(floor("0")), {"x": 0.5}, times=[1.0, 2.0])
    log = crossings(run)
    assert log["event_kind"].values.tolist() == ["stick"]
    assert log["state_before"].values.tolist() == [[0.0, -1.0]]
    assert log["state_after"].values.tolist() == [[0.0, 0.0]]
    assert run["v"].values.tolist() == [-1.0, 0.0]
    log = crossings(ns.simulate(flow(belt()), {"x": 0.2, "v": 0.3}, times=[20.0]))
    assert len(log["event_kind"]) > 4
    assert np.allclose(log["state_before"], log["state_after"], rtol=0, atol=4 * EPS)
