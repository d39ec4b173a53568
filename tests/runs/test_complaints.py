"""What users of other event solvers suffered, one test each (issue numbers in the names)."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, RunWarning, System
from runs.flows import EPS, crossings, on_both_flows


def cosine(level, sign="-", **exit_words):
    """x = cos t with a guard that is x above or below a level; the other side mirrors it."""
    guard, mirror = ("x - level", "level - x") if sign == "-" else ("level - x", "x - level")
    flow = {"x": "v", "v": "-x"}
    return System(
        states=["x", "v"],
        parameters={"level": level},
        modes={
            "outer": Mode(flow, exits=[Exit(guard, to="inner", **exit_words)]),
            "inner": Mode(flow, exits=[Exit(mirror, to="outer")]),
        },
    )


@on_both_flows
@pytest.mark.parametrize("depth", [1e-2, 1e-5, 1e-8, 1e-11])
def test_1_no_double_root_is_missed_scipy_9228(flow, depth):
    # cos t dips below -1 + depth for 2 acos(1 - depth) around each odd multiple of pi,
    # less than 1e-5 for the least depth. The rate there is sqrt(2 depth), values have
    # errors of a few eps, some 40 eps after six turns.
    run = ns.simulate(flow(cosine(-1.0 + depth)), {"x": 1.0}, t_end=40.0)
    level = -1.0 + depth  # as rounded
    half = np.sqrt(2 * (1 + level)) * (1 + (1 + level) / 12)
    centres = np.pi * np.arange(1, 13, 2)
    expected = np.sort(np.concatenate([centres - half, centres + half]))
    assert run.attrs["n_events"] == 12
    error = np.abs(run["event_time"].values[1:] - expected)
    assert np.all(error < 200 * EPS / half + 0.03 * half**5)
    assert bool(run["certified"].all())


@on_both_flows
@pytest.mark.parametrize("depth", [1e-2, 1e-5, 1e-8, 1e-11, 2e-13])
def test_1_no_root_is_invented(flow, depth):
    # the same dip ends this much above the level
    run = ns.simulate(flow(cosine(-1.0 - depth)), {"x": 1.0}, t_end=40.0)
    assert run.attrs["n_events"] == 0
    assert run.attrs["n_uncertain"] == 0


@on_both_flows
@pytest.mark.parametrize("depth", [3e-14, 1e-14, 1e-15])
def test_1_a_shallow_root_is_flagged_not_fatal(flow, depth):
    # within the margin of rounding either answer is right, if it says uncertain
    run = ns.simulate(flow(cosine(1.0 - depth, "+")), {"x": 0.0, "v": 1.0}, t_end=4.0)
    assert run.attrs["status"] == "completed"
    assert run.attrs["n_uncertain"] > 0


@on_both_flows
def test_2_no_fall_through_the_floor_ode_138(flow):
    """Bounces that lose a tenth of their speed; see test_accumulation for their end."""
    mode = Mode({"x": "v", "v": "-1"}, exits=[Exit("x", reset={"v": "-0.9*v"})])
    with pytest.warns(RunWarning, match="impacts accumulate"):
        run = ns.simulate(flow(System(states=["x", "v"], modes={"m": mode})), {"x": 1}, t_end=60.0)
    # sqrt 2 (1 + 2 r/(1 - r)) = 26.87
    assert float(run["event_time"][-1]) == pytest.approx(19 * np.sqrt(2.0), abs=1e-6)
    assert float(run["x"].min()) >= 0.0


@on_both_flows
def test_3_no_event_triggers_again_ode_647(flow):
    # v -> -v at the wall: each bounce once, the next a half-turn of pi later
    system = System(
        states=["x", "v"],
        modes={"m": Mode({"x": "v", "v": "-x"}, exits=[Exit("x", reset={"v": "-v"})])},
    )
    run = ns.simulate(flow(system), {"x": 0.0, "v": 1.0}, t_end=1000.0)
    times = run["event_time"].values[1:]
    assert len(times) == int(1000 / np.pi)
    # an error of eps per half-turn, none of it grows; times carry an ulp of 1000
    assert np.allclose(np.diff(times), np.pi, rtol=0, atol=4 * 1000 * EPS)
    assert np.allclose(times, np.pi * np.arange(1, len(times) + 1), rtol=0, atol=1e-12)


@on_both_flows
def test_3_a_tangential_release_does_not_trigger_again(flow):
    # the mole separates with a guard that is zero to second order
    run = ns.simulate(flow(ns.models.moling(b=0.27)), periods=50)
    gaps = np.diff(run["event_time"].values[1:])
    assert run.attrs["status"] == "completed"
    assert gaps.min() > 1e-6


@on_both_flows
@pytest.mark.parametrize("start", [0.0, 1e6, 1e9, 1e12])
def test_4_rounded_times_fire_no_event_twice_diffeqbase_1245(flow, start):
    # At 1e12 an ulp of the time is 1e-4; the motion is measured from its window, so the
    # bounces come at the same distances, as far as the times can say.
    system = System(
        states=["x", "v"],
        modes={"m": Mode({"x": "v", "v": "-x"}, exits=[Exit("x", reset={"v": "-v"})])},
    )
    run = ns.simulate(flow(system), {"x": 0.0, "v": 1.0}, t_start=start, t_end=start + 50.0)
    times = run["event_time"].values[1:] - start
    assert len(times) == 15
    ulp = max(start, 50.0) * EPS
    assert np.allclose(times, np.pi * np.arange(1, 16), rtol=0, atol=2 * ulp + 1e-13)
    speeds = run["state_after"].sel(state="v").values[1:]
    assert np.allclose(speeds, 1.0, rtol=0, atol=1e-13)


@on_both_flows
def test_5_two_guards_at_one_instant_ode_1229(flow):
    # a corner of the table: both walls in one row, in declared order, and back along the line
    exits = [
        Exit("1 - x", reset={"u": "-u"}, name="right"),
        Exit("1 - y", reset={"v": "-v"}, name="top"),
    ]
    rates = {"x": "u", "y": "v", "u": "0", "v": "0"}
    for order, path in ((exits, "right>top"), (exits[::-1], "top>right")):
        system = System(states=["x", "y", "u", "v"], modes={"m": Mode(rates, exits=order)})
        run = ns.simulate(
            flow(system), {"x": 0.25, "y": 0.25, "u": 0.5, "v": 0.5}, times=[0.0, 1.5, 2.0, 3.0]
        )
        assert run.attrs["n_events"] == 1
        assert run["event_path"].values[-1] == path
        assert float(run["event_time"][-1]) == 1.5
        assert run["x"].values.tolist() == run["y"].values.tolist() == [0.25, 1.0, 0.75, 0.25]


@on_both_flows
def test_5_of_two_equal_guards_the_first_declared_wins(flow):
    for first, second in (("one", "two"), ("two", "one")):
        exits = [Exit("1 - x", to=first), Exit("2 - 2*x", to=second)]
        modes = {
            "m": Mode({"x": "1"}, exits=exits),
            "one": Mode({"x": "0"}),
            "two": Mode({"x": "0"}),
        }
        run = ns.simulate(flow(System(states=["x"], modes=modes)), t_end=2.0)
        assert ns.phase_word(run) == ("m", first)


@on_both_flows
@pytest.mark.parametrize("scale", [1e-100, 1e-30, 1e-9, 1e9, 1e30, 1e100])
def test_6_the_scale_of_a_guard_does_not_matter_ode_671(flow, scale):
    # powers of ten change roundings only: an ulp of the level over the rate
    level, t_end = 0.9999, 40.0
    plain, scaled = (
        System(
            states=["x", "v"],
            parameters={"c": factor, "level": level},
            modes={
                "m": Mode(
                    {"x": "v", "v": "-x"}, exits=[Exit("c*(level - x)", reset={"v": "-0.9*v"})]
                )
            },
        )
        for factor in (1.0, scale)
    )
    one, other = (ns.simulate(flow(s), {"v": 1.0}, t_end=t_end) for s in (plain, scaled))
    assert one.attrs["n_events"] == other.attrs["n_events"] > 3
    rates = np.abs(one["guard_rate"].values[1:])
    error = np.abs(one["event_time"].values - other["event_time"].values)[1:]
    # errors of one impact move the next ones: 1/rate for each of them
    assert np.all(error < 50 * EPS * np.cumsum(1.0 / rates) / rates)


@on_both_flows
def test_6_the_scale_of_the_states_does_not_matter(flow):
    # the same motion in metres, micrometres and gigametres
    runs = []
    for unit in (1.0, 1e-6, 1e9):
        system = System(
            states=["x", "v"],
            parameters={"s": 0.3 * unit, "a": unit},
            period="2*pi/2.8",
            modes={
                "m": Mode(
                    {"x": "v", "v": "a*cos(2.8*t) - x"},
                    exits=[Exit("s - x", reset={"v": "-0.8*v"})],
                )
            },
        )
        runs.append(ns.simulate(flow(system), {"v": 0.5 * unit}, t_end=15.0))
    for run in runs[1:]:
        assert run.attrs["n_events"] == runs[0].attrs["n_events"]
        # some impacts on, errors of eps have grown by less than a thousand
        assert np.allclose(run["event_time"], runs[0]["event_time"], rtol=0, atol=1e-12)


@on_both_flows
def test_7_nothing_stale_after_a_reset_ode_486(flow):
    """After an impact the motion is, bit for bit, the one that begins with the state behind it."""
    system = flow(
        System(
            states=["x", "v"],
            parameters={"r": 0.7},
            modes={
                "m": Mode(
                    {"x": "v", "v": "-x - 0.02*v + 1"}, exits=[Exit("1.2 - x", reset={"v": "-r*v"})]
                )
            },
        )
    )
    run = ns.simulate(system, {"x": 0.0}, times=[0.0, 12.0])
    first, second = (crossings(run).isel(event=k) for k in range(2))
    state = {name: float(first["state_after"].sel(state=name)) for name in ("x", "v")}
    fresh = ns.simulate(system, state, t_start=float(first["event_time"]), times=[12.0])
    again = crossings(fresh).isel(event=0)
    assert float(again["event_time"]) == float(second["event_time"])
    assert np.array_equal(again["state_before"].values, second["state_before"].values)
    assert np.array_equal(fresh["end_state"].values, run["end_state"].values)


@on_both_flows
def test_8_no_event_of_a_step_that_is_not_taken_diffrax_464(flow):
    """Behind the first wall lies a second one that the motion would cross, were it not turned back.

    And behind both a pole of the rate, which a step of any length would have to see.
    """
    exits = [
        Exit("1.001 - x", to="stop", name="second"),
        Exit("1 - x", reset={"v": "-v"}, name="first"),
    ]
    mode = Mode({"x": "v", "v": "0"}, exits=exits)
    run = ns.simulate(
        flow(System(states=["x", "v"], modes={"m": mode})), {"v": 1000.0}, times=[1.5e-3]
    )
    assert (run.attrs["status"], run.attrs["n_events"]) == ("completed", 1)
    assert crossings(run)["event_name"].values.tolist() == ["first"]
    assert float(run["x"][-1]) == pytest.approx(0.5, abs=4 * EPS)


def test_8_no_pole_behind_a_wall_is_met():
    """x'' = -1/(x - 1.01) turns to infinity a little behind the wall at 1."""
    mode = Mode({"x": "v", "v": "1/(1.01 - x)"}, exits=[Exit("1 - x", reset={"v": "-v"})])
    run = ns.simulate(System(states=["x", "v"], modes={"m": mode}), {"v": 0.5}, times=[8.0])
    assert (run.attrs["status"], run.attrs["n_uncertain"]) == ("completed", 0)
    assert run.attrs["n_events"] >= 3
    # v^2/2 + log(1.01 - x) keeps its value in flight and at impacts
    log = crossings(run)
    level = 0.125 + np.log(1.01)
    for column in ("state_before", "state_after"):
        x, v = log[column].values.T
        assert np.allclose(v**2 / 2 + np.log(1.01 - x), level, rtol=0, atol=1e-12)


@on_both_flows
def test_9_the_grid_does_not_lose_the_event_point_scipy_10319(flow):
    # samples before, at and after the impact; the log has the event whatever the grid
    system = System(
        states=["x", "v"],
        modes={"m": Mode({"x": "v", "v": "0"}, exits=[Exit("1 - x", reset={"v": "-v"})])},
    )
    for times in ([0.0, 4.0], [0.0, 0.5, 2.0, 4.0], [0.0, 1.9375, 2.0, 2.0, 2.0625, 4.0], [4.0]):
        run = ns.simulate(flow(system), {"x": 0.0, "v": 0.5}, times=times)
        # 1 - |1 - t/2|: all times are exact in binary
        assert run["time"].values.tolist() == times
        assert run["x"].values.tolist() == [1 - abs(1 - t / 2) for t in times]
        assert run["event_time"].values.tolist() == [0.0, 2.0]
        assert run["state_before"].values[-1].tolist() == [1.0, 0.5]
        assert run["state_after"].values[-1].tolist() == [1.0, -0.5]


@on_both_flows
def test_10_duplicate_times_scipy_17066(flow):
    run = ns.simulate(flow(cosine(-0.5)), {"x": 1.0}, times=[0.0, 0.0, 2.5, 2.5, 2.5, 3.0])
    assert run.sizes["time"] == 6
    assert len(set(run["x"].values.tolist())) == 3


@on_both_flows
def test_12_both_limits_at_a_jump_are_there(flow):
    """The log has both sides of each jump, of all states; a sample there has the one before."""
    resets = {"v": "-v/2", "n": "n + 1"}
    mode = Mode({"x": "v", "v": "0", "n": "0"}, exits=[Exit("1 - x", reset=resets)])
    back = Mode({"x": "v", "v": "0", "n": "0"})
    system = System(states=["x", "v", "n"], modes={"m": mode, "back": back})
    run = ns.simulate(flow(system), {"v": 0.5}, times=[1.0, 2.0, 3.0])
    log = crossings(run)
    assert log["state_before"].values.tolist() == [[1.0, 0.5, 0.0]]
    assert log["state_after"].values.tolist() == [[1.0, -0.25, 1.0]]
    assert run["n"].values.tolist() == [0.0, 0.0, 1.0]
    assert run["x"].values.tolist() == [0.5, 1.0, 0.75]


@on_both_flows
@pytest.mark.parametrize(
    "window",
    [None, "100", "800", "2000"],
)
def test_no_root_is_missed_beside_growing_motions(flow, window):
    # x = exp(t) is no part of the guard; y = exp(-t) reaches 1/2 at log 2. With a declared
    # period the segment is that long, and exp of it overflows.
    system = System(
        states=["x", "y"],
        period=window,
        modes={"m": Mode({"x": "x", "y": "-y"}, exits=[Exit("y - 0.5", to="stop")])},
    )
    run = ns.simulate(flow(system), {"x": 1e-3, "y": 1.0}, t_end=20.0)
    assert run.attrs["status"] == "stopped"
    assert float(run["event_time"][-1]) == pytest.approx(np.log(2.0), rel=1e-14)


@on_both_flows
@pytest.mark.parametrize(
    "window",
    [
        None,
        "10",
        "100",
        "800",
    ],
)
def test_a_growing_motion_that_is_reset(flow, window):
    # x = exp(t) is sent back from 1000 to 1: every log 1000
    system = System(
        states=["x"],
        period=window,
        modes={"m": Mode({"x": "x"}, exits=[Exit("1000 - x", reset={"x": "1"})])},
    )
    run = ns.simulate(flow(system), {"x": 1.0}, t_end=30.0)
    assert run.attrs["status"] == "completed"
    assert np.allclose(np.diff(run["event_time"]), np.log(1000.0), rtol=1e-14)


@on_both_flows
@pytest.mark.parametrize("period", [None, 1e2, 1e4, 1e6, 1e8])
def test_the_length_of_the_period_does_not_blur_impacts(flow, period):
    # A ball dropped from 1e-3 has nothing to do with a period declared beside it: eight
    # bounces at sqrt(2e-3) (1 + 2 (r + r^2 + ...)), the last with a speed of 1.7e-4.
    system = System(
        states=["x", "v"],
        period=period,
        modes={"m": Mode({"x": "v", "v": "-1"}, exits=[Exit("x", reset={"v": "-v/2"})])},
    )
    k = np.arange(1, 9)
    times = np.sqrt(2e-3) * (1 + 2 * (1 - 0.5 ** (k - 1)))
    run = ns.simulate(flow(system), {"x": 1e-3}, times=[float(times[-1]) + 1e-4])
    assert run.attrs["n_events"] == 8
    # roundings of x, at most eps 1e-3, over the speed
    assert np.allclose(run["event_time"][1:], times, rtol=0, atol=1e-13)


@on_both_flows
@pytest.mark.parametrize("omega", [1e-1, 1e-4, 1e-6, 1e-9])
def test_slow_forcing_does_not_blur_the_first_contact(flow, omega):
    # The mole starts from rest with f = b + a cos(pi/2 + omega t) = 0.15 - 0.3 sin(omega t)
    # over a gap of 0.02: p = 0.075 t^2 - 0.3 (t - sin(omega t)/omega)/omega.
    run = ns.simulate(flow(ns.models.moling(omega=omega)), t_end=1.0)
    t = np.sqrt(0.02 / 0.075)
    for _ in range(50):  # the correction is 0.05 omega t^3, small
        u = (omega * t) ** 2
        t = np.sqrt((0.02 + 0.05 * omega * t**3 * (1 - u / 20 + u**2 / 840)) / 0.075)
    assert run["event_name"].values[1] == "impact"
    assert float(run["event_time"][1]) == pytest.approx(t, rel=1e-11)


@on_both_flows
def test_a_frequency_near_the_window_keeps_its_phase(flow):
    # 2 pi/64 and a little: windows of 2^k hold nearly whole turns, but only nearly
    w = 2 * np.pi / 64 * (1 + 9e-10)
    system = System(states=["x"], parameters={"w": w}, modes={"m": Mode({"x": "cos(w*t)"})})
    run = ns.simulate(flow(system), times=[1000.3, 64000.9])
    # the angle is 6e3 rad, so eps 6e3 in the sine, over w
    expected = np.sin(w * run["time"].values) / w
    assert np.allclose(run["x"], expected, rtol=0, atol=6e3 * EPS / w)


def test_warnings_are_run_warnings():
    # a script may turn exactly these into errors
    system = System(states=["x"], modes={"m": Mode({"x": "x"})})
    with pytest.warns(RunWarning):
        ns.simulate(system, {"x": 1.0}, t_end=100.0)
