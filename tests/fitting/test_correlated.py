"""Correlated residuals: covariances in closed form, and intervals that count them in."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter
from scipy.stats import t as student

import nonsmooth as ns
from fitting.truth import dataset
from nonsmooth.fitting.correlated import Correlation, block_length, correlation_of, ljung_box
from nonsmooth.fitting.residuals import Residuals

ONE_RECORD = np.zeros(2, np.int64)  # of both channels
NOTHING = np.zeros((0, 0))  # that was fitted


def coloured(count, colour, rng):
    """A first-order autoregression of variance one."""
    white = rng.standard_normal(count + 500)
    return lfilter([np.sqrt(1.0 - colour**2)], [1.0, -colour], white)[500:]


def rows_of(series):
    """Residuals (C, K) as rows of a fit; those that are nan are left out."""
    channel, place = np.nonzero(np.isfinite(series))
    none = np.zeros((place.size, 0))
    return Residuals(
        series[channel, place], none, none, channel, place, np.zeros_like(place),
        np.ones(place.size, bool), np.zeros(1), np.zeros(1, np.int64),
    )  # fmt: skip


def test_white_residuals_are_left_alone():
    series = np.random.default_rng(1).standard_normal((2, 2000))
    assert correlation_of(rows_of(series), ONE_RECORD, NOTHING) is None
    assert ljung_box(coloured(2000, 0.3, np.random.default_rng(1)))[1] < 1e-6


def test_ljung_box_has_the_level_that_it_tells():
    """Of 1000 white series a twentieth lies below 0.05, to three standard errors of 0.007."""
    rng = np.random.default_rng(2)
    chances = [ljung_box(rng.standard_normal(500))[1] for _ in range(1000)]
    assert np.mean(np.array(chances) < 0.05) == pytest.approx(0.05, abs=0.021)


def test_sums_of_coloured_residuals_vary_as_their_covariance_says():
    """Two channels of one noise, samples left out: beside the covariance matrix written out."""
    rng, count, colour = np.random.default_rng(3), 40_000, 0.8
    noise = coloured(count, colour, rng)
    series = np.array([noise, -0.5 * noise + 0.5 * coloured(count, colour, rng)])
    series[0, 100:130] = np.nan
    rows = rows_of(series)
    found = correlation_of(rows, ONE_RECORD, NOTHING)
    first = rows.place < 300
    weights = np.zeros((rows.place.size, 2))
    weights[first] = np.column_stack([np.ones(first.sum()), np.sin(rows.place[first] / 20)])
    near = colour ** np.abs(rows.place[first][:, None] - rows.place[first])
    cross = np.array([[1.0, -0.5], [-0.5, 0.5]])[rows.channel[first]][:, rows.channel[first]]
    known = weights[first].T @ (near * cross) @ weights[first]
    # 40,000 samples of memory 0.8 are as good as 4400: variances are known to 2 %, the sums of
    # weights, in which channels cancel in part, to several times that
    np.testing.assert_allclose(
        found.covariance_of(weights), known, rtol=0.15, atol=0.02 * known[0, 0]
    )


def slow_tangents(count, number):
    """Orthonormal polynomials, as derivatives of what a fit takes out of a series."""
    powers = np.linspace(-1.0, 1.0, count)[:, None] ** np.arange(number)
    return np.linalg.qr(powers)[0]


def test_what_a_fit_takes_out_of_residuals_is_that_of_the_matrices():
    """Beside the covariance of residuals of least squares, written out, in two channels."""
    count, colours, share = 60, (0.8, 0.5), 0.3
    rows, tangents = rows_of(np.zeros((2, count))), slow_tangents(2 * count, 4)
    news = np.array([[1.0, share], [share, 2.0]])
    found = Correlation([np.array([1.0, -each]) for each in colours], news, rows, count)
    # a sample is the sum of what was new in all samples up to 400 before
    grows = [toeplitz(a ** np.arange(count + 400), np.zeros(count + 400))[400:] for a in colours]
    noise = np.block([
        [news[c, d] * grows[c] @ grows[d].T for d in (0, 1)] for c in (0, 1)
    ])  # fmt: skip
    left = np.eye(2 * count) - tangents @ tangents.T
    lost = noise - left @ noise @ left
    known = [
        [np.trace(lost[own, own], lag) for lag in range(8)]
        for own in (slice(count), slice(count, None))
    ]
    np.testing.assert_allclose(found.lost_to(tangents, 7), known, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("colour", [0.0, 0.8])
def test_variances_from_few_coloured_residuals_are_right_on_average(colour):
    """300 samples that a cubic was taken out of, beside the covariance of its terms in closed form.

    A variance of 20 degrees of freedom, as here with colour, is off by 0.32, and the mean of 200 by
    0.022: three times that. The four terms of a draw err together at worst, so that the rate of
    intervals that hold the truth has a standard error of 1.5 %: twice that.
    """
    rng, count, draws = np.random.default_rng(7), 300, 200
    tangents = slow_tangents(count, 4)
    known = np.diag(tangents.T @ toeplitz(colour ** np.arange(count)) @ tangents)
    variances, plain, inside = [], [], []
    for _ in range(draws):
        drawn = coloured(count, colour, rng)
        sums = tangents.T @ drawn
        rows = rows_of((drawn - tangents @ sums)[None])
        found = correlation_of(rows, ONE_RECORD[:1], tangents, even_white=True)
        as_seen = correlation_of(rows, ONE_RECORD[:1], NOTHING, 4.0, even_white=True)
        variances.append(np.diag(found.covariance_of(tangents)))
        plain.append(np.diag(as_seen.covariance_of(tangents)))
        freedom = found.freedom_of(tangents, np.eye(4))
        inside.append(np.abs(sums) < student.ppf(0.975, freedom) * np.sqrt(variances[-1]))
    np.testing.assert_allclose(np.mean(variances, axis=0) / known, 1.0, atol=0.066)
    if colour:  # residuals remember less than the noise
        assert np.all(np.mean(plain, axis=0) / known < 0.85)
    assert np.mean(inside) == pytest.approx(0.95, abs=0.03)


def test_degrees_of_freedom_are_those_of_a_memory_that_is_estimated():
    """The sum of all samples: its variance is that of an innovation over (1 - a)^2.

    Its logarithm varies by 2/K from the innovations and by 4 (1 - a^2)/(1 - a)^2/K from the memory
    a, whose variance is (1 - a^2)/K. What lies beside the ends of the series is 2/(1 - a)/K.
    """
    count, memory = 4000, 0.8
    rows = rows_of(np.zeros((1, count)))
    found = Correlation([np.array([1.0, -memory])], np.ones((1, 1)), rows, count)
    freedom = found.freedom_of(np.ones((count, 1)), np.eye(1))
    known = count / (1.0 + 2.0 * (1.0 + memory) / (1.0 - memory))
    assert freedom[0] == pytest.approx(known, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("segments", [1, 6])
def test_a_line_in_coloured_noise_has_the_error_of_least_squares(segments):
    """Beside the covariance of ordinary least squares in closed form, which white noise misses."""
    count, colour = 3000, 0.9
    times = np.linspace(0.0, 2.0, count)
    x = 0.3 + 0.7 * times + 0.05 * coloured(count, colour, np.random.default_rng(4))
    ramp = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "k"})
    found = ns.fit(ramp, dataset(times, x=x), {"k": (-5, 5)}, hold_back=0.0, starts=1,
                   segments=segments)  # fmt: skip
    design = np.column_stack([np.ones(count), times])
    inverse = np.linalg.inv(design.T @ design)
    noise = 0.05**2 * toeplitz(colour ** np.arange(count))
    known = np.sqrt((inverse @ design.T @ noise @ design @ inverse)[1, 1])
    # a memory of 0.9 is known to 0.9 %, and the error grows as 1/(1 - memory): to 8 %; twice that
    assert float(found["standard_error"][0]) == pytest.approx(known, rel=0.17)
    half = float(found["interval_high"][0] - found["interval_low"][0]) / 2.0
    assert half == pytest.approx(1.96 * float(found["standard_error"][0]), rel=0.02)
    # 19 for sums of this noise
    assert float(found["variance_ratio"][0]) == pytest.approx(19.0, rel=0.35)
    assert "widened" in found.attrs["interval_method"]
    assert "residuals of x are correlated" in found.attrs["message"]


@pytest.mark.slow
def test_white_noise_keeps_the_plain_intervals():
    times = np.linspace(0.0, 2.0, 400)
    x = 0.3 + 0.7 * times + 0.05 * np.random.default_rng(5).standard_normal(400)
    ramp = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "k"})
    found = ns.fit(ramp, dataset(times, x=x), {"k": (-5, 5)}, starts=1)
    assert found["variance_ratio"].values.tolist() == [1.0]
    assert "residuals white" in found.attrs["interval_method"]


def test_blocks_are_longer_where_residuals_remember():
    rng = np.random.default_rng(6)
    assert block_length(rng.standard_normal(1000)) == 20
    # 1.5 (2 a / (1 - a^2))^2 to the power 1/3, at a = 0.9: 5.1
    assert block_length(coloured(100_000, 0.9, rng)) == pytest.approx(5.13 * 46.4, rel=0.03)
