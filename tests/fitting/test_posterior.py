"""Posteriors beside closed forms: regression, a conjugate prior, integrals over the start."""

import sys

import numpy as np
import pytest
from scipy import stats

import nonsmooth as ns
from fitting.test_fit import line, soft_record, two_springs
from fitting.test_steady import driven, linear_record, response
from fitting.truth import SOFT, dataset, noisy
from nonsmooth.fitting.marginal import Marginal
from nonsmooth.fitting.posterior_dataset import split_r_hat
from nonsmooth.fitting.restart import fitted_shooting

# what most of these tests state holds for chains that are shorter than a result needs
pytestmark = pytest.mark.filterwarnings("ignore:.*the chain is too short:nonsmooth.ResultWarning")


def fit_of_line(**options):
    """A line through 12 points with much noise: few degrees of freedom."""
    ramp, record = line(count=12, level=0.2)
    whole = {"hold_back": 0.0, "starts": 1, "segments": 1} | options
    return record, ns.fit(ramp, record, {"k": (-5, 5)}, **whole)


def marginal_of(found):
    """Likelihood without states, as a function of the values of all parameters."""
    shooting, u, noise = fitted_shooting(found)
    marginal = Marginal(shooting, u, noise)
    return lambda *values: marginal(shooting.head_of(np.array(values)), noise)


def independent(drawn, name):
    """Draws of one parameter, so many steps apart that they hardly follow each other."""
    apart = int(np.ceil(float(drawn["autocorrelation_time"].sel(parameter=name))))
    return drawn["posterior_value"].sel(parameter=name).values[:, ::apart].ravel()


@pytest.mark.slow
def test_a_straight_line_has_the_posterior_of_regression():
    """With flat priors of the line and of the logarithm of the noise these are t and chi square."""
    record, found = fit_of_line()
    drawn = ns.posterior(found, draws=400)
    assert drawn.attrs["message"] == "completed"
    known = stats.linregress(record["time"], record["x"])
    slopes = (independent(drawn, "k") - known.slope) / known.stderr
    squares = float(np.sum((record["x"] - known.intercept - known.slope * record["time"]) ** 2))
    ratios = squares / independent(drawn, "x noise") ** 2
    # a right chain fails once in 10,000; 10 degrees of freedom in place of 12 or of a normal
    # distribution would not be seen in 400 draws, a width that is a fifth off would
    assert slopes.size > 400
    assert stats.kstest(slopes, stats.t(10).cdf).pvalue > 1e-4
    assert stats.kstest(ratios, stats.chi2(10).cdf).pvalue > 1e-4


@pytest.mark.slow
def test_what_was_known_before_counts_as_a_measurement():
    """A normal prior and known noise: means are weighted by the inverse squares of errors."""
    record, found = fit_of_line(noise=0.2)
    drawn = ns.posterior(found, draws=300, prior={"k": stats.norm(0.5, 0.05)}).sel(parameter="k")
    times = record["time"].values - record["time"].values.mean()
    weights = np.array([np.sum(times**2) / 0.2**2, 1.0 / 0.05**2])
    slope = stats.linregress(record["time"], record["x"]).slope
    mean, deviation = weights @ [slope, 0.5] / weights.sum(), weights.sum() ** -0.5
    count = float(drawn["effective_number"])
    assert count > 200
    # four standard errors, of the mean and of the deviation
    assert abs(float(drawn["mean"]) - mean) < 4.0 * deviation / count**0.5
    assert float(drawn["standard_deviation"]) == pytest.approx(
        deviation, rel=4 / (2 * count) ** 0.5
    )
    assert drawn.attrs["prior"] == "{'k': 'norm(0.5, 0.05)'}"


@pytest.mark.slow
@pytest.mark.parametrize("segments", [1, 4])
def test_the_start_is_integrated_out(segments):
    """x = s exp(-k t): the integral over s of the likelihood is known for each k."""
    times = np.linspace(0.0, 3.0, 40)
    noise = 0.1 * np.random.default_rng(3).standard_normal(times.size)
    record = ns.measured.from_arrays({"x": np.exp(-0.5 * times) + noise}, times=times)
    system = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "-k*x"})
    found = ns.fit(system, record, {"k": (0.01, 3)}, hold_back=0.0, starts=1, segments=segments)
    level = float(found["noise"][0])

    def known(k):
        shape = np.exp(-k * times)
        start = shape @ record["x"].values / (shape @ shape)
        squares = np.sum((record["x"].values - start * shape) ** 2)
        return -0.5 * squares / level**2 - 0.5 * np.log(shape @ shape)

    marginal, best = marginal_of(found), float(found["estimate"][0])
    for k in best + float(found["standard_error"][0]) * np.array([-3.0, -1.0, 2.0, 4.0]):
        # steps end where they change the logarithm by 0.05; the picture is right to second order
        # in them, which is a hundredth of that here
        assert marginal(k) - marginal(best) == pytest.approx(known(k) - known(best), abs=2e-3)


