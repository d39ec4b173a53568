"""Crossings and tangencies of manifolds: broken lines in closed form, and an escape by scipy."""

from itertools import pairwise, product

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from analysis.broken_lines import lozi, manifold_line

A, B = 1.7, 0.5


def kicked(a=A, b=B):
    """Lozi's map as kicks in time: the states are those of the plane, and hold still between."""
    kick = ns.Exit("cos(2*pi*t)", to="after", reset={"x": "1 - a*abs(x) + y", "y": "b*x"})
    return ns.System(
        name="kicked",
        states=["x", "y"],
        parameters={"a": a, "b": b},
        period=1.0,
        modes={
            "before": ns.Mode({"x": "0", "y": "0"}, exits=[kick]),
            "after": ns.Mode({"x": "0", "y": "0"}, exits=[ns.Exit("-cos(2*pi*t)", to="before")]),
        },
    )


def line_of(which, way, a=A, b=B, right=True, images=7):
    """Vertices of one side of a manifold of a fixed point, by mpmath."""
    forward, backward = lozi(a, b)
    a, b = mp.mpf(a), mp.mpf(b)
    slope = -a if right else a
    x = 1 / (1 + a - b) if right else 1 / (1 - a - b)
    root = mp.sqrt(slope**2 + 4 * b)
    values = [(slope + root) / 2, (slope - root) / 2]
    value = max(values, key=abs) if which == "unstable" else min(values, key=abs)
    along = (value, b)
    scale = way * mp.mpf("1e-3") / mp.hypot(*along)
    one, border = (forward, 0) if which == "unstable" else (backward, 1)
    line = manifold_line((x, b * x), tuple(scale * v for v in along), one, border, 2, images)
    return np.array(line, float)


