"""Profiles of the likelihood and estimates of the bootstrap, kept in the result of a fit."""

import numpy as np
import pytest

import nonsmooth as ns
from fitting.truth import dataset

TIMES = np.linspace(0.0, 3.0, 60)


def decay(level=0.1):
    """A state that decays, and a record of it: exp(-0.5 t) with much noise."""
    system = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "-k*x"})
    noise = level * np.random.default_rng(3).standard_normal(TIMES.size)
    return system, dataset(TIMES, x=np.exp(-0.5 * TIMES) + noise)


def least_squares(record, k):
    """Sum of squares with the best start: the motion is its start times exp(-k t)."""
    shape = np.exp(-k * TIMES)
    start = shape @ record["x"].values / (shape @ shape)
    return float(np.sum((record["x"].values - start * shape) ** 2))


@pytest.mark.parametrize("segments", [1, 3])
def test_a_profile_is_that_of_the_closed_form(segments):
    """The state is linear in its start, so the least sum of squares is known for each k."""
    system, record = decay()
    found = ns.fit(
        system, record, {"k": (0.01, 2.0)}, hold_back=0.0, starts=1, segments=segments
    ).sel(parameter="k")
    values, rises = found["profile_value"].values, found["profile_rise"].values
    assert np.all(np.diff(values) > 0.0)
    level = float(found["noise"][0]) ** 2
    lowest = least_squares(record, float(found["estimate"]))
    known = [(least_squares(record, k) - lowest) / level for k in values]
    # the noise is settled to 1e-3, and a gap of 1e-4 of a fiftieth of the state moves no sum of
    # squares by more than 1e-3
    np.testing.assert_allclose(rises, known, rtol=2e-3, atol=2e-3)
    # the profile of a decay is no parabola, and the interval no symmetric one
    parabola = ((values - float(found["estimate"])) / float(found["standard_error"])) ** 2
    assert np.abs(parabola - rises).max() > 0.1


def test_a_profile_has_points_within_and_at_the_ends():
    system, record = decay()
    found = ns.fit(system, record, {"k": (0.01, 2.0)}, starts=1).sel(parameter="k")
    values, rises = found["profile_value"].values, found["profile_rise"].values
    threshold = found.attrs["profile_threshold"]
    for side in ("interval_low", "interval_high"):
        at_end = np.abs(values - float(found[side])).argmin()
        assert rises[at_end] == pytest.approx(threshold, rel=0.01)  # to which an end is found
    estimate = float(found["estimate"])
    for low, high in ((found["interval_low"], estimate), (estimate, found["interval_high"])):
        assert np.any((values > float(low)) & (values < float(high)))


def test_a_profile_ends_at_a_bound():
    system, record = decay()
    found = ns.fit(system, record, {"k": (0.45, 0.55)}, starts=1).sel(parameter="k")
    assert found["interval_open"]
    values = found["profile_value"].values
    assert values[np.isfinite(values)].min() == pytest.approx(0.45, rel=1e-12)
    assert np.nanmax(found["profile_rise"]) < found.attrs["profile_threshold"]


def test_estimates_of_the_bootstrap_are_kept():
    system, record = decay()
    found = ns.fit(system, record, {"k": (0.01, 2.0)}, starts=1, bootstrap=40, segments=1)
    drawn = found["bootstrap_estimate"]
    assert drawn.sizes == {"draw": 40, "parameter": 1}
    ends = drawn.quantile([0.025, 0.975], "draw").values[:, 0]
    kept = [float(found[name][0]) for name in ("bootstrap_low", "bootstrap_high")]
    np.testing.assert_allclose(ends, kept, rtol=1e-12)
