"""Neither samples, nor the end of a run, nor a cut changes an event: bit for bit."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import nonsmooth as ns
from engine.flow_survey import coefficients, template
from engine.guard_cases import draw_guards
from engine.spectra import Case

SEEDS = st.integers(0, 10**6)


@cache
def two_sided(n: int, k: int) -> ns.System:
    """A flow of the template that changes continuously where h . x + b changes sign."""
    plain = template(n, k)
    guard = " + ".join([f"h{j}*x{j}" for j in range(n)] + ["b"])
    beyond = {x: f"{text} + r{x[1:]}*({guard})" for x, text in plain.modes["m"].flow.items()}
    parameters = dict(plain.parameters) | {"b": 1.0}
    parameters |= {f"{c}{j}": 1.0 for c in "hr" for j in range(n)}
    modes = {
        "above": ns.Mode(plain.modes["m"].flow, exits=[ns.Exit(guard, to="below")]),
        "below": ns.Mode(beyond, exits=[ns.Exit(f"-({guard})", to="above")]),
    }
    return ns.System(states=plain.states, parameters=parameters, modes=modes)


def random_run(seed: int):
    """A function that runs the system of a seed with any options, and how long it is to run."""
    case, rng = draw_guards(seed), np.random.default_rng(seed)
    flow, row, n = case.flow, case.guards[-1], len(case.flow.start)
    flow = Case(*flow[:3], flow.frequencies, flow.cosines, flow.sines)
    turn = (
        rng.normal(size=n) * np.abs(np.linalg.eigvals(flow.matrix)).max() / (1 + np.abs(row).max())
    )
    values = coefficients(flow) | {"b": float(row[n])}
    values |= {f"h{j}": float(row[j]) for j in range(n)}
    values |= {f"r{j}": float(turn[j]) for j in range(n)}
    try:
        system = two_sided(n, flow.frequencies.size).with_parameters(**values)
        ns.simulate(system, times=[0.0])
    except (ns.ModelError, ns.OptionError):
        return None, 0.0
    initial = {f"x{i}": float(x) for i, x in enumerate(flow.start)}
    return lambda start=initial, **options: ns.simulate(system, start, **options), case.time


def events(*runs, left_out=("start", "graze")):
    """Every bit of every event of runs that go on from each other."""
    rows = []
    for run in runs:
        kept = run.isel(event=~np.isin(run["event_kind"].values, left_out))
        columns = [kept[c].values for c in ("event_time", "guard_rate", "certified", "event_to")]
        states = [kept["state_before"].values, kept["state_after"].values]
        rows += [
            tuple(np.asarray(part[i], float).tobytes() for part in columns + states)
            for i in range(kept.sizes["event"])
        ]
    return rows


def check(run, long, short, grids):
    """``long`` and ``short`` are options that say when a run ends, ``grids`` sample it."""
    whole = run(**long)
    expected = events(whole)
    for grid in grids:
        assert events(run(**grid)) == expected
    part = events(run(**short))
    assert part == expected[: len(part)]
    first = run(**short)
    assert events(first, run(first, **long)) == expected
    return len(expected)


def test_a_touch_belongs_to_the_run_that_reaches_it():
    """cos t + 1 touches zero at pi: not in a run that ends at 2, once if that goes on to 8."""
    touching = ns.Mode({"x": "v", "v": "-x"}, exits=[ns.Exit("1 + x", to="stop")])
    system = ns.System(states=["x", "v"], modes={"m": touching})
    first = ns.simulate(system, {"x": 1.0}, t_end=2.0)
    assert first.attrs["n_uncertain"] == 0
    second = ns.simulate(system, first, t_end=8.0)
    whole = ns.simulate(system, {"x": 1.0}, t_end=8.0)
    assert events(first, second, left_out="start") == events(whole, left_out="start")


@settings(max_examples=15)
@given(SEEDS, st.floats(0.01, 0.99), st.integers(1, 40))
def test_random_systems_without_a_period(seed, share, samples):
    run, end = random_run(seed)
    if run is None:
        return
    try:
        grid = np.sort(np.random.default_rng(seed).uniform(0, end, samples))
        grids = [{"times": np.append(grid, end)}, {"times": [end]}]
        check(run, {"t_end": end}, {"t_end": share * end}, grids)
    except ns.RunWarning:  # states beyond 1e30, or accumulating events: the run ends early
        return


WALL = ns.System(
    states=["x", "v"],
    period="2*pi/omega",
    parameters={"omega": 2.8, "zeta": 0.02, "sigma": 0.1, "r": 0.8, "F": 1.0},
    modes={
        "free": ns.Mode(
            {"x": "v", "v": "F*cos(omega*t) - 2*zeta*v - x"},
            exits=[ns.Exit("sigma - x", reset={"v": "-r*v"})],
        )
    },
)


@pytest.mark.slow
@settings(max_examples=40)
@given(SEEDS, st.floats(0.01, 11.99))
def test_impacts_under_a_periodic_force(seed, cut):
    rng = np.random.default_rng(seed)
    values = {
        "omega": rng.uniform(0.3, 4),
        "sigma": rng.uniform(0.0, 0.03),
        "r": rng.uniform(0.4, 1),
    }
    system = WALL.with_parameters(**values)

    def run(start=None, **options):
        return ns.simulate(system, {"x": -0.1} if start is None else start, **options)

    end = 12 * system.period_value
    grids = [{"periods": 12, "samples_per_period": count} for count in (1, 7, 100)]
    grids.append({"times": [*np.sort(rng.uniform(0, end, 30)).tolist(), end]})
    try:
        count = check(run, {"t_end": end}, {"t_end": cut / 12 * end}, grids)
    except ns.RunWarning:  # impacts that accumulate
        return
    assert count > 0
