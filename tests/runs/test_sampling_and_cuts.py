"""Neither samples nor cuts are part of a trajectory: all bits stay where they are."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System


def wall():
    """The rigid impact oscillator of the design, off its resonances."""
    return System(
        states=["x", "v"],
        parameters={"w": 2.8, "zeta": 0.02, "sigma": 0.1, "r": 0.8},
        period="2*pi/w",
        modes={
            "free": Mode(
                {"x": "v", "v": "cos(w*t) - 2*zeta*v - x"},
                exits=[Exit("sigma - x", reset={"v": "-r*v"}, name="impact")],
            )
        },
    )


def billiard():
    """No period, no spectrum but zero: the window is the one of last resort."""
    return System(
        name="billiard",
        states=["x", "y", "u", "v"],
        modes={
            "inside": Mode(
                {"x": "u", "y": "v", "u": "0", "v": "-0.01"},
                exits=[
                    Exit("1 - x", reset={"u": "-u"}),
                    Exit("x", reset={"u": "-u"}),
                    Exit("1 - y", reset={"v": "-v"}),
                    Exit("y", reset={"v": "-v"}),
                ],
            )
        },
    )


CASES = {
    "mole": (lambda: ns.models.moling(b=0.27), {}, 30 * 2 * np.pi / 0.1),
    "wall": (wall, {"x": -0.2, "v": 0.3}, 60 * 2 * np.pi / 2.8),
    "billiard": (billiard, {"x": 0.3, "y": 0.4, "u": 0.7, "v": 0.31}, 200.0),
}


def bits(run):
    """Everything that must not change, in one array of doubles."""
    parts = [run["event_time"], run["event_phase"], run["guard_rate"], run["state_before"]]
    parts += [run["state_after"], run["event_to"], run["certified"], run["end_state"]]
    return np.concatenate([np.ravel(part.values).astype(float) for part in parts])


@pytest.fixture(params=CASES, scope="module")
def case(request):
    make, initial, t_end = CASES[request.param]
    system = make()
    plain = ns.simulate(system, initial, times=[t_end])
    assert plain.attrs["status"] == "completed"
    assert plain.attrs["n_events"] > 40
    return system, initial, t_end, plain


@pytest.mark.parametrize("samples_per_period", [1, 7, 1000])
def test_samples_per_period_changes_no_bit(case, samples_per_period):
    system, initial, t_end, plain = case
    run = ns.simulate(system, initial, t_end=t_end, samples_per_period=samples_per_period)
    assert np.array_equal(bits(run), bits(plain), equal_nan=True)


@pytest.mark.parametrize("seed", [0, 1])
def test_times_change_no_bit(case, seed):
    system, initial, t_end, plain = case
    times = np.sort(np.random.default_rng(seed).uniform(0.0, t_end, 3000))
    run = ns.simulate(system, initial, times=[*times, t_end])
    assert np.array_equal(bits(run), bits(plain), equal_nan=True)


def test_times_at_the_events_change_no_bit(case):
    system, initial, t_end, plain = case
    run = ns.simulate(system, initial, times=[*plain["event_time"].values, t_end])
    assert np.array_equal(bits(run), bits(plain), equal_nan=True)


def test_a_sample_does_not_depend_on_the_others(case):
    # one sample alone and the same among thousands: the segment is left as it was found.
    # Events move by rounding only (see above), which the motion carries along.
    system, initial, t_end, _ = case
    dense = np.linspace(0.0, 0.1 * t_end, 501)
    many = ns.simulate(system, initial, times=dense)
    for k in (17, 250, 500):
        alone = ns.simulate(system, initial, times=dense[k : k + 1])
        for name in system.states:
            assert float(alone[name][-1]) == pytest.approx(
                float(many[name][k]), rel=1e-11, abs=1e-11
            )


def cuts_of(plain, t_end, window):
    """Anywhere, at events, just beside events, at the ends of windows."""
    events = plain["event_time"].values[1:]
    events = events[(events > 0.0) & (events < t_end)][:12]
    anywhere = np.random.default_rng(5).uniform(0.0, t_end, 12)
    boundaries = window * np.arange(1, int(t_end / window) + 1)
    cuts = [*anywhere, *events, *np.nextafter(events, np.inf), *np.nextafter(events, -np.inf)]
    cuts += [*boundaries[:4], *(events + 1e-9)]
    return [float(cut) for cut in cuts if 0.0 < cut < t_end]


def joined(*runs):
    """Bits of several runs in a row, as if they were one."""
    names = ["event_time", "event_phase", "guard_rate", "state_before", "state_after", "event_to"]
    # each run has a start row of its own; that of the first one counts
    logs = [run.isel(event=slice(min(i, 1), None)) for i, run in enumerate(runs)]
    parts = [np.concatenate([log[name].values for log in logs]) for name in [*names, "certified"]]
    parts.append(runs[-1]["end_state"].values)
    return np.concatenate([np.ravel(part).astype(float) for part in parts])


@pytest.mark.slow
def test_a_cut_anywhere_changes_no_bit(case):
    system, initial, t_end, plain = case
    cuts = cuts_of(plain, t_end, plain.attrs["window"])
    assert len(cuts) > 40
    for cut in cuts:
        first = ns.simulate(system, initial, times=[cut])
        # the last sample alone: samples may not be told apart from cuts here
        second = ns.simulate(system, first, times=[t_end])
        assert np.array_equal(joined(first, second), bits(plain), equal_nan=True), cut


def test_many_cuts_change_no_bit(case):
    system, initial, t_end, plain = case
    cuts = np.sort(np.random.default_rng(7).uniform(0.0, t_end, 25))
    runs = [ns.simulate(system, initial, times=[cuts[0]])]
    for cut in [*cuts[1:], t_end]:
        runs.append(ns.simulate(system, runs[-1], times=[cut]))
    assert np.array_equal(joined(*runs), bits(plain), equal_nan=True)


def test_a_cut_with_samples_changes_no_bit(case):
    system, initial, t_end, plain = case
    first = ns.simulate(system, initial, t_end=0.37 * t_end, samples_per_period=50)
    second = ns.simulate(system, first, t_end=t_end, samples_per_period=31)
    assert np.array_equal(joined(first, second), bits(plain), equal_nan=True)


def test_going_on_to_the_same_end_twice_is_the_same(case):
    system, initial, t_end, _ = case
    first = ns.simulate(system, initial, times=[0.4 * t_end])
    second, third = (ns.simulate(system, first, times=[0.6 * t_end]) for _ in range(2))
    assert second.identical(third)


def test_the_word_of_a_continued_run():
    mole = ns.models.moling(b=0.27)
    whole = ns.simulate(mole, periods=6)
    period = whole.attrs["period"]
    first = ns.simulate(mole, periods=4.33)
    second = ns.simulate(mole, first, t_end=6 * period)
    assert ns.phase_word(second) == ns.phase_word(whole, 4.33 * period)


def test_the_word_of_a_continued_run_without_events():
    system = System(states=["x"], modes={"only": Mode({"x": "-x"})})
    first = ns.simulate(system, {"x": 1.0}, t_end=1.0)
    assert ns.phase_word(ns.simulate(system, first, t_end=2.0)) == ("only",)
