"""The rotor against 40-digit series, and its flips against a program in other methods.

Tolerances: states to 1e-11 times the growth of the tangent, times of events to that over the rate
of their guard.
"""

import numpy as np
import pytest

import nonsmooth as ns
from models.rotor_truth import FLIPS, RUNS
from nonsmooth.models import rotor

STATES = ["x", "y", "vx", "vy", "sx", "sy", "mu"]
COMPLETED = [name for name, truth in RUNS.items() if truth["status"] == "completed"]
UNDECIDED = [name for name in RUNS if name not in COMPLETED]


def run_like(truth, **words):
    return ns.simulate(rotor(**truth["parameters"], **words), periods=10, samples_per_period=4)


def passages(run):
    """(from, to, time) of events that lead from one regime to another.

    Without preload the two sides of s = 0 are both V, and the log has what passes between them.
    """
    meanings = run["event_to"].attrs["flag_meanings"].split()
    names = ["I" if name == "free" else name for name in meanings]
    rows = zip(*(run[n].values for n in ("event_from", "event_to", "event_time")), strict=True)
    named = [(names[a], names[b], t) for a, b, t in rows]
    return [each for each in named if each[0] != each[1]]


def regimes(events):
    """As above; a ring that falls back within its preload stays in I."""
    return [(e["from"], e["to"], float(e["t"]), e) for e in events if e["from"] != e["to"]]


def growth(truth):
    return max(1.0, float(truth["tangent_growth"]["worst"]))


@pytest.mark.parametrize("name", COMPLETED)
def test_states_and_events(name):
    truth = RUNS[name]
    run = run_like(truth)
    assert run.attrs["status"] == "completed"
    expected = np.array(truth["samples"], dtype=float)
    found = np.stack([run[k].values for k in STATES], axis=1)[1:]
    assert np.abs(found - expected).max() < 1e-11 * growth(truth)
    true, own = regimes(truth["events"]), passages(run)
    assert [each[:2] for each in own] == [each[:2] for each in true]
    for (*_, t), (*_, true_t, event) in zip(own, true, strict=True):
        rate = min(1.0, abs(float(event["guard_rate"])))
        assert abs(t - true_t) < 1e-11 * growth(truth) / rate


def test_runs_pass_every_regime_both_ways():
    """What the file is for: all neighbours of each regime occur."""
    pairs = {each[:2] for name in COMPLETED for each in regimes(RUNS[name]["events"])}
    neighbours = {("II", "III"), ("II", "IV"), ("III", "V"), ("IV", "V"), ("I", "II"), ("I", "V")}
    assert neighbours | {pair[::-1] for pair in neighbours} <= pairs


@pytest.mark.parametrize("name", UNDECIDED)
def test_no_regime_holds(name):
    """After the release rotor and ring would approach: the ring rides on until it is free."""
    truth = RUNS[name]
    with pytest.warns(ns.RunWarning, match="undecided"):
        stopped = run_like(truth, ring="relaxes")
    assert stopped.attrs["status"] == "undecided" and "release" in stopped.attrs["message"]
    run = run_like(truth, ring="rides")
    assert run.attrs["status"] == "completed"
    times, modes = run["event_time"].values, run["event_to"]
    k = int(np.argmin(np.abs(times - float(truth["events"][-1]["t"]))))
    assert abs(times[k] - float(truth["events"][-1]["t"])) < 1e-12
    assert str(run["event_name"].values[k]) == "release"
    names = [modes.attrs["flag_meanings"].split()[int(m)] for m in modes.values[k:]]
    free = names.index("free")  # the springs at work may change before
    assert free > 0 and set(names[:free]) == {"riding"}


@pytest.mark.parametrize("flip", FLIPS, ids=lambda f: f"{f.delta} {f.eta}")
def test_multipliers_at_flips(flip):
    system = rotor(eta=flip.eta, delta_x=flip.delta, delta_y=flip.delta)
    start = dict(zip(STATES[:4], flip.state, strict=True))
    run = ns.simulate(system, start, periods=flip.period, samples_per_period=1, tangent=True)
    end = [float(run[name][-1]) for name in STATES[:4]]
    assert np.abs(np.subtract(end, flip.state)).max() < 1e-9
    found = np.linalg.eigvals(run["tangent"].values[-1][:4, :4])
    for value in (-1.0, *flip.others):
        assert np.abs(found - value).min() < 1e-7


def orbit(eta, flip, state):
    """State at the strobe of the orbit near a flip, and its multipliers, by Newton's method."""
    system = rotor(eta=eta, delta_x=flip.delta, delta_y=flip.delta)
    for _ in range(8):
        start = dict(zip(STATES[:4], state, strict=True))
        run = ns.simulate(system, start, periods=flip.period, samples_per_period=1, tangent=True)
        end = np.array([float(run[name][-1]) for name in STATES[:4]])
        matrix = run["tangent"].values[-1][:4, :4]
        step = np.linalg.solve(matrix - np.eye(4), end - state)
        state = state - step
        if np.abs(step).max() < 1e-12:
            break
    assert np.abs(step).max() < 1e-10
    return state, np.linalg.eigvals(matrix)


# each takes ten seconds; the first of either preload runs in any case
SOME = {FLIPS[0], next(flip for flip in FLIPS if flip.delta != FLIPS[0].delta)}


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "flip",
    [
        pytest.param(f, id=f"{f.delta} {f.eta}", marks=[pytest.mark.slow] * (f not in SOME))
        for f in FLIPS
    ],
)
def test_flips_are_found_by_bisection_on_the_multiplier(flip):
    """The truth is of another integrator and of differences; both are good for 1e-9."""
    state = np.array(flip.state)

    def excess(eta):
        nonlocal state
        state, multipliers = orbit(eta, flip, state)
        real = multipliers[np.abs(multipliers.imag) < 1e-9].real
        return float(real.min()) + 1.0

    low, high = flip.eta - 1e-5, flip.eta + 1e-5
    below = excess(low)
    assert below * excess(high) < 0.0
    while high - low > 2e-9:
        middle = 0.5 * (low + high)
        if excess(middle) * below > 0.0:
            low = middle
        else:
            high = middle
    assert abs(0.5 * (low + high) - flip.eta) < 1e-8
