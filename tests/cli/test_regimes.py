import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns


def test_one_motion(call, tmp_path):
    file = tmp_path / "r.nc"
    result = call("regime", "soft_impact", "omega=0.83", "--initial", "x=0.1", "--save", file)
    assert result.exit_code == 0, result.stderr
    expected = ns.regime(ns.models.soft_impact(omega=0.83), {"x": 0.1})
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load(), expected)
    assert expected["regime"].item() == "periodic"
    assert "periodic: strobes repeat" in result.stdout
    assert expected["word"].item() in result.stdout
    assert "multipliers" in result.stdout


def test_drift_and_chaos(call):
    mole = call("regime", "moling", "omega=1", "b=0.2")
    assert mole.exit_code == 0, mole.stderr
    assert "drift of v" in mole.stdout
    chaos = call("regime", "soft_impact", "omega=0.905", "--evidence", "300")
    assert "chaotic: exponent" in chaos.stdout
    circuit = call("regime", "chua", "--period", "1", "--evidence", "300")
    assert circuit.exit_code == 0, circuit.stderr


def test_absorption_is_a_result(call, accumulating):
    result = call("regime", "ball", "--period", "1")
    assert result.exit_code == 0
    assert "absorbed" in result.stdout


@pytest.mark.slow
def test_map_file_and_picture(call, tmp_path):
    file, picture = tmp_path / "m.nc", tmp_path / "m.png"
    result = call(
        "regimes", "soft_impact", "zeta=0.03", "--over", "omega=0.8:0.9:3", "--over", "a=0.5:0.9:3",
        "--refine", "1", "--transient", "100", "--longest", "100", "--evidence", "200", "--save",
        file, "--plot", picture, "--store", tmp_path / "store",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    expected = ns.regime_map(
        ns.models.soft_impact(zeta=0.03),
        {"omega": np.linspace(0.8, 0.9, 3), "a": np.linspace(0.5, 0.9, 3)},
        refine=1,
        transient=100,
        longest=100,
        evidence=200,
    )
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load(), expected)
    assert picture.stat().st_size > 1000
    assert "5 of omega times 5 of a" in result.stdout


@pytest.mark.slow
def test_a_followed_map_with_every_number(call, tmp_path):
    file = tmp_path / "m.nc"
    line = "regimes soft_impact zeta=0.03 --over omega=0.8:0.9:3 --over a=0.5:0.9:2"
    more = "--start follow-down --fill motions --transient 100 --evidence 60"
    result = call(*line.split(), *more.split(), "--save", file)
    assert result.exit_code == 0, result.stderr
    expected = ns.regime_map(
        ns.models.soft_impact(zeta=0.03),
        {"omega": np.linspace(0.8, 0.9, 3), "a": np.linspace(0.5, 0.9, 2)},
        start="follow down",
        fill="motions",
        transient=100,
        evidence=60,
    )
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load(), expected)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            [
                "regimes",
                "soft_impact",
                "--over",
                "a=0.7:0.8:99",
                "--over",
                "zeta=0.1:0.2:99",
                "--start",
                "on",
            ],
            "--start = 'on' is not one of restart, follow-up, follow-down",
        ),
        (["regimes", "soft_impact"], "--over"),
        (["regimes", "soft_impact", "--over", "omega=0.7:0.8:3"], "two different parameters"),
        (
            ["regimes", "soft_impact", "--over", "a=0.7:0.8:3", "--over", "a=0.7:0.9:3"],
            "two different parameters",
        ),
        (
            ["regimes", "soft_impact", "--over", "a=0.7:0.8", "--over", "zeta=0.1:0.2:3"],
            "name=first:last:count",
        ),
        (["regime", "chua"], "has no period"),
        (["regime", "soft_impact", "--record", "1"], "seen twice"),
        (["regime", "soft_impact", "--initial", "y=1"], "unknown state 'y'"),
        (["regime", "soft_impact", "--save", "a.csv"], "'.csv'"),
    ],
)
def test_wrong_use(call, arguments, message):
    result = call(*arguments)
    assert result.exit_code == 2
    assert message in result.stderr
