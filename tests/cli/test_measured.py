import json

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns

RATE = 2000.0


@pytest.fixture
def files(tmp_path):
    """Three records of a harmonic motion in V with a pulse per revolution."""
    found = []
    for k, speed in enumerate((90.0, 100.0, 120.0)):
        t = np.arange(4000) / RATE
        table = np.column_stack(
            [t, 1.0 + 8.0 * np.cos(speed * t), 2 * np.sin(speed * t), np.cos(speed * t - 0.4)]
        )
        path = tmp_path / f"run{k}.csv"
        np.savetxt(path, table, fmt="%.7f", delimiter=",", header="t,a,b,key", comments="")
        found.append(path)
    return found


def test_a_section(call, files, tmp_path):
    picture, file = tmp_path / "s.png", tmp_path / "s.nc"
    result = call(
        "measured", files[0], "--columns", "x=a,y=b", "--mark", "key", "--sensitivity", "8",
        "--offset", "1", "--units", "mm", "--length", "0.5", "--natural-frequency", "2*pi*10",
        "--threshold", "0.1", "--highest", "1.5", "--draw", "x,vy", "--transient", "2",
        "--plot", picture, "--save", file,
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert "speed" in result.stdout and "gain" in result.stdout
    assert picture.stat().st_size > 1000
    probe = {"sensitivity": 8.0, "offset": 1.0, "units": "mm"}
    record = ns.measured.read_csv(
        files[0],
        {"x": ns.measured.Channel("a", **probe), "y": ns.measured.Channel("b", **probe)},
        mark="key",
        threshold=0.1,
    )
    record = ns.measured.dimensionless(record, length=0.5, natural_frequency=2 * np.pi * 10)
    points = ns.measured.section(ns.measured.velocities(record, highest=1.5), transient=2)
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load().drop_indexes("point"), points)
    # in closed form: the pulse rises through 0.1 at the phase 0.4 - arccos(0.1)
    np.testing.assert_allclose(points["x"], 2 * np.cos(0.4 - np.arccos(0.1)), atol=1e-3)


