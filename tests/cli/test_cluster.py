"""Maps in tiles from the shell: parts, what is told, exit codes."""

import json
from importlib import import_module

import pytest

import nonsmooth as ns
from cli.test_options import plan_small_map
from nonsmooth.cluster.tile_store import TileStore

work_file = import_module("nonsmooth.cluster.work")  # the package has the verb by this name
PLAN = ["plan", "soft_impact", "zeta=0.03", "--over", "omega=0.7:0.8:3", "--over", "a=0.7:0.8:2"]


@pytest.fixture
def store(tmp_path):
    """A map in two tiles."""
    return plan_small_map(tmp_path / "map.zarr")


def told(result):
    """The JSON document of a command."""
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def test_parts_make_the_whole(call, store):
    first = told(call("work", store, "--part", "2/2", "--json"))
    assert (first["tiles"], first["done"], first["status"]) == (2, 1, "incomplete")
    assert TileStore.open(store).done() == {1}
    both = told(call("work", store, "--tiles", "0,1", "--json"))
    assert (both["done"], both["status"]) == (2, "completed")
    assert told(call("progress", store, "--json"))["message"] == "all 2 tiles are done"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--part", "3/2"], "--part: '3/2' is no part of several, such as 1/16"),
        (["--part", "a"], "--part: 'a' is no part of several"),
        (["--part", "1/2", "--tiles", "0"], "--part: --tiles is given too"),
        (["--tiles", "0,x"], "--tiles: '0,x' is no list of whole numbers"),
        (["--tiles", "7"], "tiles: there is no tile 7"),
    ],
)
def test_wrong_parts_are_refused(call, store, words, said):
    result = call("work", store, *words)
    assert result.exit_code == 2 and said in result.stderr


def test_a_tile_that_fails_is_told(call, store, monkeypatch):
    def faulty(*given):
        raise ValueError("no such luck")

    monkeypatch.setattr(work_file, "tile_map", faulty)
    result = call("work", store)
    assert result.exit_code == 1
    assert result.stdout.count("ValueError: no such luck") == 2
    monkeypatch.undo()
    assert told(call("work", store, "--retry", "--json"))["failed"] == 0


@pytest.mark.slow
def test_a_plan_is_that_of_python(call, tmp_path):
    """The shell and a script plan the same job, so either may go on with it."""
    assert call(*PLAN, "--store", tmp_path / "m.zarr", "--tile", "2").exit_code == 0
    system = ns.models.soft_impact(zeta=0.03)
    over = {"omega": [0.7, 0.75, 0.8], "a": [0.7, 0.8]}
    ns.cluster.plan_map(tmp_path / "m.zarr", system, over, tile=2)
    result = call(*PLAN, "--store", tmp_path / "m.zarr", "--tile", "4")
    assert result.exit_code == 2 and "tile: 2 then, 4 now" in result.stderr
    result = call(*PLAN[:5], "--store", tmp_path / "n.zarr")
    assert result.exit_code == 2 and "give it twice" in result.stderr


def test_a_forecast_speaks(call, store):
    found = told(call("forecast", store, "--sample", "8", "--threads", "1", "--json"))
    assert found["points"] == 6 and found["threads"] == 1 and found["seconds"] > 0.0
