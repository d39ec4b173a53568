"""Dimensions of sets of points beside those that are known."""

from math import log, sqrt

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import OptionError


def game(corners, ratio, count, seed=0):
    """Points of a set made of copies of itself, each smaller by a ratio, drawn at random."""
    generator = np.random.default_rng(seed)
    chosen = np.array(corners, float)[generator.integers(len(corners), size=count + 100)]
    points, place = np.empty(chosen.shape), np.zeros(chosen.shape[1])
    for k, corner in enumerate(chosen):
        place = ratio * place + (1 - ratio) * corner
        points[k] = place
    return points[100:]


TRIANGLE = [(0, 0), (1, 0), (0.5, sqrt(3) / 2)]
CARPET = [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)]
SETS = [
    (TRIANGLE, 1 / 2, log(3) / log(2)),
    (CARPET, 1 / 3, log(8) / log(3)),
    ([(0,), (1,)], 1 / 3, log(2) / log(3)),
]


def henon(count):
    x, y = 0.1, 0.1
    points = np.empty((count, 2))
    for k in range(-1000, count):
        x, y = 1 - 1.4 * x * x + y, 0.3 * x
        if k >= 0:
            points[k] = x, y
    return points


def carpet_cells(levels):
    """Middles of the cells of the carpet, and its corners, which give it its extent."""
    cells = np.zeros((1, 2))
    for level in range(1, levels + 1):
        cells = (cells[:, None] + np.array(CARPET)[None] / 3.0**level).reshape(-1, 2)
    return np.concatenate([cells + 0.5 / 3.0**levels, [[0, 0], [1, 1]]])


def test_boxes_of_the_carpet_are_counted():
    found = ns.box_dimension(carpet_cells(5), boxes=[3, 9, 27, 81])
    assert found["boxes"].values.tolist() == [8, 64, 512, 4096]
    assert float(found["box_dimension"]) == pytest.approx(log(8) / log(3), abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("corners", "ratio", "truth"), SETS)
def test_dimensions_of_similar_copies(corners, ratio, truth):
    """Copies that are drawn with equal chances: both dimensions are those of the set."""
    points = game(corners, ratio, 40_000)
    for verb, most in ((ns.box_dimension, 0.07), (ns.correlation_dimension, 0.03)):
        found = verb(points)
        error = float(found["standard_error"])
        assert error < most
        assert float(found[verb.__name__]) == pytest.approx(truth, abs=2 * error)


@pytest.mark.slow
def test_the_henon_attractor():
    """P. Grassberger and I. Procaccia (1983): correlation dimension 1.21 with error 0.01; D. A.
    Russell, J. D. Hanson and E. Ott (1980): 1.26 by counting boxes."""
    points = henon(100_000)
    pairs = ns.correlation_dimension(points)
    boxes = ns.box_dimension(points)
    assert float(pairs["standard_error"]) < 0.02
    assert float(pairs["correlation_dimension"]) == pytest.approx(1.21, abs=0.02)
    assert float(boxes["standard_error"]) < 0.05
    assert float(boxes["box_dimension"]) == pytest.approx(1.26, abs=0.03)


@pytest.mark.parametrize("count", [1, 4])
def test_a_periodic_motion_has_dimension_zero(count):
    cycle = np.random.default_rng(0).random((count, 2))
    points = np.tile(cycle, (400, 1)) + np.random.default_rng(1).random((400 * count, 2)) * 1e-14
    for verb in (ns.box_dimension, ns.correlation_dimension):
        assert float(verb(points)[verb.__name__]) == pytest.approx(0, abs=1e-12)


def test_units_and_idle_coordinates_change_nothing():
    points = game(TRIANGLE, 1 / 2, 5_000)
    other = np.column_stack([2**20 * points[:, 0], np.full(5_000, 3.7), points[:, 1] / 2**10])
    for verb in (ns.box_dimension, ns.correlation_dimension):
        assert float(verb(other)[verb.__name__]) == float(verb(points)[verb.__name__])


def test_pairs_by_hand():
    """All pairs, those close in time left out, counted one by one."""
    points = np.random.default_rng(5).random((300, 1))
    unit = (points - points.min()) / np.ptp(points)
    for window in (1, 7):
        found = ns.correlation_dimension(points, window=window)
        i, j = np.indices((300, 300))
        counted = np.abs(i - j) >= window
        for distance in (0.125, 0.5):
            close = np.abs(unit - unit.T) <= distance
            share = np.count_nonzero(close & counted) / np.count_nonzero(counted)
            assert float(found["correlation_sum"].sel(distance=distance)) == pytest.approx(share)


