"""A period beside a signal or t by itself: strobes are there, motions that repeat are not."""

import numpy as np
import pytest

import nonsmooth as ns

EPS = 2.0**-52
RAMP = ns.Signal([0.0, 400.0], [0.0, 400.0], "linear")
TEXTS = {
    "linear in t": ("t", {}),
    "a signal": ("ramp", {"ramp": RAMP}),
    "by Taylor series": ("t + 0*x**2", {}),
}


def system_of(kind):
    text, signals = TEXTS[kind]
    return ns.System(
        states=["x"], period="2*pi", signals=signals, equations={"x": f"-x + {text} + cos(t)"}
    )


def truth(t):
    """From x = 1: x' = -x + t + cos t."""
    return t - 1.0 + 0.5 * (np.cos(t) + np.sin(t)) + 1.5 * np.exp(-t)


@pytest.mark.parametrize("kind", TEXTS)
def test_runs_and_strobes(kind):
    system = system_of(kind)
    run = ns.simulate(system, {"x": 1.0}, periods=40, samples_per_period=4)
    assert run.attrs["status"] == "completed"
    time = run["time"].values
    assert time[-1] == pytest.approx(80.0 * np.pi, abs=4 * EPS * time[-1])
    # values as large as t, each of some roundings, and steps in a row where there is no closed form
    allowed = 64 * EPS * (1.0 + time)
    assert np.all(np.abs(run["x"].values - truth(time)) <= allowed)
    points = ns.stroboscopic_map(system, {"x": 1.0}, transient=5, record=20)
    at = 2.0 * np.pi * np.arange(5, 25)
    assert points["x"].values == pytest.approx(truth(at), rel=64 * EPS)


@pytest.mark.parametrize("kind", TEXTS)
def test_what_needs_a_motion_that_repeats_is_refused(kind):
    system, word = system_of(kind), "does not repeat|no motion repeats"
    with pytest.raises(ns.OptionError, match=word):
        ns.find_orbit(system, {"x": 1.0})
    with pytest.raises(ns.OptionError, match=word):
        ns.attractors(system, {"x": (0.0, 1.0)})
    with pytest.raises(ns.OptionError, match=word):
        ns.basins_of_attraction(system, {"x": (0.0, 1.0, 4)})
    if kind == "a signal":
        with pytest.raises(ns.OptionError, match="does not repeat"):
            ns.regime(system)


def test_a_slow_parameter_of_a_system_that_nothing_drives():
    # the stiffness is kept for 0.5 each, so the motion is a product of rotations
    system = ns.System(
        states=["x", "v"], parameters={"k": 1.0}, period=0.5, slow={"k": "1 + t/10"},
        equations={"x": "v", "v": "-k*x"},
    )  # fmt: skip
    run = ns.simulate(system, {"x": 1.0}, periods=20, samples_per_period=1)
    state = np.array([1.0, 0.0])
    for number in range(20):
        w = np.sqrt(1.0 + 0.05 * number)
        c, s = np.cos(0.5 * w), np.sin(0.5 * w)
        state = np.array([[c, s / w], [-w * s, c]]) @ state
    assert float(run["x"][-1]) == pytest.approx(state[0], abs=400 * EPS)
    assert float(run["v"][-1]) == pytest.approx(state[1], abs=400 * EPS)
