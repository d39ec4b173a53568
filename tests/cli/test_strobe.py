import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from cli.test_chaos_commands import value


def test_summary_file_and_picture(call, tmp_path):
    file, picture = tmp_path / "points.nc", tmp_path / "points.png"
    result = call(
        "strobe", "soft_impact", "omega=0.85", "--transient", "300", "--record", "40",
        "--phase", "0.25", "--initial", "x=0.1", "--save", file, "--plot", picture, "--modes",
        "--draw", "v,x",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    points = ns.stroboscopic_map(
        ns.models.soft_impact(omega=0.85), {"x": 0.1}, transient=300, record=40, phase=0.25
    )
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load().drop_indexes("point"), points)
    assert picture.stat().st_size > 1000
    assert value(result.stdout, "points") == "40 of 40"
    x = points["x"].values
    assert np.allclose(x[2:], x[:-2], rtol=0, atol=1e-9) and abs(x[1] - x[0]) > 0.1
    assert value(result.stdout, "repeats") == "after 2 points"
    assert f"x = {float(points['x'][-1]):.7g}" in value(result.stdout, "last point")


def test_other_periods_and_drift(call):
    result = call("strobe", "chua", "--period", "pi/4", "--record", "50", "--transient", "0")
    assert result.exit_code == 0, result.stderr
    assert value(result.stdout, "time") == f"0 to {49 * 0.7853981634:.7g}"
    assert value(result.stdout, "repeats") == "not within these points"
    result = call("strobe", "moling", "b=0.15", "--record", "50")
    assert value(result.stdout, "repeats") == "after 1 points"


def test_points_of_what_does_not_repeat(call, tmp_path):
    """x = t at all times: the strobes are there, and nobody looks for a period in them."""
    file = tmp_path / "ramp.toml"
    file.write_text('states = ["x"]\nperiod = "2"\nequations = { x = "1 - x + t" }\n')
    result = call("strobe", file, "--transient", "0", "--record", "9")
    assert result.exit_code == 0, result.stderr
    assert value(result.stdout, "last point") == "x = 16"
    assert value(result.stdout, "repeats") == (
        "no: t by itself in the rate of 'x' in mode 'flow' does not either"
    )
    result = call("zero-one", file, "--record", "300")
    assert result.exit_code == 2 and "which does not repeat" in result.stderr


def test_an_early_end(call, accumulating):
    result = call("strobe", "ball", "--period", "1", "--transient", "0", "--initial", "h=1")
    assert result.exit_code == 1
    assert "impacts accumulate" in value(result.stdout, "status")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--phase", "2"], "phase"),
        (["--record", "0"], "record"),
        (["--initial", "w=1"], "'w'"),
        (["--period", "w"], "'w'"),
        (["--draw", "x,v"], "--plot picture.png"),
        (["--plot", "a.png", "--draw", "x"], "not two variables"),
        (["--plot", "a.png", "--draw", "x,w"], "unknown variable 'w'"),
        (["--save", "a.csv"], "'.csv'"),
    ],
)
def test_wrong_use(call, arguments, message):
    result = call("strobe", "duffing", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr


def test_without_a_period(call):
    for command in ("strobe", "zero-one"):
        result = call(command, "chua")
        assert result.exit_code == 2
        assert "--period" in result.stderr


def test_zero_one(call, tmp_path):
    file, picture = tmp_path / "k.nc", tmp_path / "k.png"
    result = call(
        "zero-one", "soft_impact", "omega=0.905", "--record", "500", "--variable", "v",
        "--seed", "2", "--save", file, "--plot", picture,
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    points = ns.stroboscopic_map(ns.models.soft_impact(omega=0.905), transient=200, record=500)
    expected = ns.zero_one_test(points, "v", seed=2)
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load(), expected)
    assert value(result.stdout, "K") == f"{float(expected['K']):.4g}"
    assert picture.stat().st_size > 1000
    regular = call("zero-one", "soft_impact", "omega=0.85", "--record", "500")
    assert abs(float(value(regular.stdout, "K"))) < 0.1


def test_zero_one_says_what_is_doubtful(call):
    result = call("zero-one", "chua", "--period", "0.02", "--record", "400", "--initial", "x=0.1")
    assert result.exit_code == 0, result.stderr
    assert "sampled too densely" in value(result.stdout, "doubt")


def test_zero_one_of_what_it_cannot_test(call, accumulating):
    assert call("zero-one", "duffing", "--variable", "w").exit_code == 2
    assert call("zero-one", "duffing", "--record", "50").exit_code == 2
    ended = call("zero-one", "ball", "--period", "1", "--initial", "h=1")
    assert ended.exit_code == 1 and "impacts accumulate" in ended.stderr
