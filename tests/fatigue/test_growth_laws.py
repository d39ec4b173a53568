"""Laws of growth and closure against hand calculation and limits."""

import numpy as np
import pytest

from nonsmooth.errors import OptionError
from nonsmooth.fatigue import Forman, NewmanClosure, Paris, Walker, effective_range, published_laws


def test_walker_is_paris_at_zero_ratio_and_at_gamma_one():
    sizes = np.array([3.0, 10.0, 30.0])
    paris = Paris(C=2e-8, m=3.3)
    np.testing.assert_allclose(Walker(2e-8, 3.3, 0.5).rate(sizes, 0.0), paris.rate(sizes))
    np.testing.assert_allclose(Walker(2e-8, 3.3, 1.0).rate(sizes, 0.6), paris.rate(sizes))


def test_walker_at_gamma_zero_knows_the_largest_value_alone():
    law = Walker(2e-8, 3.3, 0.0)
    high, ratio = 20.0, np.array([0.0, 0.3, 0.7])
    np.testing.assert_allclose(law.rate(high * (1 - ratio), ratio), law.rate(high), rtol=1e-13)


def test_forman_by_hand_and_at_fracture():
    law = Forman(C=5e-6, m=2.0, K_c=60.0)
    assert float(law.rate(10.0, 0.5)) == pytest.approx(5e-6 * 100 / (0.5 * 60 - 10), rel=1e-14)
    assert float(law.rate(30.0, 0.5)) == np.inf


def test_nothing_grows_up_to_the_threshold():
    law = Paris(1e-8, 3.0, threshold=2.0)
    np.testing.assert_array_equal(law.rate([0.0, 1.0, 2.0]), 0.0)
    assert float(law.rate(2.1)) > 0


LAWS = [Paris(1e-8, 3.0), Walker(1e-8, 3.0, 0.5), Forman(1e-6, 3.0, 60.0, threshold=2.0)]
LAWS += published_laws().values()


@pytest.mark.parametrize("law", LAWS)
def test_a_range_that_is_not_known_or_negative_is_not_no_growth(law):
    assert np.isnan(law.rate(np.nan))
    assert np.isnan(law.rate([10.0, np.nan, 0.0])).tolist() == [False, True, False]
    for wrong in (-3.0, [1.0, np.nan, -3.0]):
        with pytest.raises(OptionError, match=r"delta_K = -3 MPa sqrt\(m\)"):
            law.rate(wrong)


@pytest.mark.parametrize("law", [Walker(1e-8, 3.0, 0.5), Forman(1e-6, 3.0, 60.0, threshold=2.0)])
def test_a_load_ratio_that_is_not_known_or_not_below_one(law):
    assert np.isnan(law.rate(10.0, np.nan))
    assert float(law.rate(0.0, 1.0)) == 0.0  # no load changes
    with pytest.raises(OptionError, match=r"R = 1.5: a load ratio is below 1"):
        law.rate(10.0, [1.5, np.nan])


@pytest.mark.parametrize("closure", ["shut", "none", 0.3, NewmanClosure()])
def test_stress_intensities_of_a_cycle_in_the_wrong_order(closure):
    with pytest.raises(OptionError, match="K_min = 10 is above K_max = 5"):
        effective_range([1.0, 10.0], [2.0, 5.0], closure)
    for high in (7.0, 7.0 * (1.0 - 1e-15)):  # of one load, the two are as large but for rounding
        size, ratio = effective_range(7.0, high, closure)
        assert float(size) == 0.0 and float(Walker(1e-8, 3.0, 0.5).rate(size, ratio)) == 0.0


def test_published_laws_carry_their_sources():
    laws = published_laws()
    assert all(law.source for law in laws.values())
    assert "digits are unverified" in laws["walker 2024-T3"].source
    # two sources, two forms of law, one alloy: alike where both were measured
    walker, forman = laws["walker 2024-T3"], laws["forman 2024-T351"]
    for size, ratio in ((8.0, 0.0), (15.0, 0.0), (10.0, 0.5)):
        assert 0.5 < float(walker.rate(size, ratio) / forman.rate(size, ratio)) < 2.0


