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


@pytest.mark.slow
def test_a_record_that_begins_later_in_the_forcing(call, tmp_path):
    """x' = -k x + cos 2 (t + s) in closed form, begun 0.3 of a period late."""
    (tmp_path / "forced.toml").write_text(
        'states = ["x"]\nperiod = "pi"\n[parameters]\nk = 1.0\n[equations]\nx = "-k*x + cos(2*t)"\n'
    )
    t, late, k = np.arange(240) * np.pi / 60, 0.3 * np.pi, 1.3
    wave = (k * np.cos(2 * (t + late)) + 2 * np.sin(2 * (t + late))) / (k**2 + 4)
    x = wave + 0.8 * np.exp(-k * t) + 1e-3 * np.random.default_rng(5).standard_normal(t.size)
    np.savetxt(tmp_path / "a.csv", np.column_stack([t, x]), delimiter=",", header="t,x")
    words = ["fit", tmp_path / "forced.toml", tmp_path / "a.csv", "--columns", "x", "--json"]
    result = call(*words, "--free", "k=0.5:2", "--shift", "0:pi", "--starts", "2")
    assert result.exit_code == 0, result.stderr
    found = {row["parameter"]: row for row in json.loads(result.stdout)["parameters"]}
    for name, truth in (("k", k), ("shift", late)):
        # of noise of 1e-3 in 216 samples 1e-4 is left, over a change of about a half per unit
        assert found[name]["estimate"] == pytest.approx(truth, abs=2e-3)
        assert found[name]["interval_low"] < truth < found[name]["interval_high"]


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


@pytest.fixture
def flawed(ramp, tmp_path):
    """The same line; a nan, an empty cell and a spike are among its samples."""
    lines = (tmp_path / "a.csv").read_text().splitlines()
    for row, cell in ((21, "nan"), (22, ""), (23, ""), (61, "9.0")):
        lines[row] = lines[row].partition(",")[0] + "," + cell
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    known = ("--gain", "ch1=2", "--channel-offset", "ch1=0.5")
    return ["fit", *ramp, "--free", "k=0:2", *known, "--starts", "1"]


def test_a_wrong_parameter_is_told_before_flaws_of_the_record(call, flawed):
    result = call(*flawed, "--free", "q=0:1")
    assert result.exit_code == 2
    assert "unknown parameter 'q'" in result.stderr
    assert "no reading" not in result.stderr


def test_flaws_are_told_and_flawed_samples_left_out(call, flawed, tmp_path):
    """Of samples in steps of 0.04 those of 0.8 to 0.88 are missing, and 2.4 is a spike."""
    file = tmp_path / "f.nc"
    result = call(*flawed, "--save", file, "--json")
    assert result.exit_code == 3, result.stderr
    assert "a: ch1 has no reading from t = 0.8 to 0.88, 3 samples" in result.stderr
    assert "ch1" in result.stderr and "t = 2.4" in result.stderr
    found = json.loads(result.stdout)
    assert found["flaws"] == 2
    (row,) = found["parameters"]
    # a hundred samples with a standard deviation of 0.01 and the gain 2, over 4 units of time
    assert row["estimate"] == pytest.approx(0.7, abs=2e-3)
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        left_out = saved["time"].values[np.isnan(saved["residual"].values[0])]
    np.testing.assert_allclose(left_out, [0.8, 0.84, 0.88, 2.4])
    assert call(*flawed, "--accept-flaws").exit_code == 0
    # as a script does it, where nobody has looked for the spike
    assert call(*flawed, "--leave-out", "spike", "--json").stdout != result.stdout


@pytest.mark.slow
def test_a_fit_that_has_not_converged_is_told(call, ramp, tmp_path, monkeypatch):
    """The result is there, and there is nothing to draw a posterior from."""
    monkeypatch.setattr("nonsmooth.fitting.solver._CLOSED", 0.0)
    words = ["fit", *ramp, "--free", "k=0:2", "--starts", "1", "--save", tmp_path / "f.nc"]
    result = call(*words, "--posterior", "20")
    assert result.exit_code == 1
    assert "has not converged: segments do not join" in result.stderr
    assert "give narrower bounds in --free, more --starts" in result.stderr
    assert "not drawn, since the fit has not converged" in result.stdout
    assert (tmp_path / "f.nc").is_file()