@pytest.mark.slow
def test_a_window_keeps_a_slow_curve_from_looking_longer():
    """Neighbours in time on a slow walk through the plane look like a line."""
    walk = np.random.default_rng(2).normal(size=(6_000, 2)).cumsum(axis=0) * 0.02 % 1.0
    short = ns.correlation_dimension(walk)["correlation_dimension"]
    long = ns.correlation_dimension(walk, window=500)["correlation_dimension"]
    assert abs(float(long) - 2) < 0.15
    assert float(long) > float(short) + 0.02


def attractors():
    points = np.full((2, 3_000, 3), np.nan)
    points[0, :, :2] = henon(3_000)
    points[1, :2, :2] = [[0.0, 1.0], [1.0, 0.0]]
    return xr.Dataset(
        {"points": (("attractor", "point", "state"), points)},
        {"attractor": [1, 2], "state": ["x", "y", "drift"]},
    )


def test_points_from_datasets(tmp_path):
    plain = ns.correlation_dimension(henon(3_000))
    found = ns.correlation_dimension(attractors(), attractor=1)
    assert float(found["correlation_dimension"]) == float(plain["correlation_dimension"])
    part = ns.box_dimension(attractors(), attractor=1, states=["x"])
    assert float(part["box_dimension"]) == pytest.approx(1, abs=0.1)
    mole = ns.models.moling()
    drifting = attractors().assign_coords(state=["p", "y", "v"])
    drifting["points"][0, :, 2] = np.arange(3_000) ** 2.0
    drifting.attrs["system"] = mole.to_toml()  # in which v drifts
    found = ns.correlation_dimension(drifting, attractor=1)
    assert float(found["correlation_dimension"]) == float(plain["correlation_dimension"])
    strobes = ns.stroboscopic_map(mole, transient=100, record=60)
    found = ns.box_dimension(strobes)
    assert float(found["box_dimension"]) == pytest.approx(0, abs=1e-12)  # in p, y and q; v drifts
    assert found.attrs["system_name"] == "moling"
    found.to_netcdf(tmp_path / "d.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "d.nc", engine="h5netcdf") as again:
        xr.testing.assert_equal(again.load(), found)


@pytest.mark.parametrize("verb", [ns.box_dimension, ns.correlation_dimension])
@pytest.mark.parametrize(
    ("points", "options", "message"),
    [
        (np.zeros((10, 2)), {}, "too few"),
        (np.zeros((10, 2, 2)), {}, "3 dimensions"),
        ("abc", {}, "give a dataset or an array"),
        (np.zeros((500, 2)), {"states": ["x"]}, "choose from a dataset"),
        (attractors(), {}, "attractor= is needed"),
        (attractors(), {"attractor": 3}, "the dataset has 1, 2"),
        (attractors(), {"attractor": 2}, "too few"),
        (attractors(), {"attractor": 1, "states": ["z"]}, "unknown state 'z'"),
        (attractors(), {"attractor": 1, "states": []}, "states= is empty"),
        (xr.Dataset({"a": (("x", "y"), np.ones((2, 2)))}), {}, "no variable"),
    ],
)
def test_what_holds_no_points(verb, points, options, message):
    with pytest.raises(OptionError, match=message):
        verb(points, **options)


@pytest.mark.parametrize("boxes", [[2, 4], [2, 4, 4.5], "abc", [2, 4, 10**6]])
def test_wrong_boxes(boxes):
    with pytest.raises(OptionError, match="boxes"):
        ns.box_dimension(henon(1000), boxes=boxes)


@pytest.mark.parametrize("window", [0, 500, "a"])
def test_wrong_windows(window):
    with pytest.raises(OptionError, match="window"):
        ns.correlation_dimension(henon(1000), window=window)


@pytest.mark.parametrize("verb", [ns.box_dimension, ns.correlation_dimension])
@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_points_that_are_not_finite_are_refused(verb, wrong):
    points = np.random.default_rng(0).random((500, 2))
    points[[7, 9], 1] = wrong
    with pytest.raises(OptionError, match=r"2 of 500 have a coordinate .* row 7"):
        verb(points)
    with pytest.raises(OptionError, match="500 of 500"):
        verb(np.full((500, 2), wrong))
    with pytest.raises(OptionError, match=r"all of them are nan|500 of 500"):
        verb(xr.Dataset({"x": ("point", np.full(500, wrong))}))
