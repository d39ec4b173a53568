"""`manifold`: lines and broken lines in closed form, scipy, basins, borders, errors."""

import mpmath as mp
import numpy as np
import pytest

import nonsmooth as ns
from analysis.broken_lines import bends, distances, kicked, lozi, manifold_line

A, B = 1.7, 0.5
FIXED = 1.0 / (1.0 + A - B)  # of Lozi's map, on the right


def columns(curves, number):
    """Points of one curve, and its lengths."""
    here = curves["curve_of_point"].values == number
    return np.column_stack([curves["x"], curves["y"]])[here], curves["arclength"].values[here]


def closed_form(number, which, fixed=(FIXED, B * FIXED), slope=-A, **more):
    """The broken line of one side of the fixed point, as `manifold` numbers the sides."""
    root = mp.sqrt(mp.mpf(slope) ** 2 + 4 * mp.mpf(B))
    values = [(slope + root) / 2, (slope - root) / 2]
    value = max(values, key=abs) if which == "unstable" else min(values, key=abs)
    along = [value, mp.mpf(B)]
    largest = max(along, key=abs)
    sign = (1 if largest > 0 else -1) * (1 if number == 0 else -1)
    along = tuple(sign * mp.mpf("1e-3") * each / mp.hypot(*along) for each in along)
    forward, backward = lozi(A, B, **more)
    one, border = (forward, 0) if which == "unstable" else (backward, 1)
    # the fixed point with all its digits: the place where rounding would lead away from
    exact = 1 / (1 + mp.mpf(A) - mp.mpf(B))
    return manifold_line((exact, mp.mpf(B) * exact), along, one, border, 2, 8)


@pytest.fixture(scope="module")
def lozi_orbit():
    system, strobe = kicked(A, B)
    return strobe, ns.find_orbit(system, {"x": FIXED + 1e-3, "y": B * FIXED})


def corners_of(curves, number):
    """Points of one curve that are told as corners."""
    at = curves["border_point"].values[curves["border_kind"].values == "corner"]
    at = at[curves["curve_of_point"].values[at] == number]
    return np.column_stack([curves["x"], curves["y"]])[at]


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("which", "length"),
    [("unstable", 12.0), ("stable", 4.0), pytest.param("stable", 12.0, marks=pytest.mark.slow)],
)
def test_broken_lines(lozi_orbit, which, length):
    """Points lie on the closed form, and its vertices are the corners that are told.

    Both are sums of a few tens of terms of size one, so they agree to some 1e-14; corners lie in
    pairs that rounding separates.
    """
    strobe, orbit = lozi_orbit
    curves = ns.manifold(
        strobe, orbit, which=which, length=length, largest_step=0.1, side="-",
    )  # fmt: skip
    assert curves.attrs["status"] == "completed" and curves.attrs["message"] == "completed"
    assert curves.attrs["sides_alternate"] == 1
    with mp.workdps(40):
        line = closed_form(1, which)
    points, lengths = columns(curves, 0)
    assert distances(points, line).max() < 1e-12
    exact = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    assert exact[-1] > lengths[-1] > length - 0.1
    # an arc is the line, so lengths along both are the same
    near = np.argmin(np.linalg.norm(points[:, None] - line, axis=2), axis=0)
    reached = exact < lengths[-1] - 0.1
    np.testing.assert_allclose(lengths[near[reached]], exact[reached], atol=0.1)
    wanted = [vertex for vertex, there in zip(line, reached, strict=True) if there]
    wanted = [v for v in bends(line) if np.any(np.all(v == np.array(wanted), axis=1))]
    found = corners_of(curves, 0)
    assert len(wanted) >= 2
    np.testing.assert_allclose(found[: len(wanted)], wanted, atol=1e-12)
    # the narrowest corner opens by 0.03 only, and lines along it meet its sides at half of that
    assert np.all(curves["border_gap"].values < 1e-11)


