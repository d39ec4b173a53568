"""Chains of cells against closed forms, and the generalised cell mapping against exact basins."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scipy import ndimage

import nonsmooth as ns
from analysis.wells import forced_wells, runaway
from nonsmooth.analysis.basins.by_cell_shares import closed_classes, end_shares, transitions

GENERALISED = "generalised cell mapping"
UNKNOWN = -9


def _ueda() -> ns.System:
    """Five attractors, two of which have a few cells in a hundred."""
    return ns.System(
        states=["x", "v"],
        period="2*pi",
        equations={"x": "v", "v": "-0.08*v - x**3 + 0.2*cos(t)"},
    )


def _walk(count: int, up: float) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of a random walk on 0 ... count - 1 that ends at both ends; ``up`` in tenths."""
    source, image = [0, count - 1], [0, count - 1]
    for i in range(1, count - 1):
        steps = [i + 1] * round(10 * up) + [i - 1] * round(10 * (1 - up))
        source += [i] * 10
        image += steps
    return np.array(source), np.array(image)


@pytest.mark.parametrize("up", [0.5, 0.3, 0.8])
def test_the_ruin_of_a_gambler(up: float) -> None:
    """Probability to end at the top: (1 - r**i)/(1 - r**n) with r = (1 - up)/up, or i/n."""
    n = 12
    matrix = transitions(*_walk(n + 1, up), n + 1)
    classes = closed_classes(matrix)
    assert classes[0] != classes[n]
    assert classes[0] >= 0
    assert classes[n] >= 0
    assert np.all(classes[1:n] == -1)
    ends = np.zeros((n + 1, 2))
    ends[0, 0] = ends[n, 1] = 1.0
    r, i = (1 - up) / up, np.arange(n + 1)
    expected = i / n if up == 0.5 else (1 - r**i) / (1 - r**n)
    shares = end_shares(matrix, ends)
    assert shares[:, 1] == pytest.approx(expected, abs=1e-13)
    assert shares.sum(axis=1) == pytest.approx(np.ones(n + 1), abs=1e-13)


def test_a_cycle_is_one_class_and_a_cell_without_points_none() -> None:
    matrix = transitions(np.array([0, 1, 2, 3]), np.array([1, 2, 0, 0]), 5)
    classes = closed_classes(matrix)
    assert len(set(classes[:3].tolist())) == 1
    assert classes[0] >= 0
    assert classes[3:].tolist() == [-1, -1]


def test_wells_but_for_the_cells_on_their_border() -> None:
    """The border cuts the cells on the diagonal: three points on it, three on either side."""
    side = np.linspace(-2.0, 2.0, 41)
    basins = ns.basins_of_attraction(
        forced_wells(), {"x": side, "y": side}, method="generalised cell mapping"
    )
    assert basins["period"].values.tolist() == [1, 1]
    x, y = np.meshgrid(side, side)
    off = np.abs(x + y) > 1e-9
    assert np.array_equal(basins["label"].values[off], np.where(x + y > 0, 2, 1)[off])
    assert basins["probability"].values[off] == pytest.approx(1.0, abs=1e-12)


def test_motions_that_end_have_a_share() -> None:
    """x is less than 1 in size in two of the three columns of points of a cell that 1 cuts."""
    side = np.array([-0.75, -0.25, 0.25, 0.75, 1.0 + 1e-3, 1.25])
    basins = ns.basins_of_attraction(
        runaway(), {"x": side, "y": np.linspace(-1, 1, 5)}, method="generalised cell mapping"
    )
    assert basins["label"].values[2, :4].tolist() == [1, 1, 1, 1]
    assert basins["label"].values[2, 5] == -1


@pytest.mark.slow
def test_it_agrees_with_exact_basins_away_from_borders() -> None:
    system, side = ns.models.duffing(gamma=0.2), np.linspace(-2.0, 2.0, 60)
    region = {"x": side, "v": side}
    exact = ns.basins_of_attraction(system, region, samples=100)
    shared = ns.basins_of_attraction(
        ns.StroboscopicMap(system), region, method="generalised cell mapping"
    )
    assert shared["period"].values.tolist() == exact["period"].values.tolist() == [1, 1]
    label = exact["label"].values
    away = ndimage.maximum_filter(label, 7) == ndimage.minimum_filter(label, 7)
    assert away.sum() > 1000
    assert np.mean(label[away] == shared["label"].values[away]) > 0.99
    # the less probable, the nearer to a border
    assert np.nanmin(shared["probability"].values) < 0.9