def test_a_cycle_has_no_start_to_integrate():
    record = linear_record()
    found = ns.fit(
        driven(), record, {"k": (0.5, 2.5), "c": (0.05, 0.6)}, hold_back=0.0, starts=1,
        form="steady",
    )  # fmt: skip
    level = float(found["noise"][0])

    def known(k, c):
        left = record["x"].values - response(record["time"].values, k, c)
        return -0.5 * np.sum(left**2) / level**2

    marginal, best = marginal_of(found), found["estimate"].values
    errors = found["standard_error"].values
    for steps in ([2.0, 0.0], [-1.0, 2.0], [3.0, -3.0]):
        there = best + errors * steps
        known_fall = known(*there) - known(*best)
        assert marginal(*there) - marginal(*best) == pytest.approx(known_fall, abs=2e-3)


@pytest.mark.slow
def test_impacts_have_a_posterior_like_the_profile():
    """Eight periods: the likelihood is nearly normal, so both intervals are nearly the same."""
    record, events = soft_record(8, 0.02, 1, per_period=40)
    assert len(events) > 5
    free = {"beta": (15, 45), "e": (0.9, 1.6)}
    found = ns.fit(ns.models.soft_impact(), record, free, {"x": "x"}, starts=1)
    drawn = ns.posterior(found, draws=120, transient=20).sel(parameter=list(free))
    assert drawn.attrs["status"] == "completed"
    # of 300 independent draws the ends of an interval are known to 0.06 of its width
    assert (drawn["effective_number"] > 300).all()
    width = found["interval_high"] - found["interval_low"]
    for side in ("interval_low", "interval_high"):
        assert (np.abs(drawn[side] - found[side]) < 0.2 * width).all()
    for name in free:
        low, high = (float(drawn[f"interval_{side}"].sel(parameter=name)) for side in
                     ("low", "high"))  # fmt: skip
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        assert abs(SOFT[name] - middle) < 2.0 * half


@pytest.mark.slow
def test_a_chain_goes_on_from_its_store(tmp_path):
    """An interruption, a longer chain, and one without a store have the same draws."""
    _, found = fit_of_line()
    whole = ns.posterior(found, draws=90, transient=10)
    first = ns.posterior(found, draws=35, transient=10, store=tmp_path / "chain")
    assert first["posterior_value"].identical(whole["posterior_value"].isel(draw=slice(35)))
    (tmp_path / "chain" / "000001.npz").unlink()
    later = ns.posterior(found, draws=90, transient=10, store=tmp_path / "chain")
    assert later["posterior_value"].identical(whole["posterior_value"])
    assert later["acceptance"].identical(whole["acceptance"])
    with pytest.raises(ns.OptionError, match="was begun with other options:\n  prior"):
        prior = {"k": stats.norm(0.0, 1.0)}
        ns.posterior(found, draws=90, prior=prior, store=tmp_path / "chain")
    _, other = fit_of_line(noise=0.2)
    with pytest.raises(ns.OptionError, match="was begun with other options"):
        ns.posterior(other, draws=90, store=tmp_path / "chain")


def test_an_interruption_keeps_what_was_drawn(monkeypatch):
    _, found = fit_of_line()
    call, count = Marginal.__call__, iter(range(1000))

    def interrupted(self, head, noise):
        if next(count) == 300:  # of six a step, behind the second block of 20
            raise KeyboardInterrupt
        return call(self, head, noise)

    monkeypatch.setattr(Marginal, "__call__", interrupted)
    drawn = ns.posterior(found, draws=100, transient=0)
    assert drawn.attrs["status"] == "interrupted"
    assert drawn.sizes["draw"] == 40
    assert np.isfinite(drawn["posterior_value"]).all()


