"""Basin measures beside sets of known dimension and labels of known entropy."""

from fractions import Fraction
from math import factorial, log

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import brentq

import nonsmooth as ns
from nonsmooth import OptionError


def halves(side=128, at=64, ndim=2):
    labels = np.ones((side,) * ndim, int)
    labels[..., at:] = 2
    return labels


def gaps(points, left, right, generations=60):
    """1 or 2 by the generation of the gap of a Cantor set, whose parts shrink by two factors.

    Gaps of both kinds accumulate at every point of the set, so it is the boundary; its dimension
    d solves left^d + right^d = 1.
    """
    points = np.array(points)
    labels = np.zeros(points.shape, int)
    for generation in range(generations):
        below, above = points < left, points > 1 - right
        labels[~(below | above) & (labels == 0)] = 1 + generation % 2
        points = np.where(below, points / left, np.where(above, (points - 1 + right) / right, 0.5))
    return np.maximum(labels, 1)


def dimension(left, right):
    return brentq(lambda d: left**d + right**d - 1, 1e-3, 1)


def cells(count):
    return (np.arange(count) + 0.5) / count


def test_a_grid_that_does_not_tell_the_exponent_from_zero_or_one():
    """A middle-third Cantor set times a line has 1 - ln 2/ln 3 = 0.369; 60 cells are too few."""
    labels = np.tile(gaps(cells(3**7), 1 / 3, 1 / 3, generations=7)[:, None], (1, 60))
    found = ns.uncertainty_exponent(labels)
    exponent, error = (float(found[name]) for name in ("uncertainty_exponent", "standard_error"))
    assert exponent < 2 * error and 1 - exponent < 2 * error
    assert found.attrs["message"].startswith("the exponent is not determined: 0 and 1 are both")
    wide = ns.uncertainty_exponent(np.tile(labels[:, :1], (1, 729)))
    assert "not determined" not in wide.attrs["message"]


