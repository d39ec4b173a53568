"""What commands say of a record with flaws, and how they end."""

import json

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns

RATE, SPEED = 2000.0, 90.0  # samples per s, rad/s


@pytest.fixture
def file(tmp_path):
    """A record in V with a clipped channel, a spike and two missing readings."""
    rng = np.random.default_rng(0)
    t = np.arange(6000) / RATE
    a = 2 * np.cos(SPEED * t) + rng.normal(0, 0.01, t.size)
    b = np.minimum(np.sin(SPEED * t) + rng.normal(0, 0.01, t.size), 0.8)
    a[3001] += 0.7
    table = np.column_stack([t, np.round(a, 3), np.round(b, 3), np.cos(SPEED * t - 0.4)])
    path = tmp_path / "run.csv"
    np.savetxt(path, table, fmt="%.7f", delimiter=",", header="t,a [V],b [V],key", comments="")
    return path


def test_a_check_names_each_flaw(call, file, tmp_path):
    picture, saved = tmp_path / "q.png", tmp_path / "q.nc"
    words = ["check", file, "--columns", "x=a,y=b", "--mark", "key"]
    result = call(*words, "--plot", picture, "--save", saved)
    assert result.exit_code == 3
    assert len(result.stderr.splitlines()) == 2
    assert "nonsmooth: run: x has a spike of" in result.stderr
    assert "nonsmooth: run: y is clipped at 0.8 V" in result.stderr
    assert picture.stat().st_size > 1000
    with xr.open_dataset(saved, engine="h5netcdf") as found:
        assert found["kind"].values.tolist() == ["clipped", "spike"]
        assert np.flatnonzero(found["x_quality"]).tolist() == [3001]
    result = call(*words, "--json", "--accept-flaws")
    assert result.exit_code == 0
    told = json.loads(result.stdout)
    assert [one["kind"] for one in told["findings"]] == ["clipped", "spike"]
    assert told["findings"][1]["begin"] == pytest.approx(3001 / RATE)
    assert told["channels"]["x"]["bad_samples"] == 1 and "spike" in told["findings"][1]["sentence"]
    assert call(*words, "--leave-out", "clipped,spike").exit_code == 0
    assert call(*words, "--leave-out", "spikes").exit_code == 2
    assert call(*words, "--plot", picture, "--draw", "z", "--mains", "50").exit_code == 2


def test_a_clean_record(call, file, tmp_path):
    t = np.arange(6000) / RATE
    clean = np.round(np.cos(SPEED * t) + np.random.default_rng(1).normal(0, 0.01, t.size), 3)
    path = tmp_path / "clean.csv"
    np.savetxt(path, np.column_stack([t, clean]), fmt="%.4f", delimiter=",", header="t,a")
    result = call("check", path, "--columns", "a", "--plot", tmp_path / "clean.svg")
    assert result.exit_code == 0 and result.stderr == ""
    assert "0, 0 of them doubtful" in result.stdout


def test_what_reading_refuses_is_told(call, file):
    lines = file.read_text().splitlines()
    lines[1000] = lines[1000].replace(",", ",nan,", 1).rpartition(",")[0]
    del lines[2000:2005]
    file.write_text("\n".join(lines))
    words = [file, "--columns", "x=a", "--mark", "key"]
    assert call("measured", *words).exit_code == 2
    result = call("check", *words)
    assert result.exit_code == 3
    assert "x has no reading from t = 0.4995" in result.stderr
    assert "about 5 samples are missing" in result.stderr


@pytest.mark.slow
def test_a_section_of_a_record_with_flaws(call, file, tmp_path):
    """Files are written, the flaws are in them, and the code says that there are some."""
    saved = tmp_path / "s.nc"
    words = ["measured", file, "--columns", "x=a,y=b", "--mark", "key", "--save", saved]
    result = call(*words)
    assert result.exit_code == 3 and "y is clipped" in result.stderr
    with xr.open_dataset(saved, engine="h5netcdf") as points:
        assert points["y_quality"].dims == ("point",)
        assert set(np.unique(points["x_quality"])) <= {0, 8}
    assert call(*words, "--accept-flaws").exit_code == 0


def test_a_frozen_accelerometer(call, tmp_path):
    """Half the range of the displacement came out ten times too large, with exit code 0."""
    t = np.arange(20_000) / 5000
    rate = 2 * np.pi * 19.15
    a = -3.45 * rate**2 * np.cos(rate * t) + np.random.default_rng(0).normal(0, 100, t.size)
    a[8100:10100] = a[8100]
    path = tmp_path / "frozen.csv"
    np.savetxt(path, np.column_stack([t, a]), fmt="%.4f", delimiter=",", header="t,a [mm/s^2]")
    saved = tmp_path / "s.nc"
    result = call("measured", path, "--columns", "z=a", "--lowest", "8", "--save", saved)
    assert result.exit_code == 3
    assert "stands still at" in result.stderr and "from t = 1.62 to 2.0198" in result.stderr
    with xr.open_dataset(saved, engine="h5netcdf") as found:
        good = found["z"].where(found["z_quality"] == 0)
        assert 0.5 * float(good.max() - good.min()) == pytest.approx(3.45, rel=0.05)


def test_drift_that_is_integrated_away_is_no_flaw(call, tmp_path):
    t = np.arange(20_000) / 5000
    a = -3e3 * np.cos(90 * t) + np.random.default_rng(0).normal(0, 10, t.size) + 800 * t
    path = tmp_path / "drift.csv"
    np.savetxt(path, np.column_stack([t, a]), fmt="%.4f", delimiter=",", header="t,a [mm/s^2]")
    assert "the mean of a moves" in call("check", path, "--columns", "a").stderr
    assert call("measured", path, "--columns", "a", "--lowest", "8").exit_code == 0


def test_each_column_has_its_own_calibration(call, file, tmp_path):
    saved = tmp_path / "s.nc"
    call(
        "measured", file, "--columns", "x=a,y=b", "--sensitivity", "x=8,y=-0.5", "--offset",
        "y=0.25", "--units", "x=mm,y=um", "--highest", "60", "--save", saved,
    )  # fmt: skip
    probes = {
        "x": ns.measured.Channel("a", sensitivity=8.0, units="mm"),
        "y": ns.measured.Channel("b", sensitivity=-0.5, offset=0.25, units="um"),
    }
    record = ns.measured.velocities(ns.measured.read_csv(file, probes), highest=60)
    with xr.open_dataset(saved, engine="h5netcdf") as found:
        np.testing.assert_array_equal(found["y"], record["y"])
        np.testing.assert_array_equal(found["vx"], record["vx"])
        assert (found["x"].attrs["units"], found["y"].attrs["units"]) == ("mm", "um")
    result = call("check", file, "--columns", "x=a", "--offset", "z=1")
    assert result.exit_code == 2 and "--offset: unknown name 'z'" in result.stderr
    result = call("check", file, "--columns", "x=a", "--sensitivity", "x=much")
    assert result.exit_code == 2 and "--sensitivity" in result.stderr


def test_rows_from_the_last_to_the_first_are_not_evened_out(call, file):
    lines = file.read_text().splitlines()
    file.write_text("\n".join([lines[0], *lines[:0:-1]]))
    result = call("check", file, "--columns", "x=a")
    assert result.exit_code == 2
    assert "most samples are earlier than the one before" in result.stderr
