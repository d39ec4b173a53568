"""What goes on from a result of a fit begins where the fit has ended."""

import numpy as np
import pytest
import xarray as xr
from scipy import stats

import nonsmooth as ns
from fitting.test_event_times import ball, falling, picked
from fitting.test_several_records import lines, ramp
from fitting.test_steady import driven, linear_record
from nonsmooth.fitting.restart import fitted_shooting
from nonsmooth.fitting.solver import data_cost


def bounces():
    noise = 1e-3 * np.random.default_rng(1).standard_normal(12)
    return ns.fit(
        falling(), picked(bounce=ball() + noise), {"r": (0.7, 1.0)}, initial={"x": 1.0}, starts=1
    )


def two_lines():
    return ns.fit(ramp(), lines(), {"k": (-5, 5)}, starts=1, private=["k"])


def samples_late_and_scaled():
    record = linear_record()
    return ns.fit(
        driven(), record, {"k": (0.5, 2.5)}, gain=(0.5, 2.0), offset="free", delay=(-0.1, 0.1),
        parameters={"c": 0.3}, starts=1, form="steady",
    )  # fmt: skip


def two_speeds():
    records = {"one": linear_record(), "other": linear_record(periods=12)}
    values = {"other": {"c": 0.4}}
    return ns.fit(driven(), records, {"k": (0.5, 2.5)}, by_record=values, starts=1)


@pytest.mark.few(1)
@pytest.mark.parametrize("make", [bounces, two_lines, samples_late_and_scaled, two_speeds])
def test_equations_come_back_from_a_file(make, tmp_path):
    """The same residuals and gaps, with the same unknowns."""
    found = make()
    found.to_netcdf(tmp_path / "fit.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "fit.nc", engine="h5netcdf") as read:
        shooting, u, noise = fitted_shooting(read.load())
    assert shooting.names == found["parameter"].values.tolist()
    again = shooting.evaluate(u, noise)
    assert again.rows.residual.size == found.attrs["n_fitted"]
    cost = data_cost(again.rows.residual, "linear")
    # the cost of a fit has that of its gaps too, which are closed to 1e-4 of their unit
    assert cost == pytest.approx(found.attrs["cost"], rel=1e-6, abs=1e-4)
    assert np.abs(again.gap).max(initial=0.0) < 1e-3


@pytest.mark.slow
def test_several_records_have_one_posterior():
    """A slope that is shared: both regressions together, with the noise of each known."""
    found = ns.fit(ramp(), lines(), {"k": (-5, 5)}, starts=1, noise=0.05, hold_back=0.0, segments=2)
    drawn = ns.posterior(found, draws=150).sel(parameter="k")
    count = float(drawn["effective_number"])
    assert count > 150
    estimate, error = float(found["estimate"][0]), float(found["standard_error"][0])
    # the fit is the pooled regression, which a test of several records tells; four standard errors
    assert abs(float(drawn["mean"]) - estimate) < 4.0 * error / count**0.5
    deviation = float(drawn["standard_deviation"])
    assert deviation == pytest.approx(error, rel=4.0 / (2.0 * count) ** 0.5)


@pytest.mark.slow
def test_instants_of_bounces_have_a_posterior():
    """Instants are nearly linear in the coefficient, which is then t with the spread of the fit."""
    found = bounces()
    drawn = ns.posterior(found, draws=200)
    assert drawn["parameter"].values.tolist() == ["r", "bounce noise"]
    apart = int(np.ceil(float(drawn["autocorrelation_time"][0])))
    values = drawn["posterior_value"].sel(parameter="r").values[:, ::apart].ravel()
    scaled = (values - float(found["estimate"][0])) / float(found["standard_error"][0])
    freedom = found.attrs["n_fitted"] - 3  # the coefficient and two states
    assert stats.kstest(scaled, stats.t(freedom).cdf).pvalue > 1e-4