def test_masks_of_a_netcdf_file_are_kept(call, ramp, tmp_path):
    """Nothing is wrong with the first samples but that somebody has flagged them."""
    t = np.linspace(0.0, 4.0, 101)
    x = 0.7 * t + 0.01 * np.random.default_rng(3).standard_normal(t.size)
    x[:20] += 0.5
    mask = ("time", (t < 0.79).astype(np.uint8), {"standard_name": "quality_flag"})
    record = xr.Dataset({"x": ("time", x)}, {"time": t, "x_quality": mask})
    record.to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    result = call("fit", ramp[0], tmp_path / "a.nc", "--free", "k=0:2", "--starts", "1", "--json")
    assert result.exit_code == 0, result.stderr
    (row,) = json.loads(result.stdout)["parameters"]
    assert row["estimate"] == pytest.approx(0.7, abs=0.01)


@pytest.mark.slow
def test_columns_of_two_words(call, ramp, tmp_path):
    text = (tmp_path / "a.csv").read_text().replace("t,ch1", "elapsed time [s],upper mass [mm]", 1)
    (tmp_path / "a.csv").write_text(text)
    words = ["fit", *ramp[:2], "--free", "k=0:2", "--starts", "1", "--time", "elapsed time"]
    words += ["--json"]
    known = ["--gain", "x=2", "--channel-offset", "x=0.5"]
    found = [
        call(*words, "--columns", columns, *more, *known)
        for columns, more in (
            ("x=upper mass", []), ("x=upper mass", ["--observe", "x=x"]), ("x=1", []),
        )
    ]  # fmt: skip
    assert [each.exit_code for each in found] == [0, 0, 0], found[0].stderr
    assert found[0].stdout == found[1].stdout == found[2].stdout
    assert json.loads(found[0].stdout)["channels"][0]["channel"] == "x"
    result = call(*words, "--observe", "upper mass=x")
    assert result.exit_code == 2
    assert "--columns 'a1=upper mass' --observe a1=x" in result.stderr
    result = call(*words, "--columns", "a1=upper mass")
    assert result.exit_code == 2
    assert "--observe does not say what the column a1 shows" in result.stderr


@pytest.fixture
def ball(tmp_path):
    """A ball that falls from 1.2, its bounces, and its height until the last of them.

    It rises with 0.8 of the velocity with which it fell, so flights are a geometric series.
    """
    (tmp_path / "ball.toml").write_text(
        'states = ["x", "v"]\n[parameters]\ng = 9.81\nr = 0.9\n[modes.flight.flow]\nx = "v"\n'
        'v = "-g"\n[[modes.flight.exits]]\nguard = "x"\nname = "bounce"\nreset = { v = "-r*v" }\n'
    )
    first = np.sqrt(2.0 * 1.2 / 9.81)
    bounces = first + np.concatenate([[0.0], np.cumsum(2.0 * first * 0.8 ** np.arange(1, 5))])
    t = np.arange(0.0, bounces[-1], 0.01)
    tops = 0.5 * (np.concatenate([[-first], bounces[:-1]]) + bounces)
    flight = np.searchsorted(bounces, t)
    peak = 0.5 * 9.81 * (bounces[flight] - tops[flight]) ** 2
    noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    table = np.column_stack([t, peak - 0.5 * 9.81 * (t - tops[flight]) ** 2 + noise])
    np.savetxt(tmp_path / "fall.csv", table, delimiter=",", header="t,x", comments="")
    np.savetxt(tmp_path / "bounces.csv", bounces, header="instant", comments="")
    return bounces


