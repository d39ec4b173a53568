"""Guards that are quadratic, on flows in closed form: distances, products, stiff motions."""

import math

import mpmath
import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System


def circle(**changes):
    """A point on a spring that bounces off the inside of a circle."""
    words = {"guard": "1 - x**2 - y**2", "rate": "-x"} | changes
    return System(
        states=["x", "u", "y", "v"],
        parameters={"w": 0.6},
        modes={
            "inside": Mode(
                {"x": "u", "u": words["rate"], "y": "v", "v": "-w**2*y"},
                exits=[Exit(words["guard"], to="stop", name="out")],
            )
        },
    )


def first_root(x0, u0, y0, v0, w, end):
    """Time at which the point is on the circle first: 40 digits on a fine grid, then bisection."""

    def gap(t):
        x = x0 * mpmath.cos(t) + u0 * mpmath.sin(t)
        y = y0 * mpmath.cos(w * t) + v0 / w * mpmath.sin(w * t)
        return 1 - x * x - y * y

    with mpmath.workdps(40):
        times = [mpmath.mpf(k) * end / 4000 for k in range(1, 4001)]
        late = next((t for t in times if gap(t) < 0), None)
        return (
            None
            if late is None
            else mpmath.findroot(
                gap, (late - mpmath.mpf(end) / 4000, late), solver="anderson", tol=1e-50
            )
        )


@pytest.mark.slow
def test_first_crossings_of_a_circle():
    rng = np.random.default_rng(7)
    for _ in range(25):
        x0, y0 = rng.uniform(-0.6, 0.6, 2)
        u0, v0 = rng.uniform(-0.9, 0.9, 2)
        run = ns.simulate(circle(), {"x": x0, "u": u0, "y": y0, "v": v0}, times=[20.0])
        truth = first_root(x0, u0, y0, v0, 0.6, 20.0)
        if truth is None:
            assert run.attrs["status"] == "completed" and run.sizes["event"] == 1
        else:
            assert run.attrs["status"] == "stopped"
            slope = 0.02  # crossings are no flatter than that here
            assert abs(float(run["event_time"][-1]) - truth) < 1e-14 / slope


def test_a_graze_is_no_crossing_and_a_hair_more_is_one():
    # along x = A cos(t), y = 0 the circle is touched for A = 1
    for change, status in ((-1e-9, "completed"), (1e-9, "stopped")):
        run = ns.simulate(circle(), {"u": 1.0 + change}, times=[6.0])
        assert run.attrs["status"] == status
    run = ns.simulate(circle(), {"u": 1.0}, times=[6.0])
    assert run.attrs["n_uncertain"] > 0  # certified or flagged


def test_products_of_different_states():
    system = System(
        states=["x", "y"],
        modes={"m": Mode({"x": "1", "y": "-y"}, exits=[Exit("0.2 - x*y", to="stop")])},
    )
    run = ns.simulate(system, {"y": 1.0}, times=[5.0])
    truth = mpmath.findroot(lambda t: t * mpmath.exp(-t) - 0.2, 0.25)
    assert float(run["event_time"][-1]) == pytest.approx(float(truth), rel=1e-15)
    # the same by series
    series = System(
        states=["x", "y"],
        modes={"m": Mode({"x": "1", "y": "-y"}, exits=[Exit("0.2 - x*sin(asin(y))", to="stop")])},
    )
    other = ns.simulate(series, {"y": 0.999}, times=[5.0])
    assert other.attrs["status"] == "stopped"


@pytest.mark.parametrize("rate", [3.0, 300.0, 3e5])
def test_a_distance_to_what_relaxes_fast(rate):
    """x = t/2 follows a stop s = exp(-rate t): when (x - s)^2 = 1/16, first from within."""
    system = System(
        states=["x", "s"],
        parameters={"k": rate},
        modes={"m": Mode({"x": "0.5", "s": "-k*s"}, exits=[Exit("1/16 - (x - s)**2", to="stop")])},
    )
    start = 0.2
    run = ns.simulate(system, {"s": start}, times=[3.0])
    truth = mpmath.findroot(lambda t: t / 2 - start * mpmath.exp(-rate * t) - 0.25, 0.5)
    assert run.attrs["status"] == "stopped" and run.attrs["n_uncertain"] == 0
    assert float(run["event_time"][-1]) == pytest.approx(float(truth), rel=1e-14)


def test_what_only_fades_never_reaches_zero():
    """A guard that is one fading motion is positive for ever, also when nothing is left of it."""
    system = System(
        states=["s", "x", "v"],
        modes={"m": Mode({"s": "-5000*s", "x": "v", "v": "-x"}, exits=[Exit("s", to="stop")])},
    )
    for start in (1.0, 1e-280, 5e-324, 0.0):
        run = ns.simulate(system, {"s": start, "x": 1.0}, times=np.linspace(0.0, 20.0, 5))
        assert run.attrs["status"] == "completed" and run.attrs["n_uncertain"] == 0
        np.testing.assert_allclose(run["x"], np.cos(run["time"]), atol=1e-14)


def test_derivatives_across_a_curved_exit():
    """Reflection at the circle: columns against differences of the closed-form map."""
    normal = {"u": "u - 2*x*(x*u + y*v)", "v": "v - 2*y*(x*u + y*v)"}
    system = System(
        states=["x", "u", "y", "v"],
        modes={
            "inside": Mode(
                {"x": "u", "u": "0", "y": "v", "v": "0"},
                exits=[Exit("1 - x**2 - y**2", reset=normal, name="wall")],
            )
        },
    )
    start = {"x": 0.1, "u": 0.7, "y": -0.2, "v": 0.45}
    run = ns.simulate(system, start, times=[6.0], tangent=True)
    assert run.sizes["event"] >= 4
    step = 1e-6
    for j, name in enumerate(start):
        ends = [
            ns.simulate(system, start | {name: start[name] + d}, times=[6.0]) for d in (step, -step)
        ]
        for i, other in enumerate(start):
            slope = float(ends[0][other][-1] - ends[1][other][-1]) / (2 * step)
            column = float(run["tangent"].isel(time=-1)[i, j])
            assert column == pytest.approx(slope, abs=2e-7 * math.exp(3.0))
