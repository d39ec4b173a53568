"""`manifold` of a nonlinear oscillator with a wall, beside an integrator of scipy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import nonsmooth as ns

# the wall stands where the push is always away from it, so that no impacts accumulate
DAMPING, FORCE, OMEGA, WALL, R = 0.3, 0.15, 1.2, 1.1, 0.7
PERIOD = 2.0 * np.pi / OMEGA

wells = ns.System(
    states=["x", "v"],
    definitions={"push": f"x - x**3 - {DAMPING}*v + {FORCE}*cos({OMEGA}*t)"},
    period=f"2*pi/{OMEGA}",
    modes={
        "free": ns.Mode(
            {"x": "v", "v": "push"},
            exits=[ns.Exit(f"{WALL} - x", reset={"v": f"-{R}*v"}, name="impact")],
        )
    },
    name="wells",
)


def rates(t, state):
    x, v = state
    return v, x - x**3 - DAMPING * v + FORCE * np.cos(OMEGA * t)


def wall(t, state):
    return WALL - state[0]


wall.terminal, wall.direction = True, -1.0


def once(state):
    """The stroboscopic map, by DOP853 with a stop at each impact."""
    t, state = 0.0, np.array(state, float)
    while True:
        run = solve_ivp(rates, (t, PERIOD), state, "DOP853", events=wall, rtol=3e-14, atol=1e-15)
        state = run.y[:, -1]
        if not run.t_events[0].size:
            return state
        t, state = run.t[-1], np.array([WALL, -R * state[1]])


def after(state, count):
    for _ in range(count):
        state = once(state)
    return state


@pytest.fixture(scope="module")
def saddle():
    """The orbit near the top of the hill: found by the library, and by scipy alone."""
    linear = -FORCE / (1.0 + OMEGA**2 - 1j * DAMPING * OMEGA)
    point = np.array([linear.real, -OMEGA * linear.imag])
    orbit = ns.find_orbit(wells, {"x": point[0], "v": point[1]})
    h = 1e-6
    for _ in range(8):  # Newton's method, with differences for derivatives
        jacobian = np.column_stack(
            [(once(point + h * e) - once(point - h * e)) / (2.0 * h) for e in np.eye(2)]
        )
        point = point - np.linalg.solve(jacobian - np.eye(2), once(point) - point)
    values, vectors = np.linalg.eig(jacobian)
    order = np.argsort(-abs(values))
    return orbit, point, values[order], vectors[:, order]


def test_the_saddle(saddle):
    orbit, point, values, _ = saddle
    assert [float(orbit["x"]), float(orbit["v"])] == pytest.approx(point, abs=1e-11)
    assert orbit["multipliers"].values.real == pytest.approx(values, abs=1e-7)  # by differences


@pytest.mark.slow  # thousands of periods of scipy
def test_unstable_points_are_images_of_the_first_piece(saddle):
    """Through each point goes the image of the eigenvector's line, by scipy.

    Places on the line are found by the projection on the tangent, and the distance across is what
    the curve is off: rounding of scipy's steps, and 1e-11 of the first piece.
    """
    orbit, point, values, vectors = saddle
    curves = ns.manifold(wells, orbit, length=4.0, accuracy=1e-11)
    assert "corner" in curves["border_kind"].values
    checked = 0
    for number in (0, 1):
        here = curves.isel(point=np.flatnonzero(curves["curve_of_point"].values == number))
        first = float(curves["first_length"][number])
        along = vectors[:, 0] * np.sign(vectors[:, 0] @ curves["saddle_direction"].values[number])
        points, images = np.column_stack([here["x"], here["v"]]), here["image"].values
        count = images.max()
        places = np.geomspace(first / values[0], first, 60)
        coarse = np.array([after(point + s * along, count) for s in places])
        at = np.flatnonzero((images == count) & (here["border"].values == ""))
        for k in at[2 : -2 : max(1, at.size // 4)]:
            tangent = points[k + 1] - points[k - 1]
            tangent /= np.linalg.norm(tangent)

            def ahead(s, k=k, tangent=tangent, along=along, count=count, points=points):
                return (after(point + s * along, count) - points[k]) @ tangent

            near = np.linalg.norm(coarse - points[k], axis=1).argmin()
            low, high = places[max(near - 1, 0)], places[min(near + 1, places.size - 1)]
            if ahead(low) * ahead(high) > 0.0:
                continue
            s = brentq(ahead, low, high, xtol=1e-22, rtol=1e-14)
            assert np.linalg.norm(after(point + s * along, count) - points[k]) < 1e-9
            checked += 1
    assert checked >= 5


@pytest.mark.slow
def test_stable_points_come_to_the_saddle(saddle):
    """After their ``image`` periods, by scipy, they lie on the eigenvector's line at the saddle.

    What they miss it by, divided by the growth on the way, is what they are off the manifold.
    """
    orbit, point, values, vectors = saddle
    curves = ns.manifold(wells, orbit, which="stable", length=6.0)
    dual = np.linalg.inv(vectors)[0]  # measures the unstable direction
    points, images = np.column_stack([curves["x"], curves["v"]]), curves["image"].values
    at = np.flatnonzero((images > 0) & (curves["border"].values == ""))
    longest = curves["first_length"].values.max()
    for k in at[:: at.size // 20]:
        end = after(points[k], int(images[k])) - point
        assert np.linalg.norm(end) < 1.1 * longest + 1e-9 * values[0] ** images[k]
        assert abs(dual @ end) / values[0] ** images[k] < 1e-10
