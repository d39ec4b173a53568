"""The stable manifold of an oscillator between two stops goes on behind grazes and resets."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import nonsmooth as ns

FORCE, OMEGA, DAMPING, CUBIC, RIGHT, LEFT, R = 0.9, 2.0, 0.06, 0.3, 0.9, 1.4, 0.7
PERIOD = 2.0 * np.pi / OMEGA

stops = ns.System(
    name="two stops",
    states=["x", "v"],
    period=f"2*pi/{OMEGA}",
    modes={
        "free": ns.Mode(
            {"x": "v", "v": f"{FORCE}*cos({OMEGA}*t) - 2*{DAMPING}*v - x - {CUBIC}*x**3"},
            exits=[
                ns.Exit(f"{RIGHT} - x", reset={"v": f"-{R}*v"}, name="right"),
                ns.Exit(f"x + {LEFT}", reset={"v": f"-{R}*v"}, name="left"),
            ],
        )
    },
)


def rates(t, state):
    x, v = state
    return v, FORCE * np.cos(OMEGA * t) - 2.0 * DAMPING * v - x - CUBIC * x**3


def turn(t, state):
    return state[1]


turn.terminal = True


def once(state):
    """The stroboscopic map, by DOP853 from turn to turn, so that it cannot miss a low impact."""
    t, state = 0.0, np.array(state, float)
    while t < PERIOD:
        run = solve_ivp(
            rates, (t, PERIOD), state, "DOP853", events=turn, rtol=3e-14, atol=1e-15,
            dense_output=True,
        )  # fmt: skip
        begin, t, state = t, run.t[-1], run.y[:, -1]
        if t - begin < 1e-9:  # the turn with which it began
            t, state = t + 1e-9, state + 1e-9 * np.array(rates(t, state))
        for wall in (RIGHT, -LEFT):
            if state[0] * wall > wall**2:  # beyond it
                t = brentq(lambda s, wall=wall, run=run: run.sol(s)[0] - wall, begin, t, xtol=1e-15)
                state = np.array([wall, -R * run.sol(t)[1]])
    return state


def after(state, count):
    for _ in range(count):
        state = once(state)
    return state


@pytest.fixture(scope="module")
def saddle():
    """The saddle: a guess of the library, and Newton's method on scipy's map from there."""
    orbit = ns.find_orbit(stops, {"x": -1.229, "v": 1.022})
    point, h = np.array([orbit["x"].item(), orbit["v"].item()]), 1e-6
    for _ in range(4):
        jacobian = np.column_stack(
            [(once(point + h * e) - once(point - h * e)) / (2.0 * h) for e in np.eye(2)]
        )
        point = point - np.linalg.solve(jacobian - np.eye(2), once(point) - point)
    values, vectors = np.linalg.eig(jacobian)
    order = np.argsort(-abs(values))
    return orbit, point, values[order], vectors[:, order]


@pytest.mark.slow  # hundreds of periods of scipy, and twice a curve with grazes
@pytest.mark.parametrize("largest", [None, 0.1])
def test_it_goes_on_behind_grazes_and_resets(saddle, largest):
    """Points come to the eigenvector's line at the saddle, also behind the ends of before.

    One side turns at grazes of the stops, where the map grows as a root, at the lengths 1.89 and
    4.47. What a point misses the line by, divided by the growth on the way, is what it is off the
    manifold: 1e-10, as rounding of scipy's steps, 1e-13, grows at low impacts.
    """
    orbit, point, values, vectors = saddle
    curves = ns.manifold(stops, orbit, which="stable", length=5.0, largest_step=largest)
    assert curves["curve_end"].values.tolist() == ["length", "length"]
    dual = np.linalg.inv(vectors)[0]  # measures the unstable direction
    points, images = np.column_stack([curves["x"], curves["v"]]), curves["image"].values
    usual = (images > 0) & (curves["border"].values == "")
    for number, least in ((0, 1.9), (0, 4.5), (1, 0.2)):
        at = np.flatnonzero(
            usual & (curves["curve_of_point"] == number) & (curves["arclength"] > least)
        )
        assert at.size
        for k in at[:: max(1, at.size // 8)]:
            end = after(points[k], int(images[k])) - point
            assert abs(dual @ end) / values[0] ** images[k] < 1e-10


@pytest.mark.slow
def test_it_goes_on_where_a_reset_comes_from(saddle):
    """A start at the left stop with -v/r is reset to the end of the curve there, with v."""
    orbit, *_ = saddle
    curves = ns.manifold(stops, orbit, which="stable", length=1.0, side="-")
    kinds = curves["border_kind"].values.tolist()
    assert kinds == ["jump"]
    at = int(curves["border_point"][0])
    ends = curves.isel(point=[at, at + 1])
    assert ends["x"].values == pytest.approx([-LEFT, -LEFT], abs=1e-10)
    v, before = ends["v"].values
    assert v > 0.0 and before == pytest.approx(-v / R, abs=1e-9)
