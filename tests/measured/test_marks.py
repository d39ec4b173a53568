import numpy as np
import pytest

import nonsmooth as ns
from measured import rigs
from nonsmooth.errors import OptionError

RATE = 5000.0
TIMES = np.arange(20_000) / RATE
MARKS = rigs.jittering_marks(55)
X = {"x": rigs.derivative(TIMES, 0)}


def record(**options):
    return ns.measured.from_arrays(X, times=TIMES, **options)


def test_edges_on_a_slope_are_exact():
    """A straight line between samples finds an edge that rises over several of them."""
    found = record(pulse=rigs.pulses(TIMES, MARKS, rise=12 / RATE))
    np.testing.assert_allclose(found["mark_time"], MARKS, atol=1e-12)
    assert found.attrs["mark_error"] < 1e-10


@pytest.mark.parametrize("bend", [0.3, 0.05])
def test_edges_that_bend_are_off_by_what_is_stated(bend):
    """Exponential edges of two to twelve samples, which a straight line cuts."""
    since = TIMES[:, None] - MARKS[None, :]
    time = bend * 40 / RATE
    start = time * np.log(2.0)  # an exponential passes the middle there
    rise = -np.expm1(-np.maximum(since + start, 0) / time)
    fall = np.where(since > 0.02, 1.0, 0.0)
    found = record(pulse=(rise * (1 - fall)).sum(axis=1))
    away = np.abs(found["mark_time"].values - MARKS).max()
    assert 0.02 * found.attrs["mark_error"] < away <= found.attrs["mark_error"] <= 1 / RATE


def test_falling_edges_and_other_levels():
    pulse = rigs.pulses(TIMES, MARKS, rise=12 / RATE)
    found = record(pulse=5.0 - pulse, edge="falling")
    np.testing.assert_allclose(found["mark_time"], MARKS, atol=1e-12)
    found = record(pulse=pulse, threshold=1.25, hysteresis=0.5)
    np.testing.assert_allclose(found["mark_time"], MARKS - 3 / RATE, atol=1e-12)


def test_edges_within_a_sample_are_off_by_what_is_stated():
    found = record(pulse=rigs.pulses(TIMES, MARKS, rise=1e-9))
    away = np.abs(found["mark_time"].values - MARKS)
    assert found.attrs["mark_error"] == pytest.approx(0.5 / RATE)
    assert 0.4 / RATE < away.max() <= found.attrs["mark_error"]


def test_noise_about_the_threshold_makes_no_marks():
    rng = np.random.default_rng(1)
    pulse = rigs.pulses(TIMES, MARKS, rise=40 / RATE, width=0.02) + rng.normal(0, 0.12, TIMES.size)
    with pytest.raises(OptionError, match="double one"):  # without a band there are many
        record(pulse=pulse, hysteresis=0.0)
    found = record(pulse=pulse)
    assert found.sizes["mark"] == MARKS.size
    # noise of 0.12 V on a slope of 5 V per 40 samples is one sample
    assert np.abs(found["mark_time"].values - MARKS).max() < 5 / RATE


def test_speed_and_spread():
    found = record(marks=MARKS)
    single = 2 * np.pi / np.diff(MARKS)
    mean = 2 * np.pi * 54 / (MARKS[-1] - MARKS[0])
    assert found.attrs["speed"] == pytest.approx(mean, rel=1e-12)
    assert found.attrs["speed_spread"] == pytest.approx(
        np.sqrt(((single - mean) ** 2).mean()), rel=1e-12
    )
    assert found.attrs["n_marks"] == 55


def test_bad_marks_are_named():
    extra = MARKS[20] + 0.02
    bad = np.sort(np.append(np.delete(MARKS, [7, 30, 31]), extra))
    with pytest.raises(OptionError) as told:
        record(marks=bad)
    text = str(told.value)
    assert f"a double one at t = {extra:.7g}" in text
    assert f"1 missing between t = {MARKS[6]:.7g} and {MARKS[8]:.7g}" in text
    assert f"2 missing between t = {MARKS[29]:.7g} and {MARKS[32]:.7g}" in text


@pytest.mark.parametrize("late", [0.002, 0.02, 0.03, 0.06])
def test_bad_marks_are_repaired(late):
    bad = np.sort(np.append(np.delete(MARKS, [7, 30, 31]), MARKS[20] + late))
    found = record(marks=bad, bad_marks="repair")
    assert found.attrs["n_repaired"] == 4
    kept = found["mark_time"].values
    assert kept.size == MARKS.size
    good = np.delete(np.arange(55), [7, 30, 31])
    np.testing.assert_array_equal(kept[good], MARKS[good])
    assert np.abs(kept - MARKS).max() < 0.02 * 2 * np.pi / rigs.SPEED


def test_a_run_up_is_no_fault():
    """Each revolution is a tenth shorter than the one before."""
    marks = 0.1 + np.cumsum(0.3 * 0.9 ** np.arange(12))
    assert record(marks=marks).sizes["mark"] == 12


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"threshold": 0.5}, "threshold= is about marks .* none came"),
        ({"bad_marks": "repair"}, "bad_marks= is about marks"),
        ({"marks": MARKS, "pulse": X["x"]}, "either marks= or pulse="),
        ({"marks": []}, "no marks lie within"),
        ({"marks": MARKS[:2]}, "2 marks lie within"),
        ({"marks": MARKS + 100}, "no marks lie within"),
        ({"marks": MARKS[::-1]}, "marks must increase, and mark 1 at"),
        ({"marks": [[1.0, 2.0]]}, "one dimension"),
        ({"marks": "abc"}, "give the times"),
        ({"marks": [0.1, np.nan, 0.3]}, "finite"),
        ({"pulse": np.ones(TIMES.size)}, "is 1 throughout"),
        ({"pulse": np.ones(7)}, "pulse: 7 samples"),
        ({"pulse": np.where(TIMES > 1, np.nan, 0.0)}, "pulse: 14999 samples are not finite"),
        ({"pulse": X["x"], "threshold": 9.0}, "must lie within the mark channel"),
        ({"pulse": X["x"], "hysteresis": -1.0}, "must not be negative"),
        ({"pulse": X["x"], "edge": "up"}, "'rising' or 'falling'"),
        ({"marks": MARKS, "bad_marks": "drop"}, "'refuse' or 'repair'"),
        ({"marks": np.append(MARKS[:20], MARKS[20:28] + 0.4567)}, "missing between"),
    ],
)
def test_wrong_use(options, message):
    with pytest.raises(OptionError, match=message):
        record(**options)
