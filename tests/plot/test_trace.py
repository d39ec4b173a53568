"""Thinning keeps what a picture shows."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.plot.trace import DENSE, curve, thinned


def test_few_points_are_kept():
    time = np.linspace(0.0, 1.0, DENSE)
    values = np.sin(time)
    assert thinned(time, values) == (time, values)


def test_extremes_stay():
    """One sample of a million that sticks out is the very thing to look for."""
    time = np.linspace(0.0, 7.0, 1_000_000)
    values = np.sin(900.0 * time)
    values[[123_456, 777_777]] = 5.0, -6.0
    t, v = thinned(time, values)
    assert v.size <= 8_000
    assert (v.min(), v.max()) == (-6.0, 5.0)
    assert (t[0], t[-1]) == (time[0], time[-1])
    assert np.all(np.diff(t) > 0.0)


def test_every_column_keeps_its_extremes():
    rng = np.random.default_rng(1)
    time = np.sort(rng.uniform(0.0, 1.0, 50_000))
    values = rng.normal(size=time.size)
    t, v = thinned(time, values)
    for low in (0.1, 0.5, 0.8):  # many columns, whose edges need not be those of the thinning
        all_here = values[(time > low) & (time < low + 0.1)]
        kept = v[(t > low - 0.001) & (t < low + 0.101)]
        assert kept.max() >= all_here.max()
        assert kept.min() <= all_here.min()


def test_kept_points_are_unchanged():
    time = np.arange(30_000.0)
    values = np.cos(time)
    t, v = thinned(time, values)
    np.testing.assert_array_equal(v, values[t.astype(int)])


def test_values_that_are_no_numbers_hide_nothing():
    time = np.arange(30_000.0)
    values = np.where(time % 4 == 0, np.nan, time)
    _, v = thinned(time, values)
    assert v.max() == 29_999.0
    assert np.all(np.isfinite(v))


@pytest.mark.parametrize("fill", [0.0, np.nan])
def test_all_alike(fill):
    time = np.zeros(DENSE + 5)
    t, _ = thinned(time, np.full(time.size, fill))
    assert t.size <= 4


def test_part_of_a_run_has_no_points_outside_its_samples():
    """Cut out by samples: the events of the rest are no part of the curve."""
    whole = ns.simulate(ns.models.moling(), periods=6)
    part = whole.isel(time=slice(250, 450))
    low, high = float(part["time"][0]), float(part["time"][-1])
    trace = curve(part, ["p", "y"])
    assert (trace.time[0], trace.time[-1]) == (low, high)
    inside = (whole["event_time"] >= low) & (whole["event_time"] <= high)
    assert trace.time.size == part.sizes["time"] + 2 * int(inside.sum())
    np.testing.assert_array_equal(trace.values, curve(whole, ["p", "y"], (low, high)).values)
    short = whole.isel(time=slice(250, 252))
    assert curve(short, ["p"]).time.size >= 2