@pytest.mark.slow
def test_a_fit_from_a_file_has_the_same_posterior(tmp_path):
    import xarray as xr

    _, found = fit_of_line()
    found.to_netcdf(tmp_path / "fit.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "fit.nc", engine="h5netcdf") as read:
        again = ns.posterior(read, draws=20, transient=0)
    once = ns.posterior(found, draws=20, transient=0)
    assert again["posterior_value"].identical(once["posterior_value"])
    once.to_netcdf(tmp_path / "posterior.nc", engine="h5netcdf")


@pytest.mark.slow
def test_a_chain_that_is_too_short_says_what_would_be_enough():
    _, found = fit_of_line()
    with pytest.warns(ns.ResultWarning, match="the chain is too short"):
        drawn = ns.posterior(found, draws=30)
    assert drawn.attrs["status"] == "not_converged"
    assert "the chain is too short: 30 draws of each walker are" in drawn.attrs["message"]


def test_bounds_of_parameters_and_noise_hold():
    ramp, record = line(count=12, level=0.2)
    found = ns.fit(ramp, record, {"k": (0.5, 0.7)}, noise=(0.19, 0.21), starts=1, segments=1)
    drawn = ns.posterior(found, draws=60)["posterior_value"]
    for name, low, high in (("k", 0.5, 0.7), ("x noise", 0.19, 0.21)):
        one = drawn.sel(parameter=name)
        assert low <= one.min() and one.max() <= high
        assert one.max() - one.min() > 0.8 * (high - low)


def test_split_r_hat_is_that_of_its_definition():
    """Chains 0, 1, 0, 1 and d, d + 1, ...: halves have the variance 1/3 and means 0.5, d + 0.5."""
    chain = np.array([0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0])
    for apart in (0.0, 1.0, 3.0):
        between = 4.0 * np.var([0.0, 0.0, apart, apart], ddof=1)
        known = np.sqrt(3.0 / 4.0 + between / (4.0 * (1.0 / 3.0)))
        assert split_r_hat(np.array([chain, chain + apart])) == pytest.approx(known, rel=1e-12)


BAD = [
    ({"draws": 3}, "draws = 3 must be a whole number of at least 10"),
    ({"walkers": 3}, "walkers = 3 must be a whole number of at least 4"),
    ({"prior": {"q": stats.norm()}}, r"prior: unknown parameter 'q' \(known: k, x noise\)"),
    ({"prior": {"k": (0, 1)}}, r"prior\['k'\] = .*: give a distribution of scipy.stats"),
    ({"prior": 3}, "prior = 3: give a distribution for each parameter"),
    ({"seed": -1}, "seed = -1 must be a whole number"),
]


@pytest.mark.few(1)
@pytest.mark.parametrize(("options", "words"), BAD, ids=lambda each: str(each)[:30])
def test_bad_input_is_named_with_what_is_allowed(options, words):
    _, found = fit_of_line()
    with pytest.raises(ns.OptionError, match=words):
        ns.posterior(found, **options)


def test_fits_without_a_likelihood_are_refused(monkeypatch):
    _, found = fit_of_line(loss="cauchy")
    with pytest.raises(ns.OptionError, match="'cauchy' makes outliers count less"):
        ns.posterior(found)
    with pytest.raises(ns.OptionError, match="found: give a result of fit"):
        ns.posterior(found.drop_vars("measured"))
    lost = found.assign_attrs(status="not_converged", message="segments do not join")
    with pytest.raises(ns.OptionError, match="did not converge: segments do not join"):
        ns.posterior(lost)
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(ns.OptionError, match=r"pip install 'nonsmooth\[fit\]'"):
        ns.posterior(found)


@pytest.mark.slow
def test_what_is_not_determined_spreads_over_its_bounds():
    """Of two springs the sum alone counts: along the line k1 + k2 = 4 all places are alike."""
    times = np.linspace(0.0, 20.0, 100)
    x = np.exp(-0.05 * times) * np.cos(np.sqrt(4.0 - 0.05**2) * times)
    record = dataset(times, x=noisy(x, 0.02, np.random.default_rng(2)))
    free = {"k1": (0.5, 4), "k2": (0.5, 3)}
    found = ns.fit(two_springs(), record, free, starts=1, segments=1)
    drawn = ns.posterior(found, draws=300, transient=50)
    # k2 is at most 3 and at least 0.5, but for the width of the line, 0.5 % of this range
    assert stats.kstest(independent(drawn, "k1"), stats.uniform(1.0, 2.5).cdf).pvalue > 1e-4
    together = drawn["posterior_value"].sel(parameter=["k1", "k2"]).sum("parameter")
    assert float(together.std()) < 0.01
