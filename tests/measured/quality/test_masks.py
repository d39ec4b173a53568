"""Masks go on through all that is made of a record; turns are not invented."""

import numpy as np
import pytest

import nonsmooth as ns

RATE, SPEED = 5000.0, 19.15
AMPLITUDE = 3.45  # mm


def accelerations(frozen=False, count=20_000):
    """Acceleration of a harmonic motion in mm/s^2, with noise; frozen for 0.4 s."""
    t = np.arange(count) / RATE
    rate = 2 * np.pi * SPEED
    a = -AMPLITUDE * rate**2 * np.cos(rate * t) + np.random.default_rng(0).normal(0, 100, count)
    a = np.round(a)
    if frozen:
        first = int(np.argmax(a[8000:8260])) + 8000
        a[first : first + 2000] = a[first]
    marks = np.arange(int(t[-1] * SPEED)) / SPEED
    return ns.measured.from_arrays({"a": a}, times=t, marks=marks, units="mm/s^2")


def half_range(values):
    return 0.5 * float(values.max() - values.min())


def test_a_channel_that_froze_for_a_moment():
    """Ten times the true half range came of it; the mask leaves the true one."""
    found = ns.measured.displacements(accelerations(), {"a": "x"}, lowest=8)
    assert half_range(found["x"]) == pytest.approx(AMPLITUDE, rel=0.02)
    record = accelerations(frozen=True)
    plain = ns.measured.displacements(record, {"a": "x"}, lowest=8)
    assert half_range(plain["x"]) > 5 * AMPLITUDE
    kept = ns.measured.displacements(ns.measured.flagged(record), {"a": "x"}, lowest=8)
    good = kept["x"].where(kept["x_quality"] == 0)
    # the flaw does not move the line that is taken out of the reading, so the rest is nearer
    true = AMPLITUDE * np.cos(2 * np.pi * SPEED * kept["time"])
    left, right = (
        float(abs(x.where(good.notnull()) - true).max()) for x in (kept["x"], plain["x"])
    )
    assert left < 0.05 * AMPLITUDE and left < 0.5 * right
    # a ten-thousandth is left of the hundreds of mm that the integral of the largest value is off
    assert half_range(good) == pytest.approx(AMPLITUDE, rel=0.05)
    assert 0.2 < float((kept["x_quality"] == 0).mean()) < 0.9
    assert "a_quality" not in kept.coords and "vx_quality" in kept.coords
    assert kept["x"].attrs["ancillary_variables"] == "x_quality"


@pytest.mark.slow
def test_with_a_period_flagged_samples_are_left_out_of_the_fit():
    record = accelerations(frozen=True)
    plain = ns.measured.displacements(record, {"a": "x"}, period=1 / SPEED)
    kept = ns.measured.displacements(ns.measured.flagged(record), {"a": "x"}, period=1 / SPEED)
    assert half_range(kept["x"]) == pytest.approx(AMPLITUDE, rel=2e-3)
    assert abs(half_range(plain["x"]) - AMPLITUDE) > 0.05 * AMPLITUDE
    assert kept["x"].attrs["residual"] == pytest.approx(100, rel=0.1)
    count = int((ns.measured.check(record)["a_quality"] > 0).sum())
    assert int((kept["x_quality"] > 0).sum()) == count


def test_filters_spread_the_flags_over_what_they_take_in():
    record = ns.measured.flagged(accelerations(frozen=True))
    bad = np.flatnonzero(record["a_quality"])
    smooth = ns.measured.low_pass(record, 500.0)
    reach = round(smooth["a"].attrs["edge"] * RATE)
    spread = np.flatnonzero(smooth["a_quality"])
    assert spread[0] == bad[0] - reach and spread[-1] == bad[-1] + reach
    fast = ns.measured.velocities(record, highest=200)
    half = fast["va"].attrs["window"] // 2
    times = fast["time"].values[fast["va_quality"].values > 0]
    assert times[0] == pytest.approx(record["time"].values[bad[0] - half])
    own = fast["time"].values[fast["a_quality"].values > 0]
    assert own[0] == pytest.approx(record["time"].values[bad[0]])


def test_points_and_angles_have_the_flags_of_their_samples():
    record = ns.measured.flagged(accelerations(frozen=True))
    bad = record["time"].values[record["a_quality"].values > 0]
    points = ns.measured.section(record)
    inside = (points["time"] > bad[0]) & (points["time"] < bad[-1])
    assert 6 <= int(inside.sum()) <= 9
    assert points["a_quality"].values[inside.values].all()
    assert not points["a_quality"].values[np.abs(points["time"] - 1.8).values > 0.25].any()
    even = ns.measured.synchronous(record, 64)
    inside = (even["measured_time"] > bad[0]) & (even["measured_time"] < bad[-1])
    np.testing.assert_array_equal(even["a_quality"].values[inside.values], 2)
    scaled = ns.measured.dimensionless(record, length=2.0, natural_frequency=10.0)
    np.testing.assert_array_equal(scaled["a_quality"], record["a_quality"])


def test_a_check_of_other_samples():
    record = accelerations()
    with pytest.raises(ns.OptionError, match="other samples"):
        ns.measured.flagged(record, ns.measured.check(record.isel(time=slice(1000))))
    with pytest.raises(ns.OptionError, match=r"measured\.check"):
        ns.measured.flagged(record, record)


@pytest.mark.parametrize("both", [True, False])
def test_no_turn_is_invented_where_all_channels_stand_still(both):
    """A recorder that hung has no marks; if one channel goes on, the marks alone were lost."""
    t = np.arange(8000) / 2000.0
    turn = 2 * np.pi * 10 * t
    channels = {"x": np.cos(turn), "y": np.sin(turn)}
    marks = np.delete(np.arange(1, 40) / 10.0, [14, 15, 16])
    still = slice(3010, 3590)
    for name in ("x", "y") if both else ("x",):
        channels[name][still] = channels[name][still.start]
    give = {"times": t, "marks": marks, "bad_marks": "repair"}
    if not both:
        assert ns.measured.from_arrays(channels, **give).attrs["n_repaired"] == 3
        return
    with pytest.raises(ns.OptionError, match=r"all channels stand still from t = 1\.505 to 1\.79"):
        ns.measured.from_arrays(channels, **give)
    for part in ((0.0, 1.4), (1.8, 4.0)):
        record = ns.measured.from_arrays(channels, time_range=part, **give)
        assert record.attrs["n_repaired"] == 0


def test_flags_that_a_record_has_stay():
    """Somebody has flagged the first ten samples as missing; the check finds the frozen ones."""
    record = accelerations(frozen=True)
    own = np.zeros(record.sizes["time"], np.uint8)
    own[:10] = 1
    record = record.assign_coords(a_quality=("time", own))
    frozen = ns.measured.check(record)["a_quality"].values
    both = ns.measured.flagged(record)["a_quality"].values
    np.testing.assert_array_equal(both, own | frozen)