def crossings_of(one, other):
    """Points in which two broken lines cross."""
    found = []
    for p, q in pairwise(one):
        begin, step = other[:-1], np.diff(other, axis=0)
        arc = q - p
        with np.errstate(divide="ignore", invalid="ignore"):
            area = arc[0] * step[:, 1] - arc[1] * step[:, 0]
            gap = begin - p
            u = (gap[:, 0] * step[:, 1] - gap[:, 1] * step[:, 0]) / area
            v = (gap[:, 0] * arc[1] - gap[:, 1] * arc[0]) / area
        inside = (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
        found += [p + w * arc for w in u[inside]]
    return np.array(found).reshape(-1, 2)


@pytest.fixture(scope="module")
def saddle():
    return ns.find_orbit(kicked(), {"x": 0.45, "y": 0.22})


@pytest.mark.slow
def test_points_of_broken_lines(saddle):
    """Every crossing of the exact broken lines is found, to a few roundings, and no other one."""
    length = 7.0
    found = ns.homoclinic_points(kicked(), saddle, length=length, largest_step=0.05)
    assert found.attrs["unrefined"] == 0 and found.attrs["message"] == "completed"
    points = np.column_stack([found["x"], found["y"]])
    with mp.workdps(40):
        lines = {
            (which, way): line_of(which, way)
            for which, way in product(("unstable", "stable"), (1, -1))
        }
    x = float(1 / (1 + mp.mpf(A) - mp.mpf(B)))

    def cut(line, much):
        lengths = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
        return line[: np.searchsorted(lengths, much) + 1]

    # the exact lines are a piece longer and a piece shorter than the curves that were followed
    longer, shorter = (
        np.concatenate([
            crossings_of(cut(lines["unstable", i], much), cut(lines["stable", j], much))
            for i, j in product((1, -1), (1, -1))
        ])
        for much in (length + 2.0, length - 2.0)
    )  # fmt: skip
    away = np.linalg.norm(longer - [x, B * x], axis=1) > 1e-2
    longer = longer[away]
    off = np.linalg.norm(points[:, None] - longer, axis=2).min(axis=1)
    assert len(points) >= 10 and off.max() < 1e-12
    shorter = shorter[np.linalg.norm(shorter - [x, B * x], axis=1) > 1e-2]
    missed = np.linalg.norm(shorter[:, None] - points, axis=2).min(axis=1)
    assert len(shorter) >= 4 and missed.max() < 1e-12
    assert np.all(found["position_error"] < 1e-12)


@pytest.mark.slow
def test_points_of_one_orbit_are_images_of_each_other(saddle):
    """The map of two kicks, which leaves the sides as they are, leads from one to the next."""
    found = ns.homoclinic_points(kicked(), saddle, length=7.0, largest_step=0.05)
    forward, _ = lozi(A, B)
    checked = 0
    for number in np.unique(found["orbit_number"].values):
        rows = np.flatnonzero(found["orbit_number"].values == number)
        for one, other in pairwise(rows):
            step = int(found["images"][other] - found["images"][one])
            point = (float(found["x"][one]), float(found["y"][one]))
            for _ in range(2 * step):
                point = forward(point)
            assert float(point[0]) == pytest.approx(float(found["x"][other]), abs=1e-11)
            # angles differ, but a crossing stays a crossing
            assert min(found["crossing_angle"].values[[one, other]]) > 1e-3
            checked += 1
    assert checked >= 5


@pytest.mark.slow
def test_angles_are_those_of_lines():
    """Beside the saddle both manifolds are lines, whose slopes are known."""
    a, b = 1.7, 0.5
    saddle = ns.find_orbit(kicked(a, b), {"x": 0.45, "y": 0.22})
    found = ns.homoclinic_points(kicked(a, b), saddle, length=7.0, largest_step=0.05)
    with mp.workdps(30):
        unstable = [line_of("unstable", way) for way in (1, -1)]
        stable = [line_of("stable", way) for way in (1, -1)]
    for k in range(found.sizes["crossing"]):
        point = np.array([float(found["x"][k]), float(found["y"][k])])
        ways = []
        for lines in (unstable, stable):
            best = None
            for line in lines:
                step = np.diff(line, axis=0)
                part = np.clip(
                    ((point - line[:-1]) * step).sum(axis=1) / (step**2).sum(axis=1), 0, 1
                )
                gap = np.linalg.norm(line[:-1] + part[:, None] * step - point, axis=1)
                i = int(np.argmin(gap))
                if best is None or gap[i] < best[0]:
                    best = gap[i], step[i] / np.linalg.norm(step[i])
            ways.append(best[1])
        cross = abs(ways[0][0] * ways[1][1] - ways[0][1] * ways[1][0])
        assert float(found["crossing_angle"][k]) == pytest.approx(np.arcsin(cross), abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    "b", [0.3, pytest.param(0.1, marks=pytest.mark.slow), pytest.param(0.5, marks=pytest.mark.slow)]
)
def test_the_boundary_crisis_of_lozis_map(b):
    """2 a + b = 4 (Misiurewicz): the attractor's tip is on the stable manifold of the other saddle.

    The value is a zero of a function that rounding changes by some 1e-15.
    """
    exact = 2.0 - b / 2.0
    system = kicked(exact - 0.05, b)
    inside, border = ns.find_orbit(system, {"x": 0.4}), ns.find_orbit(system, {"x": -0.9})
    found = ns.homoclinic_tangency(
        system, "a", (exact - 0.03, exact + 0.04), inside, border, side="-", to_side="+",
        length=3.0, largest_step=0.1, bumps=2,
    )  # fmt: skip
    assert found.attrs["crossings"].split()[0] == "0"
    assert float(found["a"][0]) == pytest.approx(exact, abs=1e-12)
    assert found["tangency_kind"][0].item() == "corner"


@pytest.mark.slow
def test_a_homoclinic_tangency_of_broken_lines():
    """The first bump of the unstable manifold comes off the stable one: mpmath finds where.

    The tip is the image of the place where the line of the unstable direction meets x = 0; it lies
    on the broken line of the stable manifold, pulled back from the saddle.
    """
    b = 0.5
    system = kicked(1.7, b)
    saddle = ns.find_orbit(system, {"x": 0.45, "y": 0.22})
    found = ns.homoclinic_tangency(
        system, "a", (1.2, 1.7), saddle, to_side="-", length=5.0, largest_step=0.05, bumps=2
    )
    value = float(found["a"][0])
    counts = [
        ns.homoclinic_points(
            system.with_parameters(a=each), ns.find_orbit(system, saddle, parameters={"a": each}),
            length=5.0, largest_step=0.02, to_side="-",
        ).sizes["crossing"]
        for each in (value - 2e-3, value + 2e-3)
    ]  # fmt: skip
    assert counts[0] == 0 < counts[1]
    point = np.array([float(found["x"][0]), float(found["y"][0])])

    def gap(a):
        """Signed distance, along y, of the corner from a piece of the stable manifold nearby."""
        forward, _ = lozi(a, b)
        fixed = 1 / (1 + mp.mpf(a) - mp.mpf(b))
        root = mp.sqrt(mp.mpf(a) ** 2 + 4 * mp.mpf(b))
        leave, come = (-mp.mpf(a) - root) / 2, (-mp.mpf(a) + root) / 2
        # on the line through the fixed point along (leave, b), at x = 0
        corner = (mp.mpf(0), b * fixed - fixed * b / leave)
        tips = [forward(corner)]
        for _ in range(6):
            tips.append(forward(tips[-1]))
        tip = min(tips, key=lambda p: mp.hypot(p[0] - point[0], p[1] - point[1]))
        # how far across the stable direction the tip is after it has come to the saddle's side
        best = None
        for _ in range(6):
            away = (tip[0] - fixed, tip[1] - b * fixed)
            across = away[0] * b - away[1] * come  # zero on the stable line
            if tip[0] > 0 and (best is None or mp.hypot(*away) < best[0]):
                best = mp.hypot(*away), across
            tip = forward(tip)
        return best[1]

    with mp.workdps(40):
        exact = mp.findroot(gap, (value - 1e-6, value + 1e-6), solver="secant")
        assert abs(float(exact) - value) < 1e-12


ESCAPE = {"omega": 0.85, "zeta": 0.05}


def escape(force=0.12):
    """A mass in a well that may leave it over a hill at x = 2."""
    return ns.System(
        name="escape",
        states=["x", "v"],
        parameters={"F": force, **ESCAPE},
        period="2*pi/omega",
        equations={"x": "v", "v": "where(x < 1, -x, x - 2) - 2*zeta*v + F*cos(omega*t)"},
    )


def hilltop(force):
    """The orbit on the hill, with the rates of its directions, in closed form."""
    omega, zeta = ESCAPE["omega"], ESCAPE["zeta"]
    gain = force / (-1.0 - omega**2 + 2j * zeta * omega)
    state = np.array([2.0 + gain.real, (1j * omega * gain).real])
    rates = -zeta + np.sqrt(zeta**2 + 1.0) * np.array([1.0, -1.0])
    return state, rates


def across_by_scipy(force, places, periods):
    """How far across the stable direction motions are that begin on the unstable one."""
    state, (out, into) = hilltop(force)
    omega, zeta = ESCAPE["omega"], ESCAPE["zeta"]
    along = np.array([1.0, out]) / np.hypot(1.0, out)
    starts = state - places[:, None] * along

    def rates(t, z):
        x, v = z.reshape(2, -1)
        pull = np.where(x < 1.0, -x, x - 2.0)
        return np.concatenate([v, pull - 2.0 * zeta * v + force * np.cos(omega * t)])

    end = periods * 2.0 * np.pi / omega
    run = solve_ivp(
        rates, (0.0, end), starts.T.ravel(), "DOP853", rtol=1e-11, atol=1e-12, max_step=0.1
    )
    away = run.y[:, -1].reshape(2, -1).T - state
    return away[:, 1] - into * away[:, 0]


@pytest.mark.slow
def test_a_tangency_of_a_driven_mass_by_scipy():
    """Below the force that is found, motions from the hill stay on one side of it; above, not.

    scipy runs some hundreds of starts around the top at forces 1e-6 to both sides.
    """
    system = escape()
    saddle = ns.find_orbit(system, {"x": 2.0})
    state, _ = hilltop(0.12)
    np.testing.assert_allclose([float(saddle["x"]), float(saddle["v"])], state, atol=1e-12)
    found = ns.homoclinic_tangency(
        system, "F", (0.1, 0.2), saddle, side="-", to_side="both", length=8.0, bumps=2
    )
    assert found.attrs["status"] == "completed", found.attrs
    value = float(found["F"][0])
    periods = int(found["images"][0] + found["ahead"][0])
    place = float(found["place"][0])
    near = place * (1.0 + np.linspace(-0.02, 0.02, 401))
    below, above = (across_by_scipy(value + step, near, periods) for step in (-1e-6, 1e-6))
    signs = [np.unique(np.sign(each)).size for each in (below, above)]
    assert signs == [1, 2]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"parameter": "k"}, "unknown parameter 'k'"),
        ({"between": 1.0}, "between"),
        ({"between": (1.0, 1.0)}, "two different values"),
        ({"orbit": 1.0}, "orbit"),
        ({"side": "left"}, "side"),
        ({"parameters": {"a": 1.0}}, "counts for nothing"),
    ],
)
def test_wrong_use(saddle, change, message):
    given = {"parameter": "a", "between": (1.6, 1.7), "orbit": saddle} | change
    with pytest.raises(ns.OptionError, match=message):
        ns.homoclinic_tangency(kicked(), **given)
