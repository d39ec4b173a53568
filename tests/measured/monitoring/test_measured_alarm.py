"""Alarms: rates of false alarms on windows that were not seen, and what is refused."""

import numpy as np
import pytest
import xarray as xr
from scipy.special import ndtr
from scipy.stats import binom

import nonsmooth as ns


def windows(**columns):
    return xr.Dataset({name: ("window", np.asarray(one)) for name, one in columns.items()})


def healthy(count=400, seed=0):
    a, b = np.random.default_rng(seed).normal(size=(2, count))
    return windows(a=a, b=a + 0.5 * b)


def true_rate(found, values):
    """Rate of one normal indicator: the score is |x - mean| / spread, with the same first half."""
    first = values[: values.size // 2]
    reach = float(found["threshold"]) * first.std(ddof=1)
    return ndtr(-(first.mean() + reach)) + ndtr(first.mean() - reach)


def autoregressive(count, factor, rng):
    """Stationary, with unit variance."""
    x = rng.normal(size=count)
    for i in range(1, count):
        x[i] = factor * x[i - 1] + np.sqrt(1 - factor**2) * x[i]
    return x


@pytest.mark.few(1)
@pytest.mark.parametrize("factor", [0.0, 0.6, 0.9])
def test_the_true_rate_lies_within_its_interval_as_often_as_stated(factor):
    rng, repeats, inside, rates = np.random.default_rng(1), 200, 0, []
    for _ in range(repeats):
        x = autoregressive(1000, factor, rng)
        found = ns.measured.alarm(windows(x=x), rate=0.05)
        rates.append(true_rate(found, x))
        inside += found["rate_low"] <= rates[-1] <= found["rate_high"]
    assert inside >= binom.ppf(1e-4, repeats, 0.95)
    # as many false alarms as wanted, on the average; five standard errors
    assert abs(np.mean(rates) - 0.05) < 5 * np.std(rates) / np.sqrt(repeats)
    if factor == 0.0:
        assert inside <= binom.ppf(1 - 1e-4, repeats, 0.95)


def records(count, windows_each, between, rng):
    """Levels that differ from record to record by a normal variable."""
    return [windows(x=between * rng.normal() + rng.normal(size=windows_each)) for _ in range(count)]


def true_rate_of_records(found, healthy, between):
    """Rate of further records, whose windows have the variance 1 + between^2 about zero."""
    values = np.concatenate([one["x"].values for one in healthy])
    reach = float(found["threshold"]) * values.std(ddof=1)
    width = np.sqrt(1.0 + between**2)
    return ndtr((-values.mean() - reach) / width) + ndtr((values.mean() - reach) / width)


@pytest.mark.few(1)
@pytest.mark.parametrize(("count", "between"), [(8, 0.0), (20, 0.5), (20, 1.0)])
def test_the_interval_holds_for_further_records_that_differ(count, between):
    rng, repeats, inside, rates, worth = np.random.default_rng(3), 150, 0, [], []
    for _ in range(repeats):
        healthy = records(count, 50, between, rng)
        found = ns.measured.alarm(healthy, rate=0.05)
        rates.append(true_rate_of_records(found, healthy, between))
        inside += found["rate_low"] <= rates[-1] <= found["rate_high"]
        worth.append(float(found["n_effective"]))
    assert inside >= binom.ppf(1e-4, repeats, 0.95)
    # windows of one record know what differs too little: each reference lacks one record of 20,
    # and the estimate of the effect is rough, so the rate is a little low
    assert 0.7 * 0.05 < np.mean(rates) < 0.05 + 4 * np.std(rates) / np.sqrt(repeats)
    if between == 1.0:
        assert np.median(worth) < 0.2 * 50 * count


def test_one_long_record_of_days_that_differ_would_state_too_much():
    """What the interval of records is for: pooled as one record, it holds far too seldom."""
    rng, repeats, inside = np.random.default_rng(4), 60, 0
    for _ in range(repeats):
        one = records(1, 1000, 1.0, rng)[0]
        found = ns.measured.alarm(one, rate=0.05)
        first = one["x"].values[:500]
        reach = float(found["threshold"]) * first.std(ddof=1)
        rate = ndtr((-first.mean() - reach) / 2**0.5) + ndtr((first.mean() - reach) / 2**0.5)
        inside += found["rate_low"] <= rate <= found["rate_high"]
    assert inside < 0.3 * repeats


def test_the_rate_of_two_windows_of_three():
    """Of independent windows it is 3 p^2 - 2 p^3, p being the true rate of single ones."""
    rng, repeats, inside, told, true = np.random.default_rng(5), 200, 0, [], []
    for _ in range(repeats):
        x = rng.normal(size=1000)
        found = ns.measured.alarm(windows(x=x), rate=0.1, needed=2, among=3)
        p = true_rate(found, x)
        true.append(3 * p**2 - 2 * p**3)
        told.append(float(found["alarm_rate"]))
        inside += found["alarm_rate_low"] <= true[-1] <= found["alarm_rate_high"]
    assert inside >= binom.ppf(1e-4, repeats, 0.95)
    # it is estimated with thresholds from nine tenths of the windows: four standard errors, and the
    # share 2/450 of windows at the begin of blocks, which have no two before them
    error = 4 * np.std(np.subtract(told, true)) / np.sqrt(repeats)
    assert abs(np.mean(told) - np.mean(true)) < error + 0.05 * np.mean(true)


def test_single_windows_are_their_own_rule():
    found = ns.measured.alarm(healthy(), rate=0.05)
    for end in ("", "_low", "_high"):
        single = "rate_expected" if not end else f"rate{end}"
        assert found[f"alarm_rate{end}"] == found[single]


def test_too_few_independent_windows_are_told():
    rng = np.random.default_rng(6)
    drift = windows(x=np.repeat(rng.normal(size=20), 20))
    with pytest.warns(ns.ResultWarning, match="that follow each other .* do not support"):
        found = ns.measured.alarm(drift, rate=0.01)
    assert found["rate_expected"] > 0.01 and found["rate_low"] == 0.0
    with pytest.warns(ns.ResultWarning, match="that differ .* give more healthy records"):
        ns.measured.alarm(records(5, 50, 5.0, rng), rate=0.01)


def test_what_never_varied_is_judged_by_its_resolution():
    """A contact that was never lost: one window in which it is."""
    a = np.random.default_rng(7).normal(size=300)
    share = ("window", np.ones(300), {"resolution": 0.001})
    watched = windows(a=[0.0, 0.0], contact=[1.0, 0.9])
    found = ns.measured.alarm(windows(a=a).assign(contact=share), watched, rate=0.02)
    assert found["alarmed"].values.tolist() == [False, True]
    assert found["leading"].values[1] == "contact"
    np.testing.assert_allclose(found["score"].values[1], 100.0, rtol=0.01)


def test_watched_records_follow_each_other():
    late = windows(a=[0.0, 50.0], b=[0.0, 50.0]).assign_coords(time=("window", [3.0, 4.0]))
    early = windows(a=[0.0], b=[0.0]).assign_coords(time=("window", [2.0]))
    found = ns.measured.alarm(healthy(), [early, late], rate=0.02)
    assert found["record"].values.tolist() == [0, 1, 1]
    assert float(found["first_alarm_time"]) == 4.0
    quiet = ns.measured.alarm(healthy(), [early], rate=0.02)
    assert np.isnan(quiet["first_alarm_time"])


def test_windows_that_follow_each_other_are_worth_fewer():
    rng = np.random.default_rng(2)
    found = ns.measured.alarm(windows(x=autoregressive(4000, 0.8, rng)))
    alone = ns.measured.alarm(windows(x=rng.normal(size=4000)))
    assert found["n_effective"] < 0.5 * found["n_calibration"]
    assert alone["n_effective"] > 0.7 * alone["n_calibration"]


def test_scales_of_indicators_do_not_matter():
    plain, watched = healthy(), healthy(50, seed=1)
    one = ns.measured.alarm(plain, watched, rate=0.05)
    two = ns.measured.alarm(
        plain.assign(a=1e3 * plain["a"] + 7), watched.assign(a=1e3 * watched["a"] + 7), rate=0.05
    )
    np.testing.assert_allclose(one["score"], two["score"], rtol=1e-9)


def test_an_alarm_needs_several_windows_where_that_is_asked():
    watched = windows(a=[0, 50, 0, 0, 50, 50.0], b=[0, 50, 0, 0, 50, 50.0])
    found = ns.measured.alarm(healthy(), watched, rate=0.02, needed=2, among=3)
    assert found["exceeded"].values.tolist() == [False, True, False, False, True, True]
    assert found["alarmed"].values.tolist() == [False, False, False, False, False, True]
    assert int(found["first_alarm"]) == 5
    quiet = ns.measured.alarm(healthy(), watched.isel(window=[0, 2]), rate=0.02)
    assert int(quiet["first_alarm"]) == -1


def test_the_indicator_that_left_is_named():
    found = ns.measured.alarm(healthy(), windows(a=[9.0, 0.0], b=[0.0, -9.0]), rate=0.02)
    assert found["leading"].values.tolist() == ["a", "b"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rate": 0.001}, "support no rate below 0.00498, .* at least 999"),
        ({"needed": 3, "among": 2}, "needed = 3 must not exceed among = 2"),
        ({"watched": windows(a=[1.0])}, "watched: the indicator b is missing"),
        ({"watched": windows(a=[1.0], b=[np.nan])}, "watched: an indicator is not finite"),
        ({"training": 0.005}, "too few for 2 indicators"),
        ({"healthy": []}, "healthy: give a dataset over window"),
        ({"healthy": [healthy(), healthy()], "training": 0.4}, "training= is for one healthy"),
        ({"watched": []}, "watched: give a dataset over window"),
        ({"watched": healthy().isel(window=slice(0, 0))}, "watched: a dataset has no windows"),
        ({"watched": [healthy(), healthy(0)]}, "watched: a dataset has no windows"),
        ({"healthy": [healthy(), healthy(0)]}, "healthy: a dataset has no windows"),
        ({"healthy": windows(a=np.ones(400))}, "the indicator a does not vary"),
    ],
)
def test_what_cannot_be_judged_is_refused(arguments, message):
    with pytest.raises(ns.OptionError, match=message):
        ns.measured.alarm(**{"healthy": healthy(), "rate": 0.02, **arguments})


def test_windows_of_one_record_raise_no_alarm_in_the_next():
    """Of the second record one window of three lies above the threshold, and two are needed."""
    first, second = windows(a=[0.0, 9.0, 9.0], b=[0.0] * 3), windows(a=[9.0, 0.0, 0.0], b=[0.0] * 3)
    found = ns.measured.alarm(healthy(), [first, second], rate=0.05, needed=2, among=3)
    assert found["exceeded"].values.tolist() == [False, True, True, True, False, False]
    assert found["alarmed"].values.tolist() == [False, False, True, False, False, False]
    # one record in two parts, however it is cut, is not one record
    whole = xr.concat([first, second], "window")
    found = ns.measured.alarm(healthy(), whole, rate=0.05, needed=2, among=3)
    assert found["alarmed"].values.tolist() == [False, False, True, True, True, False]
