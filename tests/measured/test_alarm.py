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


@pytest.mark.parametrize("factor", [0.0, 0.6])
def test_the_true_rate_lies_within_its_interval_as_often_as_stated(factor):
    rng, repeats, inside, rates = np.random.default_rng(1), 300, 0, []
    for _ in range(repeats):
        x = autoregressive(1000, factor, rng)
        found = ns.measured.alarm(windows(x=x), rate=0.05)
        rates.append(true_rate(found, x))
        inside += found["rate_low"] <= rates[-1] <= found["rate_high"]
    assert inside >= binom.ppf(1e-4, repeats, 0.95)
    if factor == 0.0:  # the mean of Beta(25, 476), by simulation; five standard errors
        assert abs(np.mean(rates) - 25 / 501) < 5 * np.std(rates) / np.sqrt(repeats)
        assert inside <= binom.ppf(1 - 1e-4, repeats, 0.95)


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
        ({"healthy": windows(a=np.ones(400))}, "the indicator a does not vary"),
    ],
)
def test_what_cannot_be_judged_is_refused(arguments, message):
    with pytest.raises(ns.OptionError, match=message):
        ns.measured.alarm(**{"healthy": healthy(), "rate": 0.02, **arguments})
