import re

import pytest
import xarray as xr

import nonsmooth as ns
from cli.test_chaos_commands import value


def row(output: str, number: int) -> list[str]:
    """Cells of a line of the table of attractors."""
    line = re.search(rf"^ {number} {{2,}}(.*)$", output, re.M).group(1)
    return re.split(r" {2,}", line.strip())


def test_table_file_and_picture(call, tmp_path):
    file, picture = tmp_path / "a.nc", tmp_path / "a.png"
    result = call(
        "attractors", "trilinear", "omega=2.5", "--over", "x=-2:2", "--over", "v=-3:6/2",
        "--starts", "40", "--seed", "3", "--save", file, "--plot", picture, "--draw", "v,x",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    expected = ns.attractors(
        ns.models.trilinear(omega=2.5), {"x": (-2, 2), "v": (-3, 3)}, samples=40, seed=3
    )
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load(), expected)
    assert picture.stat().st_size > 1000
    assert value(result.stdout, "starts") == "40" and value(result.stdout, "attractors") == "2"
    share, error = (float(expected[name][0]) for name in ("fraction", "fraction_error"))
    # the multiplier of two states of which zeta alone takes: exp(-zeta 2 pi/omega)
    point = ", ".join(f"{value:.3g}" for value in expected["points"].values[0, 0])
    told = ["periodic", "1", point, f"{share:.4g} +- {error:.1g}", "0.951", "free"]
    assert row(result.stdout, 1) == told
    # both have the period 1, and the points tell which is which
    assert "point (x, v)" in result.stdout and row(result.stdout, 2)[2] != point
    assert "exponent" not in result.stdout  # no attractor has one here


def test_a_completion_and_a_chaotic_set(call):
    result = call(
        "attractors", "moling", "a=0.3", "b=0.1", "xi=0.1", "omega=1.45", "--over", "p=-3:1",
        "--over", "y=-1:1", "--complete", "q=max(0, p - g)", "--starts", "60", "--record", "2000",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    kinds = re.findall(r"^ \d+ +(\w+)", result.stdout, re.M)
    assert kinds[-1] == "chaotic"
    last = row(result.stdout, len(kinds))
    assert float(last[3].partition(" ")[0]) == pytest.approx(0.38, abs=0.03)
    assert value(result.stdout, "exponents") == "per iterate" and "point (p, y, q)" in result.stdout
    assert last[1].count(",") == 2 and "e-1" not in result.stdout  # rounding is shown as zero


def test_maps(call):
    box = ["--over", "x=-2:2", "--starts", "16", "--record", "1000"]
    result = call("attractors", "chua", "alpha=8", *box, "--section", "y", "--over", "z=-2:2")
    assert row(result.stdout, 1)[:2] == ["periodic", "1"]
    result = call("attractors", "chua", "alpha=6", *box, "--period", "1", "--over", "z=-2:2")
    assert row(result.stdout, 1)[-1] == "left"  # a point of rest there
    once = call("attractors", "trilinear", *box, "--over", "v=-2:2")
    twice = call("attractors", "trilinear", *box, "--over", "v=-2:2", "--every", "2")
    sizes = [float(row(result.stdout, 1)[4]) for result in (once, twice)]
    assert sizes[1] == pytest.approx(sizes[0] ** 2, abs=2e-4)


def test_nothing_but_early_ends(call, accumulating):
    result = call("attractors", "ball", "--over", "h=0.5:1", "--period", "4", "--starts", "8")
    assert result.exit_code == 1
    assert "all starts ended early" in value(result.stdout, "status")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "--over"),
        (["--over", "x=0"], "name=low:high"),
        (["--over", "x=0:1:5"], "name=low:high"),
        (["--over", "x=0:1", "--over", "x=0:2"], "given twice"),
        (["--over", "x=1:1"], "empty range"),
        (["--over", "x=0:q"], "'q'"),
        (["--over", "w=0:1"], "unknown state 'w'"),
        (["--over", "x=0:1", "--complete", "v"], "of the form q=max(0,p-g)"),
        (["--over", "x=0:1", "--complete", "v=w + 1"], "'w'"),
        (["--over", "x=0:1", "--complete", "v=1 +"], "--complete: v"),
        (["--over", "x=0:1", "--starts", "0"], "--starts = 0"),
        (["--over", "x=0:1", "--direction", "1"], "--section"),
        (["--over", "x=0:1", "--section", "v", "--phase", "0.5"], "--phase"),
        (["--over", "x=0:1", "--every", "0"], "every"),
        (["--over", "x=0:1", "--period", "3"], "--period = 3 is no whole multiple of 2*pi/omega"),
        (["--over", "x=0:1", "--draw", "x,v"], "--plot picture.png"),
        (["--over", "x=0:1", "--plot", "a.png", "--draw", "x"], "not two states"),
        (["--over", "x=0:1", "--plot", "a.png", "--draw", "x,w"], "unknown state 'w'"),
        (["--over", "x=0:1", "--plot", "a.gif"], "'.gif'"),
    ],
)
def test_wrong_use(call, arguments, message):
    result = call("attractors", "duffing", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr


def test_a_system_without_a_period(call):
    result = call("attractors", "chua", "--over", "x=-1:1")
    assert result.exit_code == 2
    assert "chua has no period" in result.stderr and "--section" in result.stderr
