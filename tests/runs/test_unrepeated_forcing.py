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
        states=["x"], period="2*pi", signals=signals, parameters={"k": 1.0, "m": 1.0},
        equations={"x": f"-x + {text} + k*m*cos(t)"},
    )  # fmt: skip


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


ASKED = {
    "StroboscopicMap": ns.StroboscopicMap,
    "regime": ns.regime,
    "regime_map": lambda system: ns.regime_map(system, {"k": [1.0, 2.0], "m": [1.0, 2.0]}),
    "find_orbit": lambda system: ns.find_orbit(system, {"x": 1.0}),
    "orbits": lambda system: ns.orbits(system, 1),
    "continue_orbit": lambda system: ns.continue_orbit(system, "k", (0.5, 1.5)),
    "attractors": lambda system: ns.attractors(system, {"x": (0.0, 1.0)}),
    "basins": lambda system: ns.basins_of_attraction(system, {"x": (0.0, 1.0, 4)}),
    "diagram": lambda system: ns.bifurcation_diagram(system, "k", [1.0, 2.0]),
    "diagram of a section": lambda system: ns.bifurcation_diagram(
        ns.PoincareMap(system, "x"), "k", [1.0, 2.0]
    ),
    "picture": lambda system: ns.bifurcation_picture(system, "k", (1.0, 2.0), {"x": (0.0, 1.0)}),
    "contacts": lambda system: ns.contact_statistics(system, contact="flow"),
    "waterfall": lambda system: ns.waterfall(system, "x", "k", [1.0, 2.0]),
    "return_map": lambda system: ns.return_map(ns.PoincareMap(system, "x"), "x", (0.0, 1.0)),
    "manifold": lambda system: ns.manifold(system, {"x": 1.0}),
    "edge_state": lambda system: ns.edge_state(system, {"x": 0.0}, {"x": 1.0}),
}


@pytest.mark.parametrize("verb", ASKED)
@pytest.mark.parametrize("kind", TEXTS)
def test_what_needs_a_motion_that_repeats_is_refused(kind, verb):
    """By one rule and in the same words, whatever it is that does not repeat."""
    has = "the signal 'ramp'" if kind == "a signal" else "t by itself in the rate of 'x'"
    with pytest.raises(ns.OptionError, match=f"has {has}.*which does not repeat"):
        ASKED[verb](system_of(kind))


@pytest.mark.parametrize("kind", TEXTS)
def test_what_looks_at_one_motion_is_there(kind):
    """Strobes of many motions, and exponents of a stretch of one: x' = -x + ... has -1."""
    system = system_of(kind)
    runs = ns.ensemble(system, {"x": [1.0, 0.5]}, record=20)
    at = 2.0 * np.pi * np.arange(20)
    assert runs["x"].values[0] == pytest.approx(truth(at), rel=64 * EPS)
    exponents = ns.lyapunov_spectrum(system, transient=2, record=8, confirm=100)
    assert float(exponents["lyapunov_exponent"][0]) == pytest.approx(-1.0, rel=1e-12)


def test_many_motions_do_not_go_beyond_a_record():
    """With the longest of several periods too: the spline has nothing to say behind its end."""
    system = ns.System(
        states=["x"], parameters={"T": 1.0}, period="T", equations={"x": "ramp - x"},
        signals={"ramp": ns.Signal([0.0, 30.0], [0.0, 30.0], "linear")},
    )  # fmt: skip
    with pytest.raises(ns.OptionError, match="to 30, and the run goes from t = 0 to 40;"):
        ns.ensemble(system, {"x": [0.0, 1.0]}, record=41)
    with pytest.raises(ns.OptionError, match="to 30, and the run goes from t = 0 to 60;"):
        ns.ensemble(system, {"x": 0.0}, parameters={"T": [0.5, 1.0, 3.0]}, record=21)
    last = ns.ensemble(system, {"x": 0.0}, parameters={"T": [0.5, 1.0]}, record=31)["x"][1, -1]
    assert float(last) == pytest.approx(29.0 + np.exp(-30.0), rel=64 * EPS)


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
