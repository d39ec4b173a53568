import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from measured import rigs
from nonsmooth.errors import OptionError

RATE = 5000.0
TIMES = 0.25 + np.arange(5_000) / RATE
MARKS = rigs.jittering_marks(30)
X = rigs.derivative(TIMES, 0)


def record(x=X, **options):
    return ns.measured.from_arrays({"x": x}, **{"times": TIMES, "marks": MARKS} | options)


def test_times_and_words():
    found = record(units="mm", labels={"x": "probe"}, name="rig")
    np.testing.assert_allclose(found["time"], TIMES, atol=1e-12)
    assert found["x"].attrs == {"long_name": "probe", "units": "mm"}
    assert found.attrs["sample_rate"] == pytest.approx(RATE)
    assert found.attrs["system_name"] == "rig"
    assert found["mark_time"].values.min() >= TIMES[0]


def test_rounded_times_are_put_on_the_even_grid():
    found = record(times=np.round(TIMES, 5))
    np.testing.assert_allclose(found["time"], TIMES, atol=1e-9)
    found = record(times=TIMES + np.where(np.arange(TIMES.size) % 2, 1e-5, -1e-5))
    np.testing.assert_allclose(found["time"], TIMES, atol=1e-8)
    assert found.attrs["time_off"] == pytest.approx(0.05, rel=1e-3)


def test_a_sample_rate_in_place_of_times():
    found = record(times=None, sample_rate=RATE)
    np.testing.assert_allclose(found["time"], TIMES - 0.25, atol=1e-12)


def test_a_part_without_a_gap():
    gap = X.copy()
    gap[1000:1010] = np.nan
    with pytest.raises(OptionError) as told:
        record(gap)
    text = str(told.value)
    assert "x: 10 samples are not finite, the first at t = 0.45" in text
    low, high = (float(v) for v in text.split("time_range=(")[1].rstrip(")").split(", "))
    found = record(gap, time_range=(low, high))
    np.testing.assert_array_equal(found["x"], X[1010:])
    assert found["time"].values[0] == pytest.approx(TIMES[1010])
    # a gap in the times does no harm either where it is left out
    lost = np.delete(np.arange(TIMES.size), np.arange(300, 320))
    found = ns.measured.from_arrays(
        {"x": X[lost]}, times=TIMES[lost], marks=MARKS, time_range=(TIMES[320], 9.0)
    )
    np.testing.assert_array_equal(found["x"], X[320:])
    rated = record(times=None, sample_rate=RATE, time_range=(0.1, 0.5))
    np.testing.assert_array_equal(rated["x"], X[500:2501])


def test_a_record_is_saved_whole(tmp_path):
    found = ns.measured.velocities(record(units="mm"))
    found.to_netcdf(tmp_path / "r.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "r.nc", engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load(), found)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"times": None}, "either the times="),
        ({"sample_rate": 3.0}, "either the times="),
        ({"times": None, "sample_rate": -1.0}, "must be positive"),
        ({"times": None, "sample_rate": "fast"}, "not a finite number"),
        ({"times": TIMES[:-1]}, "4999 times came for 5000 samples"),
        ({"times": TIMES[::-1]}, "sample 1 at 1.2496 follows 1.2498"),
        ({"times": np.round(TIMES, 3)}, "rounded too coarsely"),
        ({"times": np.where(np.arange(TIMES.size) == 9, np.nan, TIMES)}, "sample 9 .* no time"),
        ({"times": TIMES + 0.01 * (TIMES > 1)}, "after sample 3750 at 1, is 51 usual"),
        ({"times": TIMES**2}, "steps off an even grid"),
        ({"x": X[:3], "times": TIMES[:3]}, "3 samples are too few"),
        ({"x": np.where(TIMES > 1, np.inf, X)}, "1249 samples are not finite"),
        ({"x": "abc"}, "give numbers"),
        ({"x": np.zeros((3, 3))}, "one dimension"),
        ({"x": X + 1j}, "real samples"),
        ({"x": np.where(TIMES > 1, 1e38, X)}, r"1e\+38 at t = 1.0002 is beyond 1e\+30"),
        ({"units": 5}, "units= is a text"),
        ({"labels": "x"}, "labels= a mapping"),
        ({"time_range": (3, 4)}, "which covers 0.25 to 1.2498"),
        ({"time_range": (1, 0.5)}, "must run forward"),
        ({"time_range": "all"}, "give two times"),
    ],
)
def test_wrong_use(options, message):
    with pytest.raises(OptionError, match=message):
        record(**options)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "give arrays by name"),
        (X, "give arrays by name"),
        ({"x": X, "y": X[1:]}, "differ in their number"),
        ({"time": X}, "is taken"),
        ({"x y": X}, "cannot be the name"),
        ({3: X}, "cannot be the name"),
    ],
)
def test_wrong_displacements(given, message):
    with pytest.raises(OptionError, match=message):
        ns.measured.from_arrays(given, times=TIMES, marks=MARKS)