def test_the_other_side_of_the_stable_manifold_is_a_line(lozi_orbit):
    strobe, orbit = lozi_orbit
    curves = ns.manifold(strobe, orbit, which="stable", length=4.0, largest_step=0.2, side="+")
    with mp.workdps(40):
        line = closed_form(0, "stable")
    points, _ = columns(curves, 0)
    assert distances(points, line).max() < 1e-13
    assert len(bends(line)) == curves.sizes["at_border"] == 0


def test_a_map_that_jumps():
    """Images of both sides of the border lie the jump of the map apart."""
    c = 0.25
    system, strobe = kicked(A, B, c)
    x = (1.0 + c) / (1.0 + A - B)
    orbit = ns.find_orbit(system, {"x": x, "y": B * x})
    curves = ns.manifold(strobe, orbit, length=3.0, side="+")
    kinds = curves["border_kind"].values.tolist()
    first = kinds.index("jump")
    assert float(curves["border_gap"][first]) == pytest.approx(c, abs=1e-12)
    at = int(curves["border_point"][first])
    low, high = (curves.isel(point=at + k) for k in (0, 1))
    assert float(low["y"]) == pytest.approx(0.0, abs=1e-13)  # b x, with x = 0
    assert float(low["y"] - high["y"]) == pytest.approx(0.0, abs=1e-13)
    assert abs(float(low["x"] - high["x"])) == pytest.approx(c, abs=1e-12)
    steps = np.diff(curves["arclength"].values)
    assert steps[at] == 0.0 and np.all(steps >= 0.0)


@pytest.mark.slow
def test_each_point_of_an_orbit_of_period_two_has_its_curves():
    """The map takes the curves of one point to those of the next."""
    a, b = 1.2, 0.1
    _, strobe = kicked(a, b)
    matrix = np.array([[a, 1.0 - b], [1.0 - b, -a]])  # of the cycle with x > 0, then x < 0
    right, left = np.linalg.solve(matrix, [1.0, 1.0])
    assert right > 0 > left
    cycle = ns.find_orbit(strobe.system, {"x": right + 1e-3, "y": b * left, "clock": 0.0}, period=2)
    # multipliers: the product of both sides' matrices
    sides = [np.array([[-a * s, 1.0], [b, 0.0]]) for s in (1.0, -1.0)]
    wanted = np.sort(np.linalg.eigvals(sides[1] @ sides[0]))[::-1]
    curves = ns.manifold(strobe, cycle, length=1.0)
    assert curves.attrs["period"] == 2 and curves.sizes["curve"] == 4
    wanted = sorted(wanted, key=abs, reverse=True)
    np.testing.assert_allclose(curves["multipliers"].values[:2].real, wanted, atol=1e-12)
    points = np.column_stack([curves["x"], curves["y"]])
    forward, _ = lozi(a, b)
    number = curves["orbit_point"].values
    for k in (0, 1):
        near = curves["arclength"].values[number == k] < 0.3
        images = np.array([[float(v) for v in forward(p)] for p in points[number == k][near]])
        other = points[number == 1 - k]
        lines = [other[curves["side"].values[number == 1 - k] == way] for way in (1, -1)]
        off = np.minimum(*(distances(images, line) for line in lines))
        assert off.max() < 1e-12


def hill(rate=1.0):
    """An oscillator on a hill, driven: its orbit is x = -cos(t)/2, its manifolds are lines."""
    return ns.System(
        states=["x", "v"],
        parameters={"k": rate},
        equations={"x": "v", "v": "k*x + cos(t)"},
        period="2*pi",
        name="hill",
    )


@pytest.mark.few(1)
@pytest.mark.parametrize(("which", "slope"), [("unstable", 1.0), ("stable", -1.0)])
def test_lines_of_a_linear_saddle(which, slope):
    """The multiplier of the unstable direction is exp(2 pi), about 535."""
    system = hill()
    orbit = ns.find_orbit(system, {"x": -0.4})
    curves = ns.manifold(system, orbit, which=which, length=3.0)
    x, v, length = (curves[name].values for name in ("x", "v", "arclength"))
    np.testing.assert_allclose(v, slope * (x + 0.5), atol=1e-12)
    np.testing.assert_allclose(length, np.hypot(x + 0.5, v), atol=1e-12)
    np.testing.assert_allclose(curves.attrs["multiplier"], np.exp(slope * 2 * np.pi), atol=1e-9)
    for number in (0, 1):
        reached = length[curves["curve_of_point"].values == number]
        assert reached[-1] == pytest.approx(3.0, abs=0.02) and np.diff(reached).max() < 0.0151


