"""Variances of random errors beside the analysis of variance in closed form."""

import numpy as np
import pytest
from scipy.stats import t as student

from nonsmooth.fitting.variance_components import variance_components

GROUPS, EACH = 12, 40


def one_way(rng, between):
    """A balanced one-way layout: group effects and noise of variance one, about a mean."""
    member = np.repeat(np.eye(GROUPS), EACH, axis=0)
    values = 3.0 + member @ (between * rng.standard_normal(GROUPS))
    return values + rng.standard_normal(values.size), member


def mean_squares(values):
    """Between and within groups."""
    table = values.reshape(GROUPS, EACH)
    middle = table.mean(axis=1)
    between = EACH * np.sum((middle - values.mean()) ** 2) / (GROUPS - 1)
    within = np.sum((table - middle[:, None]) ** 2) / (GROUPS * (EACH - 1))
    return between, within


def test_a_balanced_layout_has_the_variance_of_the_analysis_of_variance():
    """Restricted likelihood and mean squares agree exactly where the layout is balanced."""
    values, member = one_way(np.random.default_rng(1), 0.8)
    found = variance_components(values, [member], np.ones((values.size, 1)), 0.01)
    between, within = mean_squares(values)
    known = (between - within) / EACH
    assert found.families == [0]
    assert found.variances[0] == pytest.approx(known, rel=1e-4)  # to which the solver stops
    # variance of a mean square of f degrees of freedom: 2/f of its square. The noise is known to
    # 1 part in 234, which the degrees of freedom of the ratio have in them: to 2 %
    spread = 2.0 / EACH**2 * (between**2 / (GROUPS - 1) + within**2 / (GROUPS * (EACH - 1)))
    assert found.freedom[0] == pytest.approx(2.0 * known**2 / spread, rel=0.04)
    # the best predictor shrinks the means of the groups by a known factor
    shrunk = 1.0 - within / between
    means = values.reshape(GROUPS, EACH).mean(axis=1) - values.mean()
    np.testing.assert_allclose(found.coefficients, shrunk * means, rtol=1e-3, atol=1e-6)


@pytest.mark.slow
def test_noise_alone_speaks_for_no_family_but_as_often_as_the_level():
    """At a level of 0.05, 400 layouts of noise: 20 are found, to three standard errors of 4.4."""
    rng = np.random.default_rng(2)
    count = 0
    for _ in range(400):
        values, member = one_way(rng, 0.0)
        ones = np.ones((values.size, 1))
        count += variance_components(values, [member], ones, 0.05) is not None
    assert 20 - 13.1 <= count <= 20 + 13.1


@pytest.mark.slow
def test_a_variance_counts_before_it_is_named():
    """400 layouts of noise at 0.25 and 0.01: 100 and 4 are found, to three standard errors."""
    rng = np.random.default_rng(5)
    counted = named = 0
    for _ in range(400):
        values, member = one_way(rng, 0.0)
        found = variance_components(values, [member], np.ones((values.size, 1)), 0.01, 0.25)
        if found is not None:
            counted += 1
            named += found.named[0]
    assert 100 - 26 <= counted <= 100 + 26
    assert named <= 4 + 6


@pytest.mark.slow
def test_counting_variances_early_keeps_the_intervals_of_a_mean():
    """The mean of 12 groups whose effects are as large as the noise of a mean of a group.

    An interval that forgets them where they are not significant is too short. With counted
    variances the rate is within 4 % of the nominal one, to three standard errors of 1.5 %.
    """
    between = 1.0 / np.sqrt(EACH)
    rates = []
    for counted in (None, 0.25):
        rng, inside = np.random.default_rng(6), []
        for _ in range(300):
            values, member = one_way(rng, between)
            found = variance_components(
                values, [member], np.ones((values.size, 1)), 0.01, counted
            )  # fmt: skip
            noise = values.var(ddof=1) / values.size
            error, freedom = noise, values.size - 1.0
            if found is not None:
                part = found.variances[0] / GROUPS
                error = found.noise / values.size + part
                freedom = error**2 * found.freedom[0] / part**2
            half = student.ppf(0.975, max(1.0, freedom)) * np.sqrt(error)
            inside.append(abs(values.mean() - 3.0) < half)
        rates.append(np.mean(inside))
    assert rates[0] < 0.9
    assert rates[1] >= 0.95 - 0.04 - 3.0 * 0.015
    assert rates[1] > rates[0] + 0.03


@pytest.mark.slow
def test_two_families_are_told_from_each_other():
    """Means of variances over 60 draws, to three standard errors of what each draw says."""
    rng = np.random.default_rng(3)
    count, size = 600, 40
    families = [rng.standard_normal((count, size)) for _ in range(3)]
    deviations = [0.3, 0.0, 0.15]
    found = np.zeros((60, 3))
    for each in found:
        values = rng.standard_normal(count)
        for columns, deviation in zip(families, deviations, strict=True):
            values = values + columns @ (deviation * rng.standard_normal(size))
        told = variance_components(values, families, np.ones((count, 1)), 0.01)
        each[told.families] = told.variances
    error = found.std(axis=0, ddof=1) / np.sqrt(len(found))
    assert np.all(np.abs(found.mean(axis=0) - np.square(deviations)) < 3.0 * error + 1e-12)
    assert np.mean(found[:, 1] > 0.0) < 0.1


def test_what_was_fitted_tells_nothing_of_a_family():
    """A family that lies in the tangents, and one of which they leave a part."""
    rng = np.random.default_rng(4)
    columns = rng.standard_normal((300, 6))
    values = columns @ rng.standard_normal(6) * 5.0 + rng.standard_normal(300)
    same = columns @ rng.standard_normal((6, 6))
    assert variance_components(values, [columns], same, 0.01) is None
    found = variance_components(values, [columns], columns[:, :3], 0.01)
    assert found.families == [0]
    # three of six coefficients of standard deviation 5 are left to tell their variance
    assert 5.0 < found.variances[0] < 120.0