@pytest.mark.parametrize(
    ("ratio", "C", "m", "between", "factors"),
    [
        (0.1, 1e-8, 3.645, (5.395, 22.696), (1.3, 1.5)),
        (0.2, 1e-8, 3.7053, (4.85, 16.88), (1.3, 1.6)),
        (0.3, 9e-9, 3.8712, (4.22, 15.9), (1.05, 1.6)),
        (0.5, 5e-8, 2.9287, (5.535, 15.82), (1.9, 4.0)),
    ],
)
def test_rates_beside_paris_lines_of_another_source(ratio, C, m, between, factors):
    """Coefficients and ranges of doi 10.2478/fas-2022-0004, as the source of the law says."""
    sizes = np.linspace(*between, 20)
    beside = published_laws()["walker 2024-T3"].rate(sizes, ratio) / (C * sizes**m)
    assert factors[0] < beside.min() and beside.max() < factors[1]


@pytest.mark.parametrize(
    ("low", "high", "size", "ratio"),
    [(-10, 10, 10, 0), (0, 10, 10, 0), (5, 10, 5, 0.5), (-10, -2, 0, 0), (-10, 0, 0, 0)],
)
def test_shut_cracks_do_not_grow(low, high, size, ratio):
    assert tuple(map(float, effective_range(low, high))) == (size, ratio)


def test_other_closures_by_hand():
    assert tuple(map(float, effective_range(-10, 10, "none"))) == (20, -1)
    assert tuple(map(float, effective_range(0, 10, 0.3))) == (pytest.approx(7), 0)
    assert tuple(map(float, effective_range(5, 10, 0.3))) == (pytest.approx(5), 0)


def test_newman_limits():
    """0.535 and 0.255 at R = 0 under small stresses; closed never at R = 1; nothing jumps."""
    assert float(NewmanClosure(1, 0.0).opening(0.0)) == pytest.approx(0.535, abs=1e-12)
    assert float(NewmanClosure(3, 0.0).opening(0.0)) == pytest.approx(0.255, abs=1e-12)
    closure = NewmanClosure(2, 0.4)
    assert float(closure.opening(1 - 1e-9)) == pytest.approx(1.0, abs=1e-8)
    assert abs(float(closure.opening(1e-9) - closure.opening(-1e-9))) < 1e-8
    assert np.all(np.diff(closure.opening(np.linspace(-1, 0.99, 50))) > -1e-12)


def test_newman_keeps_the_range_at_its_reference():
    size, ratio = effective_range(2.0, 10.0, NewmanClosure(2, 0.3, reference=0.2))
    assert (float(size), float(ratio)) == (pytest.approx(8.0, rel=1e-14), 0.2)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: Paris(0.0, 3.0), "C = 0"),
        (lambda: Paris(1e-8, -3.0), "m = -3"),
        (lambda: Paris(1e-8, 3.0, threshold=-1.0), "cannot be negative"),
        (lambda: Walker(1e-8, 3.0, float("nan")), "gamma"),
        (lambda: Walker(1e-8, 3.0, 2.0), "gamma = 2 must be from 0 to 1: above 1 a larger mean"),
        (lambda: Walker(1e-8, 3.0, -0.1), "gamma = -0.1 must be from 0 to 1"),
        (lambda: Forman(1e-8, 3.0, 0.0), "K_c"),
        (lambda: NewmanClosure(4.0), "alpha"),
        (lambda: NewmanClosure(2.0, 1.0), "stress_ratio"),
        (lambda: NewmanClosure(2.0, 0.3, 1.0), "reference"),
        (lambda: effective_range(0, 1, "open"), "known are"),
        (lambda: effective_range(0, 1, 1.0), "below 1"),
    ],
)
def test_bad_constants(make, text):
    with pytest.raises(OptionError, match=text):
        make()