def test_scales_stretch_lengths():
    """In a unit of v a hundred times as large, the line is steeper and its length another."""
    system = hill()
    orbit = ns.find_orbit(system, {"x": -0.4})
    curves = ns.manifold(system, orbit, length=2.0, scales={"v": 0.01}, side="+")
    x, v = curves["x"].values, curves["v"].values
    np.testing.assert_allclose(v, x + 0.5, atol=1e-13)
    np.testing.assert_allclose(curves["arclength"], np.hypot(x + 0.5, 100.0 * v), atol=1e-11)


# ------------------------------------------------------------- an oscillator that hits a wall

WALL = {"zeta": 0.05, "omega": 1.7, "sigma": 1.5, "r": 0.9}


@pytest.fixture(scope="module")
def struck():
    system = ns.models.impact_oscillator(**WALL)
    orbit = ns.find_orbit(system, {"x": -3.99, "v": 2.6})
    assert not orbit["stable"]
    return system, orbit


def flight(x, v, times, zeta, omega, F=1.0):
    """Free motion from a state at time zero, in closed form."""
    amplitude = F / (1.0 - omega**2 + 2j * zeta * omega)
    x0, v0 = x - amplitude.real, v - (1j * omega * amplitude).real
    wd = np.sqrt(1.0 - zeta**2)
    free = np.exp(-zeta * times) * (
        x0 * np.cos(wd * times) + (v0 + zeta * x0) / wd * np.sin(wd * times)
    )
    return free + (amplitude * np.exp(1j * omega * times)).real


@pytest.mark.slow
def test_corners_at_a_graze(struck):
    """A corner is the image of the start whose flight touches the wall.

    The point on the side without impact has come by a free flight over the period before; going
    back along it in closed form, its largest displacement is the wall. The other point has hit it
    at a speed that is the root of what rounding leaves.
    """
    system, orbit = struck
    curves = ns.manifold(system, orbit, length=9.0)
    assert curves["border_kind"].values.tolist() == ["corner"]
    assert np.all(curves["border_gap"].values < 1e-5)
    at = int(curves["border_point"][0])
    pair = curves.isel(point=slice(at, at + 2))
    flies = [word == "free" for word in pair["word"].values]
    assert sorted(flies) == [False, True]
    point = pair.isel(point=flies.index(True))
    times = -np.linspace(0.0, 2 * np.pi / WALL["omega"], 200_001)
    back = flight(float(point["x"]), float(point["v"]), times, WALL["zeta"], WALL["omega"])
    assert back.max() == pytest.approx(WALL["sigma"], abs=1e-9)


@pytest.mark.slow
def test_the_stable_manifold_is_the_boundary_of_basins(struck):
    """Starts 1e-10 to both sides of it settle to different motions.

    Unit vectors across the curve are taken from neighbours; what points are off the manifold is
    less than what separates the starts.
    """
    system, orbit = struck
    curves = ns.manifold(system, orbit, which="stable", length=11.0)
    assert curves["border_kind"].values.tolist() == ["jump"]
    points = np.column_stack([curves["x"], curves["v"]])
    chosen = [
        k
        for number in (0, 1)
        for k in np.flatnonzero(curves["curve_of_point"].values == number)[20:-1:12]
        if curves["border"].values[k] == curves["border"].values[k - 1] == ""
        and curves["border"].values[k + 1] == "" and points[k, 0] < 1.49
    ]  # fmt: skip
    across = points[np.array(chosen) + 1] - points[chosen]
    across = np.column_stack([-across[:, 1], across[:, 0]])
    across *= 1e-10 / np.linalg.norm(across, axis=1)[:, None]
    runner = ns.StroboscopicMap(system).runner(1e-12)
    ends = [runner.last(runner.start(points[chosen] + way * across), 400)[0] for way in (1.0, -1.0)]
    attractors = ns.attractors(system, {"x": (-4, 1.5), "v": (-4, 4)}, samples=60)
    settled = attractors["points"].values[:, 0]
    labels = [np.linalg.norm(end[:, None] - settled, axis=2).argmin(axis=1) for end in ends]
    off = [np.linalg.norm(end[:, None] - settled, axis=2).min(axis=1) for end in ends]
    assert len(chosen) >= 20 and np.max(off) < 1e-6
    assert np.all(labels[0] != labels[1])


