"""Maps in tiles whose borders are refined: the points and digits of `regime_map`."""

import threading

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import OptionError
from nonsmooth.cluster.forecast import _area, _around
from nonsmooth.cluster.plan_map import planned_question
from nonsmooth.cluster.tile_map import tile_points
from nonsmooth.cluster.tile_store import TileStore
from nonsmooth.runs.sweep_runner import SweepRunner

SYSTEM = ns.models.soft_impact(zeta=0.03)
OVER = {"omega": np.linspace(0.7, 0.9, 6), "a": np.linspace(0.5, 0.9, 5)}
SHORT = {"transient": 30, "record": 20, "evidence": 20, "confirm": 0, "longest": 60, "refine": 2}


def computed_map(store, **options):
    ns.cluster.plan_map(store, SYSTEM, OVER, **SHORT, **options)
    ns.cluster.work(store, threads=2)
    return ns.cluster.open_map(store).load()


@pytest.fixture(scope="module")
def whole():
    """The same map from one process: 21 times 17 points."""
    return ns.regime_map(SYSTEM, OVER, **SHORT)


def test_one_tile_is_the_refined_map(tmp_path, whole):
    found = computed_map(tmp_path / "map.zarr", tile=64)
    for name in whole.data_vars:
        values = found[name].values.astype(object if name == "word" else whole[name].dtype)
        np.testing.assert_array_equal(values, whole[name].values, err_msg=name)
    np.testing.assert_array_equal(found["omega"], whole["omega"])
    assert found.attrs["refine"] == whole.attrs["refine"] == 2
    assert 0 < int((whole["computed"] == 0).sum()) < whole["computed"].size


@pytest.mark.few(1)
@pytest.mark.parametrize("tile", [4, 8, 12])
def test_tiles_refine_their_own_cells(tile, tmp_path, whole):
    """What is computed has the same digits; what is filled, the label of the cell around it."""
    found = computed_map(tmp_path / "map.zarr", tile=tile)
    both = (found["computed"] == 1) & (whole["computed"] == 1)
    for name in ("regime", "period", "exponent", "impacts"):
        np.testing.assert_array_equal(found[name].values[both], whole[name].values[both])
    # a tile computes nothing that the whole map would not
    assert not np.any((found["computed"].values == 1) & (whole["computed"].values == 0))
    # and it halves a cell only for what lies on it: two points that are computed on a cell of the
    # finest level but one, whose labels differ, leave nothing of that cell to be filled
    label = whole["regime"].values.astype(np.int64) * 1000 + whole["period"].values
    computed = found["computed"].values == 1
    for row in range(0, computed.shape[0] - 2, 2):
        for column in range(0, computed.shape[1] - 2, 2):
            own = np.s_[row : row + 2, column : column + 2]  # what lies in the tile of the cell
            if np.unique(label[own][computed[own]]).size > 1:
                assert np.all(computed[own]), (row, column)
    corners = np.zeros(whole["computed"].shape, bool)
    corners[::4, ::4] = True
    assert np.all(found["computed"].values[corners] == 1)


@pytest.mark.slow
def test_a_tile_does_not_depend_on_who_computes_it(tmp_path):
    """Tile by tile and in another order, with an interruption: equal to the bit."""
    first = computed_map(tmp_path / "first.zarr", tile=8)
    store = tmp_path / "second.zarr"
    ns.cluster.plan_map(store, SYSTEM, OVER, tile=8, **SHORT)
    count = TileStore.open(store).count
    for number in reversed(range(count)):
        ns.cluster.work(store, tiles=[number], threads=1)
    second = ns.cluster.open_map(store).load()
    for name in first.data_vars:
        np.testing.assert_array_equal(first[name].values, second[name].values)


def test_what_a_refined_map_refuses(tmp_path):
    more = {key: value for key, value in SHORT.items() if key != "refine"}
    for refine, tile, message in (
        (3, 12, "tile = 12 and refine = 3: .* multiple of 8"),
        (9, 64, "refine = 9: give how often"),
        (0.5, 64, "refine = 0.5: give how often"),
    ):
        with pytest.raises(OptionError, match=message):
            ns.cluster.plan_map(tmp_path / "m", SYSTEM, OVER, tile=tile, refine=refine, **more)
    ns.cluster.plan_map(tmp_path / "m", SYSTEM, OVER, tile=8, refine=1, **more)
    with pytest.raises(OptionError, match=r"refine: 1 then, 2 now"):
        ns.cluster.plan_map(tmp_path / "m", SYSTEM, OVER, tile=8, refine=2, **more)


def test_places_of_a_forecast_are_parts_of_tiles(tmp_path):
    store = tmp_path / "m"
    ns.cluster.plan_map(store, SYSTEM, OVER, tile=16, **SHORT)
    opened = TileStore.open(store)
    for number in range(opened.count):
        tile = opened.at(number)
        for row in range(tile.rows.start, tile.rows.stop):
            for column in range(tile.columns.start, tile.columns.stop):
                rows, columns = _around(opened, tile, row, column)
                assert row in range(rows.start, rows.stop)
                assert column in range(columns.start, columns.stop)
                assert rows.start % 4 == columns.start % 4 == 0
                assert tile.rows.start <= rows.start and rows.stop <= tile.rows.stop
    question = planned_question(opened)
    runner = SweepRunner(question.system, question.tolerance)
    place = (slice(0, 8), slice(8, 16))
    found = tile_points(question, 2, *place, runner, threading.Event())
    assert found.verdicts.shape == (8, 8) and _area(*place) == 64


@pytest.mark.slow
def test_a_forecast_of_a_refined_map_is_right_within_thirty_percent(tmp_path):
    """Both times are told by the same clock; what else runs may change, so three attempts."""
    ratios = []
    for attempt in range(3):
        store = tmp_path / f"map-{attempt}.zarr"
        over = {"omega": np.linspace(0.7, 0.9, 33), "a": np.linspace(0.5, 0.9, 33)}
        ns.cluster.plan_map(store, SYSTEM, over, tile=32, refine=2, evidence=100, confirm=400)
        told = ns.cluster.forecast(store, sample=40, threads=1, seed=attempt)
        job = ns.cluster.work(store, threads=1)
        ratios.append(float(told["seconds"]) / float(job["tile_seconds"] * job["tiles"]))
        if 0.7 < ratios[-1] < 1.3:
            return
    raise AssertionError(f"forecast over truth: {ratios}")
