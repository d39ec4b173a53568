"""An alarm from the shell: what is told of its rate, where the first alarm is, and wrong use."""

import json

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from cli.test_options import write_days

READING = ["--columns", "x=CH1", "--mark", "KEY"]


@pytest.fixture
def days(tmp_path):
    return write_days(tmp_path)


def test_a_second_harmonic_raises_an_alarm(call, days, tmp_path):
    monday, tuesday, today = days
    saved, picture = tmp_path / "alarm.nc", tmp_path / "alarm.png"
    words = ["alarm", monday, tuesday, "--watched", today, *READING, "--rate", "0.1",
             "--indicators", "x_harmonic_2,x_rms", "--needed", "2", "--among", "2",
             "--periods", "12", "--most-period", "4"]  # fmt: skip
    result = call(*words, "--save", saved, "--plot", picture)
    assert result.exit_code == 0, result.output
    assert "x_harmonic_2 leads" in result.stdout and "rate of alarms" in result.stdout
    assert picture.stat().st_size > 1000
    told = json.loads(call(*words, "--json").stdout)
    with xr.open_dataset(saved, engine="h5netcdf") as found:
        assert told["first_alarm"] == int(found["first_alarm"])
        first = float(found["first_alarm_time"])
        turn = 2 * np.pi / 90
        # of the window that ends first behind 6 s and of the next one, whose second half at least
        # has the harmonic
        assert 6.0 < first < 6.0 + 3 * 12 * turn
        assert told["rate_low"] < told["rate_expected"] < told["rate_high"]
        np.testing.assert_allclose(told["threshold"], found["threshold"])
    # people count windows from 1, programs from 0
    assert f"window {told['first_alarm'] + 1} of {told['watched_windows']}," in result.stdout
    rows = told["windows_with_an_alarm"]
    assert len(rows) == told["alarms"] and rows[0]["leading"] == "x_harmonic_2"
    assert rows[0]["file"] == str(today)


def test_indicators_of_a_script_are_taken_as_they_are(call, days, tmp_path):
    rng, files = np.random.default_rng(1), []
    for name, size in (("healthy", 200), ("watched", 20)):
        found = xr.Dataset({"stiffness": ("window", rng.normal(size=size))})
        files.append(tmp_path / f"{name}.nc")
        found.to_netcdf(files[-1], engine="h5netcdf")
    result = call("alarm", files[0], "--watched", files[1], "--rate", "0.05", "--json")
    told = json.loads(result.stdout)
    assert result.exit_code == 0 and told["watched_windows"] == 20
    assert told["indicators"] == "stiffness"


def test_flaws_are_told_and_give_their_code(call, days):
    lines = days[2].read_text().splitlines()
    for k in range(2000, 2400):
        lines[k] = f"{lines[k].split(',')[0]},0.5,{lines[k].split(',')[2]}"
    days[2].write_text("\n".join(lines))
    words = ["alarm", *days[:2], "--watched", days[2], *READING, "--rate", "0.1"]
    result = call(*words)
    assert result.exit_code == 3 and "stands still" in result.stderr
    assert "windows are left out" in result.stderr
    assert call(*words, "--accept-flaws").exit_code == 0


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--plot", "a.png"], "--plot draws watched windows"),
        (["--contact-range", "x=1:2", "--contact-range", "x=3:4"], "'x' is given twice"),
        (["--contact-range", "x=1"], "is not of the form name=low:high"),
        (["--contact-range", "y=1:"], "unknown variable 'y'"),
        (["--indicators", "x_har"], "did you mean 'x_harmonic_1'?"),
        (["--indicators", "x_fourth"], "--indicators: unknown indicator 'x_fourth'"),
        (["--training", "0.5"], "--training is for one healthy record"),
        (["--rate", "0.001"], "support no rate below"),
        (["--period", "0.07"], "is for a record without marks"),
    ],
)
def test_wrong_use_is_refused(call, days, more, message):
    result = call("alarm", *days[:2], *READING, *more)
    assert result.exit_code == 2 and message in result.stderr, result.stderr


@pytest.mark.parametrize(
    ("healthy", "watched", "where", "twice"),
    [((0, 1, 0), (2,), "healthy records", 0), ((0, 1), (2, 2), "--watched", 2)],
)
def test_a_record_counts_once(call, days, healthy, watched, where, twice):
    more = [word for k in watched for word in ("--watched", days[k])]
    result = call("alarm", *(days[k] for k in healthy), *more, *READING)
    assert result.exit_code == 2 and "is given twice" in result.stderr
    assert f"{where}: '{days[twice]}'" in result.stderr


def test_columns_are_wanted_of_a_text_file(call, days):
    result = call("alarm", days[0], "--mark", "KEY")
    assert result.exit_code == 2 and "--columns: name the columns" in result.stderr


def test_contact_from_the_shell(call, days):
    """The share of a cosine above a half is a third."""
    words = ["alarm", *days[:2], *READING, "--contact-range", "x=0.5:", "--rate", "0.2", "--json"]
    assert "x_contact" in json.loads(call(*words).stdout)["indicators"]
    record = ns.measured.read_csv(days[0], {"x": "CH1"}, mark="KEY")
    share = ns.measured.indicators(record, contact={"x": (0.5, np.inf)})["x_contact"]
    # noise of 0.05 and samples every 0.225 rad blur the ends of it evenly; 667 samples a window
    np.testing.assert_allclose(share, 1 / 3, atol=0.02)
