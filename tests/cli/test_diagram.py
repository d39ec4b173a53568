import json

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns


def test_summary_file_and_picture(call, tmp_path):
    file, picture = tmp_path / "d.nc", tmp_path / "d.pdf"
    result = call(
        "diagram", "soft_impact", "zeta=0.02", "--over", "omega=0.7:0.8:5", "--transient", "50",
        "--record", "20", "--save", file, "--plot", picture, "--draw", "v",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    expected = ns.bifurcation_diagram(
        ns.models.soft_impact(zeta=0.02), "omega", np.linspace(0.7, 0.8, 5), transient=50, record=20
    )
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load(), expected)
    assert picture.stat().st_size > 1000
    assert "5 values of omega, 1 initial state(s)" in result.stdout
    assert "5 completed" in result.stdout


def test_several_initial_states(call):
    result = call(
        "diagram", "soft_impact", "--over", "omega=0.7:0.8:3", "--transient", "5", "--record", "5",
        "--initial", "x=0.1", "--initial", "x=pi/10,v=1",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert "3 values of omega, 2 initial state(s)" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "--over"),
        (["--over", "omega=0.7:0.8"], "name=first:last:count"),
        (["--over", "omega"], "not of the form name=first:last:count"),
        (["--over", "omega=0.7:0.8:0"], "whole number"),
        (["--over", "q=0.7:0.8:5"], "unknown parameter 'q'"),
        (["--over", "omega=0.7:0.8:5", "--start", "follow"], "follow-up"),
        (["--over", "omega=0.7:0.8:5", "--draw", "x"], "--plot picture.png"),
        (["--over", "omega=0.7:0.8:5", "--plot", "a.png", "--draw", "w"], "unknown variable"),
        (["--over", "omega=0.7:0.8:5", "--save", "a.csv"], "'.csv'"),
        (["--over", "omega=0.7:0.8:5", "--initial", "y=1"], "unknown state 'y'"),
    ],
)
def test_wrong_use(call, arguments, message):
    result = call("diagram", "soft_impact", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr


def test_a_section_in_place_of_strobes(call):
    """Chua's circuit has no period; its return map has."""
    arguments = ["chua", "--over", "alpha=7.9:8.1:3", "--initial", "x=0.1", "--transient", "400"]
    result = call("diagram", *arguments, "--section", "y", "--record", "40")
    assert result.exit_code == 0, result.stderr
    assert "3 of period 1" in result.stdout
    result = call("diagram", *arguments, "--direction", "1")
    assert result.exit_code == 2 and "--section" in result.stderr


def test_an_interruption_is_told(call, monkeypatch, tmp_path):
    """Fewer columns than were asked for must not look like all; a picture of none is not drawn."""
    from nonsmooth.analysis import bifurcation_diagram as home

    real = home.bifurcation_diagram

    def interrupted(*arguments, **options):
        options.pop("store")
        found = real(*arguments, **options).isel(parameter=slice(0, 0))
        message = "interrupted by the user; 0 of 3 columns are done and kept"
        found.attrs |= {"status": "interrupted", "message": message}
        return found

    monkeypatch.setattr(home, "bifurcation_diagram", interrupted)
    picture, store = tmp_path / "d.png", tmp_path / "kept"
    words = ["diagram", "soft_impact", "--over", "omega=0.7:0.8:3", "--transient", "5"]
    result = call(*words, "--plot", picture)
    assert result.exit_code == 130
    assert "0 of 3 columns are done and kept" in result.stdout
    assert "name a folder by --store" in result.stdout
    assert not picture.exists()
    result = call(*words, "--store", store, "--json")
    told = json.loads(result.stdout)
    assert told["message"].startswith("interrupted by the user; 0 of 3")
    assert told["to_go_on"] == "repeat the command"


def test_why_values_are_refused(call):
    result = call(
        "diagram", "soft_impact", "--over", "zeta=-0.1:0.1:3", "--transient", "5", "--record", "5"
    )
    assert result.exit_code == 1
    assert "such as zeta = -0.1: zeta >= 0 is required" in result.stdout


def test_a_system_without_a_period(call):
    result = call("diagram", "chua", "--over", "alpha=7.9:8.1:3")
    assert result.exit_code == 2
    assert "take points on a section in place of strobes, such as --section" in result.stderr
