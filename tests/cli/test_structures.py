"""`nonsmooth campbell` against the function that it calls."""

import json

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from cli.test_options import write_shaft


def test_the_table_is_that_of_the_function(call, tmp_path):
    shaft = write_shaft(tmp_path)
    words = ["--speeds", "0:2000:11", "--count", "4", "--harmonics", "1,2"]
    result = call("campbell", shaft, *words, "--json", "--save", tmp_path / "a.nc")
    expected = ns.structures.campbell(
        ns.Structure.from_files(shaft), np.linspace(0.0, 2000.0, 11), count=4, harmonics=(1.0, 2.0)
    )
    told = json.loads(result.stdout)["critical_speeds"]
    assert [row["speed"] for row in told] == expected["critical_speed"].values.tolist()
    assert len(told) >= 4
    with xr.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as saved:
        xr.testing.assert_equal(saved, expected)


def test_speeds_in_revolutions_per_minute(call, tmp_path):
    shaft = write_shaft(tmp_path)
    one = call("campbell", shaft, "--speeds", "0:2000:5", "--json")
    rpm = call("campbell", shaft, "--rpm", "--speeds", f"0:{2000 * 30 / np.pi!r}:5", "--json")
    speeds = [
        [row["speed"] for row in json.loads(each.stdout)["critical_speeds"]] for each in (one, rpm)
    ]
    assert speeds[0] == pytest.approx(speeds[1], rel=1e-12)


def test_where_a_mode_grows_is_told(call, tmp_path):
    """Cross-coupled stiffness beyond c w makes forward whirl grow: see the tests of root loci."""
    stiffness = [[2e5, 3e4], [-3e4, 2e5]]
    np.savez(
        tmp_path / "a.npz", M=5 * np.eye(2), C=np.eye(2), K=stiffness, coordinates=["1x", "1y"]
    )
    result = call("campbell", tmp_path / "a.npz", "--speeds", "0:300:4")
    assert "a mode grows, first at 0 rad/s" in result.stdout


@pytest.mark.parametrize(
    "words, says",
    [
        (["--speeds", "0:1"], "--speeds: '0:1' is not of the form first:last:count"),
        (["--speeds", "5:1:3"], "--speeds: give increasing ones"),
        (["--speeds", "0:1:3", "--units", "mile"], "units: unknown unit 'mile'"),
        (["--speeds", "0:1:3", "--harmonics", "0"], "--harmonics"),
    ],
)
def test_wrong_words_are_refused(call, tmp_path, words, says):
    result = call("campbell", write_shaft(tmp_path), *words)
    assert result.exit_code == 2 and says in result.stderr