OF_A_BALL = ("--free", "r=0.5:0.95", "--initial", "x=1.2", "--hold-back", "0", "--json")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("header", "factor"), [("instant", 1.0), ("instant [ms]", 1e3), ("t_ms", 1e3)]
)
def test_instants_beside_a_record(call, ball, tmp_path, header, factor):
    """The instant of a bounce says what its height does, in the unit of its header."""
    np.savetxt(tmp_path / "bounces.csv", factor * ball, header=header, comments="")
    result = call(
        "fit", tmp_path / "ball.toml", tmp_path / "fall.csv", "--observe", "x=x",
        "--events", f"hit={tmp_path / 'bounces.csv'}", "--observe", "hit=bounce",
        "--noise", "x=0.001", "--noise", "hit=0.001", *OF_A_BALL,
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    (row,) = json.loads(result.stdout)["parameters"]
    assert row["estimate"] == pytest.approx(0.8, abs=1e-3)


@pytest.mark.parametrize("observe", [("--observe", "hit=bounce"), ()])
def test_instants_alone(call, ball, tmp_path, observe):
    """Their file is RECORD; what is called like an event shows it."""
    name, file = "hit" if observe else "bounce", tmp_path / "bounces.csv"
    words = ["fit", tmp_path / "ball.toml", file, "--events", f"{name}={file}", *observe]
    result = call(*words, "--noise", f"{name}=0.001", *OF_A_BALL)
    assert result.exit_code == 0, result.stderr
    (row,) = json.loads(result.stdout)["parameters"]
    assert row["estimate"] == pytest.approx(0.8, abs=1e-3)


@pytest.mark.slow
def test_instants_within_the_part_that_is_kept(call, ball, tmp_path):
    words = ["fit", tmp_path / "ball.toml", tmp_path / "fall.csv", "--observe", "x=x"]
    words += ["--events", f"bounce={tmp_path / 'bounces.csv'}", "--noise", "x=0.001"]
    words += ["--noise", "bounce=0.001", *OF_A_BALL, "--time-range", f"0,{ball[3] + 0.05}"]
    result = call(*words, "--save", tmp_path / "f.nc")
    assert result.exit_code == 0, result.stderr
    with xr.open_dataset(tmp_path / "f.nc", engine="h5netcdf") as saved:
        np.testing.assert_allclose(saved["picked_measured"], ball[:4])


def test_instants_that_cannot_be_fitted(call, ball, tmp_path):
    file = tmp_path / "bounces.csv"
    alone = ["fit", tmp_path / "ball.toml", tmp_path / "fall.csv", *OF_A_BALL]
    words = [*alone, "--observe", "x=x"]
    for given, said in (
        ((*words, "--events", f"hit={file}"), "--observe does not say what the instants hit shows"),
        ((*alone, "--events", f"bounce={file}"), "to fit the instants of --events alone, give"),
    ):
        result = call(*given)
        assert result.exit_code == 2 and said in result.stderr, result.stderr
    ranges = f"from {1e3 * ball[0]:.6g} to {1e3 * ball[-1]:.6g}, the samples from "
    for header, said in (
        ("instant", "5 of 5 instants lie outside"), ("instant", ranges), ("instant", " to 2.83;"),
        ("t [min]", "times are in 'min', known are s, ms and us"),
        ("t_min", "times are in 'min', known are s, ms and us"),
    ):  # fmt: skip
        np.savetxt(file, 1e3 * ball, header=header, comments="")
        result = call(*words, "--events", f"bounce={file}")
        assert result.exit_code == 2 and said in result.stderr, result.stderr


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--free", "q=0:1"], "--free: unknown parameter 'q' (known: k)"),
        (["--free", "k=0:1", "--free", "k=0:2"], "--free: 'k' is given twice"),
        (["--free", "k=0.5"], "--free: 'k=0.5' is not of the form name=low:high"),
        (["--free", "k=0:1", "--gain", "y=1"], "--gain: unknown channel 'y'"),
        (["--free", "k=0:1", "--delay", "ch1=free"], "give a number or low:high"),
        (["--free", "k=0:1", "--more", "a=b.csv"], "--more: a is the name of RECORD"),
        (["--free", "k=0:1", "--by-record", "k=1"], "is not of the form record.name=value"),
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


def test_a_record_counts_once(call, ramp):
    result = call("fit", *ramp, "--free", "k=0:1", "--more", f"b={ramp[1]}")
    assert result.exit_code == 2
    assert f"--more: '{ramp[1]}' is given twice" in result.stderr


@pytest.mark.few(1)
@pytest.mark.parametrize("draw", ["fit", "profiles", "corner", "spectra"])
def test_every_picture_is_drawn(call, ramp, tmp_path, draw):
    picture = tmp_path / "fit.png"
    result = call(
        "fit", *ramp, "--free", "k=0:2", "--gain", "ch1=2", "--channel-offset", "ch1=0.5",
        "--starts", "1", "--plot", picture, "--draw", draw,
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
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
