"""Events on samples, at strobes, at period boundaries, at the start and at the end of a run."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import nonsmooth as ns
from engine.test_sampling_invariance import check, events
from nonsmooth import Exit, Mode, RunWarning, System
from runs.flows import crossings, on_both_flows


def shuttle(period=None):
    """Between walls at 0 and 1 with speed 1/2; all times are exact in binary."""
    exits = [
        Exit("1 - x", reset={"v": "-v"}, name="right"),
        Exit("x", reset={"v": "-v"}, name="left"),
    ]
    mode = Mode({"x": "v", "v": "0"}, exits=exits)
    return System(states=["x", "v"], period=period, modes={"m": mode})


@on_both_flows
@pytest.mark.parametrize("period", [None, 2.0, 1.0, 0.25, 8.0])
def test_events_at_strobes_and_period_boundaries(flow, period):
    """Bounces at 2, 4, 6, ...: for most of these periods each is at a boundary."""
    run = ns.simulate(flow(shuttle(period)), {"v": 0.5}, times=np.arange(0.0, 21.0, 0.5))
    log = crossings(run)
    assert log["event_time"].values.tolist() == list(range(2, 21, 2))
    assert log["event_name"].values.tolist() == ["right", "left"] * 5
    assert bool(log["certified"].all())
    triangle = 1.0 - np.abs(1.0 - np.mod(run["time"].values / 2, 2.0))
    assert np.array_equal(run["x"].values, triangle)
    if period is not None:
        strobes = ns.simulate(flow(shuttle(period)), {"v": 0.5}, periods=int(24 / period))
        assert strobes.attrs["n_events"] == 11


@on_both_flows
def test_a_sample_at_an_event_is_the_state_before(flow):
    run = ns.simulate(flow(shuttle()), {"v": 0.5}, times=[2.0, 2.0, 2.5, 4.0, 4.5])
    assert run["v"].values.tolist() == [0.5, 0.5, -0.5, -0.5, 0.5]
    assert crossings(run)["state_before"].values.tolist() == [[1.0, 0.5], [0.0, -0.5]]
    assert crossings(run)["state_after"].values.tolist() == [[1.0, -0.5], [0.0, 0.5]]


@on_both_flows
@pytest.mark.parametrize("end", [2.0, 4.0, 64.0, 128.0])
def test_an_event_at_the_end(flow, end):
    """It belongs to the run that goes on, or to this one: never to both, and never to none."""
    system = flow(shuttle())
    first = ns.simulate(system, {"v": 0.5}, t_end=end)
    second = ns.simulate(system, first, t_end=end + 3.0)
    assert first.attrs["n_events"] + second.attrs["n_events"] == end // 2 + 1
    whole = ns.simulate(system, {"v": 0.5}, t_end=end + 3.0)
    assert events(first, second) == events(whole)


@on_both_flows
@pytest.mark.parametrize("start", [0.0, 2.0, 64.0, 1e6])
def test_an_event_at_the_start(flow, start):
    run = ns.simulate(flow(shuttle()), {"x": 1.0, "v": 0.5}, t_start=start, times=[start + 1.0])
    assert run["event_kind"].values.tolist() == ["start"]
    assert run["event_path"].values.tolist() == ["right"]
    assert run["x"].values.tolist() == [0.5]


# ---------------------------------------------------------------- sampling and cutting

DUFFING = System(
    states=["x", "v"],
    period="2*pi/w",
    parameters={"w": 1.2, "F": 0.5, "s": 0.9, "r": 0.8},
    modes={
        "m": Mode(
            {"x": "v", "v": "x - x**3 - 0.1*v + F*cos(w*t)"},
            exits=[Exit("s - x", reset={"v": "-r*v"})],
        )
    },
)
ROUND = System(  # a bead that is thrown about in a bowl, and slides where it is slow
    states=["x", "y", "u", "v"],
    parameters={"r": 0.9},
    definitions={"normal": "(x*u + y*v)/(x**2 + y**2)"},
    modes={
        "m": Mode(
            {"x": "u", "y": "v", "u": "-0.05*u*abs(u)", "v": "-1 - 0.05*v*abs(v)"},
            exits=[
                Exit(
                    "1 - x**2 - y**2",
                    reset={"u": "u - (1 + r)*x*normal", "v": "v - (1 + r)*y*normal"},
                )
            ],
        )
    },
)


@settings(max_examples=15)
@given(st.integers(0, 10**6), st.floats(0.01, 9.99))
def test_sampling_changes_no_bit_of_a_forced_taylor_run(seed, cut):
    rng = np.random.default_rng(seed)
    values = {"w": rng.uniform(0.5, 3), "s": rng.uniform(0.3, 1.0), "r": rng.uniform(0.4, 1)}
    system = DUFFING.with_parameters(**values)

    def run(start=None, **options):
        return ns.simulate(system, {"x": 0.1} if start is None else start, **options)

    end = 10 * system.period_value
    grids = [{"periods": 10, "samples_per_period": count} for count in (1, 50)]
    grids.append({"times": [*np.sort(rng.uniform(0, end, 30)).tolist(), end]})
    try:
        assert check(run, {"t_end": end}, {"t_end": cut / 10 * end}, grids) > 0
    except RunWarning:  # impacts that accumulate
        return


@settings(max_examples=15)
@given(st.integers(0, 10**6), st.floats(0.01, 0.99))
def test_sampling_changes_no_bit_of_a_free_taylor_run(seed, share):
    rng = np.random.default_rng(seed)
    start = dict(zip("xyuv", rng.uniform(-0.5, 0.5, 4), strict=True))

    def run(begin=start, **options):
        return ns.simulate(ROUND, begin, **options)

    end = 8.0
    times = [*np.sort(rng.uniform(0, end, 25)).tolist(), end]
    try:
        check(run, {"t_end": end}, {"t_end": share * end}, [{"times": times}, {"times": [end]}])
    except RunWarning:  # impacts that accumulate
        return