def _agreement(shared: xr.Dataset, exact: xr.Dataset, width: int) -> float:
    """Part of the cells away from borders whose attractor is that of the exact motion."""
    same = np.full(shared.sizes["attractor"] + 1, UNKNOWN)
    for number, points in enumerate(shared["points"].values, 1):
        off = np.linalg.norm(exact["points"].values - points[0], axis=2)
        same[number] = np.nanmin(off, axis=1).argmin() + 1
        assert np.nanmin(off) < 1e-6
    label = exact["label"].values
    away = ndimage.maximum_filter(label, width) == ndimage.minimum_filter(label, width)
    assert away.sum() > 50
    return float(np.mean(same[shared["label"].values[away]] == label[away]))


def test_cells_wider_than_what_an_iterate_contracts() -> None:
    """One period of these gears brings motions together by less than a cell."""
    gears = ns.models.gear_pair(Omega=0.5)
    region = {"x": np.linspace(-3.0, 4.0, 45), "v": np.linspace(-2.0, 2.0, 40)}
    exact = ns.basins_of_attraction(gears, region, samples=100)
    shared = ns.basins_of_attraction(gears, region, method=GENERALISED)
    assert shared["fraction"].values == pytest.approx(exact["fraction"].values, abs=0.01)
    assert _agreement(shared, exact, 3) > 0.99
    assert shared.attrs["iterates_per_cell"] >= 8
    assert shared.attrs["changed_by_doubling"] <= 1e-3


@pytest.mark.slow
def test_attractors_with_small_basins_and_little_damping() -> None:
    side = np.linspace(-1.0, 1.0, 24)
    region = {"x": side, "v": np.linspace(-1.0, 1.0, 25)}
    exact = ns.basins_of_attraction(_ueda(), region, samples=200)
    shared = ns.basins_of_attraction(_ueda(), region, method=GENERALISED)
    assert shared["period"].values.tolist() == exact["period"].values.tolist() == [1, 1, 2, 2, 3]
    assert _agreement(shared, exact, 3) > 0.99
    assert np.all(shared["label"].values > 0)


@pytest.mark.slow
def test_a_grid_without_any_attractor() -> None:
    region = {"x": np.linspace(3.0, 5.0, 8), "v": np.linspace(3.0, 5.0, 9)}
    shared = ns.basins_of_attraction(_ueda(), region, method=GENERALISED)
    exact = ns.basins_of_attraction(_ueda(), region, samples=50)
    assert np.all(shared["label"].values > 0)
    sure = shared["probability"].values > 0.99
    assert sure.sum() > 10
    for number, points in enumerate(shared["points"].values, 1):
        off = np.nanmin(np.linalg.norm(exact["points"].values - points[0], axis=2), axis=1)
        cells = sure & (shared["label"].values == number)
        assert np.all(exact["label"].values[cells] == off.argmin() + 1)


def test_cells_that_hold_several_attractors_are_told() -> None:
    """At t = 0 the wells are at (0.7, 0.3) and (-0.3, -0.7), both in the cell about 0."""
    side = np.linspace(-6.0, 6.0, 5)
    basins = ns.basins_of_attraction(forced_wells(), {"x": side, "y": side}, method=GENERALISED)
    assert basins.sizes["attractor"] == 2
    assert basins.attrs["cells_of_several_attractors"] == 1
    assert "several attractors: 1; take finer cells" in basins.attrs["message"]
    x, y = np.meshgrid(side, side)
    off = np.abs(x + y) > 1e-9
    assert np.array_equal(basins["label"].values[off], np.where(x + y > 0, 2, 1)[off])


@pytest.mark.parametrize("method", ["cell mapping", GENERALISED])
def test_sections_have_no_cells(method: str) -> None:
    top = ns.PoincareMap(ns.models.chua(), "y")
    side = np.linspace(-1.0, 1.0, 5)
    for region in ({"x": side, "z": side}, {"x": side, "y": side, "z": side}):
        with pytest.raises(ns.OptionError, match=r"lie on a surface.*method='recurrences'"):
            ns.basins_of_attraction(top, region, method=method)
