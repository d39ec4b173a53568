"""Stiffness laws, stress intensities and crack lengths: what is drawn."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns


def by_label(ax):
    return {line.get_label(): line for line in ax.lines}


def test_stiffness_laws(ax):
    laws = ns.fatigue.compare_stiffness_laws(np.linspace(0.0, 19.0, 20))
    ns.plot.stiffness_laws(laws, ax=ax)
    lines = by_label(ax)
    np.testing.assert_array_equal(
        lines["cubic law of Fig. 29"].get_ydata(), laws["cubic_relative"].values
    )
    first = lines["law of Guinea et al., Eq. (48)"].get_ydata()[0]
    assert lines["crack shut, Eq. (47)"].get_ydata()[0] == pytest.approx(first)
    assert ax.get_xlabel() == "crack length [mm]"


def test_stress_intensity(ax):
    found = ns.fatigue.compare_stress_intensity([1.0, 5.0, 10.0], load=50.0)
    ns.plot.stress_intensity(found, ax=ax)
    np.testing.assert_array_equal(
        by_label(ax)["tada"].get_ydata(), found["stress_intensity"].sel(formula="tada")
    )
    assert ax.get_yscale() == "log"
    assert ax.get_ylabel() == "stress intensity [MPa √m], 50 N"


def test_differences(ax):
    found = ns.fatigue.compare_stress_intensity([1.0, 5.0, 10.0])
    ns.plot.stress_intensity(found, "difference", ax=ax)
    np.testing.assert_array_equal(by_label(ax)["irwin"].get_ydata(), 0.0)
    assert ax.get_ylabel() == "difference from irwin [%]"


def test_crack_lengths_of_two_tests(ax):
    times, curve = [0.0, 500.0, 1000.0], ns.fatigue.CrackCurve(6.4, 1.0, 700.0, 200.0)
    ns.plot.crack_lengths(curve, times, [6.4, 6.8, 10.9], ax=ax, label="one")
    ns.plot.crack_lengths(curve, times, ax=ax, label="two")
    circles, one, two = ax.lines
    assert circles.get_color() == one.get_color() != two.get_color()
    np.testing.assert_array_equal(circles.get_ydata(), [6.4, 6.8, 10.9])
    np.testing.assert_allclose(one.get_ydata(), curve.length(one.get_xdata()))
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["one", "two"]
    assert ax.get_xlabel() == "time [s]"


def test_bad_input(ax):
    with pytest.raises(ns.OptionError, match="compare_stiffness_laws"):
        ns.plot.stiffness_laws(xr.Dataset(), ax=ax)
    with pytest.raises(ns.OptionError, match="compare_stress_intensity"):
        ns.plot.stress_intensity(xr.Dataset(), ax=ax)
    with pytest.raises(ns.OptionError, match="variable = 'load'"):
        ns.plot.stress_intensity(ns.fatigue.compare_stress_intensity([5.0]), "load", ax=ax)
    curve = ns.fatigue.CrackCurve(5.0, 1.0, 1.0, 1.0)
    with pytest.raises(ns.OptionError, match="two at least"):
        ns.plot.crack_lengths(curve, 3.0, ax=ax)
    with pytest.raises(ns.OptionError, match="one length per time"):
        ns.plot.crack_lengths(curve, [0.0, 1.0], [5.0], ax=ax)
