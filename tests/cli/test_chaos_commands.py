import re

import pytest
import xarray as xr

import nonsmooth as ns


def value(output: str, label: str) -> str:
    return re.search(rf"^  {label} +(.*)$", output, re.M).group(1)


def test_exponents(call, tmp_path):
    file, picture = tmp_path / "a.nc", tmp_path / "a.png"
    lengths = ["--transient", "60", "--record", "40"]
    result = call("lyapunov", "moling", "b=0.15", *lengths, "--save", file, "--plot", picture)
    assert result.exit_code == 0, result.stderr
    spectrum = ns.lyapunov_spectrum(ns.models.moling(b=0.15), {}, transient=60, record=40)
    assert value(result.stdout, "exponent 2").startswith("-0.0387962")
    assert value(result.stdout, "exponent 4") == "-inf per unit time"
    assert value(result.stdout, "dimension") == "1"
    assert value(result.stdout, "averaged over").startswith("time 2513.274, 40 periods, 160 events")
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load(), spectrum)
    assert picture.stat().st_size > 10_000


def test_some_exponents_and_a_start(call):
    result = call(
        "lyapunov", "soft_impact", "--record", "10", "--exponents", "1", "--initial", "x=0.5"
    )
    assert result.exit_code == 0, result.stderr
    assert "exponent 2" not in result.stdout and "sum" not in result.stdout
    assert "take a longer --record" in result.stdout


def test_an_early_end(call, accumulating):
    result = call("lyapunov", "ball", "--record", "50")
    assert result.exit_code == 1
    assert "impacts accumulate" in value(result.stdout, "status")


def test_spectrum(call, tmp_path):
    file, picture = tmp_path / "a.nc", tmp_path / "a.png"
    result = call(
        "spectrum", "moling", "--variable", "y", "--record", "20", "--save", file, "--plot", picture
    )
    assert result.exit_code == 0, result.stderr
    first = re.search(r"amplitude (.*), harmonic 1$", result.stdout, re.M).group(1)
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        amplitude = saved["amplitude"].swap_dims(frequency="harmonic").sel(harmonic=1)
        assert float(first) == float(f"{float(amplitude):.6g}") > 0.1
    assert picture.stat().st_size > 10_000


def test_the_spectrum_of_a_drifting_state_has_no_mean(call):
    """It is that of the motion less its progression; the mean of that is a matter of the start."""
    result = call("spectrum", "moling", "--variable", "v", "--record", "20", "--transient", "20")
    assert result.exit_code == 0, result.stderr
    assert value(result.stdout, "drift") == "the mean progression of v is taken off"
    assert "  mean " not in result.stdout


@pytest.mark.parametrize("variable", ["y", "y,v"])
def test_the_mean_has_its_sign(call, tmp_path, variable):
    """A dead load of -2 on a unit spring; the amplitude at zero is its size."""
    text = """states = ["y", "v"]
period = "2*pi"
[equations]
y = "v"
v = "cos(t) - v - y - 2"
"""
    (tmp_path / "loaded.toml").write_text(text)
    lengths = "--record", "10", "--transient", "60"
    result = call("spectrum", tmp_path / "loaded.toml", "--variable", variable, *lengths)
    assert result.exit_code == 0, result.stderr
    label = "mean" if variable == "y" else "mean of y"
    assert value(result.stdout, label) == "-2"


def test_spectrum_without_a_period(call):
    result = call(
        "spectrum", "chua", "--transient", "20", "--record", "100", "--samples-per-period", "10",
        "--window", "hann", "--segments", "4",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert value(result.stdout, "record") == "4 x 250 samples, window hann"
    assert "harmonic" not in result.stdout


def test_wrong_use(call, accumulating):
    assert call("spectrum", "moling", "--variable", "w").exit_code == 2
    assert call("spectrum", "moling", "--record", "0").exit_code == 2
    assert call("lyapunov", "moling", "--exponents", "9").exit_code == 2
    assert call("lyapunov", "moling", "--plot", "a.gif").exit_code == 2
    ended = call("spectrum", "ball")
    assert ended.exit_code == 1 and "impacts accumulate" in ended.stderr
