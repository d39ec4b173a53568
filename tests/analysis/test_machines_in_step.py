"""Equal machines in step, where that is unstable: arithmetic keeps them so, and nothing else does.

Two neurons v' = I - v + g (w - v) that fire at 1, and are at 0 then, fire together in step once in
T = log(I/(I - 1)). In the flow their difference falls by exp(-(1 + 2 g) T). Where one is ahead by d
and fires, the other one takes d/(I - 1 - g) longer, and the first goes on by I + g meanwhile. So
a difference grows by exp(-(1 + 2 g) T) (I + g)/(I - 1 - g) in a turn.
"""

import warnings

import numpy as np
import pytest

import nonsmooth as ns

DRIVE, G = 1.3, 0.05
T = np.log(DRIVE / (DRIVE - 1.0))
GROWS = np.exp(-(1.0 + 2.0 * G) * T) * (DRIVE + G) / (DRIVE - 1.0 - G)  # 1.076 in a turn
IN_STEP = {"v": 0.2, "w": 0.2}


def neurons() -> ns.System:
    """Two neurons."""
    return ns.System(
        states=["v", "w"],
        parameters={"I": DRIVE, "g": G},
        modes={
            "rising": ns.Mode(
                {"v": "I - v + g*(w - v)", "w": "I - w + g*(v - w)"},
                exits=[
                    ns.Exit("1 - v", reset={"v": "0"}, name="first"),
                    ns.Exit("1 - w", reset={"w": "0"}, name="second"),
                ],
            )
        },
    )


def repelling() -> ns.System:
    """Two van der Pol oscillators whose dampers push their difference."""
    return ns.System(
        states=["x", "u", "y", "w"],
        equations={
            "x": "u", "u": "(1 - x**2)*u - x + 0.1*(u - w)",
            "y": "w", "w": "(1 - y**2)*w - y + 0.1*(w - u)",
        },
    )  # fmt: skip


def test_the_motion_in_step_is_unstable():
    orbit = ns.find_orbit(neurons(), IN_STEP, transient=0)
    assert float(orbit["length"]) == pytest.approx(T, rel=1e-12)
    np.testing.assert_allclose(orbit["multipliers"].values.real, [GROWS], rtol=1e-9)
    assert GROWS > 1.0


@pytest.mark.parametrize(
    ("system", "start"),
    [(neurons(), IN_STEP), (repelling(), {"x": 2.0, "u": 0.0, "y": 2.0, "w": 0.0})],
    ids=["neurons", "oscillators"],
)
def test_no_regime_is_that_of_machines_in_step(system, start):
    """Both pairs come to a cycle out of step, as from any start that is not the same for both."""
    apart = dict(start) | {system.states[0]: start[system.states[0]] + 1e-3}
    for begin in (start, apart):
        found = ns.regime(system, begin, period=1.0)
        assert found["regime"].item() == "limit-cycle"
        assert found["exponent"].item() < 0.0


def test_exponents_in_step_are_those_of_a_motion_that_is_left():
    """The largest one is that of the multiplier; the other one is along the motion."""
    with pytest.warns(ns.ResultWarning, match="returns later"):
        found = ns.lyapunov_spectrum(neurons(), IN_STEP)
    np.testing.assert_allclose(
        found["lyapunov_exponent"].values, [np.log(GROWS) / T, 0.0], atol=1e-3
    )
    assert found.attrs["settled"] == 0
    assert found.attrs["chaotic_for"] == 0.0
    assert "its neighbours leave for ever" in found.attrs["message"]


