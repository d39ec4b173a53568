"""Eq. (49): numbers, text, and the fit, whose errors are judged over many noisy records."""

import math
import warnings

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.fatigue import CrackCurve

FIG_30 = CrackCurve(5.0, 1e-3, 7.8 * 54734, 54734)


def record(noise=0.02, points=40, seed=0, curve=(6.4, 1.0, 1200.0, 250.0), end=1628.0):
    t = np.linspace(0.0, end, points)
    errors = noise * np.random.default_rng(seed).standard_normal(points)
    return t, CrackCurve(*curve).length(t) + errors


def test_length_rate_and_time():
    for tau in (0.0, 900514.0, 936903.0):
        exact = 5 + 1e-3 * math.exp(tau / 54734 - 7.8)
        assert FIG_30.length(tau) == pytest.approx(exact, rel=1e-13)
        assert FIG_30.rate(tau) == pytest.approx((exact - 5) / 54734, rel=1e-12)
    lengths = np.array([5.001, 10.7, 19.0])
    np.testing.assert_allclose(FIG_30.length(FIG_30.time(lengths)), lengths, rtol=1e-13)
    assert FIG_30.length(1e9) == math.inf


def test_text_is_the_curve():
    system = ns.System(
        name="crack",
        states=["u"],
        definitions={"a": FIG_30.text()},
        equations={"u": "1"},
        outputs={"length": "a"},
    )
    times = np.array([0.0, 5e5, 9e5])
    run = ns.simulate(system, times=times)
    np.testing.assert_allclose(run["length"], FIG_30.length(times), rtol=1e-12)
    assert CrackCurve(5.0, 1.0, -3.0, 2.0).text("t/7") == "5.0 + 1.0*exp(((t/7) - (-3.0))/2.0)"


def test_fit_without_noise():
    t, a = record(0.0)
    curve = CrackCurve.from_measured(t, a)
    assert (curve.a0, curve.a1, curve.a2, curve.a3) == pytest.approx((6.4, 1, 1200, 250), rel=1e-9)
    assert curve.standard_errors["residual"] < 1e-9


@pytest.mark.few(1)
@pytest.mark.parametrize("constants", [(6.4, 1.0, 1200.0, 90.0), (5.0, 1.0, 300.0, 900.0)])
def test_standard_errors_over_many_records(constants):
    """Spread of the fits over 200 records against their own errors: chi-square, four sigma.

    The relative error of a standard deviation of n values is 1/sqrt(2n), 5 %.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of slips, which noise alone makes in one of 100
        fits = [CrackCurve.from_measured(*record(0.02, 60, seed, constants)) for seed in range(200)]
    for name, true in zip(("a0", "a2", "a3"), np.delete(constants, 1), strict=True):
        scores = [(getattr(fit, name) - true) / fit.standard_errors[name] for fit in fits]
        assert abs(np.mean(scores)) < 4 / math.sqrt(200)
        assert 1 - 4 * 0.05 < np.std(scores) < 1 + 4 * 0.05
    residual = np.mean([fit.standard_errors["residual"] for fit in fits])
    assert residual == pytest.approx(0.02, rel=0.03)


@pytest.mark.parametrize("place", [0, 17, 38, 39])
@pytest.mark.parametrize("slip", [5.0, -5.0, 0.3])
def test_a_slip_is_told(place, slip):
    t, a = record(0.02, 40, seed=place)
    a[place] += slip
    with pytest.warns(ns.ResultWarning, match=rf"point {place} \(from 0\).* lies off the curve"):
        curve = CrackCurve.from_measured(t, a)
    assert curve.outliers[0] == place
    clean = CrackCurve.from_measured(np.delete(t, place), np.delete(a, place))
    assert clean.outliers == () and clean.a3 == pytest.approx(250.0, rel=0.05)


@pytest.mark.slow
def test_false_alarms_of_slips():
    """Binomial of 200 at 1 %: 2 +- 1.4."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = [CrackCurve.from_measured(*record(0.02, 40, seed)) for seed in range(200)]
    assert 0 < sum(bool(curve.outliers) for curve in found) < 2 + 4 * 1.4


def test_exact_lengths_have_no_slips():
    for points in (6, 40, 400):
        assert CrackCurve.from_measured(*record(0.0, points)).outliers == ()


def test_a1_only_moves_a2():
    t, a = record()
    one, other = (CrackCurve.from_measured(t, a, a1=a1) for a1 in (1.0, 1e-3))
    assert other.a2 == pytest.approx(one.a2 + one.a3 * math.log(1e-3), rel=1e-9)
    np.testing.assert_allclose(other.length(t), one.length(t), rtol=1e-12)


def test_times_in_any_unit_from_any_origin():
    t, a = record()
    one = CrackCurve.from_measured(t, a)
    other = CrackCurve.from_measured(1e6 + 50.0 * t, a)
    assert other.a3 == pytest.approx(50.0 * one.a3, rel=1e-6)
    assert other.a2 == pytest.approx(1e6 + 50.0 * one.a2, rel=1e-8)


@pytest.mark.parametrize(
    ("times", "lengths", "says"),
    [
        (*record(points=5), "5 points are too few.*give 6"),
        ([0, 1, 3, 2, 4, 5], [5, 5, 5, 5, 6, 8], r"times\[3\] = 2 comes after 3; sort both"),
        ([0, 1, 2], [5, 6], r"shapes \(3,\) and \(2,\)"),
        ([0, 1, 2, 3, 4, math.nan], [5] * 6, r"times\[5\] = nan"),
        ([0, 0, 0, 1, 1, 2, 2], [5, 5, 5, 6, 6, 7, 8], "four different times"),
        (np.arange(20.0), 5 + 0.1 * np.arange(20.0), "a straight line"),
        (np.arange(20.0), 9 - np.exp(np.arange(20.0) / 8), "no growth"),
        (np.arange(20.0), 5 + np.sqrt(np.arange(20.0)), "a straight line"),
        (np.arange(20.0), np.full(20, 5.0), "all lengths are 5"),
    ],
)
def test_records_without_a_curve(times, lengths, says):
    with pytest.raises(ns.OptionError, match=says):
        CrackCurve.from_measured(times, lengths)


def test_noise_is_no_growth():
    for seed in range(30):
        noise = np.random.default_rng(seed).standard_normal(40)
        with pytest.raises(ns.OptionError, match=r"fits as well|no growth"):
            CrackCurve.from_measured(np.arange(40.0), 6.0 + 0.01 * noise)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ((5, 0, 1, 1), "a1 = 0 must be positive"),
        ((5, 1, 1, -2), "a3 = -2 must be positive"),
        ((-5, 1, 1, 2), "a0 = -5 must not be negative"),
        ((5, math.nan, 1, 2), "a1 = nan is not a finite number"),
    ],
)
def test_constants_that_cannot_be(values, says):
    with pytest.raises(ns.ModelError, match=says):
        CrackCurve(*values)


def test_length_that_is_never_reached():
    with pytest.raises(ns.OptionError, match=r"length = 4\.9 mm is never reached.*a0 = 5 mm"):
        FIG_30.time([6.0, 4.9])
