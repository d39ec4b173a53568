"""Areas under the curve against their closed form, and how often intervals hold them."""

import numpy as np
import pytest
import xarray as xr
from scipy.special import ndtr
from scipy.stats import binom

import nonsmooth as ns


def windows(x):
    return xr.Dataset({"x": ("window", np.asarray(x))})


def area(shift):
    """P(|X + shift| > |Y|) of standard normal variables; X - Y and X + Y are independent."""
    return ndtr(shift / 2**0.5) ** 2 + ndtr(-shift / 2**0.5) ** 2


@pytest.mark.parametrize("shift", [1.0, 3.0])
def test_the_interval_holds_the_area(shift):
    rng, repeats, inside, found = np.random.default_rng(0), 120, 0, []
    for _ in range(repeats):
        healthy, faulty = rng.normal(size=1600), shift + rng.normal(size=80)
        curve = ns.measured.roc(windows(healthy), windows(faulty))
        found.append(float(curve["area"]))
        inside += curve["area_low"] <= area(shift) <= curve["area_high"]
    assert inside >= binom.ppf(1e-4, repeats, 0.95)
    # the mean of the reference is off by 1/sqrt(800), which moves the area by its square
    assert abs(np.mean(found) - area(shift)) < 4 * np.std(found) / np.sqrt(repeats) + 1 / 800


def test_shares_are_those_above_the_threshold():
    rng = np.random.default_rng(1)
    healthy, faulty = rng.normal(size=400), 2.0 + rng.normal(size=50)
    curve = ns.measured.roc(windows(healthy), windows(faulty))
    first = healthy[:200]
    for k in (1, 60, 150):
        limit = float(curve["threshold"][k])
        for name, values in (("false_alarms", healthy[200:]), ("detections", faulty)):
            score = np.abs(values - first.mean()) / first.std(ddof=1)
            assert float(curve[name][k]) == np.mean(score > limit)
            assert curve[f"{name}_low"][k] <= curve[name][k] <= curve[f"{name}_high"][k]
    assert curve["detections"].values[[0, -1]].tolist() == [0.0, 1.0]


def test_what_is_told_apart_throughout():
    """Of k pairs that all are, the least area is 0.025 to the power of 1/k."""
    rng = np.random.default_rng(2)
    curve = ns.measured.roc(windows(rng.normal(size=400)), windows(50.0 + rng.normal(size=20)))
    assert curve["area"] == curve["area_high"] == 1.0
    assert 0.025 ** (1 / 5) < curve["area_low"] <= 0.025 ** (1 / 20)


def test_records_that_differ_widen_the_interval():
    rng = np.random.default_rng(3)

    def sets(between):
        return [windows(between * rng.normal() + rng.normal(size=40)) for _ in range(10)]

    widths = []
    for between in (0.0, 2.0):
        faulty = [one + 1.0 for one in sets(between)]
        curve = ns.measured.roc(sets(between), faulty)
        widths.append(float(curve["area_high"] - curve["area_low"]))
    assert widths[1] > 1.5 * widths[0]


def test_what_is_refused():
    with pytest.raises(ns.OptionError, match="faulty: the indicator x is missing"):
        ns.measured.roc(windows(np.arange(50.0)), xr.Dataset({"y": ("window", [1.0])}))
    with pytest.raises(ns.OptionError, match="faulty: a dataset has no windows"):
        ns.measured.roc(windows(np.arange(50.0)), windows(np.arange(0.0)))