def test_accelerations_are_integrated(call, files, tmp_path):
    """-A w^2 cos w t gives A cos w t; the marks are those of the pulse."""
    file, speed = tmp_path / "s.nc", 90.0
    t = np.arange(8000) / RATE
    table = np.column_stack([t, -3e3 * np.cos(speed * t) + 5e3, np.cos(speed * t - 0.4)])
    path = tmp_path / "accelerations.csv"
    np.savetxt(path, table, fmt="%.7f", delimiter=",", header="t,a [mm/s^2],key", comments="")
    result = call(
        "measured", path, "--columns", "x=a", "--mark", "key", "--low-pass", "300", "--lowest", "6",
        "--save", file,
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert "integrated, right to 0.01 from the frequency 6 on" in result.stdout
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        assert saved["x"].attrs["units"] == "mm" and saved["vx"].attrs["units"] == "mm/s"
        height = 3e3 / speed**2
        np.testing.assert_allclose(saved["x"], height * np.cos(0.4 - np.pi / 2), atol=0.01 * height)
        kept = saved["time"].values
    # the pulse rises through zero at 0.4 - pi/2, from the first whole turn on
    marks = (0.4 - np.pi / 2 + 2 * np.pi * np.arange(1, 58)) / speed
    assert marks[-1] < t[-1] < marks[-1] + 2 * np.pi / speed
    lost = marks.size - kept.size
    assert f"{kept.size} of {marks.size} marks; {lost} lie in the ends that" in result.stdout
    for options, words in (
        (("--lowest", "6", "--highest", "50"), "--low-pass"),
        (("--low-pass", "2000"), "below half the sample rate, 1000"),
    ):
        result = call("measured", path, "--columns", "x=a", "--mark", "key", *options)
        assert result.exit_code == 2 and words in result.stderr


@pytest.mark.slow
def test_a_record_without_marks(call, files, tmp_path):
    """Integrated, or as it is; what is taken once per revolution asks for marks."""
    file, picture = tmp_path / "s.nc", tmp_path / "s.png"
    t = np.arange(8000) / RATE
    table = np.column_stack([t, -30.0 * np.cos(90.0 * t)])
    path = tmp_path / "accelerations.csv"
    np.savetxt(path, table, fmt="%.7f", delimiter=",", header="t,a [m/s^2]", comments="")
    arguments = ["measured", path, "--columns", "x=a"]
    result = call(*arguments, "--lowest", "6", "--save", file, "--plot", picture)
    assert result.exit_code == 0, result.stderr
    assert "no marks" in result.stdout and "integrated" in result.stdout
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        assert saved["x"].attrs["units"] == "m"
        truth = 30.0 / 90.0**2 * np.cos(90.0 * saved["time"])
        np.testing.assert_allclose(saved["x"], truth, atol=0.01 * 30.0 / 90.0**2)
    assert picture.stat().st_size > 1000
    for options in ((), ("--low-pass", "300"), ("--highest", "50", "--draw", "x,vx")):
        result = call(*arguments, *options, "--plot", picture)
        assert result.exit_code == 0, result.stderr
    for options, words in (
        (("--transient", "2"), "--transient is that of a section: name the column of --mark"),
        (("--phase", "0.5"), "--phase is that"),
        ((files[0],), "several files make a diagram"),
        (("--plot", picture, "--draw", "x,x,x"), "must name 1 or 2 of x"),
    ):
        result = call(*arguments, *options)
        assert result.exit_code == 2 and words in result.stderr


def test_a_diagram(call, files, tmp_path):
    picture, file = tmp_path / "d.pdf", tmp_path / "d.nc"
    result = call(
        "measured", *reversed(files), "--columns", "a", "--mark", "3", "--time", "0", "--edge",
        "falling", "--speed-unit", "rpm", "--plot", picture, "--draw", "va", "--save", file,
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert result.stdout.count("rpm") == 3
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        assert saved["parameter"].values == pytest.approx(
            np.array([90, 100, 120]) * 30 / np.pi, rel=1e-4
        )
    assert picture.stat().st_size > 1000


def test_a_dead_probe_is_told(call, tmp_path, files):
    dead = tmp_path / "dead.csv"
    table = np.loadtxt(files[0], delimiter=",", skiprows=1)
    table[:, 2] = 0.25
    np.savetxt(dead, table, fmt="%.7f", delimiter=",", header="t,a,b,key", comments="")
    result = call("measured", dead, "--columns", "x=a,y=b", "--mark", "key")
    assert result.exit_code == 0
    assert "y does not change" in result.stderr


@pytest.mark.parametrize("several", [False, True])
def test_points_of_flagged_samples_are_counted(call, files, several):
    """The probe stands still for a half of the record, so about half of its points are no good."""
    table = np.loadtxt(files[0], delimiter=",", skiprows=1)
    table[:, 1] += 0.01 * np.random.default_rng(1).standard_normal(len(table))
    table[2000:, 1] = table[2000, 1]
    np.savetxt(files[0], table, fmt="%.7f", delimiter=",", header="t,a,b,key", comments="")
    words = ["measured", *files[: 2 if several else 1], "--columns", "x=a", "--mark", "key"]
    told = json.loads(call(*words, "--json").stdout)
    told = told["records"][0] if several else told
    turn = 2 * np.pi / 90.0
    assert told["points_flagged"] == pytest.approx(1.0 / turn, abs=1.5)
    assert 2 * told["points_flagged"] == pytest.approx(told["points"], abs=3)
    said = f"{told['points_flagged']} of "
    said += "flagged" if several else f"{told['points']} points are made of flagged samples"
    assert said in call(*words).stdout


def test_a_record_counts_once(call, files):
    result = call("measured", *files, files[0], "--columns", "x=a", "--mark", "key")
    assert result.exit_code == 2
    assert f"records: '{files[0]}' is given twice" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--columns", "x=c", "--mark", "key"], "unknown column 'c'"),
        (["--columns", "x=a", "--mark", "b", "--time", "key"], "times must increase"),
        (["--columns", "x=a,x=b", "--mark", "key"], "'x' is given twice"),
        (["--columns", "x=", "--mark", "key"], "not of the form"),
        (["--columns", "", "--mark", "key"], "--columns: the text is empty"),
        (["--columns", "a", "--mark", "key", "--length", "2"], "together"),
        (["--columns", "a", "--mark", "key", "--draw", "a,va"], "--plot picture.png"),
        (["--columns", "a", "--mark", "key", "--speed-unit", "Hz"], "several files"),
        (["--columns", "a", "--mark", "key", "--plot", "a.gif"], "'.gif'"),
        (["--columns", "a", "--mark", "key", "--sensitivity", "2"], "units"),
        (["--columns", "a", "--mark", "key", "--plot", "a.png", "--draw", "a"], "name 2 of"),
        (["--columns", "a", "--mark", "key", "--plot", "a.png", "--draw", "a,q"], "'q'"),
        (["--columns", "a", "--mark", "key", "--highest", "990"], "times faster"),
        (
            ["--columns", "a", "--mark", "key", "--length", "1", "--natural-frequency", "w"],
            "'w' is not a number",
        ),
    ],
)
def test_wrong_use(call, files, arguments, message):
    result = call("measured", files[0], *arguments)
    assert result.exit_code == 2
    assert message in result.stderr


def test_no_file(call):
    result = call("measured", "nowhere.csv", "--columns", "x", "--mark", "key")
    assert result.exit_code == 2
    assert "nowhere.csv" in result.stderr


def test_a_cure_in_a_message_can_be_followed(call, files):
    lines = files[0].read_text().splitlines()
    lines[1000] = lines[1000].replace(",", ",nan,", 1).rpartition(",")[0]
    files[0].write_text("\n".join(lines))
    words = ["measured", files[0], "--columns", "x=a", "--mark", "key"]
    result = call(*words)
    assert result.exit_code == 2
    cure = result.stderr.split("without a gap is ")[1].split()
    assert cure[0] == "--time-range"
    result = call(*words, *cure)
    assert result.exit_code == 0, result.stderr


def test_where_velocities_come_from(call, files):
    result = call("measured", files[0], "--columns", "x=a", "--draw", "x,vx", "--plot", "a.png")
    assert result.exit_code == 2
    assert "--highest gives vx, the velocity of x" in result.stderr