def test_a_smaller_exponent_tells_that_chaos_in_step_is_left():
    """Two equal wells: in step they are as chaotic as apart, and each exponent comes twice.

    Apart the second one is below zero: -0.022 by Runge and Kutta's method from 1e-6 apart, as here
    from 1e-9.
    """
    well = "{x} - {x}**3 - 0.3*{v} + 0.5*cos(1.2*t) + e*({y} - {x})"
    system = ns.System(
        states=["x", "v", "y", "w"],
        parameters={"e": 0.05},
        period="2*pi/1.2",
        equations={
            "x": "v", "v": well.format(x="x", v="v", y="y"),
            "y": "w", "w": well.format(x="y", v="w", y="x"),
        },
    )  # fmt: skip
    with pytest.warns(ns.ResultWarning, match="strobes later exponent 2 is -0"):
        found = ns.lyapunov_spectrum(system, {"x": 0.1, "y": 0.1})
    first, second, *_ = found["lyapunov_exponent"].values
    assert first == pytest.approx(second, abs=0.02) and second > 0.05
    assert found.attrs["settled"] == 0


@pytest.mark.parametrize(
    ("system", "start"),
    [
        (ns.System(states=["x", "v"], equations={"x": "v", "v": "-sin(x)"}), {"x": 1.0}),
        (
            ns.System(
                states=["x", "u", "y", "w"],
                equations={
                    "x": "u", "u": "(1 - x**2)*u - x",
                    "y": "w", "w": "(1 - y**2)*w - y",
                },
            ),
            {"x": 1.0, "u": -0.5, "w": 0.3},
        ),
    ],
    ids=["pendulum", "uncoupled oscillators"],
)  # fmt: skip
def test_a_closed_orbit_that_attracts_nothing_is_no_torus(system, start):
    """A pendulum without damping, and two oscillators whose phases nothing ties."""
    found = ns.regime(system, start, period=1.0)
    assert found["regime"].item() == "unsettled"
    assert "one closed curve" in found.attrs["message"]


def test_exponents_of_a_run_that_ended_early_have_not_settled():
    for rate, options in (("x**2", {"transient": 0, "record": 10}), ("x", {})):
        system = ns.System(states=["x"], equations={"x": rate})
        with pytest.warns(ns.RunWarning):
            found = ns.lyapunov_spectrum(system, {"x": 1.0}, **options)
        assert found.attrs["status"] != "completed" and found.attrs["settled"] == 0


def test_events_of_one_instant_are_told_as_such():
    mass = "cos(omega*t) - 0.04*{v} - {x}"
    system = ns.System(
        states=["x", "v", "y", "w"],
        parameters={"omega": 2.8},
        period="2*pi/omega",
        modes={
            "free": ns.Mode(
                {
                    "x": "v", "v": mass.format(x="x", v="v"),
                    "y": "w", "w": mass.format(x="y", v="w"),
                },
                exits=[
                    ns.Exit("0.1 - x", reset={"v": "-0.8*v"}, name="first"),
                    ns.Exit("0.1 - y", reset={"w": "-0.8*w"}, name="second"),
                ],
            )
        },
    )  # fmt: skip
    run = ns.simulate(system, {"x": -0.2}, periods=1200)
    assert run.attrs["n_uncertain"] > 0
    assert (
        "on rounding: tangencies, or guards that are zero at the same instant"
        in (run.attrs["message"])
    )


def test_chaos_that_lasts_stays_what_it_is():
    """Beside a chaotic motion lies the same chaos: Lorenz's system at r = 28 and below 24.06."""
    equations = {"x": "10*(y - x)", "y": "x*(r - z) - y", "z": "x*y - 8/3*z"}
    start = {"x": 30.0, "y": -5.0, "z": 15.0}
    options = {"transient": 10.0, "exponents": 1}
    lasting, passing = (
        ns.System(states=["x", "y", "z"], parameters={"r": r}, equations=equations)
        for r in (28.0, 23.5)
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = ns.lyapunov_spectrum(lasting, start, record=200.0, **options)
    assert found.attrs["settled"] == 1
    assert found.attrs["chaotic_for"] > 1000.0
    # chaos is a transient below 24.06 (Kaplan and Yorke 1979): all comes to one of two equilibria
    with pytest.warns(ns.ResultWarning, match="10000 returns later the motion repeats"):
        found = ns.lyapunov_spectrum(passing, start, record=60.0, **options)
    assert found["lyapunov_exponent"].item() > 0.5