@pytest.mark.parametrize("ndim", [1, 2, 3])
def test_a_straight_boundary_has_exponent_one(ndim):
    """2 d of N cells in a row are within d cells of the boundary."""
    side = 32 if ndim == 3 else 128
    found = ns.uncertainty_exponent(halves(side, side // 2, ndim))
    distance = found["distance"].values
    assert found["uncertain_fraction"].values == pytest.approx(2 * distance / side, abs=1e-15)
    assert float(found["uncertainty_exponent"]) == pytest.approx(1, abs=1e-12)
    assert float(found["standard_error"]) == pytest.approx(0, abs=1e-12)
    assert float(found["boundary_dimension"]) == pytest.approx(ndim - 1, abs=1e-12)
    assert "smooth" in found.attrs["message"]


@pytest.mark.parametrize(("left", "right"), [(1 / 3, 1 / 3), (0.4, 0.25), (0.3, 0.5), (0.2, 0.2)])
def test_cantor_sets_on_a_line(left, right):
    found = ns.uncertainty_exponent(gaps(cells(3**11), left, right))
    error = float(found["standard_error"])
    assert error < 0.05
    assert float(found["uncertainty_exponent"]) == pytest.approx(
        1 - dimension(left, right), abs=2 * error
    )
    assert found.attrs["message"] == "fitted"


@pytest.mark.slow
def test_a_cantor_set_of_slanted_lines():
    """The middle-third set times a line: its dimension is 1 + log 2/log 3."""
    across, up = np.meshgrid(cells(1500), cells(1500))
    found = ns.uncertainty_exponent(gaps((across + 0.37 * up) % 1.0, 1 / 3, 1 / 3))
    error = float(found["standard_error"])
    assert error < 0.04
    assert float(found["boundary_dimension"]) == pytest.approx(1 + log(2) / log(3), abs=2 * error)


def test_pairs_of_labels():
    """Between 1 and 2 the boundary is smooth, between 2 and 3 it is a Cantor set."""
    labels = np.ones((64, 4000), int)
    labels[:, 1000:2000] = 2
    labels[:, 2000:] = 1 + gaps(cells(2000), 0.4, 0.25)
    smooth = ns.uncertainty_exponent(labels, between=(1, 2))
    fractal = ns.uncertainty_exponent(labels, between=(2, 3), distances=[1, 2, 4, 8, 16, 32])
    other = ns.uncertainty_exponent(
        np.where(labels == 1, 0, labels), distances=[1, 2, 4, 8, 16, 32]
    )
    assert float(smooth["uncertainty_exponent"]) == pytest.approx(1, abs=1e-9)
    assert float(fractal["uncertainty_exponent"]) == pytest.approx(
        float(other["uncertainty_exponent"]), abs=1e-12
    )
    assert float(fractal["uncertainty_exponent"]) < 0.6


def test_a_pair_of_which_one_does_not_occur_is_told():
    with pytest.warns(ns.ResultWarning, match=r"label 7, so there is no such .*; labels are 1, 2"):
        found = ns.uncertainty_exponent(halves(), between=(1, 7))
    assert np.isnan(float(found["uncertainty_exponent"]))


def test_what_is_left_out_is_not_compared():
    """A strip of inadmissible or unsettled cells along the boundary hides it up to its width."""
    labels = halves()
    labels[:, 60:64], labels[:, 64:68] = -2, 0
    found = ns.uncertainty_exponent(labels, distances=[2, 4, 8, 12, 16])
    assert found["uncertain_fraction"].values[:3].tolist() == [0, 0, 0]
    assert found["uncertain_fraction"].values[3] == pytest.approx(2 * 4 / 120)
    assert found.attrs["n_cells"] == 120 * 128
    ended = ns.uncertainty_exponent(np.where(labels == 1, -1, 2))
    assert float(ended["uncertainty_exponent"]) == pytest.approx(1, abs=1e-12)


def test_labels_without_order_saturate():
    labels = np.random.default_rng(1).integers(1, 3, (100, 100))
    found = ns.uncertainty_exponent(labels)
    assert abs(float(found["uncertainty_exponent"])) < 0.05
    assert "mixed at nearly every distance" in found.attrs["message"]
    assert found["fitted"].values.sum() == 3


def test_one_outcome_has_no_boundary():
    found = ns.uncertainty_exponent(np.ones((40, 40), int))
    assert np.isnan(float(found["uncertainty_exponent"]))
    assert "one outcome" in found.attrs["message"]
    entropy = ns.basin_entropy(np.ones((40, 40), int))
    assert float(entropy["basin_entropy"]) == 0.0
    assert np.isnan(float(entropy["boundary_basin_entropy"]))
    assert not bool(entropy["fractal"])


@pytest.mark.parametrize("ndim", [1, 2, 3])
def test_entropy_of_a_chessboard(ndim):
    board = 1 + np.indices((24,) * ndim).sum(axis=0) % 2
    entropy = ns.basin_entropy(board, box=4)
    assert float(entropy["basin_entropy"]) == pytest.approx(log(2), abs=1e-15)
    assert float(entropy["boundary_basin_entropy"]) == pytest.approx(log(2), abs=1e-15)
    assert int(entropy["n_boxes"]) == int(entropy["n_boundary_boxes"]) == 6**ndim
    assert not bool(entropy["fractal"])


def expected_entropy(size, kinds):
    """Mean entropy of a box of labels at random: every composition with its probability."""
    total = 0.0
    for first in range(size + 1):
        for second in range(size + 1 - first) if kinds == 3 else [size - first]:
            parts = [first, second, size - first - second][:kinds]
            ways = factorial(size)
            for part in parts:
                ways //= factorial(part)
            chance = float(Fraction(ways, kinds**size))
            total -= chance * sum(p / size * log(p / size) for p in parts if p)
    return total


@pytest.mark.parametrize("kinds", [2, 3])
def test_entropy_of_labels_at_random(kinds):
    labels = np.random.default_rng(3).integers(1, kinds + 1, (500, 500))
    entropy = ns.basin_entropy(labels, box=5)
    error = float(entropy["basin_entropy_error"])
    assert error < 1e-3
    assert float(entropy["basin_entropy"]) == pytest.approx(
        expected_entropy(25, kinds), abs=3 * error
    )
    assert bool(entropy["fractal"]) == (kinds == 3)
    large = ns.basin_entropy(labels, box=50)
    assert float(large["basin_entropy"]) == pytest.approx(log(kinds), abs=1e-3)


def test_entropy_of_a_straight_boundary():
    """Boxes of five across the boundary hold two columns of one label and three of the other."""
    entropy = ns.basin_entropy(halves(100, 42), box=5)
    mixed = -(0.4 * log(0.4) + 0.6 * log(0.6))
    assert float(entropy["boundary_basin_entropy"]) == pytest.approx(mixed, abs=1e-14)
    assert float(entropy["basin_entropy"]) == pytest.approx(mixed / 20, abs=1e-14)
    assert int(entropy["n_boundary_boxes"]) == 20


def test_entropy_with_gaps():
    """Half a box is enough, less is not; gaps are no outcome."""
    labels = halves(8, 4)
    labels[:2, :] = -2
    labels[2, 0], labels[2:4, 4:6] = 0, -2
    entropy = ns.basin_entropy(labels, box=4)
    # of 16 cells the boxes have 7, 4, 16, 16
    assert int(entropy["n_boxes"]) == 2
    assert int(ns.basin_entropy(labels, box=2)["n_boxes"]) == 11


def test_fractions():
    labels = np.array([[1, 1, 3, -2], [1, 0, -1, -1]])
    found = ns.basin_fractions(xr.Dataset({"label": (("y", "p"), labels)}))
    assert found["label"].values.tolist() == [1, 3, 0, -1]
    assert found["outcome"].values.tolist()[1:] == ["attractor 3", "unsettled", "ended early"]
    assert found["starts"].values.tolist() == [3, 1, 1, 2]
    share = np.array([3, 1, 1, 2]) / 7
    assert found["fraction"].values == pytest.approx(share)
    assert found["fraction_error"].values == pytest.approx(np.sqrt(share * (1 - share) / 7))
    assert found.attrs["n_starts"] == 7
    dataset = xr.Dataset({"label": (("y", "p"), labels)}, {"attractor": [1, 2, 3, 4]})
    assert ns.basin_fractions(dataset)["label"].values.tolist() == [1, 2, 3, 4, 0, -1]


def test_the_error_of_fractions_is_the_scatter_of_random_starts():
    chance = 0.3
    drawn = np.random.default_rng(0).random((400, 250)) < chance
    scatter = drawn.mean(axis=1).std()
    one = ns.basin_fractions(np.where(drawn[0], 1, 2))
    assert float(one["fraction_error"][0]) == pytest.approx(scatter, rel=0.15)


def test_results_survive_files_and_keep_the_system(tmp_path):
    dataset = xr.Dataset({"label": (("y", "p"), halves(32, 9))}, attrs={"system_name": "mole"})
    for k, verb in enumerate((ns.uncertainty_exponent, ns.basin_entropy, ns.basin_fractions)):
        found = verb(dataset)
        assert found.attrs["system_name"] == "mole"
        found.to_netcdf(tmp_path / f"{k}.nc", engine="h5netcdf")
        with xr.open_dataset(tmp_path / f"{k}.nc", engine="h5netcdf") as again:
            xr.testing.assert_equal(again.load(), found)


@pytest.mark.parametrize("verb", [ns.uncertainty_exponent, ns.basin_entropy, ns.basin_fractions])
@pytest.mark.parametrize(
    ("basins", "message"),
    [
        (xr.Dataset({"x": ("t", [1.0])}), "no variable 'label'"),
        (np.ones((20, 20)), "whole numbers"),
        (np.ones((0, 20), int), "whole numbers"),
        (np.full((20, 20), -2), "all 400 cells"),
        ("abc", "whole numbers"),
    ],
)
def test_what_holds_no_labels(verb, basins, message):
    with pytest.raises(OptionError, match=message):
        verb(basins)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"basins": halves(15, 7)}, "15 cells"),
        ({"distances": [1, 2]}, "three or more"),
        ({"distances": [1, 2, 128]}, "three or more"),
        ({"distances": [1, 2, 2.5]}, "whole number"),
        ({"distances": "abc"}, "whole numbers"),
        ({"between": (1, 1)}, "two different labels"),
        ({"between": 1}, "two different labels"),
        ({"leave_out": 0}, "leave_out = 0"),
        ({"leave_out": (0.5,)}, "leave_out"),
    ],
)
def test_wrong_options_of_the_exponent(options, message):
    given = {"basins": halves()} | options
    with pytest.raises(OptionError, match=message):
        ns.uncertainty_exponent(given.pop("basins"), **given)


@pytest.mark.parametrize("box", [1, 129, 2.5, "a"])
def test_wrong_boxes(box):
    with pytest.raises(OptionError, match="box"):
        ns.basin_entropy(halves(), box=box)


def test_truth_values_are_two_outcomes():
    lower = np.arange(4096).reshape(64, 64) % 64 < 20
    asked = ns.uncertainty_exponent(lower)
    numbered = ns.uncertainty_exponent(np.where(lower, 2, 1))
    assert asked.attrs["n_cells"] == 4096
    assert asked.identical(numbered)


def test_a_coarse_grid_is_told():
    """An eighth of 32 cells leaves the distances 1, 2, 3 and 4."""
    found = ns.uncertainty_exponent(halves(32, 16, 2))
    assert found["distance"].values.tolist() == [1, 2, 3, 4]
    assert found.attrs["message"].endswith("fitted to 4 distances only; refine the grid")
    assert "coarse" not in ns.uncertainty_exponent(halves(128, 64, 2)).attrs["message"]
    chosen = ns.uncertainty_exponent(halves(32, 16, 2), distances=(1, 2, 4))
    assert "coarse" not in chosen.attrs["message"]
