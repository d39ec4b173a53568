"""A continuous right-hand side never slides, however its cells lie beside each other."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth import System

LAWS = {
    "min(abs(v), c)": lambda x, v, c, d: min(abs(v), c),
    "clip(sin(v), -c, d)": lambda x, v, c, d: min(max(np.sin(v), -c), d),
    "min(x + c, v, d)": lambda x, v, c, d: min(x + c, v, d),
    "clip(v, -c, d)": lambda x, v, c, d: min(max(v, -c), d),
    "min(max(v, -c), d)": lambda x, v, c, d: min(max(v, -c), d),
    "max(min(v, d), -c)": lambda x, v, c, d: min(max(v, -c), d),
    "max(abs(x) - c, abs(v) - d)": lambda x, v, c, d: max(abs(x) - c, abs(v) - d),
    "min(-1, abs(sin(t)))": lambda x, v, c, d: -1.0,
}


@pytest.mark.few(1)
@pytest.mark.parametrize("law", LAWS)
def test_runs_through(law):
    """Against scipy in small steps, whose error where it misses a kink is about 1e-9."""
    rng = np.random.default_rng(7)
    for _ in range(8):
        c, d = rng.uniform(0.1, 1.0, 2)
        start = rng.normal(size=2)
        system = System(
            states=["x", "v"],
            parameters={"c": c, "d": d},
            equations={"x": "v", "v": f"-x + cos(1.3*t) - {law}"},
        )
        run = ns.simulate(system, dict(zip("xv", start, strict=True)), t_end=15)
        assert run.attrs["status"] == "completed", run.attrs["message"]
        force = LAWS[law]

        def rates(t, y, force=force, c=c, d=d):
            return [y[1], -y[0] + np.cos(1.3 * t) - force(*y, c, d)]

        end = solve_ivp(
            rates, (0, 15), start, method="DOP853", rtol=1e-9, atol=1e-9, max_step=0.05
        ).y[:, -1]
        assert run["end_state"].values == pytest.approx(end, abs=1e-5)


def test_smoothed_belt_friction():
    """Friction -mu clip((v - vb)/eps, -1, 1), the usual cure for a sign, runs."""
    text = "-x - 2*clip((v - 0.2)/0.05, -1, 1)"
    block = System(states=["x", "v"], equations={"x": "v", "v": text})
    run = ns.simulate(block, {"x": 1.0}, t_end=3)
    assert run.attrs["status"] == "completed"
    # sticks to the belt within the smoothing: x grows as vb t, v = vb - eps x/2
    assert float(run["v"][-1]) == pytest.approx(0.2 - 0.05 * float(run["x"][-1]) / 2, abs=2e-3)


def test_the_angle_of_a_turning_point():
    """atan2 is the principal value, wherever a run was started or cut."""
    turn = System(states=["x", "y", "q"], equations={"x": "-y", "y": "x", "q": "atan2(y, x)"})
    run = ns.simulate(turn, {"x": 1.0}, times=[3.0, 3.5, 7.0])
    # the integral of the angle t up to pi, then of t - 2 pi, and so on
    low = np.pi**2 / 2
    expected = [
        4.5,
        low + (3.5 - np.pi) * (0.5 * (3.5 + np.pi) - 2 * np.pi),
        0.5 * (7 - 2 * np.pi) ** 2,
    ]
    assert run["q"].values == pytest.approx(expected, abs=1e-12)
    again = ns.simulate(turn, run.isel(time=1), t_end=7.0)
    assert float(again["q"][-1]) == pytest.approx(expected[-1], abs=1e-12)
