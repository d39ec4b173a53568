"""Correlated residuals: covariances in closed form, and intervals that count them in."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

import nonsmooth as ns
from fitting.truth import dataset
from nonsmooth.fitting.correlated import block_length, correlation_of, ljung_box
from nonsmooth.fitting.residuals import Residuals

ONE_RECORD = np.zeros(2, np.int64)  # of both channels


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
    assert correlation_of(rows_of(series), ONE_RECORD, 0) is None
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
    found = correlation_of(rows, ONE_RECORD, 0)
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
