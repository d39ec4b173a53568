"""Records of angles as an encoder gives them, within one turn.

The reference is the record of the angle as it grows: whole turns say nothing of the parameters, so
both give the same estimates.
"""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns

SPAN = {"c": (0.1, 0.4), "m": (0.3, 0.7)}


def pendulum(c=0.2, m=0.42):
    return ns.System(
        states=["q", "w"],
        parameters={"T": 0.8, "m": m, "c": c},
        drift={"q": "2*pi"},
        period="2*pi/1.5",
        equations={"q": "w", "w": "T*cos(1.5*t) + m - c*w - sin(q)"},
    )


@pytest.fixture(scope="module")
def motion():
    """A pendulum that turns over eight times."""
    run = ns.simulate(pendulum(0.25, 0.5), {"q": 0.0, "w": 1.5}, periods=8, samples_per_period=30)
    noise = 0.01 * np.random.default_rng(0).standard_normal(run.sizes["time"])
    return run["time"].values, run["q"].values + noise


def fitted(times, angle, **options):
    record = ns.measured.from_arrays({"angle": angle}, times=times)
    return ns.fit(pendulum(), record, SPAN, {"angle": "q"}, starts=1, **options)


@pytest.fixture(scope="module")
def grown(motion):
    found = fitted(*motion)
    assert found.attrs["status"] == "completed"
    return found


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("low", "unit"), [(-np.pi, 1.0), (0.0, 180.0 / np.pi)], ids=["-pi to pi", "0 to 360"]
)
def test_an_angle_within_one_turn_gives_what_the_grown_one_does(motion, grown, low, unit):
    times, angle = motion
    wrapped = np.mod(angle - low, 2.0 * np.pi) + low
    found = fitted(times, wrapped * unit, gain=unit)
    assert found.attrs["status"] == "completed"
    # both solvers stop within some hundredths of a standard error of the minimum
    errors = grown["standard_error"].values
    assert np.all(np.abs(found["estimate"].values - grown["estimate"].values) < 0.05 * errors)
    assert found["standard_error"].values == pytest.approx(errors, rel=0.02)
    # what was held back is predicted within the turn too
    assert float(found["prediction_error"][0]) < 1.5
    assert np.nanmax(np.abs(found["residual"].values)) < 0.06 * unit


@pytest.mark.slow
def test_a_gap_of_some_turns_does_not_matter(motion, grown):
    """Where samples are missing, unwrapping would miss turns."""
    times, angle = motion
    wrapped = np.mod(angle, 2.0 * np.pi)
    wrapped[60:130] = np.nan  # more than two turns
    record = xr.Dataset({"angle": ("time", wrapped)}, {"time": times})
    found = ns.fit(pendulum(), record, SPAN, {"angle": "q"}, starts=1)
    assert found.attrs["status"] == "completed"
    apart = np.abs(found["estimate"].values - grown["estimate"].values)
    assert np.all(apart < 4.0 * found["standard_error"].values)


@pytest.mark.slow
def test_a_wrapped_angle_in_degrees_names_its_gain(motion):
    times, angle = motion
    with pytest.warns(ns.ResultWarning, match="degrees for radians"):
        fitted(times, np.degrees(np.mod(angle, 2.0 * np.pi)), hold_back=0.4)


@pytest.mark.slow
def test_a_steady_swing_is_fitted_as_such():
    """An angle is no drift: a swing that repeats itself has a cycle."""
    run = ns.simulate(pendulum(0.25, 0.1), periods=100, samples_per_period=30)
    run = run.isel(time=slice(70 * 30, None))
    times = run["time"].values
    noise = 0.01 * np.random.default_rng(1).standard_normal(times.size)
    found = fitted(times, run["q"].values + noise, form="steady")
    apart = np.abs(found["estimate"].values - [0.25, 0.1])
    assert np.all(apart < 4.0 * found["standard_error"].values)
