import pytest
import xarray as xr

import nonsmooth as ns


def test_summary_and_file(call, tmp_path):
    file, picture = tmp_path / "points.nc", tmp_path / "points.png"
    result = call(
        "section", "soft_impact", "omega=0.8", "--section", "v", "--direction", "-1",
        "--transient", "30", "--record", "25", "--initial", "x=0.1", "--save", file,
        "--plot", picture, "--draw", "phase,x", "--modes",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    points = ns.poincare_section(
        ns.models.soft_impact(omega=0.8), {"x": 0.1}, section="v", direction=-1, transient=30.0,
        record=25,
    )  # fmt: skip
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load(), points)
    assert picture.stat().st_size > 1000
    assert "points       25 of 25" in result.stdout
    assert "certified    yes" in result.stdout
    assert f"x = {float(points['x'][-1]):.7g}" in result.stdout


def test_events_of_a_model(call, accumulating):
    result = call("section", "ball", "--section", "h", "--t-end", "2", "--direction", "0")
    assert result.exit_code == 1
    assert "nothing crosses section = 'h' in either direction" in result.stdout
    result = call("section", "ball", "--section", "flight", "--side", "after")
    assert result.exit_code == 1
    assert "event_limit" in result.stdout


@pytest.mark.slow
@pytest.mark.parametrize("more", [[], ["--json"], ["--t-end", "50"]])
def test_a_section_that_is_never_crossed_is_no_success(call, tmp_path, more):
    """Orbits of this oscillator stay within a few units of its wells."""
    file, picture = tmp_path / "points.nc", tmp_path / "points.png"
    result = call(
        "section", "duffing", "--section", "x-100", "--transient", "1", "--record", "3",
        "--save", file, "--plot", picture, *more,
    )  # fmt: skip
    assert result.exit_code == 1
    assert "nothing crosses section = 'x-100' upward" in result.stdout
    assert "there are no points to draw" in result.stderr
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        assert saved.sizes["point"] == 0
    assert not picture.exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--section", "w"], "unknown variable or event 'w'"),
        (["--section", "v", "--direction", "3"], "direction = 3"),
        (["--section", "v", "--draw", "x,v"], "--plot picture.png"),
        (["--section", "v", "--plot", "a.png", "--draw", "x"], "not two variables"),
        (["--section", "v", "--plot", "a.png", "--draw", "x,w"], "unknown variable 'w'"),
        (["--section", "v", "--plot", "a.gif"], "'.gif'"),
        (["--section", "v", "--save", "a.csv"], "'.csv'"),
        ([], "--section"),
    ],
)
def test_wrong_use(call, arguments, message):
    result = call("section", "duffing", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr
