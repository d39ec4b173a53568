"""The frequency of a breathing crack against the time that free motion takes."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.fatigue import bilinear_frequency, breathing_frequency_ratio


def test_free_motion_takes_that_time():
    """Returns of u'' + k(u) u = 0 through zero, found as events."""
    system = ns.System(
        name="bilinear",
        states=["u", "v"],
        modes={
            "shut": ns.Mode({"u": "v", "v": "-4*u"}, exits=[ns.Exit("-u", to="open")]),
            "open": ns.Mode({"u": "v", "v": "-u"}, exits=[ns.Exit("u", to="shut")]),
        },
    )
    run = ns.simulate(system, {"u": -1.0}, t_end=40.0)
    times = run["event_time"].values[1:]
    frequency = 1.0 / (times[2] - times[0])
    one, two = 2.0 / (2 * math.pi), 1.0 / (2 * math.pi)
    assert bilinear_frequency(one, two) == pytest.approx(frequency, rel=1e-13)
    assert bilinear_frequency(two, one) == bilinear_frequency(one, two)
    assert breathing_frequency_ratio(0.25) == pytest.approx(frequency / one, rel=1e-13)


def test_limits():
    assert breathing_frequency_ratio(1.0) == 1.0
    np.testing.assert_allclose(breathing_frequency_ratio([1e-12]), [2e-6], rtol=1e-5)


@pytest.mark.parametrize("value", [0.0, -1.0, [1.0, -2.0]])
def test_bad_input(value):
    with pytest.raises(ns.OptionError, match="must be positive"):
        breathing_frequency_ratio(value)
    with pytest.raises(ns.OptionError, match="opened = "):
        bilinear_frequency(1.0, value)
