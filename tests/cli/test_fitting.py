"""``nonsmooth fit``: a record in a file, ranges and sensors in the words of the shell."""

import json

import numpy as np
import pytest
import xarray as xr

RAMP = """
states = ["x"]
[parameters]
k = 1.0
[equations]
x = "k"
"""


@pytest.fixture
def ramp(tmp_path):
    """A straight line of slope 0.7, shown with the factor 2 and 0.5 more, and its system."""
    (tmp_path / "ramp.toml").write_text(RAMP)
    t = np.linspace(0.0, 4.0, 101)
    noise = 0.01 * np.random.default_rng(1).standard_normal(t.size)
    table = np.column_stack([t, 2.0 * (0.1 + 0.7 * t) + 0.5 + noise])
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header="t,ch1", comments="")
    return [tmp_path / "ramp.toml", tmp_path / "a.csv", "--observe", "ch1=x"]


def test_a_fit_from_a_file(call, ramp, tmp_path):
    result = call(
        "fit", *ramp, "--free", "k=0:2", "--gain", "ch1=2", "--channel-offset", "ch1=0.5",
        "--starts", "1", "--save", tmp_path / "f.nc", "--json",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    found = json.loads(result.stdout)
    (row,) = found["parameters"]
    assert row["interval_low"] < row["estimate"] < row["interval_high"]
    assert row["estimate"] == pytest.approx(0.7, abs=0.01)
    with xr.open_dataset(tmp_path / "f.nc", engine="h5netcdf") as saved:
        assert float(saved["estimate"][0]) == row["estimate"]


def test_a_record_in_netcdf(call, ramp, tmp_path):
    t = np.linspace(0.0, 4.0, 101)
    xr.Dataset({"ch1": ("time", 0.7 * t)}, {"time": t}).to_netcdf(
        tmp_path / "a.nc", engine="h5netcdf"
    )
    words = [ramp[0], tmp_path / "a.nc", *ramp[2:]]
    result = call("fit", *words, "--free", "k=0:2", "--noise", "ch1=0.1:1", "--starts", "1")
    assert result.exit_code == 0, result.stderr
    assert "k           0.7" in result.stdout


def test_several_records(call, ramp, tmp_path):
    """A second line of slope 0.9: shared, the slope lies between; by itself, each has its own."""
    t = np.linspace(0.0, 4.0, 101)
    noise = 0.01 * np.random.default_rng(2).standard_normal(t.size)
    table = np.column_stack([t, 0.4 + 0.9 * t + noise])
    np.savetxt(tmp_path / "b.csv", table, delimiter=",", header="t,ch1", comments="")
    words = [*ramp, "--more", f"late={tmp_path / 'b.csv'}", "--free", "k=0:2", "--starts", "1"]
    result = call("fit", *words, "--private", "k", "--json")
    assert result.exit_code == 0, result.stderr
    rows = json.loads(result.stdout)["parameters"]
    assert [row["parameter"] for row in rows] == ["a k", "late k"]
    # the first record shows its slope twice as large
    assert [row["estimate"] for row in rows] == pytest.approx([1.4, 0.9], abs=0.01)


def test_instants_beside_a_record(call, tmp_path):
    """A ball that falls from 1.2: the instant of a bounce says what its height does."""
    (tmp_path / "ball.toml").write_text(
        'states = ["x", "v"]\n[parameters]\ng = 9.81\nr = 0.9\n[modes.flight.flow]\nx = "v"\n'
        'v = "-g"\n[[modes.flight.exits]]\nguard = "x"\nname = "bounce"\nreset = { v = "-r*v" }\n'
    )
    first = np.sqrt(2.0 * 1.2 / 9.81)
    bounces = first + np.concatenate([[0.0], np.cumsum(2.0 * first * 0.8 ** np.arange(1, 5))])
    np.savetxt(tmp_path / "bounces.csv", bounces, header="instant", comments="")
    t = np.linspace(0.0, 0.45, 46)
    table = np.column_stack([t, 1.2 - 0.5 * 9.81 * t**2])
    np.savetxt(tmp_path / "fall.csv", table, delimiter=",", header="t,x", comments="")
    result = call(
        "fit", tmp_path / "ball.toml", tmp_path / "fall.csv", "--observe", "x=x",
        "--events", f"hit={tmp_path / 'bounces.csv'}", "--observe", "hit=bounce", "--free",
        "r=0.5:0.95", "--initial", "x=1.2", "--noise", "x=0.001", "--noise", "hit=0.001",
        "--hold-back", "0", "--json",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    (row,) = json.loads(result.stdout)["parameters"]
    assert row["estimate"] == pytest.approx(0.8, abs=1e-3)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--free", "q=0:1"], "--free: unknown parameter 'q' (known: k)"),
        (["--free", "k=0.5"], "--free: 'k=0.5' is not of the form name=low:high"),
        (["--free", "k=0:1", "--gain", "y=1"], "--gain: unknown channel 'y'"),
        (["--free", "k=0:1", "--delay", "ch1=free"], "give a number or (low, high)"),
        (["--free", "k=0:1", "--more", "a=b.csv"], "--more: a is the name of RECORD"),
        (["--free", "k=0:1", "--by-record", "k=1"], "is not of the form record.parameter"),
        (["--free", "k=0:1", "--shift", "1:0"], "--shift"),
        (["--free", "k=0:1", "--private", "k"], "--private: there is one record"),
        (["--free", "k=0:1", "--store", "a"], "--store keeps draws of a posterior: give"),
        (["--free", "k=0:1", "--posterior", "3"], "--posterior = 3 must be a whole number of at"),
        (
            ["--free", "k=0:1", "--plot", "a.png", "--draw", "corner", "--channel", "ch1"],
            "--channel is that of samples or spectra, not of --draw corner",
        ),
    ],
)
def test_wrong_words(call, ramp, more, said):
    result = call("fit", *ramp, *more)
    assert result.exit_code == 2
    assert said in result.stderr


@pytest.mark.parametrize("draw", ["fit", "profiles", "corner", "spectra"])
def test_every_picture_is_drawn(call, ramp, tmp_path, draw):
    picture = tmp_path / "fit.png"
    result = call(
        "fit", *ramp, "--free", "k=0:2", "--gain", "ch1=2", "--channel-offset", "ch1=0.5",
        "--starts", "1", "--plot", picture, "--draw", draw,
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_posterior_beside_the_fit(call, ramp, tmp_path):
    words = ["fit", *ramp, "--free", "k=0:2", "--gain", "ch1=2", "--channel-offset", "ch1=0.5",
             "--starts", "1", "--segments", "1", "--store", tmp_path / "chain"]  # fmt: skip
    result = call(*words, "--posterior", "15")
    assert result.exit_code == 1  # the chain is too short
    assert "give --posterior" in result.stdout
    result = call(*words, "--posterior", "200", "--json", "--plot", tmp_path / "a.png",
                  "--draw", "corner")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    found = json.loads(result.stdout)
    assert found["posterior"] == "completed"
    (row, noise) = found["posterior_parameters"]
    (known,) = found["parameters"]
    # 100 samples: t and normal distribution are alike; of 500 independent draws the ends of an
    # interval are known to 5 % of its width
    width = known["interval_high"] - known["interval_low"]
    assert row["interval_low"] == pytest.approx(known["interval_low"], abs=0.2 * width)
    assert noise["parameter"] == "ch1 noise"
