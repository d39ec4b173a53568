import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns

GRID = ["--over", "x=-0.5:0.5:3", "--over", "omega=0.7:0.8:2", "--over", "v=0:1:2"]


def expected():
    return ns.ensemble(
        ns.models.soft_impact(zeta=0.02),
        {"x": [-0.5, -0.5, 0, 0, 0.5, 0.5], "v": [0, 1, 0, 1, 0, 1]},
        parameters={"omega": np.linspace(0.7, 0.8, 2)},
        transient=20,
        record=5,
    )


def test_summary_and_file(call, tmp_path):
    file = tmp_path / "runs.nc"
    result = call(
        "ensemble", "soft_impact", "zeta=0.02", *GRID, "--transient", "20", "--record", "5",
        "--save", file,
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load(), expected())
    assert "runs       12\n" in result.stdout
    assert "status     12 completed" in result.stdout
    assert "certified  yes" in result.stdout


def test_a_store_is_a_file_too_and_goes_on(call, tmp_path):
    arguments = [
        "ensemble", "soft_impact", "zeta=0.02", *GRID, "--transient", "20", "--record", "5",
        "--store", tmp_path / "s",
    ]  # fmt: skip
    for _ in range(2):
        result = call(*arguments)
        assert result.exit_code == 0, result.stderr
        assert f"saved {tmp_path / 's' / 'result.nc'}" in result.stdout
        with xr.open_dataset(tmp_path / "s" / "result.nc", engine="h5netcdf") as saved:
            xr.testing.assert_identical(saved.load(), expected())
    result = call(*arguments, "--phase", "0.5")
    assert result.exit_code == 2
    assert "phase_of_period: 0.0 then, 0.5 now" in result.stderr


def test_runs_that_end_early_are_told(call):
    result = call(
        "ensemble", "moling", "--over", "p=0:1:2", "--initial", "q=0.1", "--record", "3",
    )  # fmt: skip
    assert result.exit_code == 1
    assert "status     1 completed, 1 inadmissible" in result.stdout


def test_a_diagram_goes_on_too(call, tmp_path):
    arguments = [
        "diagram", "soft_impact", "--over", "omega=0.7:0.8:9", "--transient", "5", "--record", "5",
        "--store", tmp_path / "s",
    ]  # fmt: skip
    outputs = [call(*arguments) for _ in range(2)]
    assert [output.exit_code for output in outputs] == [0, 0]
    assert outputs[0].stdout == outputs[1].stdout
    result = call(*arguments, "--start", "follow up")
    assert result.exit_code == 2
    assert "start: 'restart' then, 'follow up' now" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "--over"),
        (["--over", "x=0.7:0.8"], "name=first:last:count"),
        (["--over", "q=0:1:5"], "unknown state or parameter 'q'"),
        (["--over", "x=0:1:5", "--over", "x=0:2:5"], "'x' is given twice"),
        (["--over", "x=0:1:5", "--initial", "x=1"], "x is given by --over already"),
        (["--over", "x=0:1:5", "--initial", "y=1"], "unknown state 'y'"),
        (["--over", "x=0:1:5", "--save", "a.nc", "--store", "s"], "leave out --save"),
        (["--over", "x=0:1:5", "--store", "no/s"], "make it first"),
    ],
)
def test_wrong_use(call, arguments, message):
    result = call("ensemble", "soft_impact", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr
