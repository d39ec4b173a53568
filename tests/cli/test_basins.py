import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from cli.test_attractors import row
from cli.test_chaos_commands import value

GRID = ["--over", "x=-2:3:20", "--over", "v=-1:1:16", "--starts", "32"]


@pytest.fixture(scope="module")
def expected():
    region = {"x": np.linspace(-2, 3, 20), "v": np.linspace(-1, 1, 16)}
    return ns.basins_of_attraction(ns.models.gear_pair(Omega=0.5), region, samples=32)


def test_table_file_picture_and_measures(call, tmp_path, expected):
    file, picture, curve = tmp_path / "b.nc", tmp_path / "b.png", tmp_path / "c.png"
    result = call("basins", "gear_pair", "Omega=0.5", *GRID, "--save", file, "--plot", picture)
    assert result.exit_code == 0, result.stderr
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load(), expected)
    assert picture.stat().st_size > 1000
    assert value(result.stdout, "cells") == "320 (20 x 16)"
    share = float(np.mean(expected["label"] == 1))
    assert float(row(result.stdout, 1)[3].partition(" ")[0]) == pytest.approx(share, rel=1e-3)

    result = call("measures", file, "--box", "4", "--plot", curve)
    assert result.exit_code == 0, result.stderr
    exponent = float(ns.uncertainty_exponent(expected)["uncertainty_exponent"])
    assert value(result.stdout, "uncertainty exponent").startswith(f"{exponent:.4g} +- ")
    entropy = float(ns.basin_entropy(expected, box=4)["basin_entropy"])
    assert value(result.stdout, "basin entropy").startswith(f"{entropy:.4g} +- ")
    assert f"{int((expected['label'] == 1).sum())}" in result.stdout
    assert "Wada" not in result.stdout  # of two basins
    assert curve.stat().st_size > 1000


@pytest.mark.parametrize("method", ["cell-mapping", "cell mapping"])
def test_cell_mapping(call, expected, method):
    result = call("basins", "gear_pair", "Omega=0.5", *GRID, "--method", method)
    assert result.exit_code == 0, result.stderr
    share = float(row(result.stdout, 1)[3].partition(" ")[0])
    assert share == pytest.approx(float(np.mean(expected["label"] == 1)), abs=0.1)


def test_a_store_and_other_cells(call, accumulating, tmp_path):
    arguments = [
        "basins", "ball", "r=0.4", "--period", "4", "--over", "h=-1:1:4", "--over", "u=-1:1:5",
        "--starts", "8", "--store", tmp_path / "store", "--threads", "1",
    ]  # fmt: skip
    result = call(*arguments)
    assert result.exit_code == 1
    assert value(result.stdout, "ended early") == "10 cells"
    assert value(result.stdout, "inadmissible") == "10 cells"
    assert list((tmp_path / "store").iterdir())
    assert call(*arguments).stdout == result.stdout
    other = call(*arguments, "--longest", "7")
    assert other.exit_code == 2 and "longest" in other.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "--over"),
        (["--over", "x=0:1:5"], "two states"),
        (["--over", "x=0:1:5", "--over", "x=0:1:5"], "given twice"),
        (["--over", "x=0:1:5", "--over", "w=0:1:5"], "unknown state 'w'"),
        (["--over", "x=0:1:5", "--over", "v=0:1"], "name=first:last:count"),
        (["--over", "x=0:1:5", "--over", "v=1:0:5"], "less than the last"),
        (["--over", "x=0:1:5", "--over", "v=0:1:1"], "the count 2 or more"),
        (["--over", "x=0:1:100000", "--over", "v=0:1:100000"], "too many"),
        (["--over", "x=0:1:5", "--over", "v=0:1:5", "--method", "guess"], "guess"),
        (["--over", "x=0:1:5", "--over", "v=0:1:5", "--threads", "0"], "threads"),
        (["--over", "x=0:1:5", "--over", "v=0:1:5", "--complete", "x=1"], "already"),
        (["--over", "x=0:1:5", "--over", "v=0:1:5", "--plot", "a.gif"], "'.gif'"),
    ],
)
def test_wrong_use(call, arguments, message):
    result = call("basins", "duffing", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr


def test_pictures_have_two_states(call):
    over = [text for name in "xyz" for text in ("--over", f"{name}=0:1:3")]
    result = call("basins", "chua", "--section", "y", *over, "--plot", "a.png")
    assert result.exit_code == 2
    assert "--over has 3" in result.stderr


def test_measures_of_three_basins(call, tmp_path):
    label = np.ones((60, 60), int)
    label[:, 20:40], label[:, 40:] = 2, 3
    file = tmp_path / "three.nc"
    xr.Dataset({"label": (("y", "x"), label)}).to_netcdf(file, engine="h5netcdf")
    result = call("measures", file, "--between", "1,2")
    assert result.exit_code == 0, result.stderr
    assert value(result.stdout, "uncertainty exponent").startswith("1")
    assert value(result.stdout, "Wada property").startswith("no, ")
    assert result.stdout.count("0.3333 +- ") == 3


def test_measures_of_what_is_none(call, tmp_path):
    text, other = tmp_path / "a.nc", tmp_path / "b.nc"
    text.write_text("no file of this kind")
    xr.Dataset({"x": ("time", [1.0])}).to_netcdf(other, engine="h5netcdf")
    faults = {
        tmp_path / "none.nc": "there is no file",
        tmp_path: "there is no file",
        text: "is no netCDF file",
        other: "holds no basins",
    }
    for file, message in faults.items():
        result = call("measures", file)
        assert result.exit_code == 2 and message in result.stderr
        assert len(result.stderr.splitlines()) == 1
    assert call("measures", other, "--between", "1").exit_code == 2