@pytest.mark.slow
def test_the_stable_manifold_goes_on_behind_the_wall(struck):
    """At the wall the two points of the jump are a start that hits it, and its rebound."""
    system, orbit = struck
    curves = ns.manifold(system, orbit, which="stable", length=9.0, side="+")
    at = int(curves["border_point"][0])
    hit, back = (curves.isel(point=at + k) for k in (0, 1))
    assert float(hit["x"]) == pytest.approx(WALL["sigma"], abs=1e-11)
    assert float(back["x"]) == pytest.approx(WALL["sigma"], abs=1e-11)
    assert float(back["v"]) == pytest.approx(-WALL["r"] * float(hit["v"]), abs=1e-11)
    assert curves["x"].values[-1] < 0.0  # and it goes on from there


def test_points_are_dense_and_turn_little(struck):
    """Neighbours are near each other, and the curve turns little but for corners."""
    system, orbit = struck
    curves = ns.manifold(system, orbit, length=9.0, largest_step=0.1, angle=0.1, side="-")
    points = np.column_stack([curves["x"], curves["v"]])
    steps = np.diff(points, axis=0)
    sizes = np.linalg.norm(steps, axis=1)
    assert sizes.max() <= 0.1
    np.testing.assert_allclose(np.diff(curves["arclength"]), sizes, atol=1e-12)
    with np.errstate(invalid="ignore"):
        unit = steps / sizes[:, None]
    turns = np.arccos(np.clip((unit[1:] * unit[:-1]).sum(axis=1), -1.0, 1.0))
    plain = (curves["border"].values[1:-1] == "") & (np.maximum(sizes[1:], sizes[:-1]) > 1e-4)
    joins = np.diff(curves["image"].values) != 0  # where one image follows the other
    plain &= ~(joins[1:] | joins[:-1])
    assert turns[plain].max() <= 0.1 + 1e-9


def test_a_soft_wall_makes_no_corners():
    """A soft wall that is just touched adds a power 3/2: the curve bends, and has a tangent."""
    system = ns.models.soft_impact()
    orbit = ns.find_orbit(system, {"x": -0.2032, "v": 1.011})
    curves = ns.manifold(system, orbit, length=2.0)
    kinds = curves["border_kind"].values
    assert kinds.size >= 3 and set(kinds) == {"smooth"}
    assert curves["border_gap"].values.max() < 1e-11


@pytest.mark.parametrize("apart", [-1e-9, 0.0, 1e-9])
def test_the_plus_side_of_a_direction_with_equal_components(apart):
    """(1, -1 - apart/2) leaves the orbit: of two equal components the first is positive."""
    system = ns.System(
        states=["x", "y"],
        parameters={"b": 0.3},
        equations={"x": "cos(2*pi*t) - b*y", "y": f"-b*(1 + {apart!r})*x"},
        period=1,
    )
    orbit = ns.find_orbit(system, {"x": 0.0, "y": 0.0})
    curves = ns.manifold(system, orbit, length=1.0, side="+")
    way = np.array([curves[name].values[-1] - orbit[name].item() for name in ("x", "y")])
    np.testing.assert_allclose(way / np.linalg.norm(way), [np.sqrt(0.5), -np.sqrt(0.5)], atol=1e-6)
